//! What either filter reports of a vehicle that is carried away, told where it is, and left without scans.

use super::world::{DT_S, Setting, Trouble, World};
use super::{JointMemory, MEASUREMENTS, Mixture};
use nalgebra::Vector2;
use scphd::models::{
    ControlNoise, PlanarPose, Pose, RangeBearing, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl,
    UniformClutter,
};
use scphd::numerics::Symmetric;
use scphd::snapshot::{from_slice, into_slice};
use scphd::{Births, Config, Detector, DetectorMemory, Health, JointConfig, JointSlam, ScPhd};

const DT: f32 = DT_S as f32;

type Lidar = Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;

fn lidar() -> Detector<Lidar> {
    let window = Setting::ALL[0].stated_window();
    let sensing = Sensing::range_bearing([0.1, 0.015], window, 2.0).unwrap();
    Detector::new(sensing, Births::of_static(sensing.clutter.intensity())).unwrap()
}

fn motion() -> Unicycle<f32> {
    Unicycle::new(Step::Arc, ControlNoise::white(0.15, 0.05)).unwrap()
}

fn control(world: &mut World) -> UnicycleControl<f32> {
    let [speed, rate] = world.go();
    UnicycleControl { speed_mps: speed as f32, rate_radps: rate as f32 }
}

/// Where it is, to some centimetres and a degree.
fn about() -> Symmetric<nalgebra::Vector3<f32>> {
    Symmetric::from_diagonal([0.01, 0.01, 0.0003])
}

#[test]
fn a_joint_map() {
    let mut world = World::new(Setting::ALL[0], Trouble::NONE, 1);
    let eyes = lidar();
    let mut state = Box::new(JointMemory::new());
    let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    slam.reset(PlanarPose::ZERO).unwrap();
    let mut sums = [0.0; 2];
    for scan in 0..200 {
        slam.predict(&control(&mut world), DT).unwrap();
        let report = slam.scan(&eyes, &world.look()).unwrap();
        assert!(report.expected_detections <= report.in_view as f32 && report.detections <= report.measurements as f32);
        if scan >= 50 {
            sums = [sums[0] + report.expected_detections, sums[1] + report.detections];
        }
    }
    assert!((sums[1] / sums[0] - 1.0).abs() < 0.1 && sums[0] > 150.0 * 5.0, "{sums:?}");

    // Left without scans.
    let still = UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 };
    let waiting: Vec<bool> =
        (0..12).map(|_| slam.predict(&still, DT).unwrap().health.contains(Health::INPUT_LOST)).collect();
    assert!(matches!(waiting.iter().position(|&lost| lost), Some(7 | 8)), "eight times 0.2 s: {waiting:?}");
    slam.scan(&eyes, &world.look()).unwrap();

    // Carried away: a filter that goes on from a snapshot finds out at the same scan.
    world.carry_away();
    let (mut bytes, mut elsewhere) = (vec![0; 200_000], Box::new(JointMemory::new()));
    let mut twin = JointSlam::new(motion(), JointConfig::default(), &mut *elsewhere).unwrap();
    let mut healths = Vec::new();
    for scan in 0..20 {
        let (go, look) = (control(&mut world), world.look());
        if scan == 1 {
            let len = slam.save(1, into_slice(&mut bytes)).unwrap();
            twin.restore(1, from_slice(&bytes[..len])).unwrap();
        }
        slam.predict(&go, DT).unwrap();
        let report = slam.scan(&eyes, &look).unwrap();
        healths.push(report.health);
        if scan >= 1 {
            twin.predict(&go, DT).unwrap();
            assert_eq!(twin.scan(&eyes, &look), Ok(report));
        }
    }
    assert!(healths[0].bits() & Health::LOST.bits() == 0 && healths[19].contains(Health::LOST), "{healths:?}");

    // Told where it is.
    let [x, y, heading] = world.pose().map(|coordinate| coordinate as f32);
    slam.relocate(PlanarPose::new(x, y, heading), &about()).unwrap();
    for _ in 0..40 {
        slam.predict(&control(&mut world), DT).unwrap();
        let health = slam.scan(&eyes, &world.look()).unwrap().health;
        assert!(!health.contains(Health::LOST) && !health.contains(Health::DIVERGENCE_SUSPECTED), "{health:?}");
    }
}

#[test]
fn a_mixture() {
    let mut world = World::new(Setting::ALL[0], Trouble::NONE, 1);
    let mut scratch = DetectorMemory::<Vector2<f32>, MEASUREMENTS>::new();
    let mut eyes = lidar().over(&mut scratch).unwrap();
    let mut state = Box::new(Mixture::new());
    let mut slam = ScPhd::new(motion(), Config::informed(4), &mut *state).unwrap();
    slam.reset(PlanarPose::ZERO, 1).unwrap();
    for _ in 0..200 {
        slam.predict(&control(&mut world), DT).unwrap();
        slam.scan(&mut eyes, &world.look()).unwrap();
    }
    let still = UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 };
    let waiting: Vec<bool> =
        (0..12).map(|_| slam.predict(&still, DT).unwrap().health.contains(Health::INPUT_LOST)).collect();
    assert!(matches!(waiting.iter().position(|&lost| lost), Some(7 | 8)), "{waiting:?}");
    slam.scan(&mut eyes, &world.look()).unwrap();

    world.carry_away();
    let mut lost = false;
    for _ in 0..20 {
        slam.predict(&control(&mut world), DT).unwrap();
        lost |= slam.scan(&mut eyes, &world.look()).unwrap().health.contains(Health::LOST);
    }
    assert!(lost);
    let [x, y, heading] = world.pose().map(|coordinate| coordinate as f32);
    slam.relocate(PlanarPose::new(x, y, heading), &about()).unwrap();
    for _ in 0..40 {
        slam.predict(&control(&mut world), DT).unwrap();
        let health = slam.scan(&mut eyes, &world.look()).unwrap().health;
        assert!(!health.contains(Health::LOST) && !health.contains(Health::DIVERGENCE_SUSPECTED), "{health:?}");
    }
}

#[test]
fn a_surveyed_map_is_known_at_once() {
    let mut world = World::new(Setting::ALL[0], Trouble::NONE, 1);
    let mut scratch = DetectorMemory::<Vector2<f32>, MEASUREMENTS>::new();
    let mut eyes = lidar().over(&mut scratch).unwrap();
    let mut state = Box::new(Mixture::new());
    let mut slam = ScPhd::new(motion(), Config::informed(4), &mut *state).unwrap();
    let map = world.map();
    // Not where the vehicle is.
    slam.reset(PlanarPose::new(5.0, 4.0, 2.0), 1).unwrap();
    slam.load_map(&map).unwrap();
    let mut lost = false;
    for _ in 0..20 {
        slam.predict(&control(&mut world), DT).unwrap();
        lost |= slam.scan(&mut eyes, &world.look()).unwrap().health.contains(Health::LOST);
    }
    assert!(lost);
}
