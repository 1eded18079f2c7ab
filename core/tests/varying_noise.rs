//! Noise that is not the same for every measurement: by range, and as a driver reports it.

use nalgebra::{Vector2, Vector3};
use scphd::models::{
    ControlNoise, Motion, PlanarPose, Pose, RangeBearing, RangeBearingWindow, ReportedNoise, Sensing, Sensor, Step,
    Unicycle, UnicycleControl, UniformClutter, WithNoise,
};
use scphd::numerics::{Noise, Symmetric, wrap};
use scphd::{Births, Config, Detector, DetectorMemory, JointConfig, JointSlam, ScPhd, joint_memory, memory};

joint_memory! { type Joint: Unicycle<f64> { measurement: Vector2<f64>, features: 40, measurements: 32 } }
memory! {
    type Particles: Unicycle<f64> { particles: 4, samples: 1, features { pages: 96, pages_per_map: 24, in_view: 256 } }
}

const DT_S: f64 = 0.1;
const RANGE_M: f64 = 20.0;
const BEARING_SIGMA_RAD: f64 = 0.05;
/// Scans before the pose has a covariance that is more than rounding.
const BEGUN: usize = 50;
const ROOM: usize = 32;

type Z = Vector2<f64>;
type R = Symmetric<Z>;

/// What a sensor measured at a time, and with what noise.
struct Seen {
    odometry: UnicycleControl<f64>,
    truth: PlanarPose<f64>,
    scan: Vec<Z>,
    noise: Vec<R>,
}

fn covariance(range_sigma_m: f64) -> R {
    Symmetric::from_diagonal([range_sigma_m * range_sigma_m, BEARING_SIGMA_RAD * BEARING_SIGMA_RAD])
}

fn by_range(z: &Z) -> R {
    covariance(0.01 + 0.08 * z.x)
}

/// Round and round a circle among landmarks; the standard deviation of a range is of its length and a number between 0 and 1.
fn drive(seed: u64, range_sigma_m: impl Fn(f64, f64) -> f64) -> Vec<Seen> {
    let mut draws = Noise::seeded(seed);
    let landmarks: Vec<[f64; 2]> = (0..20).map(|_| [0; 2].map(|_| 30.0 * (draws.uniform::<f64>() - 0.5))).collect();
    let exact = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    let mut truth = PlanarPose::new(6.0, 0.0, 0.5 * core::f64::consts::PI);
    let step = |_| {
        truth = exact.propagate(&truth, &UnicycleControl { speed_mps: 1.5, rate_radps: 0.25 }, DT_S);
        let mut odometry = |value: f64, sigma: f64| value + sigma * draws.normal::<f64>();
        let odometry = UnicycleControl { speed_mps: odometry(1.5, 0.1), rate_radps: odometry(0.25, 0.05) };
        let (mut scan, mut noise) = (Vec::new(), Vec::new());
        for [x, y] in &landmarks {
            let (dx, dy) = (x - truth.x_m, y - truth.y_m);
            let sigma_m = range_sigma_m(dx.hypot(dy), draws.uniform());
            let range = dx.hypot(dy) + sigma_m * draws.normal::<f64>();
            let bearing = wrap(dy.atan2(dx) - truth.heading_rad + BEARING_SIGMA_RAD * draws.normal::<f64>());
            if dx.hypot(dy) < RANGE_M && range > 0.0 && draws.uniform::<f64>() < 0.9 {
                scan.push(Vector2::new(range, bearing));
                noise.push(covariance(sigma_m));
            }
        }
        Seen { odometry, truth, scan, noise }
    };
    (0..600).map(step).collect()
}

fn detector<S: Sensor<Pose = PlanarPose<f64>, Measurement = Z, Frame = scphd::models::PlanarFrame<f64>>>(
    sensor: S,
) -> Detector<Sensing<S, RangeBearingWindow<f64>, UniformClutter<f64>>> {
    let window = RangeBearingWindow::full_circle(RANGE_M, 0.9).unwrap();
    let clutter = UniformClutter::of_scan(0.5, window.measure()).unwrap();
    Detector::new(Sensing { sensor, field_of_view: window, clutter }, Births::of_static(1e-3)).unwrap()
}

fn motion() -> Unicycle<f64> {
    Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05)).unwrap()
}

/// RMSE of the position, m, the mean of NEES/3, and the digest at the end.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ended {
    rmse_m: f64,
    nees: f64,
    digest: u64,
}

impl Ended {
    fn of(errors: &[Vector3<f64>], squares: &[f64], digest: u64) -> Self {
        let n = errors.len() as f64;
        let positions = errors.iter().map(|error| error.x * error.x + error.y * error.y);
        Self { rmse_m: (positions.sum::<f64>() / n).sqrt(), nees: squares.iter().sum::<f64>() / (3.0 * n), digest }
    }
}

fn joint<S>(drive: &[Seen], sensor: impl Fn(&Seen) -> S) -> Ended
where
    S: Sensor<Pose = PlanarPose<f64>, Measurement = Z, Frame = scphd::models::PlanarFrame<f64>>,
{
    let mut memory = Box::new(Joint::new());
    let mut slam: JointSlam<'_, _, Z> = JointSlam::new(motion(), JointConfig::default(), &mut memory).unwrap();
    slam.reset(PlanarPose::new(6.0, 0.0, 0.5 * core::f64::consts::PI)).unwrap();
    let (mut errors, mut squares) = (Vec::new(), Vec::new());
    for (place, seen) in drive.iter().enumerate() {
        slam.predict(&seen.odometry, DT_S).unwrap();
        slam.scan(&detector(sensor(seen)), &seen.scan).unwrap();
        let estimate = slam.estimate_pose().unwrap();
        let error = seen.truth.difference(&estimate.mean);
        if place >= BEGUN {
            squares.push(estimate.covariance.factor().unwrap().mahalanobis(&error));
            errors.push(error);
        }
    }
    Ended::of(&errors, &squares, slam.digest())
}

fn particles<S>(drive: &[Seen], sensor: impl Fn(&Seen) -> S) -> Ended
where
    S: Sensor<Pose = PlanarPose<f64>, Measurement = Z, Frame = scphd::models::PlanarFrame<f64>>,
{
    let mut memory = Box::new(Particles::new());
    let mut scratch = DetectorMemory::<Z, ROOM>::new();
    let mut eye = detector(sensor(&drive[0])).over(&mut scratch).unwrap();
    let mut slam = ScPhd::new(motion(), Config::informed(4), &mut *memory).unwrap();
    slam.reset(PlanarPose::new(6.0, 0.0, 0.5 * core::f64::consts::PI), 1).unwrap();
    let mut errors = Vec::new();
    for seen in drive {
        slam.predict(&seen.odometry, DT_S).unwrap();
        eye.adopt(detector(sensor(seen)));
        slam.scan(&mut eye, &seen.scan).unwrap();
        errors.push(seen.truth.difference(&slam.estimate_pose().unwrap().mean));
    }
    Ended::of(&errors, &[], slam.digest())
}

fn usual(range_sigma_m: f64) -> RangeBearing<f64> {
    RangeBearing::new(range_sigma_m, BEARING_SIGMA_RAD).unwrap()
}

#[test]
fn a_noise_that_is_the_same_everywhere_leaves_every_bit_as_it_was() {
    let drive = drive(1, |_, _| 0.1);
    let same = |_: &Z| *usual(0.1).noise();
    let reported =
        |seen: &Seen| ReportedNoise::<Z, ROOM>::of(&seen.scan, &vec![*usual(0.1).noise(); seen.scan.len()]).unwrap();
    // One that cannot be is that of all.
    let none = |_: &Z| Symmetric::from_diagonal([-1.0, f64::NAN]);
    let plain = joint(&drive, |_| usual(0.1));
    assert_eq!(plain, joint(&drive, |_| WithNoise { sensor: usual(0.1), noise: same }));
    assert_eq!(plain, joint(&drive, |seen| WithNoise { sensor: usual(0.1), noise: reported(seen) }));
    assert_eq!(plain, joint(&drive, |_| WithNoise { sensor: usual(0.1), noise: none }));
    let plain = particles(&drive, |_| usual(0.1)).digest;
    assert_eq!(plain, particles(&drive, |_| WithNoise { sensor: usual(0.1), noise: same }).digest);
    assert_eq!(plain, particles(&drive, |seen| WithNoise { sensor: usual(0.1), noise: reported(seen) }).digest);
}

/// Over several drives: the RMSE with the model of the noise by that with the same noise for all, and the mean of NEES/3.
fn beside(drives: &[Vec<Seen>], own: impl Fn(&[Seen]) -> Ended, same: impl Fn(&[Seen]) -> Ended) -> [f64; 2] {
    let all: Vec<[Ended; 2]> = drives.iter().map(|drive| [own(drive), same(drive)]).collect();
    let rms = |k: usize| all.iter().map(|one| one[k].rmse_m.powi(2)).sum::<f64>().sqrt();
    [rms(0) / rms(1), all.iter().map(|one| one[0].nees).sum::<f64>() / all.len() as f64]
}

#[test]
fn a_range_that_is_measured_worse_from_afar_counts_for_what_it_is_worth() {
    let drives: Vec<Vec<Seen>> = (0..12).map(|seed| drive(seed, |range_m, _| 0.01 + 0.08 * range_m)).collect();
    let lidar = |_: &Seen| WithNoise { sensor: usual(0.8), noise: by_range };
    let [ratio, nees] = beside(&drives, |drive| joint(drive, lidar), |drive| joint(drive, |_| usual(0.8)));
    assert!(ratio < 0.9 && (0.5..1.5).contains(&nees), "{ratio} {nees}");
    let [ratio, _] = beside(&drives, |drive| particles(drive, lidar), |drive| particles(drive, |_| usual(0.8)));
    assert!(ratio < 0.95, "{ratio}");
}

#[test]
fn what_a_driver_reports_with_each_measurement_counts() {
    let drives: Vec<Vec<Seen>> =
        (0..12).map(|seed| drive(seed, |_, draw| if draw < 0.5 { 0.03 } else { 0.8 })).collect();
    let radar = |seen: &Seen| {
        let noise = ReportedNoise::<Z, ROOM>::of(&seen.scan, &seen.noise).unwrap();
        WithNoise { sensor: usual(0.5), noise }
    };
    let [ratio, nees] = beside(&drives, |drive| joint(drive, radar), |drive| joint(drive, |_| usual(0.57)));
    assert!(ratio < 0.95 && (0.5..1.5).contains(&nees), "{ratio} {nees}");
    let [ratio, _] = beside(&drives, |drive| particles(drive, radar), |drive| particles(drive, |_| usual(0.57)));
    assert!(ratio < 0.95, "{ratio}");
}

#[test]
fn covariances_that_cannot_be_are_refused() {
    let z = Vector2::new(5.0, 0.1);
    let refused = |z: &[Z], r: &[R]| ReportedNoise::<Z, 2>::of(z, r).unwrap_err().field;
    assert_eq!(refused(&[z, z, z], &[covariance(0.1); 3]), "covariances");
    assert_eq!(refused(&[z], &[]), "covariances");
    assert_eq!(refused(&[z], &[covariance(0.0)]), "covariances");
    let sensor = WithNoise { sensor: usual(0.3), noise: ReportedNoise::<Z, 2>::default() };
    assert_eq!(sensor.noise_of(&z, &z), None);
    // Across the seam, the nearer one by its own standard deviations.
    let [behind, far] = [Vector2::new(5.0, -3.13), Vector2::new(5.5, 3.1)];
    let noise = ReportedNoise::<Z, 2>::of(&[behind, far], &[covariance(0.1), covariance(2.0)]).unwrap();
    let sensor = WithNoise { sensor: usual(0.3), noise };
    assert_eq!(sensor.noise_of(&Vector2::new(5.0, 3.13), &Vector2::new(5.0, 3.13)), Some(covariance(0.1)));
    assert_eq!(sensor.noise_of(&Vector2::new(5.4, 3.11), &Vector2::new(5.4, 3.11)), Some(covariance(2.0)));
}
