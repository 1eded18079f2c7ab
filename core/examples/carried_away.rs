//! A robot that is picked up and put down elsewhere: its map and its scans no longer agree, the health says so, the autopilot stops and
//! asks, and goes on from where it is told to be, with the map it has.

use nalgebra::Vector2;
use scphd::models::{
    ControlNoise, Motion, PlanarPose, Pose, RangeBearingWindow, Sensing, Sensor, Step, Unicycle, UnicycleControl,
};
use scphd::numerics::{Noise, Symmetric};
use scphd::{Births, Detector, Health, JointConfig, JointSlam, joint_memory};

joint_memory! {
    type Memory: Unicycle<f32> { measurement: Vector2<f32>, features: 40, measurements: 32 }
}

/// What an autopilot makes of the health of a scan; `docs/health.md` has all conditions.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Reaction {
    GoOn,
    /// Nothing that needs the pose to be right: no narrow passages, no landing.
    Slowly,
    /// Stop, and find out where we are.
    StopAndAsk,
}

fn reaction(health: Health) -> Reaction {
    if health.contains(Health::LOST) {
        Reaction::StopAndAsk
    } else if health.contains(Health::DIVERGENCE_SUSPECTED) || health.contains(Health::INPUT_LOST) {
        Reaction::Slowly
    } else {
        Reaction::GoOn
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut state = Box::new(Memory::new());
    let window = RangeBearingWindow::full_circle(20.0, 0.9)?;
    let sensing = Sensing::range_bearing([0.1, 0.01], window, 1.0)?;
    let lidar = Detector::new(sensing, Births::of_static(1e-3))?;
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05))?;
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
    slam.reset(PlanarPose::ZERO)?;

    let mut draws = Noise::seeded(5);
    let posts = [(); 24].map(|()| Vector2::new(30.0, 30.0).map(|side: f32| side * (draws.uniform::<f32>() - 0.5)));
    let ahead = UnicycleControl { speed_mps: 1.0, rate_radps: 0.2 };
    let (mut truth, mut asked_after) = (PlanarPose::ZERO, None);
    for step in 0..400 {
        truth = motion.propagate(&truth, &ahead, 0.1);
        if step == 200 {
            truth = PlanarPose::new(truth.x_m + 2.5, truth.y_m - 2.0, truth.heading_rad + 1.0);
        }
        let frame = lidar.sensing().sensor.frame(&truth);
        let in_view = posts.iter().filter_map(|post| lidar.sensing().sensor.expect(&frame, post));
        let scan: Vec<_> = in_view
            .map(|expected| expected.measurement)
            .filter(|measurement| measurement.x < 20.0)
            .filter_map(|z| {
                let noise = Vector2::new(0.1 * draws.normal::<f32>(), 0.01 * draws.normal::<f32>());
                (draws.uniform::<f32>() < 0.9).then_some(z + noise)
            })
            .collect();
        slam.predict(&ahead, 0.1)?;
        let report = slam.scan(&lidar, &scan)?;
        assert!(step >= 200 || reaction(report.health) == Reaction::GoOn, "{step}: {report:?}");
        if reaction(report.health) == Reaction::StopAndAsk && asked_after.is_none() {
            asked_after = Some(step - 200);
            // The operator points at the map: half a metre, five degrees. Where nobody knows, `scatter` makes the pose as
            // uncertain as it is, and `reset_within` starts a new map.
            let told = PlanarPose::new(truth.x_m + 0.3, truth.y_m - 0.2, truth.heading_rad + 0.05);
            slam.relocate(told, &Symmetric::from_diagonal([0.25, 0.25, 0.008]))?;
        }
        if step == 399 {
            assert_eq!(reaction(report.health), Reaction::GoOn, "{report:?}");
        }
    }
    let mean = slam.estimate_pose().ok_or("not started")?.mean;
    let error_m = (mean.x_m - truth.x_m).hypot(mean.y_m - truth.y_m);
    let after = asked_after.ok_or("nobody noticed")?;
    println!("lost {after} scans after it was carried away; told where it was, it ends {error_m:.2} m from the truth");
    assert!(after < 20 && error_m < 0.3);
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}
