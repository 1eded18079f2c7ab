//! A robot whose wheels are 2 % smaller than assumed, set up as in the documents with the figures of a data sheet: with the
//! library, and by a replay of the log. `bindings/capi/tests/c/worn_wheels.c` and `bindings/python/tests/test_worn_wheels.py`
//! have the same robot.

use nalgebra::Vector2;
use scphd::models::*;
use scphd::numerics::*;
use scphd::*;
use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::dimensions::Planar;
use scphd_log::log::{self, Log, Nominal, Odometry, Scan, Sensor, TruePose};
use scphd_run::session::{self, Filter};
use scphd_worlds::scenario;
use std::f64::consts::{FRAC_PI_2, PI};

joint_memory! { type Map: Unicycle<f32> { measurement: Vector2<f32>, features: 64, measurements: 48 } }

const RANGE_M: f64 = 10.0;
/// From the data sheet: standard deviations of range, m, and bearing, rad.
const SIGMAS: [f64; 2] = [0.05, 0.01];
/// Relative difference of the wheels' size.
const WORN: f64 = 0.02;
const DT_S: f64 = 0.02;
const ROWS: usize = 15_000;

/// Five minutes on a circle among 40 posts, with 50 rows of odometry and 10 scans per second.
fn drive(seed: u64) -> Log {
    let mut draws = Noise::seeded(seed);
    let posts: Vec<[f64; 2]> = (0..40).map(|_| [0, 1].map(|_| 24.0 * draws.uniform::<f64>() - 12.0)).collect();
    let (mut odometry, mut scans, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    let exact = Unicycle::<f64>::new(Step::Arc, ControlNoise::NONE).unwrap();
    let mut pose = PlanarPose::new(6.0, 0.0, FRAC_PI_2);
    let initial_pose = [pose.x_m, pose.y_m, pose.heading_rad];
    for row in 0..ROWS {
        let t_s = row as f64 * DT_S;
        let control = UnicycleControl { speed_mps: 0.8, rate_radps: 0.8 / 6.0 };
        let read = [control.speed_mps, control.rate_radps].map(|x| (1.0 + WORN) * x + 0.01 * draws.normal::<f64>());
        odometry.push(Odometry { t_s, control: [read[0], read[1], 0.0] });
        pose = exact.propagate(&pose, &control, DT_S);
        if row % 5 != 4 {
            continue;
        }
        let t_s = t_s + DT_S;
        let mut detections = Vec::new();
        for [x, y] in &posts {
            let (dx, dy) = (x - pose.x_m, y - pose.y_m);
            if dx.hypot(dy) < RANGE_M && draws.uniform::<f64>() < 0.9 {
                let noise = SIGMAS.map(|sigma| sigma * draws.normal::<f64>());
                detections.push([dx.hypot(dy) + noise[0], wrap(dy.atan2(dx) - pose.heading_rad + noise[1])]);
            }
        }
        scans.push(Scan { t_s, detections, ..Scan::default() });
        truth.push(TruePose { t_s, position: [pose.x_m, pose.y_m], heading_rad: Some(pose.heading_rad) });
    }
    Log {
        name: "worn wheels".into(),
        initial_pose,
        vehicle: log::Vehicle::UnicycleArc,
        sensor: Sensor {
            range_min_m: 0.0,
            range_max_m: RANGE_M,
            bearing_min_rad: -PI,
            bearing_max_rad: PI,
            mounting: log::Mounting::NONE,
        },
        nominal: Nominal { range_sigma_m: Some(SIGMAS[0]), bearing_sigma_rad: Some(SIGMAS[1]), ..Nominal::default() },
        simulated: false,
        odometry,
        scans,
        fixes: Vec::new(),
        truth,
        landmarks: posts,
        moving: Vec::new(),
        ..scenario::survey(1)
    }
}

/// RMSE of the position, m, and NEES divided by 3, as means over the scans.
fn by_the_library(log: &Log) -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let window = RangeBearingWindow::full_circle(RANGE_M as f32, 0.9)?;
    let sensing = Sensing::range_bearing(SIGMAS.map(|sigma| sigma as f32), window, 1.0)?;
    let lidar = Detector::new(sensing, Births::of_static(0.1 / window.measure()))?;
    let mut map = Box::new(Map::new());
    let mut slam =
        JointSlam::new(Unicycle::new(Step::Arc, ControlNoise::wheeled())?, JointConfig::default(), &mut *map)?;
    let [x, y, heading] = log.initial_pose.map(|x| x as f32);
    slam.reset(PlanarPose::new(x, y, heading))?;
    let (mut squares, mut nees) = (0.0, 0.0);
    for (scan, (rows, truth)) in log.scans.iter().zip(log.odometry.chunks(5).zip(&log.truth)) {
        for row in rows {
            let [speed_mps, rate_radps, _] = row.control.map(|x| x as f32);
            slam.predict(&UnicycleControl { speed_mps, rate_radps }, DT_S as f32)?;
        }
        let detections: Vec<_> = scan.detections.iter().map(|z| Vector2::from(z.map(|x| x as f32))).collect();
        slam.scan(&lidar, &detections)?;
        let pose = slam.estimate_pose().ok_or("no pose")?;
        let off = nalgebra::Vector3::new(
            f64::from(pose.mean.x_m) - truth.position[0],
            f64::from(pose.mean.y_m) - truth.position[1],
            wrap(f64::from(pose.mean.heading_rad) - truth.heading_rad.ok_or("no heading")?),
        );
        let covariance = pose.covariance.to_matrix().map(f64::from);
        squares += off.x.powi(2) + off.y.powi(2);
        nees += off.dot(&covariance.try_inverse().ok_or("singular").map(|inverse| inverse * off)?) / 3.0;
    }
    let scans = log.scans.len() as f64;
    Ok([(squares / scans).sqrt(), nees / scans])
}

#[test]
fn the_position_error_with_worn_wheels_is_centimetres_with_the_documented_setup() {
    for seed in 1..=3 {
        let log = drive(seed);
        let [rmse_m, nees] = by_the_library(&log).unwrap();
        let settings = Settings::for_log(&log);
        let joint = Filter::Joint(Precision::F32);
        let replay = session::run::<Planar>(&log, &settings, joint, 1, &mut |_| ()).unwrap().summary;
        println!("library {rmse_m:.3} m, NEES/3 {nees:.2}; replay {:?} m", replay.position_rmse_m);
        assert!(rmse_m < 0.05, "{rmse_m} m");
        assert!((0.3..2.0).contains(&nees), "{nees}");
        assert!(replay.position_rmse_m.unwrap() < 0.05, "{replay:?}");
    }
}
