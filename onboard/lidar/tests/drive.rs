//! A whole drive: bytes of a lidar on a robot, posts, and a filter that knows the position when dead reckoning has long diverged.

mod world;

use nalgebra::Vector2;
use scphd::models::{
    ControlNoise, PlanarPose, RangeBearingLimits, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl,
};
use scphd::{Births, Detector, JointConfig, JointSlam, joint_memory};
use scphd_lidar::{Assembler, PostFinder, PostSettings, Receiver, Resolution};
use world::{Draws, Lidar, World};

joint_memory! { type Map: Unicycle<f32> { measurement: Vector2<f32>, features: 48, measurements: 32 } }

/// Duration of a drive, s: four rounds of the yard.
const DURATION_S: f64 = 120.0;
/// Time between odometry samples, s.
const ODOMETRY_S: f64 = 0.02;
/// Number of false detections in a revolution, at most that of `tests/scene.rs`.
const CLUTTER: f32 = 0.1;
/// Greatest range of posts, m: up to there most of them have two points.
const FAR_M: f32 = 8.0;

/// Position of the robot: on an ellipse, with a varying speed.
fn place(time_s: f64) -> [f64; 2] {
    let phase = 0.2 * time_s + 0.2 * (0.1 * time_s).sin();
    [5.0 * phase.cos(), 3.5 * phase.sin()]
}

fn pose(time_s: f64) -> [f64; 3] {
    let ([x0, y0], [x1, y1]) = (place(time_s - 1e-4), place(time_s + 1e-4));
    let [x, y] = place(time_s);
    [x, y, (y1 - y0).atan2(x1 - x0)]
}

/// Odometry: 4 % too fast, 3 % too much rotation, and noise.
fn odometry(from_s: f64, to_s: f64, draws: &mut Draws) -> UnicycleControl<f32> {
    let dt = to_s - from_s;
    let ([x0, y0, h0], [x1, y1, h1]) = (pose(from_s), pose(to_s));
    let (speed, rate) = ((x1 - x0).hypot(y1 - y0) / dt, world::wrap(h1 - h0) / dt);
    UnicycleControl {
        speed_mps: (1.04 * speed + 0.05 * draws.normal()) as f32,
        rate_radps: (1.03 * rate + 0.02 * draws.normal()) as f32,
    }
}

/// Results of a drive: RMS errors of the position of the filter and of dead reckoning, m; NEES divided by 2; and the share of
/// posts in the map.
fn drive(seed: u64, takes_motion_out: bool, damage: f64) -> [f64; 4] {
    let mut draws = Draws::seeded(seed);
    let off_the_way = |[x, y]: [f64; 2]| ((x / 5.0).hypot(y / 3.5) - 1.0).abs() > 0.25;
    let world = World::random(&mut draws, 16, 0.1, off_the_way);
    let mut wheels = Draws::seeded(seed + 1_000_000);

    let posts = PostSettings { range_max_m: FAR_M, ..PostSettings::of_radius(0.1) };
    let finder = PostFinder::new(posts).unwrap();
    let (near, far) = (2.0, FAR_M);
    let [p_near, p_far] = [near, far].map(|range| Resolution::LD06.detection_probability(&posts, range));
    // Some posts in view are occluded.
    let limits = RangeBearingLimits {
        probability_far: 0.9 * p_far,
        bearing_half_width_rad: 3.05,
        bearing_edge_rad: 0.05,
        range_edge_m: 0.1,
        ..RangeBearingLimits::full_circle(FAR_M, 0.9 * p_near)
    };
    let view = RangeBearingWindow::new(limits).unwrap();
    // The greatest noise within the view. The motion is compensated by the odometry, whose error is a few percent.
    let [range_sigma_m, bearing_sigma_rad] = Resolution::LD06.worst_sigmas(&posts);
    let sensing = Sensing::range_bearing([range_sigma_m.max(0.02), bearing_sigma_rad], view, CLUTTER).unwrap();
    let detector = Detector::new(sensing, Births::of_static(0.1 / view.measure())).unwrap();
    let noise = ControlNoise::wheeled();
    let mut memory = Box::new(Map::new());
    let mut slam =
        JointSlam::new(Unicycle::new(Step::Arc, noise).unwrap(), JointConfig::default(), &mut memory).unwrap();
    let [x, y, heading] = pose(0.0).map(|number| number as f32);
    let start = PlanarPose::new(x, y, heading);
    slam.reset(start).unwrap();

    let exact = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    let mut told = start;
    let (mut lidar, mut receiver, mut assembler) = (Lidar::started(draws), Receiver::new(), Assembler::<1024>::new());
    let (mut moved_s, mut squares, mut scans) = (0.0, [0.0; 3], 0.0);
    while lidar.time_s < DURATION_S {
        let mut bytes = lidar.packet(&world, pose).to_bytes();
        bytes.iter_mut().for_each(|byte| *byte ^= if lidar.draws.uniform() < damage { 0x10 } else { 0 });
        let whole = bytes.into_iter().filter_map(|byte| receiver.push(byte)).last();
        let revolution = whole.and_then(|packet| assembler.push(&packet));
        if revolution.is_none() && lidar.time_s - moved_s < ODOMETRY_S {
            continue;
        }
        let control = odometry(moved_s, lidar.time_s, &mut wheels);
        let dt = (lidar.time_s - moved_s) as f32;
        moved_s = lidar.time_s;
        slam.predict(&control, dt).unwrap();
        told = scphd::models::Motion::propagate(&exact, &told, &control, dt);
        let Some(revolution) = revolution else { continue };
        let (speed, rate) = if takes_motion_out { (control.speed_mps, control.rate_radps) } else { (0.0, 0.0) };
        let found = finder.find::<32, _>(revolution);
        let scan: Vec<Vector2<f32>> = found.posts.iter().map(|post| post.at_end(speed, rate).into()).collect();
        slam.scan(&detector, &scan).unwrap();

        let truth = pose(moved_s);
        let estimate = slam.estimate_pose().unwrap();
        let off = |pose: &PlanarPose<f32>| [f64::from(pose.x_m) - truth[0], f64::from(pose.y_m) - truth[1]];
        let [dx, dy] = off(&estimate.mean);
        let covariance = estimate.covariance.to_matrix().map(f64::from);
        let (a, b, c) = (covariance[(0, 0)], covariance[(1, 0)], covariance[(1, 1)]);
        squares[0] += dx * dx + dy * dy;
        squares[1] += off(&told).map(|x| x * x).iter().sum::<f64>();
        squares[2] += (c * dx * dx - 2.0 * b * dx * dy + a * dy * dy) / (a * c - b * b) / 2.0;
        scans += 1.0;
    }
    let [filter, reckoning, nees] = squares.map(|square| square / scans);
    let is_there = |[x, y]: &&[f64; 2]| {
        slam.features().any(|feature| (f64::from(feature.mean.x) - x).hypot(f64::from(feature.mean.y) - y) < 0.3)
    };
    let known = world.posts.iter().filter(is_there).count() as f64 / world.posts.len() as f64;
    [filter.sqrt(), reckoning.sqrt(), nees, known]
}

/// Means over the seeds.
fn drives(takes_motion_out: bool, damage: f64) -> [f64; 4] {
    let mut mean = [0.0; 4];
    for seed in 0..5 {
        let one = drive(seed, takes_motion_out, damage);
        println!(
            "seed {seed}: filter {:.3} m, dead reckoning {:.2} m, NEES/2 {:.2}, map {:.2}",
            one[0], one[1], one[2], one[3]
        );
        mean.iter_mut().zip(one).for_each(|(mean, one)| *mean += one / 5.0);
    }
    println!(
        "mean: filter {:.3} m, dead reckoning {:.2} m, NEES/2 {:.2}, map {:.2}",
        mean[0], mean[1], mean[2], mean[3]
    );
    mean
}

#[test]
fn a_lidar_keeps_a_robot_located() {
    let [clean, reckoning, nees, known] = drives(true, 0.0);
    println!("a byte in a thousand damaged:");
    let [damaged, ..] = drives(true, 1e-3);
    println!("without taking the motion of a revolution out:");
    let [blurred, ..] = drives(false, 0.0);
    assert!(clean < 0.0132 && reckoning > 10.0 * clean, "{clean} {reckoning}");
    assert!(nees < 3.0 && known > 0.9, "{nees} {known}");
    assert!(damaged < 1.5 * clean + 0.01, "{damaged}");
    assert!((0.074..0.107).contains(&blurred), "{blurred}");
}
