//! A robot with a black box. Its own filter, which is not one of this crate's, drives past posts with two lidars and a satellite
//! receiver; one lidar is retuned during the drive. All inputs are recorded, and after every 50th scan a snapshot in small
//! slices. Then parts of the recording are removed, and the rest is replayed on the host: the filter ends in the state of the
//! robot's filter, to the bit.
//!
//!     cargo run -p scphd-stream --example black_box

use nalgebra::Vector2;
use scphd::models::{
    ControlNoise, Mounting, PlanarPose, PositionFix, RangeBearing, RangeBearingLimits, RangeBearingWindow, Sensing,
    Step, Unicycle, UnicycleControl, UniformClutter,
};
use scphd::numerics::{Noise, wrap};
use scphd::settings::HypothesesConfig;
use scphd::snapshot::into_slice;
use scphd::{Births, Detector, JointConfig, JointSlam, joint_memory};
use scphd_stream::planar::{BlackBoxJoint, Fix, Models, Odometry, Planar, Sensor, SensorModels, Vehicle};
use scphd_stream::{
    Aboard, Header, Joint, Monitor, Numbers, Part, Recursion, Scalar, ScanCost, Seen, Which, Writer,
    find_whole_snapshot, recover,
};
use std::convert::Infallible;

joint_memory! {
    /// The state of the robot's filter. The filter of the replay has a capacity of 64 features: the capacity has no effect while
    /// no feature is left out.
    type RobotMap: Unicycle<f32> { measurement: Vector2<f32>, features: 40, measurements: 32 }
}
/// Maximum number of bytes of a snapshot.
const SNAPSHOT: usize = 16 * 1024;
/// Number of bytes of a snapshot that are recorded after a scan, which the flash can write before the next.
const SLICE: usize = 700;
const SCANS: usize = 330;
const SNAPSHOT_EVERY: usize = 50;
const DT_S: f32 = 0.1;

/// The numbers of the models, used by the filter and recorded in the head. They are in single precision in flight and in records,
/// and in double precision in the head; all are exact in single precision.
const TURN_SIGMA: f32 = 0.05;
const SPEED_SIGMA: f32 = 0.1;
const BIRTHS: f32 = 0.005;

/// The front lidar; the other one is rotated to the left.
fn lidar() -> Sensor {
    let models = SensorModels {
        mounted_forward_m: 0.5,
        range_sigma_m: 0.125,
        bearing_sigma_rad: 0.015625,
        range_max_m: 12.0,
        bearing_half_width_rad: 1.5,
        detection_near: 0.9375,
        detection_far: 0.875,
        clutter_per_scan: 0.5,
        ..SensorModels::ZERO
    };
    Sensor { models, birth_intensity: f64::from(BIRTHS), ..Sensor::ZERO }
}

/// Models of a lidar.
type Lidar = Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;
/// The recording, and the digest after every scan.
type Driven = (Vec<u8>, Vec<(u32, u64)>);

/// A detector of the robot with these numbers.
fn detector(
    Sensor { models: sensor, birth_intensity, .. }: &Sensor,
) -> Result<Detector<Lidar>, scphd::models::ModelError> {
    let single = |number: f64| number as f32;
    let field_of_view = RangeBearingWindow::new(RangeBearingLimits {
        range_min_m: single(sensor.range_min_m),
        range_max_m: single(sensor.range_max_m),
        range_edge_m: single(sensor.range_edge_m),
        bearing_center_rad: single(sensor.bearing_center_rad),
        bearing_half_width_rad: single(sensor.bearing_half_width_rad),
        bearing_edge_rad: single(sensor.bearing_edge_rad),
        probability_near: single(sensor.detection_near),
        probability_far: single(sensor.detection_far),
    })?;
    let sensing = Sensing {
        sensor: RangeBearing::new(single(sensor.range_sigma_m), single(sensor.bearing_sigma_rad))?,
        field_of_view,
        clutter: UniformClutter::of_scan(single(sensor.clutter_per_scan), field_of_view.measure())?,
    };
    let seat = Mounting::in_plane(
        single(sensor.mounted_forward_m),
        single(sensor.mounted_left_m),
        single(sensor.mounted_yaw_rad),
    )?;
    Detector::new(sensing, Births::of_static(single(*birth_intensity)))?.mounted(seat)
}

/// The head of the recording: all parameters of the filter.
fn head(front: &Sensor) -> Header<Planar> {
    Header {
        scalar: Scalar::F32,
        vehicle: Vehicle::UnicycleArc,
        models: Models {
            speed_sigma_mps: f64::from(SPEED_SIGMA),
            turn_sigma: f64::from(TURN_SIGMA),
            noise_interval_s: 0.0,
            sensor: front.models,
            ..Models::ZERO
        },
        recursion: Recursion { birth_intensity: front.birth_intensity, ..Recursion::ZERO },
        joint: Joint::of(&JointConfig::<f32>::default(), &HypothesesConfig::default()),
        scan_interval_s: f64::from(DT_S),
        ..Header::EMPTY
    }
}

/// The measurements of a lidar at this pose.
fn seen(pose: &PlanarPose<f32>, sensor: &SensorModels, draws: &mut Noise) -> Vec<[f32; 2]> {
    let posts = (0..24).map(|k| {
        let angle = 0.7 * k as f32;
        [(6.0 + (k % 5) as f32) * angle.cos(), 4.0 + (6.0 + (k % 7) as f32) * angle.sin()]
    });
    let heading = pose.heading_rad;
    let (forward, yaw) = (sensor.mounted_forward_m as f32, sensor.mounted_yaw_rad as f32);
    let eye = [pose.x_m + forward * heading.cos(), pose.y_m + forward * heading.sin()];
    let measured = posts.filter_map(|[x, y]| {
        let (dx, dy) = (x - eye[0], y - eye[1]);
        let (range, bearing) = (dx.hypot(dy), wrap(dy.atan2(dx) - heading - yaw));
        let in_view = range < sensor.range_max_m as f32 && bearing.abs() < sensor.bearing_half_width_rad as f32;
        let noise: [f32; 2] = [0.1 * draws.normal::<f32>(), 0.015 * draws.normal::<f32>()];
        (in_view && draws.uniform::<f32>() < 0.9).then(|| [range + noise[0], wrap(bearing + noise[1])])
    });
    measured.take(32).collect()
}

/// The digest after every scan.
#[derive(Default)]
struct Digests {
    all: Vec<(u32, u64)>,
    disagree: usize,
}

impl Monitor for Digests {
    fn scanned(&mut self, cost: &ScanCost, _: &Seen, digest: u64) {
        self.all.push((cost.scan, digest));
    }

    fn snapshot(&mut self, _: u32, agrees: bool) {
        self.disagree += usize::from(!agrees);
    }
}

/// Drives and records. Returns the recording and the digest after every scan.
fn drive() -> Result<Driven, Box<dyn std::error::Error>> {
    let front = lidar();
    let left = Sensor { models: SensorModels { mounted_yaw_rad: 1.5, ..front.models }, ..front };
    let head = head(&front);
    let second = Which::number(1).ok_or("a vehicle in the plane has four")?;

    // On a robot the recording is in a ring of flash.
    let mut bytes = Vec::new();
    let mut log = Writer::start(&head, |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), Infallible>(())
    })?;
    log.detector(second, &left)?;

    let motion = Unicycle::new(Step::Arc, ControlNoise::white(SPEED_SIGMA, TURN_SIGMA))?;
    let mut state = Box::new(RobotMap::new());
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
    let mut lidars = [detector(&front)?, detector(&left)?];
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0))?;

    // The snapshot that is being recorded: a static on a robot.
    let mut saved = [0; SNAPSHOT];
    let mut pending = 0..0;
    let (mut truth, mut draws, mut digests) = (PlanarPose::new(0.0, 0.0, 0.0), Noise::seeded(7), Vec::new());
    let exact = Unicycle::new(Step::Arc, ControlNoise::NONE)?;
    for scan in 0..SCANS {
        let control = UnicycleControl { speed_mps: 1.0_f32, rate_radps: 0.25 };
        truth = scphd::models::Motion::propagate(&exact, &truth, &control, DT_S);
        let control = UnicycleControl { speed_mps: control.speed_mps + 0.1 * draws.normal::<f32>(), ..control };
        // First recorded, then passed to the filter, so that refused inputs are recorded too.
        let of_box = [control.speed_mps, control.rate_radps].map(f64::from);
        log.predict(&Odometry { control: of_box, dt_s: f64::from(DT_S) })?;
        slam.predict(&control, DT_S)?;

        if scan % 25 == 24 {
            let place = [truth.x_m + 0.1, truth.y_m];
            let place_m = place.map(f64::from);
            log.fix(&Fix::Position { place_m, sigma_m: 0.5, gate: f64::INFINITY, antenna_m: [0.0; 2] })?;
            slam.observe(&PositionFix::new(0.5)?, &Vector2::from(place))?;
        }
        if scan == 120 {
            // Rain: more false measurements, and a smaller probability of detection.
            let models = SensorModels { clutter_per_scan: 4.0, detection_far: 0.5, ..left.models };
            let rainy = Sensor { models, ..left };
            log.detector(second, &rainy)?;
            lidars[1].adopt(detector(&rainy)?);
        }

        let which = scan % 2;
        let measured = seen(&truth, &[front, left][which].models, &mut draws);
        let of_box: Vec<[f64; 2]> = measured.iter().map(|z| z.map(f64::from)).collect();
        log.scan_of([Which::FIRST, second][which], &of_box)?;
        let measured: Vec<Vector2<f32>> = measured.into_iter().map(Vector2::from).collect();
        slam.scan(&lidars[which], &measured)?;
        digests.push((scan as u32, slam.digest()));

        if (scan + 1) % SNAPSHOT_EVERY == 0 {
            // The present state, saved to RAM.
            pending = 0..slam.save(1, into_slice(&mut saved))?;
            log.snapshot(&[Part::Filter], slam.digest())?;
        }
        // From there a slice is recorded after every scan.
        let slice = pending.start..pending.end.min(pending.start + SLICE);
        if !slice.is_empty() {
            log.slice(Part::Filter, &saved[slice.clone()])?;
            pending.start = slice.end;
        }
    }
    log.end()?;
    Ok((bytes, digests))
}

/// Drives, removes parts of the recording, and replays the rest.
///
/// # Errors
/// Those that a robot would have, too.
pub fn run() -> Result<(), Box<dyn std::error::Error>> {
    let (bytes, driven) = drive()?;
    println!("{} scans in {} bytes", driven.len(), bytes.len());
    let mut memory = Box::new(<BlackBoxJoint as Aboard<f32>>::MEMORY);
    let mut replayed = 0;
    for torn in (0..bytes.len()).step_by(bytes.len() / 9) {
        let left = &bytes[torn..];
        // Behind the last snapshot there is no start point.
        if torn > 0 && find_whole_snapshot::<Planar>(left, 0).is_none() {
            break;
        }
        let mut digests = Digests::default();
        let recovered = recover::<BlackBoxJoint, f32>(left, &mut memory, &mut digests)?;
        assert!(recovered.ended && digests.disagree == 0, "an input is missing in the box");
        assert!(driven.ends_with(&digests.all), "torn at {torn}");
        println!("torn at byte {torn}: scan {} to the end, the same states", digests.all[0].0);
        replayed += 1;
    }
    assert!(replayed > 5);
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run()
}
