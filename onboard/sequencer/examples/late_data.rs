//! A robot whose lidar has a delay of up to 150 ms. With the time of arrival as time stamp, its scans would be assigned to wrong
//! poses; with the time of measurement they are not. Beside the filter, a pose without jumps for the controller.

use heapless::Vec as List;
use scphd::models::{
    ControlNoise, Motion, PlanarPose, Pose, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl,
};
use scphd::numerics::nalgebra::Vector2;
use scphd::numerics::{Noise, wrap};
use scphd::{Births, Detector, JointConfig, JointSlam, joint_memory};
use scphd_sequencer::{Action, Flags, Sequencer, Settings, SmoothOdometry, Stamp};

joint_memory! { type Memory: Unicycle<f32> { measurement: Vector2<f32>, features: 24, measurements: 16 } }
type Scan = List<Vector2<f32>, 16>;
type Control = UnicycleControl<f32>;

enum Input {
    Wheels(Control),
    Lidar(Scan),
}

const MS: u64 = 1_000_000;
const WHEELS: u8 = 0;
const LIDAR: u8 = 1;
const POSTS: [[f32; 2]; 6] = [[6.0, 3.0], [2.0, 9.0], [-6.0, 6.0], [-5.0, -2.0], [4.0, -4.0], [0.0, 4.0]];

/// The true pose: the robot drives a circle.
fn truth(exact: &Unicycle<f32>, at_ns: u64) -> PlanarPose<f32> {
    let control = UnicycleControl { speed_mps: 1.5, rate_radps: 0.6 };
    exact.propagate(&PlanarPose::new(0.0, 0.0, 0.0), &control, at_ns as f32 / 1e9)
}

/// A minute of inputs, with the time of arrival of each, ns: the wheels every 20 ms without delay, the lidar every 100 ms with a
/// delay between 10 and 150 ms, and one scan with a delay of a second.
fn log(exact: &Unicycle<f32>) -> Vec<(u64, Stamp, Input)> {
    let (mut log, mut draws) = (Vec::new(), Noise::seeded(1));
    for step in 0..3000 {
        let at_ns = step * 20 * MS;
        let (speed, rate) = (0.1 * draws.normal::<f32>(), 0.03 * draws.normal::<f32>());
        let told = UnicycleControl { speed_mps: 1.53 + speed, rate_radps: 0.61 + rate };
        log.push((at_ns, Stamp::new(WHEELS, at_ns), Input::Wheels(told)));
        if step % 5 == 4 {
            let seen_ns = at_ns + 7 * MS;
            let (pose, mut scan) = (truth(exact, seen_ns), Scan::new());
            for [x, y] in POSTS {
                let (dx, dy) = (x - pose.x_m, y - pose.y_m);
                let (range, bearing) = (0.03 * draws.normal::<f32>(), 0.01 * draws.normal::<f32>());
                scan.extend([Vector2::new(range + dx.hypot(dy), wrap(bearing + dy.atan2(dx) - pose.heading_rad))]);
            }
            let delay_ms = if step == 999 { 1000 } else { 10 + (140.0 * draws.uniform::<f64>()) as u64 };
            log.push((seen_ns + delay_ms * MS, Stamp::new(LIDAR, seen_ns).numbered(step as u32), Input::Lidar(scan)));
        }
    }
    log.sort_by_key(|(at_ns, ..)| *at_ns);
    log
}

/// RMSE of the current pose at every time, m. Time stamps are the times of measurement, or those of arrival.
fn drive(exact: &Unicycle<f32>, when_measured: bool) -> Result<f32, Box<dyn std::error::Error>> {
    let window = RangeBearingWindow::full_circle(15.0, 0.95)?;
    let sensing = Sensing::range_bearing([0.03, 0.01], window, 0.1)?;
    let lidar = Detector::new(sensing, Births::of_static(0.001))?;
    let noise = ControlNoise { interval_s: 0.5, ..ControlNoise::white(0.1, 0.05) };
    let mut memory = Box::new(Memory::new());
    let mut slam = JointSlam::new(Unicycle::new(Step::Arc, noise)?, JointConfig::default(), &mut *memory)?;
    slam.reset(truth(exact, 0))?;
    let mut odometry = SmoothOdometry::new(truth(exact, 0));
    let mut sequencer = Sequencer::<Control, Scan, 16, 8>::new();
    let standing = UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 };
    sequencer.start(Settings { window_ns: 150 * MS, ..Settings::DEFAULT }, 0, standing)?;

    let (mut squares, mut arrivals, mut fastest_mps) = (0.0, 0.0_f32, 0.0_f32);
    for (at_ns, stamp, input) in log(exact) {
        let stamp = if when_measured { stamp } else { Stamp { time_ns: at_ns, ..stamp } };
        let _counted = match input {
            Input::Wheels(control) => sequencer.push_control(stamp, control),
            Input::Lidar(scan) => sequencer.push_event(stamp, scan),
        };
        while let Some(action) = sequencer.next_action() {
            match action {
                Action::Predict { control, dt } | Action::Gap { control, dt } => {
                    let before = odometry.pose();
                    slam.predict(&control, dt.seconds())?;
                    odometry.predict(exact, &control, dt.seconds())?;
                    fastest_mps = fastest_mps.max(odometry.pose().distance_m(&before) / dt.seconds::<f32>());
                }
                Action::Event(scan) => {
                    slam.scan(&lidar, scan)?;
                    odometry.correct(&slam.estimate_pose().ok_or("not started")?.mean)?;
                }
            }
        }
        // The estimate of the filter is delayed by the window; the queued controls give the current pose.
        let now = sequencer
            .ahead(at_ns)
            .fold(odometry.pose(), |pose, (control, dt)| exact.propagate(&pose, &control, dt.seconds()));
        squares += odometry.map_from_odom().apply(&now).distance_m(&truth(exact, at_ns)).powi(2);
        arrivals += 1.0;
    }
    let (report, late, greatest) = (sequencer.report(), u32::from(when_measured), odometry.greatest());
    println!("{} corrections of at most {:.3} m, {:?}", odometry.corrections(), greatest.distance_m, report.flags);
    assert!(report.count(Flags::LATE) == late && report.flags.is_empty() == (late == 0), "{report:?}");
    assert!(fastest_mps < 2.0, "{fastest_mps}");
    Ok((squares / arrivals).sqrt())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let exact = Unicycle::new(Step::Arc, ControlNoise::NONE)?;
    let (by_arrival, by_measurement) = (drive(&exact, false)?, drive(&exact, true)?);
    println!("RMSE {by_arrival:.3} m by the time of arrival, {by_measurement:.3} m by the time of measurement");
    assert!(by_measurement < 0.03 && by_measurement < 0.5 * by_arrival);
    Ok(())
}

#[test]
fn it_ends_well() {
    main().unwrap();
}
