//! A robot with a black box. Its filter is built from a description, and drives past posts with two lidars and a satellite receiver;
//! one lidar is retuned during the drive. All inputs are recorded, and after every 50th scan a snapshot in small slices. Then parts
//! of the recording are removed, and the rest is replayed on the host: the filter ends in the state of the robot's filter, to the
//! bit.
//!
//!     cargo run -p scphd-stream --example black_box

use nalgebra::Vector2;
use scphd::Births;
use scphd::models::{ControlNoise, Motion, PlanarPose, Step, Unicycle, UnicycleControl};
use scphd::numerics::{Noise, wrap};
use scphd::snapshot::into_slice;
use scphd_stream::planar::{BlackBoxJoint, Fix, Odometry, Planar};
use scphd_stream::{
    Aboard, Header, Monitor, Part, Scalar, ScanCost, Seen, Which, Writer, find_whole_snapshot, recover,
};
use scphd_vehicle::sets::Joint40;
use scphd_vehicle::{Backing, Control, Description, FixSpec, Measurements, Sensor, Services, Slam};
use std::convert::Infallible;

/// Maximum number of bytes of a snapshot.
const SNAPSHOT: usize = 16 * 1024;
/// Number of bytes of a snapshot that are recorded after a scan, which the flash can write before the next.
const SLICE: usize = 700;
const SCANS: usize = 330;
const SNAPSHOT_EVERY: usize = 50;
const DT_S: f32 = 0.1;
/// Standard deviation of the positions, m, and their gate.
const FIX: (f32, f32) = (0.5, f32::INFINITY);

/// The recording, and the digest after every scan.
type Driven = (Vec<u8>, Vec<(u32, u64)>);

/// The robot: its odometry, two lidars, the second of which is rotated to the left, and positions.
fn robot() -> Description<f32> {
    let mut front = Sensor::range_bearing(12.0, 0.9375, [0.125, 0.015_625]);
    front.window.bearing_half_width_rad = 1.5;
    front.window.probability_far = 0.875;
    front.clutter_per_scan = 0.5;
    front.births = Births::of_static(0.005);
    front.seat_m = [0.5, 0.0];
    let mut robot = Description::robot();
    robot.vehicle.noise = ControlNoise::white(0.1, 0.05);
    robot.sensors[0] = Some(front);
    robot.sensors[1] = Some(Sensor { yaw_rad: 1.5, ..front });
    robot.position = Some(FixSpec { gate: FIX.1, ..FixSpec::of_sigma(FIX.0) });
    robot
}

/// The measurements of a lidar at this pose.
fn seen(pose: &PlanarPose<f32>, sensor: &Sensor<f32>, draws: &mut Noise) -> Vec<[f32; 2]> {
    let posts = (0..24).map(|k| {
        let angle = 0.7 * k as f32;
        [(6.0 + (k % 5) as f32) * angle.cos(), 4.0 + (6.0 + (k % 7) as f32) * angle.sin()]
    });
    let heading = pose.heading_rad;
    let (forward, yaw) = (sensor.seat_m[0], sensor.yaw_rad);
    let eye = [pose.x_m + forward * heading.cos(), pose.y_m + forward * heading.sin()];
    let measured = posts.filter_map(|[x, y]| {
        let (dx, dy) = (x - eye[0], y - eye[1]);
        let (range, bearing) = (dx.hypot(dy), wrap(dy.atan2(dx) - heading - yaw));
        let in_view = range < sensor.window.range_max_m && bearing.abs() < sensor.window.bearing_half_width_rad;
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
    let mut robot = robot();
    let second = Which::number(1).ok_or("a vehicle in the plane has four")?;

    // On a robot the recording is in a ring of flash, and the filter's memory a static.
    let mut bytes = Vec::new();
    let mut log = Writer::start(&Header::of(&robot, Scalar::F32)?, |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), Infallible>(())
    })?;
    let mut memory = Box::new(Joint40::new());
    let mut slam = memory.start(&robot)?;
    slam.reset(&robot.start)?;

    // The snapshot that is being recorded: a static on a robot.
    let mut saved = [0; SNAPSHOT];
    let mut pending = 0..0;
    let (mut truth, mut draws, mut digests) = (PlanarPose::new(0.0, 0.0, 0.0), Noise::seeded(7), Vec::new());
    let exact = Unicycle::new(Step::Arc, ControlNoise::NONE)?;
    for scan in 0..SCANS {
        let control = UnicycleControl { speed_mps: 1.0_f32, rate_radps: 0.25 };
        truth = exact.propagate(&truth, &control, DT_S);
        let speed_mps = control.speed_mps + 0.1 * draws.normal::<f32>();
        let control = Control { speed_mps, turn: control.rate_radps, ..Control::STILL };
        // First recorded, then passed to the filter, so that refused inputs are recorded too.
        log.predict(&Odometry::of(control, DT_S))?;
        slam.predict(control, DT_S)?;

        if scan % 25 == 24 {
            let place = [truth.x_m + 0.1, truth.y_m];
            let ((sigma_m, gate), place_m) = (FIX, place.map(f64::from));
            let (sigma_m, gate) = (f64::from(sigma_m), f64::from(gate));
            log.fix(&Fix::Position { place_m, sigma_m, gate, antenna_m: [0.0; 2] })?;
            slam.observe_position(place[0], place[1])?;
        }
        if let (120, Some(left)) = (scan, &mut robot.sensors[1]) {
            // Rain: more false measurements, and a smaller probability of detection.
            (left.clutter_per_scan, left.window.probability_far) = (4.0, 0.5);
            let numbers = left.numbers();
            slam.configure(&robot)?;
            log.detector(second, &numbers)?;
        }

        let which = scan % 2;
        let measured = robot.sensors[which].map_or(Vec::new(), |lidar| seen(&truth, &lidar, &mut draws));
        let of_box: Vec<[f64; 2]> = measured.iter().map(|z| z.map(f64::from)).collect();
        log.scan_of([Which::FIRST, second][which], &of_box)?;
        let measured: Vec<Vector2<f32>> = measured.into_iter().map(Vector2::from).collect();
        slam.scan(which, Measurements::RangeBearing(&measured))?;
        digests.push((scan as u32, slam.digest()));

        if (scan + 1) % SNAPSHOT_EVERY == 0 {
            // The present state, saved to RAM.
            pending = 0..slam.save(1, &mut into_slice(&mut saved))?;
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
