//! The filter's state does not depend on who weighs the candidates, nor on how many jobs that is divided into.

use nalgebra::Vector2;
use scphd::{
    Ackermann, AckermannControl, AckermannGeometry, Births, Config, ControlNoise, Detector, DetectorMemory, Dynamic,
    Executor, MapMemory, PlanarPose, RangeBearing, RangeBearingWindow, Real, ScPhd, Sensing, Serial, State, Static,
    UniformClutter,
};
use scphd_sim::events::{Event, events};
use scphd_sim::log::{Log, Vehicle};
use scphd_sim::scenario;
use scphd_sim::threads::Threads;
use scphd_tests::with_roomy_stack;

/// Enough for a whole turn of the loop among moving features, and for resampling.
const SCANS: usize = 150;

type Still<T> = MapMemory<Static<Vector2<T>>, 32, 512, 64, 512>;
type Moving<T> = MapMemory<Dynamic<Vector2<T>>, 32, 256, 32, 256>;
type Memory<T> = State<PlanarPose<T>, 32, 64, Still<T>, Moving<T>>;

/// The last job first.
struct Backwards;

impl Executor for Backwards {
    fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync) {
        let jobs: Vec<J> = jobs.collect();
        jobs.into_iter().rev().for_each(work);
    }
}

fn thesis_dynamic() -> Log {
    let mut log = scenario::thesis_dynamic(1);
    log.scans.truncate(SCANS);
    log
}

/// The digest after every scan of the log, with 32 particles of two samples.
fn digests<T: Real, const WORKERS: usize>(log: &Log, executor: &(impl Executor + Sync)) -> Vec<u64> {
    let Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } = log.vehicle else {
        panic!("the scenario's vehicle is a car")
    };
    let geometry = AckermannGeometry {
        wheelbase_m: T::from_f64(wheelbase_m),
        encoder_offset_m: T::from_f64(encoder_offset_m),
        sensor_forward_m: T::from_f64(sensor_forward_m),
        sensor_left_m: T::from_f64(sensor_left_m),
    };
    let window = RangeBearingWindow::full_circle(T::from_f64(15.0), T::from_f64(0.95)).unwrap();
    let noise = ControlNoise::white(T::from_f64(1.0), T::from_f64(0.035));
    let motion = Ackermann::new(geometry, noise).unwrap();
    let sensing = Sensing {
        sensor: RangeBearing::new(T::from_f64(0.25), T::from_f64(0.009)).unwrap(),
        field_of_view: window,
        clutter: UniformClutter::of_scan(T::from_f64(20.0), window.measure()).unwrap(),
    };
    let births = Births { of_static: T::from_f64(0.01), of_moving: T::from_f64(0.005) };
    let config = Config { particles: 32, samples: 2, ..Config::default() };
    with_roomy_stack(|| {
        let mut state = Box::new(Memory::<T>::new());
        let mut scratch = Box::new(DetectorMemory::<Vector2<T>, 128, WORKERS>::new());
        let mut radar = Detector::new(sensing, births).unwrap().over(&mut scratch).unwrap();
        let mut filter = ScPhd::new(motion, config, &mut *state).unwrap();
        let [x, y, heading] = log.initial_pose.map(T::from_f64);
        filter.reset(PlanarPose::new(x, y, heading), 1).unwrap();
        let (mut digests, mut resampled) = (Vec::new(), 0);
        for event in events(log) {
            match event {
                Event::Predict { control, dt_s, .. } => {
                    let [speed_mps, steering_rad] = control.map(T::from_f64);
                    filter.predict(&AckermannControl { speed_mps, steering_rad }, T::from_f64(dt_s)).unwrap();
                }
                Event::Scan { index } => {
                    let scan = &log.scans[index].detections;
                    let scan: Vec<_> = scan.iter().map(|z| z.map(T::from_f64).into()).collect();
                    let report = filter.scan_on(&mut radar, &scan, executor, &mut ()).unwrap();
                    assert!(report.in_view > 0 || index == 0);
                    resampled += usize::from(report.resampled);
                    digests.push(filter.digest());
                }
                Event::Fix { .. } => unreachable!("the scenario has no fixes"),
            }
        }
        assert!(resampled > 0);
        digests
    })
}

fn agree<T: Real>() {
    let log = thesis_dynamic();
    let alone = digests::<T, 1>(&log, &Serial);
    assert_eq!(alone.len(), SCANS);
    assert_eq!(digests::<T, 2>(&log, &Serial), alone, "two jobs");
    assert_eq!(digests::<T, 5>(&log, &Backwards), alone, "five jobs, the last first");
    for threads in [2, 5] {
        assert_eq!(digests::<T, 16>(&log, &Threads::new(threads).unwrap()), alone, "{threads} threads");
    }
}

#[test]
fn single_precision() {
    agree::<f32>();
}

#[test]
fn double_precision() {
    agree::<f64>();
}
