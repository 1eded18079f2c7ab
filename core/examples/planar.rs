//! A robot with a lidar in the plane: odometry and scans in, pose and map out.

use core::f32::consts::PI;
use nalgebra::Vector2;
use scphd::models::{ControlNoise, Motion, PlanarPose, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl};
use scphd::numerics::{Noise, wrap};
use scphd::{Births, Component, Config, Detector, DetectorMemory, ScPhd, memory};

memory! {
    type Memory: Unicycle<f32> {
        particles: 4, samples: 1,
        features { pages: 64, pages_per_map: 16, in_view: 256 },
    }
}

const LANDMARKS: [[f32; 2]; 5] = [[6.0, 3.0], [2.0, 9.0], [-6.0, 6.0], [-5.0, -2.0], [4.0, -4.0]];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let window = RangeBearingWindow::full_circle(12.0, 0.9)?;
    let sensing = Sensing::range_bearing([0.1, 0.01], window, 2.0)?;
    // On a vehicle both memories are statics.
    let (mut state, mut scratch) = (Box::new(Memory::new()), DetectorMemory::<Vector2<f32>, 32>::new());
    let mut lidar = Detector::new(sensing, Births::of_static(0.002))?.over(&mut scratch)?;
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05))?;
    let mut slam = ScPhd::new(motion, Config::informed(4), &mut *state)?;
    slam.reset(PlanarPose::new(3.0, 0.0, 0.5 * PI), 1)?;

    // The world: a circle of 3 m around the origin, driven five times.
    let exact = Unicycle::new(Step::Arc, ControlNoise::NONE)?;
    let (mut truth, mut draws) = (PlanarPose::new(3.0_f32, 0.0, 0.5 * PI), Noise::seeded(7));
    let mut told = truth;
    for _ in 0..942 {
        let control = UnicycleControl { speed_mps: 1.0, rate_radps: 1.0 / 3.0 };
        truth = exact.propagate(&truth, &control, 0.1);
        let odometry = UnicycleControl {
            speed_mps: 1.0 + 0.1 * draws.normal::<f32>(),
            rate_radps: 1.0 / 3.0 + 0.05 * draws.normal::<f32>(),
        };
        told = exact.propagate(&told, &odometry, 0.1);
        let mut scan = Vec::new();
        for [x, y] in LANDMARKS {
            let (dx, dy) = (x - truth.x_m, y - truth.y_m);
            let noise = Vector2::new(0.1 * draws.normal::<f32>(), 0.01 * draws.normal::<f32>());
            if dx.hypot(dy) < 12.0 && draws.uniform::<f32>() < 0.9 {
                scan.push(Vector2::new(dx.hypot(dy), wrap(dy.atan2(dx) - truth.heading_rad)) + noise);
            }
        }
        for _ in 0..2 {
            scan.push(Vector2::new(12.0 * draws.uniform::<f32>(), PI * (2.0 * draws.uniform::<f32>() - 1.0)));
        }

        slam.predict(&odometry, 0.1)?;
        let report = slam.scan(&mut lidar, &scan)?;
        if !report.health.is_good() {
            println!("{:?}", report.health);
        }
    }

    let pose = slam.estimate_pose().ok_or("not started")?;
    let off = |pose: &PlanarPose<f32>| (pose.x_m - truth.x_m).hypot(pose.y_m - truth.y_m);
    println!("{:?}, {:.3} m off; dead reckoning {:.3} m", pose.mean, off(&pose.mean), off(&told));
    let mut features = [Component::ZERO; 16];
    let map = slam.estimate_map(&lidar, &mut features);
    for feature in features.iter().take(map.features) {
        println!(
            "feature {}: {:.2} m, {:.2} m, weight {:.2}",
            feature.label,
            feature.mean.x,
            feature.mean.y,
            feature.ln_weight.exp()
        );
    }
    assert!(off(&pose.mean) < 0.15 && off(&pose.mean) < off(&told) && map.features == LANDMARKS.len());
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}
