//! A vehicle that learns what its odometry is off by.

use nalgebra::{Vector2, Vector6};
use scphd::models::{
    Calibrated, CalibratedPose, ControlNoise, OdometryCorrection, OdometryPrior, PlanarPose, RangeBearing,
    RangeBearingWindow, SelfCalibrating, Sensing, Step, Unicycle, UnicycleControl, UniformClutter,
};
use scphd::numerics::{Noise, Symmetric, wrap};
use scphd::{Births, Detector, JointConfig, JointSlam, joint_memory};

const DT_S: f64 = 0.1;
const SCANS: usize = 1200;

joint_memory! { type Plain: Unicycle<f64> { measurement: Vector2<f64>, features: 40, measurements: 32 } }
joint_memory! { type Learning: SelfCalibrating<Unicycle<f64>, f64> { measurement: Vector2<f64>, features: 40, measurements: 32 } }

/// Round and round an eight, among landmarks; the odometry says other speeds and turn rates than the true ones.
struct Drive {
    truth: Vec<[f64; 3]>,
    controls: Vec<UnicycleControl<f64>>,
    scans: Vec<Vec<Vector2<f64>>>,
}

fn drive(seed: u64, scale: f64, turn_scale: f64, offset: f64) -> Drive {
    let mut draws = Noise::seeded(seed);
    let landmarks: Vec<[f64; 2]> =
        (0..16).map(|_| [0; 2].map(|_| 24.0 * (draws.uniform::<f64>() - 0.5))).map(|[x, y]| [x + 5.0, y]).collect();
    let [mut x, mut y, mut heading] = [0.0_f64; 3];
    let mut drive = Drive { truth: Vec::new(), controls: Vec::new(), scans: Vec::new() };
    for k in 0..SCANS {
        let (speed, rate) = (1.5, if (k / 120) % 2 == 0 { 0.5 } else { -0.5 });
        let (half, chord) = (heading + 0.5 * rate * DT_S, speed * DT_S * (1.0 - (0.5 * rate * DT_S).powi(2) / 6.0));
        (x, y, heading) = (x + chord * half.cos(), y + chord * half.sin(), wrap(heading + rate * DT_S));
        drive.truth.push([x, y, heading]);
        let noisy = |value: f64, sigma: f64, draws: &mut Noise| value + sigma * draws.normal::<f64>();
        drive.controls.push(UnicycleControl {
            speed_mps: noisy(speed * (1.0 + scale), 0.02, &mut draws),
            rate_radps: noisy(rate * (1.0 + turn_scale) + offset, 0.005, &mut draws),
        });
        let mut scan = Vec::new();
        for [east, north] in &landmarks {
            let (dx, dy) = (east - x, north - y);
            if dx.hypot(dy) < 12.0 && draws.uniform::<f64>() < 0.9 {
                let range = noisy(dx.hypot(dy), 0.05, &mut draws);
                scan.push(Vector2::new(range, wrap(noisy(dy.atan2(dx) - heading, 0.01, &mut draws))));
            }
        }
        drive.scans.push(scan);
    }
    drive
}

fn sensing() -> (RangeBearing<f64>, RangeBearingWindow<f64>, UniformClutter<f64>) {
    let window = RangeBearingWindow::full_circle(12.0, 0.9).unwrap();
    let clutter = UniformClutter::of_scan(0.1, window.measure()).unwrap();
    (RangeBearing::new(0.05, 0.01).unwrap(), window, clutter)
}

fn vehicle() -> Unicycle<f64> {
    Unicycle::new(Step::Arc, ControlNoise::white(0.02, 0.005)).unwrap()
}

/// RMSE of the position over the drive, where `step` takes in a control and a scan and tells where the vehicle is.
fn rmse(drive: &Drive, mut step: impl FnMut(&UnicycleControl<f64>, &[Vector2<f64>]) -> PlanarPose<f64>) -> f64 {
    let inputs = drive.controls.iter().zip(&drive.scans).zip(&drive.truth);
    let squares = inputs.map(|((control, scan), [x, y, _])| {
        let at = step(control, scan);
        (at.x_m - x).powi(2) + (at.y_m - y).powi(2)
    });
    (squares.sum::<f64>() / SCANS as f64).sqrt()
}

/// RMSE of the position over the drive, and the last estimate.
fn learning(drive: &Drive, sigma: OdometryCorrection<f64>) -> (f64, CalibratedPose<f64>, Symmetric<Vector6<f64>>) {
    let robot = SelfCalibrating::new(vehicle(), OdometryPrior { sigma, lasts_s: 1e9 }).unwrap();
    let (sensor, field_of_view, clutter) = sensing();
    let sensing = Sensing { sensor: Calibrated(sensor), field_of_view, clutter };
    let eyes = Detector::new(sensing, Births::of_static(0.01)).unwrap();
    let mut memory = Learning::new();
    let mut slam: JointSlam<'_, _, Vector2<f64>> = JointSlam::new(robot, JointConfig::default(), &mut memory).unwrap();
    slam.reset_within(CalibratedPose::at(PlanarPose::new(0.0, 0.0, 0.0)), &robot.prior()).unwrap();
    let off_m = rmse(drive, |control, scan| {
        slam.predict(control, DT_S).unwrap();
        slam.scan(&eyes, scan).unwrap();
        slam.estimate_pose().unwrap().mean.vehicle
    });
    let estimate = slam.estimate_pose().unwrap();
    (off_m, estimate.mean, estimate.covariance)
}

fn plain(drive: &Drive) -> (f64, PlanarPose<f64>) {
    let (sensor, field_of_view, clutter) = sensing();
    let eyes = Detector::new(Sensing { sensor, field_of_view, clutter }, Births::of_static(0.01)).unwrap();
    let mut memory = Plain::new();
    let mut slam: JointSlam<'_, _, Vector2<f64>> =
        JointSlam::new(vehicle(), JointConfig::default(), &mut memory).unwrap();
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let off_m = rmse(drive, |control, scan| {
        slam.predict(control, DT_S).unwrap();
        slam.scan(&eyes, scan).unwrap();
        slam.estimate_pose().unwrap().mean
    });
    (off_m, slam.estimate_pose().unwrap().mean)
}

const PRIOR: OdometryCorrection<f64> = OdometryCorrection { speed_scale: 0.05, turn_scale: 0.05, turn_offset: 0.02 };

#[test]
fn scale_and_offset_are_learnt() {
    let mut within = 0;
    for seed in 0..8 {
        let (scale, turn_scale, offset) = (0.05, -0.04, 0.015);
        let drive = drive(seed, scale, turn_scale, offset);
        let (off_m, estimate, covariance) = learning(&drive, PRIOR);
        let (plain_m, _) = plain(&drive);
        assert!(off_m < 0.5 * plain_m, "{seed}: {off_m} m, not learnt {plain_m} m");
        // What makes the controls right again.
        let right = [1.0 / (1.0 + scale) - 1.0, 1.0 / (1.0 + turn_scale) - 1.0, -offset / (1.0 + turn_scale)];
        let OdometryCorrection { speed_scale, turn_scale, turn_offset } = estimate.odometry;
        for (k, (found, right)) in [speed_scale, turn_scale, turn_offset].into_iter().zip(right).enumerate() {
            let sigma = covariance.get(3 + k, 3 + k).sqrt();
            assert!(sigma < 0.2 * [0.05, 0.05, 0.02][k], "{seed}: {k} is known to {sigma}");
            assert!((found - right).abs() < 4.0 * sigma, "{seed}: {k} is {found} ± {sigma}, right {right}");
            within += usize::from((found - right).abs() < 2.0 * sigma);
        }
    }
    // 95 of 100 are expected.
    assert!(within >= 20, "{within} of 24 within two standard deviations");
}

#[test]
fn where_all_is_known_it_is_the_vehicle_as_it_is() {
    let drive = drive(3, 0.0, 0.0, 0.0);
    let (off_m, estimate, _) = learning(&drive, OdometryCorrection::NONE);
    let (plain_m, pose) = plain(&drive);
    assert!((off_m - plain_m).abs() < 1e-12, "{off_m} {plain_m}");
    let PlanarPose { x_m, y_m, heading_rad } = estimate.vehicle;
    assert!((x_m - pose.x_m).hypot(y_m - pose.y_m) < 1e-12 && (heading_rad - pose.heading_rad).abs() < 1e-12);
    assert_eq!(estimate.odometry, OdometryCorrection::NONE);
}
