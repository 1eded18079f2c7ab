//! The state of the filter does not depend on the executor of its jobs, or on their number.

use nalgebra::Vector2;
use scphd::diagnostics::{Probe, Stage};
use scphd::models::{
    Ackermann, AckermannControl, AckermannGeometry, ControlNoise, PlanarPose, RangeBearing, RangeBearingWindow,
    Sensing, UniformClutter,
};
use scphd::settings::{Informed, Proposal};
use scphd::storage::{Dynamic, Executor, MapMemory, MapStorage, NoMoving, Serial, Static, UpdateMemory};
use scphd::{Births, Config, Detector, DetectorMemory, Real, ScPhd, ScanReport, State};
use scphd_filters::threads::Threads;
use scphd_log::events::{Event, events};
use scphd_log::log::{Log, Vehicle};
use scphd_tests::with_roomy_stack;
use scphd_worlds::scenario;
use std::marker::PhantomData;

/// Enough for two rounds of the loop among moving features, and for resampling.
const SCANS: usize = 300;
/// Enough to exceed small capacities.
const FEW_SCANS: usize = 100;

type Still<T, const N: usize, const PAGES: usize, const MAP_PAGES: usize, const VIEW: usize> =
    MapMemory<Static<Vector2<T>>, N, PAGES, MAP_PAGES, VIEW>;
type Moving<T, const N: usize, const PAGES: usize, const MAP_PAGES: usize, const VIEW: usize> =
    MapMemory<Dynamic<Vector2<T>>, N, PAGES, MAP_PAGES, VIEW>;

/// Executors. A single type, so that the filter is compiled only once.
#[derive(Clone, Copy)]
enum Hands<'t> {
    Serial,
    /// In reverse order.
    Backwards,
    Threads(&'t Threads),
    /// Omits every other job.
    Careless,
    /// Omits updates, except for this number of jobs in a round.
    Tired(usize),
}

impl Executor for Hands<'_> {
    fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync) {
        let updates = std::any::type_name::<J>().contains("Draft");
        match *self {
            Self::Backwards => jobs.collect::<Vec<J>>().into_iter().rev().for_each(work),
            Self::Threads(threads) => threads.run(jobs, work),
            Self::Careless => jobs.step_by(2).for_each(work),
            Self::Tired(done) if updates => jobs.skip(1).take(done).for_each(work),
            Self::Serial | Self::Tired(_) => Serial.run(jobs, work),
        }
    }
}

/// Parameters of a filter whose state has these maps.
struct Rig<T: Real, S, V, const N: usize, const C: usize> {
    log: Log,
    config: Config<T>,
    births: Births<T>,
    maps: PhantomData<fn() -> (S, V)>,
}

/// The results to compare after every scan: digest and report.
type Told<T> = Vec<(u64, ScanReport<T>)>;

impl<T: Real, S: MapStorage<Static<Vector2<T>>>, V: MapStorage<Dynamic<Vector2<T>>>, const N: usize, const C: usize>
    Rig<T, S, V, N, C>
{
    fn new(scans: usize, of_moving: f64, config: Config<T>) -> Self {
        let mut log = scenario::thesis_dynamic(1);
        log.scans.truncate(scans);
        let births = Births { of_static: T::from_f64(0.01), of_moving: T::from_f64(of_moving) };
        Self { log, config, births, maps: PhantomData }
    }

    /// Runs with this executor, and these numbers of jobs and drafts; without an executor in the plain call.
    fn told<const WORKERS: usize, const DRAFTS: usize>(&self, hands: Option<Hands<'_>>) -> Told<T> {
        with_roomy_stack(|| self.drive::<WORKERS, DRAFTS>(hands))
    }

    fn alone(&self) -> Told<T> {
        self.told::<1, 0>(None)
    }

    fn drive<const WORKERS: usize, const DRAFTS: usize>(&self, hands: Option<Hands<'_>>) -> Told<T> {
        let log = &self.log;
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
        let sensing = Sensing::range_bearing([0.25, 0.009].map(T::from_f64), window, T::from_f64(20.0)).unwrap();
        let mut state = Box::new(State::<PlanarPose<T>, N, C, S, V>::new());
        let mut updates = Box::new(UpdateMemory::<State<PlanarPose<T>, N, C, S, V>, DRAFTS>::new());
        let mut scratch = Box::new(DetectorMemory::<Vector2<T>, 128, WORKERS>::new());
        let mut radar = Detector::new(sensing, self.births).unwrap().over(&mut scratch).unwrap();
        let mut filter = ScPhd::new(motion, self.config, &mut *state).unwrap();
        let [x, y, heading] = log.initial_pose.map(T::from_f64);
        filter.reset(PlanarPose::new(x, y, heading), 1).unwrap();
        let mut drafts = updates.drafts();
        let mut told = Vec::new();
        for event in events(log) {
            match event {
                Event::Predict { control, dt_s, .. } => {
                    let [speed_mps, steering_rad, _] = control.map(T::from_f64);
                    filter.predict(&AckermannControl { speed_mps, steering_rad }, T::from_f64(dt_s)).unwrap();
                }
                Event::Scan { index } => {
                    let scan = &log.scans[index].detections;
                    let scan: Vec<_> = scan.iter().map(|z| z.map(T::from_f64).into()).collect();
                    let report = match &hands {
                        Some(hands) => filter.scan_on(&mut radar, &scan, hands, &mut drafts, &mut ()),
                        None => filter.scan(&mut radar, &scan),
                    };
                    told.push((filter.digest(), report.unwrap()));
                    filter.audit().unwrap();
                }
                Event::Fix { .. } => unreachable!("the scenario has no fixes"),
            }
        }
        told
    }

    /// Asserts that the results do not depend on jobs and drafts, and returns the reports.
    fn agree(&self) -> Vec<ScanReport<T>> {
        let alone = self.alone();
        let threads = [2, 3].map(|threads| Threads::new(threads).unwrap());
        let assert = |told: Told<T>, what: &str| {
            let differs = told.iter().zip(&alone).position(|(told, alone)| told != alone);
            assert_eq!(differs, None, "{what}: {:?}", differs.map(|scan| (&told[scan], &alone[scan])));
            assert_eq!(told.len(), alone.len(), "{what}");
        };
        assert(self.told::<1, 4>(Some(Hands::Serial)), "one job, four drafts");
        assert(self.told::<2, 2>(Some(Hands::Threads(&threads[0]))), "two jobs of a draft each");
        assert(self.told::<3, 7>(Some(Hands::Backwards)), "three jobs, seven drafts, the last one first");
        assert(self.told::<7, 16>(Some(Hands::Threads(&threads[1]))), "seven jobs, sixteen drafts");
        assert(self.told::<2, 0>(Some(Hands::Backwards)), "two jobs, no drafts");
        assert(self.told::<2, 5>(Some(Hands::Tired(0))), "no draft is made");
        assert(self.told::<7, 7>(Some(Hands::Tired(2))), "two of seven drafts are made");
        alone.into_iter().map(|(_, report)| report).collect()
    }
}

fn config<T: Real>(particles: usize, samples: usize) -> Config<T> {
    Config { particles, samples, ..Config::default() }
}

fn roomy<T: Real>() {
    type Roomy<T> = Rig<T, Still<T, 32, 512, 64, 512>, Moving<T, 32, 256, 32, 256>, 32, 64>;
    let reports = Roomy::<T>::new(SCANS, 0.005, config(32, 2)).agree();
    assert_eq!(reports.len(), SCANS);
    let several = |report: &&ScanReport<T>| report.resampled && report.survivors > 2 && report.survivors < 32;
    assert!(reports.iter().filter(several).count() > 10);
    assert!(reports.iter().any(|report| report.innovation > T::ZERO && report.merged > 0));
    assert!(reports.iter().all(|report| report.tightened == 0));
}

#[test]
fn single_precision() {
    roomy::<f32>();
}

#[test]
fn double_precision() {
    roomy::<f64>();
}

#[test]
fn an_informed_proposal() {
    let proposal = Proposal::Informed(Informed { sampled_fraction: 0.5, ..Informed::default() });
    let config = Config { proposal, ..config(8, 1) };
    let reports =
        Rig::<f32, Still<f32, 8, 512, 64, 512>, Moving<f32, 8, 256, 32, 256>, 8, 8>::new(FEW_SCANS, 0.005, config)
            .agree();
    assert!(reports.iter().any(|report| report.resampled));
}

#[test]
fn a_lone_particle() {
    let rig = Rig::<f32, Still<f32, 1, 64, 64, 512>, NoMoving, 1, 1>::new(FEW_SCANS, 0.0, config(1, 1));
    assert!(rig.agree().iter().all(|report| report.survivors == 1));
}

/// Pools that are too small: the memory for a survivor depends on all survivors before it.
fn short_of_pages<T: Real>() {
    let rig = Rig::<T, Still<T, 16, 60, 12, 512>, Moving<T, 16, 24, 6, 256>, 16, 32>::new(SCANS, 0.005, config(16, 2));
    let reports = rig.agree();
    assert!(reports.iter().filter(|report| report.tightened > 0).count() > SCANS / 2);
    assert!(reports.iter().any(|report| report.not_updated > 0));
    assert!(reports.iter().any(|report| report.tightened == 0 && report.survivors > 2));
}

#[test]
fn pools_that_run_short() {
    short_of_pages::<f32>();
}

#[test]
fn pools_that_run_short_in_double_precision() {
    short_of_pages::<f64>();
}

#[test]
fn workspaces_that_are_too_small() {
    let rig =
        Rig::<f32, Still<f32, 8, 512, 64, 16>, Moving<f32, 8, 256, 32, 8>, 8, 16>::new(SCANS, 0.005, config(8, 2));
    assert!(rig.agree().iter().filter(|report| report.tightened > 0).count() > SCANS / 2);
}

#[test]
fn smallest_capacities() {
    let rig = Rig::<f32, Still<f32, 3, 1, 1, 8>, Moving<f32, 3, 1, 1, 8>, 3, 3>::new(FEW_SCANS, 0.005, config(3, 1));
    assert!(rig.agree().iter().any(|report| report.tightened > 0 || report.not_updated > 0));
}

/// A sensor with a range of 30 m.
fn far_sighted() -> Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>> {
    Sensing::range_bearing([0.2, 0.02], RangeBearingWindow::full_circle(30.0, 0.9).unwrap(), 1.0).unwrap()
}

#[test]
fn drafts_of_other_capacities_are_ignored() {
    // Drafts of a state with smaller capacity in an update, and of one with larger capacity.
    type Mine = State<PlanarPose<f32>, 4, 4, Still<f32, 4, 64, 16, 64>>;
    type Less = State<PlanarPose<f32>, 4, 4, Still<f32, 4, 64, 16, 32>>;
    type More = State<PlanarPose<f32>, 4, 4, Still<f32, 4, 64, 16, 96>>;
    let (mut mine, mut less, mut more) =
        (UpdateMemory::<Mine, 2>::new(), UpdateMemory::<Less, 2>::new(), UpdateMemory::<More, 2>::new());
    let mut digests = Vec::new();
    for drafts in [&mut mine.drafts(), &mut less.drafts(), &mut more.drafts()] {
        let mut state = Box::new(Mine::new());
        let mut scratch = Box::new(DetectorMemory::<Vector2<f32>, 64, 2>::new());
        let mut radar = Detector::new(far_sighted(), Births::of_static(0.01)).unwrap().over(&mut scratch).unwrap();
        let mut filter = ScPhd::new(scphd::models::KnownPose::new(), config(4, 1), &mut *state).unwrap();
        let here = PlanarPose::new(0.0, 0.0, 0.0);
        filter.reset(here, 1).unwrap();
        // More measurements than the least of these capacities.
        let scan: Vec<_> = (0..48).map(|k| Vector2::new(8.0 + (k % 5) as f32, 0.13 * k as f32 - 3.1)).collect();
        for _ in 0..5 {
            filter.predict(&here, 0.1).unwrap();
            let report = filter.scan_on(&mut radar, &scan, &Hands::Backwards, drafts, &mut ()).unwrap();
            assert_eq!(report.maps_updated, report.survivors);
        }
        digests.push(filter.digest());
    }
    assert!(digests.iter().all(|digest| *digest == digests[0]), "{digests:x?}");
}

/// If jobs of weighting are omitted, some candidates keep their weights: the state differs, but is valid.
#[test]
fn omitted_jobs_leave_a_valid_state() {
    type Roomy = Rig<f32, Still<f32, 32, 512, 64, 512>, Moving<f32, 32, 256, 32, 256>, 32, 64>;
    let rig = Roomy::new(FEW_SCANS, 0.005, config(32, 2));
    let careless = rig.told::<4, 8>(Some(Hands::Careless));
    assert_ne!(careless, rig.alone());
    assert!(careless.iter().all(|(_, report)| report.particles == 32 && report.not_updated == 0));
}

/// Records the stages that it is notified of.
#[derive(Default)]
struct Listener {
    open: Vec<Stage>,
    updates: usize,
    reductions: usize,
}

impl Probe for Listener {
    fn enter(&mut self, stage: Stage) {
        assert!(!self.open.contains(&stage), "{stage:?} begins twice");
        self.open.push(stage);
        self.updates += usize::from(stage == Stage::Update);
        self.reductions += usize::from(stage == Stage::Reduce);
    }

    fn leave(&mut self, stage: Stage) {
        assert_eq!(self.open.pop(), Some(stage));
    }
}

/// The probe is called only on the calling core, for the reductions that drafts leave to it.
#[test]
fn a_probe_is_called_for_stages_on_the_calling_core() {
    type Memory = State<PlanarPose<f32>, 4, 4, Still<f32, 4, 64, 16, 64>>;
    let mut state = Box::new(Memory::new());
    let mut updates = Box::new(UpdateMemory::<Memory, 2>::new());
    let mut scratch = Box::new(DetectorMemory::<Vector2<f32>, 64, 2>::new());
    let mut radar = Detector::new(far_sighted(), Births::of_static(0.01)).unwrap().over(&mut scratch).unwrap();
    let mut filter = ScPhd::new(scphd::models::KnownPose::new(), config(4, 1), &mut *state).unwrap();
    let here = PlanarPose::new(0.0, 0.0, 0.0);
    filter.reset(here, 1).unwrap();
    let scan = [Vector2::new(5.0, 0.3)];
    let mut reductions = Vec::new();
    for (hands, count) in [(Hands::Backwards, 2), (Hands::Tired(0), 2), (Hands::Backwards, 0)] {
        filter.predict(&here, 0.1).unwrap();
        let (mut listener, mut drafts) = (Listener::default(), updates.drafts());
        let report = filter.scan_on(&mut radar, &scan, &hands, &mut drafts[..count], &mut listener);
        assert_eq!((report.unwrap().survivors, listener.updates), (4, 1));
        assert!(listener.open.is_empty());
        reductions.push(listener.reductions);
    }
    assert_eq!(reductions, [0, 4, 4]);
}
