//! Twenty-four laps of one course: an archive must not count the same information again in every lap.

use nalgebra::Vector2;
use scphd::models::{ControlNoise, Motion, PlanarPose, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl};
use scphd::numerics::{Noise, Symmetric, wrap};
use scphd::storage::{JointArchive, joint_numbers};
use scphd::{Births, Detector, JointConfig, JointSlam, JointState};
use std::thread;

type Room<const N: usize, const L: usize> = JointState<PlanarPose<f64>, Vector2<f64>, N, L, 40>;
type Window = Room<40, { joint_numbers(3, 2, 40) }>;
type Wide = Room<70, { joint_numbers(3, 2, 70) }>;

const LAPS: usize = 24;
const REACH_M: f64 = 12.0;
const DT_S: f64 = 0.1;
const SPEED_MPS: f64 = 2.0;
const STRAIGHT_M: f64 = 80.0;
const RADIUS_M: f64 = 3.0;
/// Standard deviations of the odometry, m/s and rad/s in every step, and of the sensor, m and rad.
const ODOMETRY: [f64; 2] = [0.05, 0.01];
const SENSOR: [f64; 2] = [0.1, 0.02];

/// For every lap, the mean of NEES/3 with an archive, and the mean ratio of the variance of its position to that with a
/// window for all features.
fn run(seed: u64) -> [[f64; 2]; LAPS] {
    let mut draws = Noise::seeded(77 + seed);
    let mut landmarks: Vec<[f64; 2]> = Vec::new();
    while landmarks.len() < 40 {
        let [x, y] =
            [(STRAIGHT_M + 24.0, -12.0), (22.0, -8.0)].map(|(size, from)| from + size * draws.uniform::<f64>());
        if landmarks.iter().all(|[other_x, other_y]| (x - other_x).hypot(y - other_y) > 1.5) {
            landmarks.push([x, y]);
        }
    }
    let window = RangeBearingWindow::full_circle(REACH_M, 0.9).unwrap();
    let sensing = Sensing::range_bearing([SENSOR[0], SENSOR[1]], window, 0.5).unwrap();
    let lidar = Detector::new(sensing, Births::of_static(1e-3)).unwrap();
    let noise = ControlNoise::white(ODOMETRY[0], ODOMETRY[1]);
    let motion = Unicycle::new(Step::Arc, noise).unwrap();
    let real = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    let (mut state, mut wide) = (Box::new(Window::new()), Box::new(Wide::new()));
    let mut archive = Box::new(JointArchive::<_, 400>::new());
    let slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_archive(&mut archive, REACH_M).unwrap();
    let mut all = JointSlam::new(motion, JointConfig::default(), &mut *wide).unwrap();
    let mut pose = PlanarPose::new(0.0, 0.0, 0.0);
    slam.reset(pose).unwrap();
    all.reset(pose).unwrap();
    let straight = (STRAIGHT_M / (SPEED_MPS * DT_S)) as usize;
    let bend = (std::f64::consts::PI * RADIUS_M / (SPEED_MPS * DT_S)).round() as usize;
    let lap = 2 * (straight + bend);
    let mut figures = [[0.0; 2]; LAPS];
    for step in 0..LAPS * lap {
        let is_straight = step % (straight + bend) < straight;
        let rate_radps = if is_straight { 0.0 } else { std::f64::consts::PI / (bend as f64 * DT_S) };
        let control = UnicycleControl { speed_mps: SPEED_MPS, rate_radps };
        pose = real.propagate(&pose, &control, DT_S);
        let spread = noise.covariance([SPEED_MPS, rate_radps], DT_S);
        let odometry = UnicycleControl {
            speed_mps: SPEED_MPS + spread.get(0, 0).sqrt() * draws.normal::<f64>(),
            rate_radps: rate_radps + spread.get(1, 1).sqrt() * draws.normal::<f64>(),
        };
        slam.predict(&odometry, DT_S).unwrap();
        all.predict(&odometry, DT_S).unwrap();
        if step % 2 == 0 {
            let mut seen = Vec::new();
            for [x, y] in &landmarks {
                let (dx, dy) = (x - pose.x_m, y - pose.y_m);
                let off = [SENSOR[0] * draws.normal::<f64>(), SENSOR[1] * draws.normal::<f64>()];
                let range = dx.hypot(dy);
                if draws.uniform::<f64>() < 0.9 && range < REACH_M && range > 0.5 {
                    seen.push(Vector2::new(range + off[0], wrap(dy.atan2(dx) - pose.heading_rad + off[1])));
                }
            }
            if draws.uniform::<f64>() < 0.4 {
                let (range, turn) = (REACH_M * draws.uniform::<f64>(), draws.uniform::<f64>());
                seen.push(Vector2::new(range, std::f64::consts::TAU * (turn - 0.5)));
            }
            slam.scan(&lidar, &seen).unwrap();
            all.scan(&lidar, &seen).unwrap();
        }
        let [ours, best] = [slam.estimate_pose(), all.estimate_pose()].map(Option::unwrap);
        let off = nalgebra::Vector3::new(
            ours.mean.x_m - pose.x_m,
            ours.mean.y_m - pose.y_m,
            wrap(ours.mean.heading_rad - pose.heading_rad),
        );
        let [of_ours, of_best] = [&ours, &best].map(|pose| pose.covariance.get(0, 0) + pose.covariance.get(1, 1));
        // With a standard deviation of one micrometre more, because the covariance is zero at the start.
        let certain = ours.covariance.plus(&Symmetric::from_diagonal([1e-12; 3]));
        let [nees, ratio] = &mut figures[step / lap];
        *nees += certain.factor().unwrap().mahalanobis(&off) / 3.0 / lap as f64;
        *ratio += of_ours / of_best / lap as f64;
    }
    figures
}

#[test]
fn archived_information_is_counted_once_in_twenty_four_laps() {
    // The settings of the archive were chosen on the courses 0 to 7.
    // In two threads, because the other tests of filters take less time than this one.
    let runs: Vec<_> = thread::scope(|scope| {
        let halves = [100..108, 108..116].map(|seeds| scope.spawn(|| seeds.map(run).collect::<Vec<_>>()));
        halves.into_iter().flat_map(|half| half.join().unwrap()).collect()
    });
    let figures = std::array::from_fn::<_, LAPS, _>(|lap| {
        [0, 1].map(|which| {
            let mut of_runs: Vec<f64> = runs.iter().map(|run| run[lap][which]).collect();
            of_runs.sort_by(f64::total_cmp);
            f64::midpoint(of_runs[7], of_runs[8])
        })
    });
    println!("NEES and ratio of variances, lap by lap: {figures:.2?}");
    for [nees, ratio] in figures {
        assert!((0.7..1.5).contains(&nees) && (0.8..1.3).contains(&ratio), "{figures:.2?}");
    }
}
