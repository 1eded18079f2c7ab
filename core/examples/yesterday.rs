//! A robot maps a hall and keeps the map as bytes. The next day it is switched on somewhere in the hall, finds its place in that map, and
//! goes on in it.

use nalgebra::{SVector, Vector2};
use scphd::locate::{Locator, LocatorConfig, LocatorState};
use scphd::models::{
    ControlNoise, Motion, PlanarPose, Pose, RangeBearing, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl,
    UniformClutter,
};
use scphd::numerics::{Noise, wrap};
use scphd::snapshot::{from_slice, into_slice, restore_map, save_map};
use scphd::{Births, Component, Detector, JointConfig, JointSlam, joint_memory};

joint_memory! {
    type Memory: Unicycle<f32> { measurement: Vector2<f32>, features: 64, measurements: 32 }
}
type Lidar = Detector<Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>>;
type Slam<'s> = JointSlam<'s, Unicycle<f32>, Vector2<f32>>;

/// The hall: pillars, and a robot that drives in a circle.
struct Hall {
    pillars: Vec<[f32; 2]>,
    robot: PlanarPose<f32>,
    draws: Noise,
}

impl Hall {
    /// Half a second of driving, then a scan.
    fn step(&mut self, slam: &mut Slam<'_>, lidar: &Lidar) -> Result<(), Box<dyn std::error::Error>> {
        let control = UnicycleControl { speed_mps: 1.0, rate_radps: 0.12 };
        self.robot = Unicycle::new(Step::Arc, ControlNoise::NONE)?.propagate(&self.robot, &control, 0.5);
        let noise = [0.05 * self.draws.normal::<f32>(), 0.01 * self.draws.normal::<f32>()];
        let odometry = UnicycleControl { speed_mps: 1.0 + noise[0], rate_radps: 0.12 + noise[1] };
        slam.predict(&odometry, 0.5)?;
        let mut seen: Vec<SVector<f32, 2>> = Vec::new();
        for [x, y] in &self.pillars {
            let (dx, dy) = (x - self.robot.x_m, y - self.robot.y_m);
            let noise = [0.05 * self.draws.normal::<f32>(), 0.01 * self.draws.normal::<f32>()];
            if dx.hypot(dy) < 12.0 && self.draws.uniform::<f32>() < 0.9 {
                let bearing = dy.atan2(dx) - self.robot.heading_rad;
                seen.push(Vector2::new(dx.hypot(dy) + noise[0], wrap(bearing + noise[1])));
            }
        }
        slam.scan(lidar, &seen)?;
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let window = RangeBearingWindow::full_circle(12.0, 0.9)?;
    let sensing = Sensing::range_bearing([0.05, 0.01], window, 0.2)?;
    let lidar = Detector::new(sensing, Births::of_static(1e-3))?;
    let motion = Unicycle::new(Step::Arc, ControlNoise { interval_s: 0.5, ..ControlNoise::white(0.05, 0.01) })?;
    let mut draws = Noise::seeded(5);
    let pillars = (0..30).map(|_| [0; 2].map(|_| 30.0 * draws.uniform::<f32>())).collect();
    let mut hall = Hall { pillars, robot: PlanarPose::new(15.0, 5.0, 0.0), draws };

    // The first day: the map is known from where the robot stands.
    let mut state = Box::new(Memory::new());
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
    slam.reset(hall.robot)?;
    for _ in 0..240 {
        hall.step(&mut slam, &lidar)?;
    }
    let features: Vec<_> = slam.features().collect();
    let mut flash = [0; 4096];
    let len = save_map(1, features.into_iter(), into_slice(&mut flash))?;

    // The next day: somewhere else, and two pillars are gone.
    hall.robot = PlanarPose::new(20.0, 12.0, 2.0);
    hall.pillars.truncate(28);
    let mut map = [Component::ZERO; 64];
    let features = restore_map(1, &mut map, from_slice(&flash[..len]))?;
    let map = &map[..features];
    let mut memory = Box::new(LocatorState::<f32, 64, 16>::new());
    let mut locator = Locator::new(LocatorConfig::default(), &mut *memory)?;
    locator.load_map(map)?;
    slam.reset(PlanarPose::ZERO)?;
    let mut scans = 0;
    let place = loop {
        hall.step(&mut slam, &lidar)?;
        scans += 1;
        let pose = slam.estimate_pose().ok_or("not started")?;
        if let Some(place) = locator.update(&lidar, &pose, slam.features()).found {
            break place;
        }
        assert!(scans < 50, "not found");
    };
    let off = hall.robot.difference(&place.pose.mean);
    println!(
        "found after {scans} scans by {} pillars, with probability {:.4}, {:.2} m and {:.3} rad off",
        place.matched,
        place.probability,
        off.x.hypot(off.y),
        off.z.abs()
    );
    assert!(off.x.hypot(off.y) < 0.5 && off.z.abs() < 0.05);

    // From here on in the map of the first day, and on with mapping.
    slam.reset_within(place.pose.mean, &place.pose.covariance)?;
    slam.load_map(map)?;
    for _ in 0..100 {
        hall.step(&mut slam, &lidar)?;
    }
    let estimate = slam.estimate_pose().ok_or("not started")?.mean;
    assert!(hall.robot.distance_m(&estimate) < 0.5);
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}
