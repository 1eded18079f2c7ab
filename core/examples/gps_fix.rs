//! A drifting vehicle that sees nothing but gets a position every ten seconds, with an outlier among them, and a compass: fixes of the
//! pose between predictions, to a filter with a joint map.

use nalgebra::{Vector1, Vector2};
use scphd::models::{ControlNoise, HeadingFix, Motion, PlanarPose, Pose, PositionFix, Step, Unicycle, UnicycleControl};
use scphd::numerics::Noise;
use scphd::{JointConfig, JointSlam, joint_memory};

joint_memory! {
    type Memory: Unicycle<f64> { measurement: Vector2<f64>, features: 40, measurements: 32 }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut state = Box::new(Memory::new());
    let motion = Unicycle::new(Step::Arc, ControlNoise { interval_s: 5.0, ..ControlNoise::white(0.1, 0.01) })?;
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
    slam.reset(PlanarPose::ZERO)?;
    // Half a metre; the antenna is 0.4 m behind the axle. Beyond five standard deviations it is an outlier.
    let gps = PositionFix::new(0.5)?.mounted(-0.4, 0.0)?.gated(25.0)?;
    let compass = HeadingFix::new(0.05)?.gated(25.0)?;

    let exact = Unicycle::new(Step::Arc, ControlNoise::NONE)?;
    let (mut truth, mut told, mut draws) = (PlanarPose::ZERO, PlanarPose::ZERO, Noise::seeded(2));
    let (mut outliers, mut squares) = (0, 0.0);
    for step in 1..=3000 {
        let control = UnicycleControl { speed_mps: 1.0, rate_radps: 0.05 };
        truth = exact.propagate(&truth, &control, 0.1);
        // Wheels that are worn, and a gyroscope that is biased.
        let odometry = UnicycleControl { speed_mps: 1.06, rate_radps: 0.058 };
        told = exact.propagate(&told, &odometry, 0.1);
        slam.predict(&odometry, 0.1)?;
        if step % 100 == 0 {
            let antenna =
                Vector2::new(truth.x_m - 0.4 * truth.heading_rad.cos(), truth.y_m - 0.4 * truth.heading_rad.sin());
            let noise = Vector2::new(0.5 * draws.normal::<f64>(), 0.5 * draws.normal::<f64>());
            let reflected = if step == 1500 { Vector2::new(40.0, 0.0) } else { Vector2::zeros() };
            outliers += usize::from(!slam.observe(&gps, &(antenna + noise + reflected))?.accepted);
        }
        if step % 10 == 0 {
            let heading = Vector1::new(truth.heading_rad + 0.05 * draws.normal::<f64>());
            slam.observe(&compass, &heading)?;
        }
        let mean = slam.estimate_pose().ok_or("not started")?.mean;
        squares += (mean.x_m - truth.x_m).powi(2) + (mean.y_m - truth.y_m).powi(2);
    }
    let dead_reckoning = (told.x_m - truth.x_m).hypot(told.y_m - truth.y_m);
    let rmse = (squares / 3000.0).sqrt();
    println!(
        "{rmse:.2} m RMSE over five minutes, {outliers} outlier left out; dead reckoning {dead_reckoning:.1} m at the end"
    );
    assert!(rmse < 0.8 && rmse < dead_reckoning && outliers == 1);
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}
