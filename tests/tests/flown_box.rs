//! The black box of a filter that was built from a description replays to the bits that it had on the vehicle.

use nalgebra::Vector2;
use scphd::numerics::{Noise, wrap};
use scphd::settings::MovingConfig;
use scphd::{Births, JointConfig};
use scphd_stream::planar::{self, BlackBoxArchive, BlackBoxMovers, Odometry};
use scphd_stream::{Header, How, Scalar, Writer};
use scphd_tests::with_roomy_stack;
use scphd_vehicle::{
    Backing, Control, Description, Filter, FixSpec, JointSettings, Measurements, Sensor, Services, Slam, joint_backing,
};
use std::convert::Infallible;

use crate::black_box::{ends_alike_from_every_snapshot, recorded, replayed};

joint_backing! {
    /// A joint map with tracks and an archive.
    struct Flown: PlanarPose<f32> { features: 64, measurements: 64, movers: 64, archived: 256 }
}

const SCANS: usize = 300;
const DT_S: f32 = 0.1;
/// Range of the lidar, m.
const RANGE_M: f32 = 12.0;
/// Standard deviations of range, m, and bearing, rad.
const SIGMAS: [f32; 2] = [0.1, 0.01];
/// Mean number of false measurements in a scan.
const CLUTTER: f32 = 2.0;
/// Standard deviation of the positions, m, and their gate.
const FIX: (f32, f32) = (0.5, 9.0);
/// After this number of scans the vehicle is carried away by some metres, which its odometry does not measure.
const CARRIED: usize = 150;

/// The vehicle: the strict map, tracks, archive, and positions with a monitor.
fn description() -> Description<f32> {
    let mut lidar = Sensor::range_bearing(RANGE_M, 0.9, SIGMAS);
    lidar.clutter_per_scan = CLUTTER;
    lidar.births = Births { of_static: 1e-3, of_moving: 1e-3 };
    let joint = JointSettings {
        config: JointConfig::strict(),
        movers: Some(MovingConfig::walkers()),
        archive_reach_m: Some(RANGE_M),
        ..JointSettings::default()
    };
    let mut robot = Description { filter: Filter::Joint(joint), ..Description::robot() };
    robot.sensors[0] = Some(lidar);
    robot.position = Some(FixSpec { gate: FIX.1, watch: Some(Default::default()), ..FixSpec::of_sigma(FIX.0) });
    robot
}

/// Detections of posts along a circle, some with clutter, from a true pose.
fn seen([x, y, heading]: [f32; 3], draws: &mut Noise) -> Vec<[f32; 2]> {
    let posts = (0..150).map(|k| {
        let (angle, radius) = (std::f32::consts::TAU * k as f32 / 150.0, 30.0 + 3.0 * (k % 5) as f32);
        [radius * angle.sin(), 25.0 - radius * angle.cos()]
    });
    let near = posts.map(|[u, v]| [(u - x).hypot(v - y), wrap((v - y).atan2(u - x) - heading)]);
    let mut scan: Vec<[f32; 2]> =
        near.filter(|[range, _]| *range < RANGE_M - 0.5 && draws.uniform::<f32>() < 0.9).collect();
    for measured in &mut scan {
        measured[0] += SIGMAS[0] * draws.normal::<f32>();
        measured[1] = wrap(measured[1] + SIGMAS[1] * draws.normal::<f32>());
    }
    for _ in 0..CLUTTER as usize {
        scan.push([RANGE_M * draws.uniform::<f32>().sqrt(), wrap(std::f32::consts::TAU * draws.uniform::<f32>())]);
    }
    scan
}

/// Drives with the vehicle's filter, and records what a vehicle records. Returns the recording, the digest after every scan, and
/// the numbers of relocations and of archived features.
fn flown() -> (Vec<u8>, Vec<(u32, u64)>, [usize; 2]) {
    let robot = description();
    let mut memory = Box::new(Flown::new());
    let mut slam = memory.start(&robot).unwrap();
    slam.reset(&robot.start).unwrap();
    let (mut bytes, mut digests, mut counts) = (Vec::new(), Vec::new(), [0; 2]);
    let sink = |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), Infallible>(())
    };
    let Ok(mut log) = Writer::start(&Header::of(&robot, Scalar::F32).unwrap(), sink);
    let mut draws = Noise::seeded(7);
    let (mut true_pose, speed, rate) = ([0.0_f32; 3], 4.0_f32, 4.0_f32 / 25.0);
    for scan in 0..SCANS {
        true_pose[2] = wrap(true_pose[2] + rate * DT_S);
        true_pose[0] += speed * DT_S * true_pose[2].cos();
        true_pose[1] += speed * DT_S * true_pose[2].sin();
        if scan == CARRIED {
            true_pose[0] += 9.0;
            true_pose[1] -= 7.0;
        }
        let [speed, rate] = [speed + 0.1 * draws.normal::<f32>(), rate + 0.01 * draws.normal::<f32>()];
        let control = Control { speed_mps: speed, turn: rate, ..Control::STILL };
        slam.predict(control, DT_S).unwrap();
        let Ok(()) = log.predict(&Odometry::of(control, DT_S));
        if scan % 10 == 9 {
            let place = [0, 1].map(|k| true_pose[k] + 0.3 * draws.normal::<f32>());
            let watched = slam.watch_position(place[0], place[1]).unwrap();
            let Ok(()) = log.fix(&planar::Fix::Position {
                place_m: place.map(f64::from),
                sigma_m: f64::from(FIX.0),
                gate: f64::from(FIX.1),
                antenna_m: [0.0; 2],
            });
            // The recording has no monitor: a vehicle records what its monitor decided.
            if watched.relocated {
                counts[0] += 1;
                let pose = slam.pose().unwrap();
                let Ok(()) = log.place(How::Relocate, &pose.mean, &pose.covariance, 0);
            }
        }
        let measured = seen(true_pose, &mut draws);
        let scan_of: Vec<Vector2<f32>> = measured.iter().map(|&z| z.into()).collect();
        let scphd_vehicle::Scanned::Joint(report) = slam.scan(0, Measurements::RangeBearing(&scan_of)).unwrap() else {
            unreachable!()
        };
        counts[1] = counts[1].max(report.archived);
        let measured: Vec<[f64; 2]> = measured.iter().map(|z| z.map(f64::from)).collect();
        let Ok(()) = log.scan(&measured);
        digests.push((scan as u32, slam.digest()));
    }
    let Ok(()) = log.end();
    (bytes, digests, counts)
}

#[test]
fn a_strict_map_with_tracks_archive_and_watch_replays_as_it_flew() {
    with_roomy_stack(|| {
        let (bytes, digests, [relocations, archived]) = flown();
        assert!(relocations > 0 && archived > 0, "{relocations} relocations, {archived} archived");
        assert_eq!(replayed::<BlackBoxArchive, f32>(&bytes).unwrap().1.digests, digests);
        let with_snapshots = recorded::<BlackBoxArchive, f32>(&bytes, 50);
        assert_eq!(ends_alike_from_every_snapshot::<BlackBoxArchive, f32>(&with_snapshots, 50).digests, digests);
        // A memory without the archive is not for this recording.
        let refused = replayed::<BlackBoxMovers, f32>(&bytes).unwrap_err().to_string();
        assert_eq!(refused, "the filter refuses the stream header: the memory is not for what joint.archive says");
    });
}
