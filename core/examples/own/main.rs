//! A vehicle and a sensor that the library does not have: a robot on mecanum wheels (`mecanum.rs`) with a scanner of reflectors
//! (`reflectors.rs`), by either filter.

mod mecanum;
mod reflectors;

use mecanum::Mecanum;
use nalgebra::{Vector2, Vector3};
use reflectors::{Scanner, Square};
use scphd::models::{Motion, PlanarPose, Pose, Sensing, Sensor, UniformClutter};
use scphd::numerics::{Noise, Symmetric};
use scphd::{Births, Config, Detector, DetectorMemory, JointConfig, JointSlam, ScPhd, joint_memory, memory};

memory! {
    type Mixture: Mecanum { particles: 4, samples: 1, features { pages: 96, pages_per_map: 24, in_view: 256 } }
}
joint_memory! { type Map: Mecanum { measurement: Vector2<f32>, features: 48, measurements: 32 } }

const SIDE_M: f32 = 12.0;
const SIGMA_M: f32 = 0.05;
const DT_S: f32 = 0.1;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let area = SIDE_M * SIDE_M;
    let scanner = Scanner(Symmetric::from_diagonal([SIGMA_M * SIGMA_M; 2]));
    let clutter = UniformClutter::of_scan(1.0, area)?;
    let models = Sensing { sensor: scanner, field_of_view: Square(SIDE_M), clutter };
    let mut room = DetectorMemory::<Vector2<f32>, 32>::new();
    let mut detector = Detector::new(models, Births::of_static(0.1 / area))?.over(&mut room)?;

    let robot = Mecanum { shares: [0.05, 0.15, 0.1] };
    let (mut mixture, mut map) = (Box::new(Mixture::new()), Box::new(Map::new()));
    let mut mixture = ScPhd::new(robot, Config::informed(4), &mut *mixture)?;
    let mut joint = JointSlam::new(robot, JointConfig::default(), &mut *map)?;
    let mut truth = PlanarPose::new(6.0, 0.0, 0.0);
    mixture.reset(truth, 1)?;
    joint.reset(truth)?;

    let mut draws = Noise::seeded(7);
    let reflectors: Vec<[f32; 2]> = (0..30).map(|_| [(); 2].map(|()| 24.0 * draws.uniform::<f32>() - 12.0)).collect();
    let mut told = truth;
    for step in 0..1200 {
        // Around the room sideways, while it turns slowly. Rollers slip by a tenth aside.
        let way = 0.1 * DT_S * step as f32;
        let moves = Vector3::new(-0.6 * (way - truth.heading_rad).sin(), 0.6 * (way - truth.heading_rad).cos(), 0.05);
        truth = robot.propagate(&truth, &moves, DT_S);
        let odometry = moves.component_mul(&Vector3::new(1.02, 1.1, 1.05));
        told = robot.propagate(&told, &odometry, DT_S);
        mixture.predict(&odometry, DT_S)?;
        joint.predict(&odometry, DT_S)?;

        let frame = scanner.frame(&truth);
        let mut scan = Vec::new();
        for [x, y] in &reflectors {
            let seen = scanner.expect(&frame, &Vector2::new(*x, *y)).ok_or("unseen")?.measurement;
            let in_view = (0.0..SIDE_M).contains(&seen.x) && seen.y.abs() < 0.5 * SIDE_M;
            if in_view && draws.uniform::<f32>() < 0.9 {
                scan.push(seen + SIGMA_M * Vector2::new(draws.normal(), draws.normal()));
            }
        }
        scan.push(SIDE_M * Vector2::new(draws.uniform(), draws.uniform::<f32>() - 0.5));
        mixture.scan(&mut detector, &scan)?;
        joint.scan(&detector, &scan)?;
    }
    let off =
        |pose: Option<scphd::PoseEstimate<PlanarPose<f32>>>| pose.map_or(f32::INFINITY, |p| p.mean.distance_m(&truth));
    let (by_mixture, by_joint, lost) =
        (off(mixture.estimate_pose()), off(joint.estimate_pose()), told.distance_m(&truth));
    println!(
        "after two minutes {by_mixture:.2} m off by the mixture, {by_joint:.2} m by the joint map; dead reckoning {lost:.2} m"
    );
    assert!(by_mixture < 0.3 && by_joint < 0.3 && lost > 1.0);
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}

/// Whoever writes a model asks differences whether its derivatives are right.
#[test]
fn the_derivatives_are_those_of_the_model() {
    let (robot, pose) = (Mecanum { shares: [0.1; 3] }, PlanarPose::new(1.0, -2.0, 0.7));
    let control = Vector3::new(0.8, -0.5, 0.6);
    let moved = |by: &Vector3<f32>| robot.propagate(&pose.displaced(by), &control, 0.5);
    let transition = robot.linearise(&pose, &control, 0.5).transition;
    let frame = |by: &Vector3<f32>| {
        let scanner = Scanner(Symmetric::from_diagonal([1.0; 2]));
        let frame = scanner.frame(&pose.displaced(by));
        let expected = scanner.expect(&frame, &Vector2::new(4.0, 3.0)).unwrap();
        (expected, scanner.by_pose(&frame, &Vector2::new(4.0, 3.0), &expected))
    };
    let by_pose = frame(&Vector3::zeros()).1;
    for k in 0..3 {
        let mut step = Vector3::zeros();
        step[k] = 1e-2;
        let slope = moved(&step).difference(&moved(&-step)) / 2e-2;
        assert!((slope - transition.column(k)).norm() < 1e-3, "column {k}: {slope} against {transition}");
        let slope = (frame(&step).0.measurement - frame(&-step).0.measurement) / 2e-2;
        assert!((slope - by_pose.column(k)).norm() < 1e-3, "column {k}: {slope} against {by_pose}");
    }
}
