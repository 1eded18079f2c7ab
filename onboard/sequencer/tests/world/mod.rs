//! A robot that drives a circle, with a lidar, a radar and a satellite receiver, as a log of stamped inputs.

use heapless::Vec as List;
use scphd::models::{
    ControlNoise, Motion, PlanarPose, PositionFix, RangeBearing, RangeBearingWindow, Sensing, Unicycle,
    UnicycleControl, UniformClutter,
};
use scphd::numerics::nalgebra::Vector2;
use scphd::numerics::{Noise, wrap};
use scphd::{Births, Config, Detector, DetectorMemory, JointConfig, JointSlam, Real, ScPhd, joint_memory, memory};
use scphd_sequencer::{Action, Report, Sequencer, Settings, Stamp};

pub type Scan = List<Vector2<f32>, 24>;
pub type Control = UnicycleControl<f32>;

#[derive(Clone)]
pub enum Event {
    Lidar(Scan),
    Radar(Scan),
    Gps(Vector2<f32>),
}

#[derive(Clone)]
pub enum Input {
    Control(Control),
    Event(Event),
}

pub const WHEELS: u8 = 0;
pub const LIDAR: u8 = 1;
pub const RADAR: u8 = 2;
pub const GPS: u8 = 3;
/// The clock wraps during the log.
pub const START_NS: u64 = u64::MAX - 5_000_000_000;
pub const MS: u64 = 1_000_000;
pub const STEPS: u64 = 150;
pub const STANDING: Control = UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 };
pub const SETTINGS: Settings = Settings { window_ns: 300 * MS, ..Settings::DEFAULT };
const TRUTH: Control = UnicycleControl { speed_mps: 1.0, rate_radps: 0.25 };
const POSTS: [[f32; 2]; 6] = [[6.0, 3.0], [2.0, 9.0], [-6.0, 6.0], [-5.0, -2.0], [4.0, -4.0], [0.0, 4.0]];

memory! {
    type Mixture: Unicycle<f32> { particles: 4, samples: 1, features { pages: 96, pages_per_map: 24, in_view: 256 } }
}
joint_memory! { type Map: Unicycle<f32> { measurement: Vector2<f32>, features: 24, measurements: 24 } }

pub fn truth_at(ms: u64) -> PlanarPose<f32> {
    let exact = Unicycle::new(scphd::models::Step::Arc, ControlNoise::NONE).unwrap();
    exact.propagate(&PlanarPose::new(0.0, 0.0, 0.0), &TRUTH, ms as f32 / 1000.0)
}

fn scan(ms: u64, [range_sigma, bearing_sigma]: [f32; 2], range_max: f32, draws: &mut Noise) -> Scan {
    let (pose, mut scan) = (truth_at(ms), Scan::new());
    for [x, y] in POSTS {
        let (dx, dy) = (x - pose.x_m, y - pose.y_m);
        let (range, bearing) = (Real::sqrt(dx * dx + dy * dy), wrap(Real::atan2(dy, dx) - pose.heading_rad));
        let noise = Vector2::new(range_sigma * draws.normal::<f32>(), bearing_sigma * draws.normal::<f32>());
        if range < range_max && draws.uniform::<f32>() < 0.9 {
            scan.push(Vector2::new(range, bearing) + noise).unwrap();
        }
    }
    let aside = f32::PI * (2.0 * draws.uniform::<f32>() - 1.0);
    scan.push(Vector2::new(range_max * draws.uniform::<f32>(), aside)).unwrap();
    scan
}

/// Inputs of 15 s in the order of time: wheels every 100 ms from the start, the lidar every 200 ms, the radar every 300 ms, a
/// position every second; the last three with these offsets from the wheels, ms.
pub fn log([lidar_ms, radar_ms, gps_ms]: [u64; 3]) -> Vec<(Stamp, Input)> {
    let (mut log, mut draws) = (Vec::new(), Noise::seeded(4));
    let mut put = |source, ms, input| log.push((ms, Stamp::new(source, START_NS.wrapping_add(ms * MS)), input));
    for step in 0..STEPS {
        let (speed, rate) = (0.1 * draws.normal::<f32>(), 0.03 * draws.normal::<f32>());
        let told = UnicycleControl { speed_mps: 1.03 + speed, rate_radps: 0.25 + rate };
        put(WHEELS, step * 100, Input::Control(told));
        if step % 2 == 1 {
            let ms = step * 100 + lidar_ms;
            put(LIDAR, ms, Input::Event(Event::Lidar(scan(ms, [0.05, 0.01], 12.0, &mut draws))));
        }
        if step % 3 == 1 {
            let ms = step * 100 + radar_ms;
            put(RADAR, ms, Input::Event(Event::Radar(scan(ms, [0.2, 0.03], 15.0, &mut draws))));
        }
        if step % 10 == 1 {
            let ms = step * 100 + gps_ms;
            let noise = Vector2::new(0.3 * draws.normal::<f32>(), 0.3 * draws.normal::<f32>());
            let at = truth_at(ms);
            put(GPS, ms, Input::Event(Event::Gps(Vector2::new(at.x_m, at.y_m) + noise)));
        }
    }
    log.sort_by_key(|(ms, stamp, _)| (*ms, stamp.source));
    log.into_iter().map(|(_, stamp, input)| (stamp, input)).collect()
}

/// The interface of both filters.
pub trait Feed {
    fn predict(&mut self, control: &Control, dt: f32);
    fn event(&mut self, event: &Event);
}

#[derive(Debug, PartialEq)]
pub struct Outcome {
    /// Of the mixture and of the joint map.
    pub digests: [u64; 2],
    /// The pose estimated by the mixture.
    pub pose: PlanarPose<f32>,
}

/// Constructs both filters, and runs `feed` with them.
pub fn filtered(feed: impl FnOnce(&mut dyn Feed)) -> Outcome {
    type Eye<'r> = Detector<
        Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>,
        scphd::storage::ScanRoom<'r, Vector2<f32>>,
    >;
    struct Both<'s> {
        mixture: ScPhd<'s, Unicycle<f32>>,
        joint: JointSlam<'s, Unicycle<f32>, Vector2<f32>>,
        lidar: Eye<'s>,
        radar: Eye<'s>,
        gps: PositionFix<f32>,
    }
    impl Feed for Both<'_> {
        fn predict(&mut self, control: &Control, dt: f32) {
            self.mixture.predict(control, dt).unwrap();
            self.joint.predict(control, dt).unwrap();
        }

        fn event(&mut self, event: &Event) {
            let Self { mixture, joint, lidar, radar, gps } = self;
            match event {
                Event::Lidar(scan) => (_, _) = (mixture.scan(lidar, scan).unwrap(), joint.scan(lidar, scan).unwrap()),
                Event::Radar(scan) => (_, _) = (mixture.scan(radar, scan).unwrap(), joint.scan(radar, scan).unwrap()),
                Event::Gps(at) => (_, _) = (mixture.observe(gps, at).unwrap(), joint.observe(gps, at).unwrap()),
            }
        }
    }
    let detector = |[range_sigma, bearing_sigma]: [f32; 2], range_max| {
        let field_of_view = RangeBearingWindow::full_circle(range_max, 0.9).unwrap();
        let sensing = Sensing::range_bearing([range_sigma, bearing_sigma], field_of_view, 1.0).unwrap();
        Detector::new(sensing, Births::of_static(0.1 / field_of_view.measure())).unwrap()
    };
    let (mut still, mut map) = (Box::new(Mixture::new()), Box::new(Map::new()));
    let (mut of_lidar, mut of_radar) = (DetectorMemory::<_, 24>::new(), DetectorMemory::<_, 24>::new());
    let motion = || {
        let noise = ControlNoise { interval_s: 0.1, ..ControlNoise::white(0.1, 0.05) };
        Unicycle::new(scphd::models::Step::Arc, noise).unwrap()
    };
    let mut both = Both {
        mixture: ScPhd::new(motion(), Config::informed(4), &mut *still).unwrap(),
        joint: JointSlam::new(motion(), JointConfig::default(), &mut *map).unwrap(),
        lidar: detector([0.05, 0.01], 12.0).over(&mut of_lidar).unwrap(),
        radar: detector([0.2, 0.03], 15.0).over(&mut of_radar).unwrap(),
        gps: PositionFix::new(0.3).unwrap().gated(25.0).unwrap(),
    };
    both.mixture.reset(truth_at(0), 1).unwrap();
    both.joint.reset(truth_at(0)).unwrap();
    feed(&mut both);
    let pose = both.mixture.estimate_pose().unwrap().mean;
    Outcome { digests: [both.mixture.digest(), both.joint.digest()], pose }
}

/// Runs both filters with inputs in this order of arrival through a sequencer, with ticks where a time is given.
pub fn sequenced(arrivals: &[(Option<u64>, Stamp, Input)]) -> (Outcome, Report) {
    let mut sequencer = Sequencer::<Control, Event, 16, 16>::new();
    sequencer.start(SETTINGS, START_NS, STANDING).unwrap();
    let outcome = filtered(|filters| {
        let mut drain = |sequencer: &mut Sequencer<_, _, 16, 16>| {
            while let Some(action) = sequencer.next_action() {
                match action {
                    Action::Predict { control, dt } | Action::Gap { control, dt } => {
                        filters.predict(&control, dt.seconds());
                    }
                    Action::Event(event) => filters.event(event),
                }
            }
        };
        for (now_ns, stamp, input) in arrivals {
            // Refused inputs are counted.
            let _refused = match input {
                Input::Control(control) => sequencer.push_control(*stamp, *control),
                Input::Event(event) => sequencer.push_event(*stamp, event.clone()),
            };
            now_ns.iter().for_each(|&now_ns| sequencer.tick(now_ns));
            drain(&mut sequencer);
        }
        sequencer.flush();
        drain(&mut sequencer);
        assert_eq!(sequencer.waiting(), (0, 0));
    });
    (outcome, sequencer.report())
}
