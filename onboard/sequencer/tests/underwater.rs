//! A vehicle whose odometry refers to the time before its time stamp: rows of instruments are events like the images, and a
//! navigator computes controls from them.

use scphd::models::{Auv, AuvPose, Motion, Pose, Reading};
use scphd::navigation::{Instruments, Navigator, VelocityNoise};
use scphd::numerics::Noise;
use scphd_sequencer::{Action, Flags, Interval, Sequencer, Settings, Stamp};

const MS: u64 = 1_000_000;
const INSTRUMENTS: u8 = 0;
const CAMERA: u8 = 1;

#[derive(Clone, Copy)]
enum Event {
    Row(Instruments<f64>),
    Frame,
}

/// Predicts the pose, and stores the pose of every image.
struct Vehicle {
    motion: Auv<f64>,
    navigator: Navigator<f64>,
    pose: AuvPose<f64>,
    seen_from: Vec<AuvPose<f64>>,
}

impl Vehicle {
    fn new() -> Self {
        let noise = VelocityNoise {
            walk_mps_rts: 0.1,
            dvl_sigma_mps: 0.1,
            z_sigma_m: 0.02,
            gate_sigmas: 4.0,
            outliers_believed: 5,
        };
        Self {
            motion: Auv::new(0.5, 0.0).unwrap(),
            navigator: Navigator::new(noise, -2.0, [0.0; 2]).unwrap(),
            pose: AuvPose::new(0.0, 0.0, -2.0, 0.0),
            seen_from: Vec::new(),
        }
    }

    fn after(&mut self, waited: Interval, event: &Event) {
        let dt = waited.seconds();
        let control = match event {
            Event::Row(row) => self.navigator.instruments(row, dt),
            Event::Frame => self.navigator.onward(dt),
        };
        if let Some(control) = control.unwrap() {
            self.pose = self.motion.propagate(&self.pose, &control, dt);
        }
        if matches!(event, Event::Frame) {
            self.seen_from.push(self.pose);
        }
    }
}

/// 20 s: rows every 100 ms, images every 250 ms, some at the same time.
fn log() -> Vec<(Stamp, Event)> {
    let mut draws = Noise::seeded(3);
    let rows = (1..=200_u64).map(|step| {
        let reading = |value| Reading { value, sigma: 0.02 };
        let row = Instruments {
            roll_rad: 0.05 * draws.normal::<f64>(),
            pitch_rad: 0.05 * draws.normal::<f64>(),
            yaw_rate_radps: reading(0.2 + 0.02 * draws.normal::<f64>()),
            velocity_mps: Some([0.5 + 0.1 * draws.normal::<f64>(), 0.0, 0.0]),
            z_m: (step % 2 == 0).then(|| -2.0 + 0.02 * draws.normal::<f64>()),
        };
        (Stamp::new(INSTRUMENTS, step * 100 * MS), Event::Row(row))
    });
    let frames = (1..=80).map(|step| (Stamp::new(CAMERA, step * 250 * MS), Event::Frame));
    let mut log: Vec<_> = rows.chain(frames).collect();
    log.sort_by_key(|(stamp, _)| (stamp.time_ns, stamp.source));
    log
}

#[test]
fn rows_of_instruments_are_events() {
    let mut plain = Vehicle::new();
    let mut time_ns = 0;
    for (stamp, event) in log() {
        plain.after(Interval::of_ns(stamp.time_ns - time_ns), &event);
        time_ns = stamp.time_ns;
    }

    let (mut draws, mut vehicle) = (Noise::seeded(9), Vehicle::new());
    let mut arrivals: Vec<_> = log()
        .into_iter()
        .map(|(stamp, event)| (stamp.time_ns + (2e8 * draws.uniform::<f64>()) as u64, stamp, event))
        .collect();
    arrivals.sort_by_key(|(at, ..)| *at);
    let mut inputs = Sequencer::<(), Event, 8, 16>::new();
    inputs.start(Settings::DEFAULT, 0, ()).unwrap();
    let mut waited_ns = 0;
    let mut drain = |inputs: &mut Sequencer<(), Event, 8, 16>| {
        while let Some(action) = inputs.next_action() {
            match action {
                Action::Predict { dt, .. } | Action::Gap { dt, .. } => waited_ns += dt.ns(),
                Action::Event(event) => {
                    vehicle.after(Interval::of_ns(waited_ns), event);
                    waited_ns = 0;
                }
            }
        }
    };
    for (_, stamp, event) in arrivals {
        if matches!(event, Event::Row(_)) {
            // Only for the detection of gaps.
            inputs.push_control(stamp, ()).unwrap();
        }
        inputs.push_event(stamp, event).unwrap();
        drain(&mut inputs);
    }
    assert!(inputs.report().flags.is_empty());
    inputs.tick(21_000 * MS);
    inputs.flush();
    drain(&mut inputs);
    assert_eq!(inputs.report().flags, Flags::GAP);
    assert_eq!((vehicle.seen_from.len(), &vehicle.seen_from), (80, &plain.seen_from));
    assert_eq!(vehicle.pose, plain.pose);
    assert!(plain.pose.distance_m(&AuvPose::ZERO) > 2.0, "{:?}", plain.pose);
}
