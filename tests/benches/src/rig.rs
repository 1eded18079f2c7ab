//! A filter in a world, ready for its next scan.

use crate::world::{Course, Input, World};
use nalgebra::Vector2;
use scphd::diagnostics::Probe;
use scphd::models::{
    KnownPose, Motion, PlanarPose, RangeBearing, RangeBearingWindow, Sensing, Unicycle, UnicycleControl, UniformClutter,
};
use scphd::numerics::Symmetric;
use scphd::storage::{Dynamic, MapStorage, ScanRoom, Static};
use scphd::{Births, Component, Config, Detector, DetectorMemory, ScPhd, ScanReport, State};
use std::thread;

/// Maximum number of measurements in a scan.
pub const MEASUREMENTS: usize = 256;
/// Number of 64-bit words of measurements that births can wait for: all.
const WAITING: usize = MEASUREMENTS / 64;
/// Stack of the thread that makes a state, bytes: it is on the stack before it is on the heap.
const STACK_BYTES: usize = 512 << 20;

/// A motion model with a control from a course.
pub trait Drive: Motion<Pose = PlanarPose<f32>> + Copy + Send {
    /// The control before a scan.
    fn control(input: &Input) -> Self::Control;
}

impl Drive for Unicycle<f32> {
    fn control(input: &Input) -> UnicycleControl<f32> {
        let [speed_mps, rate_radps] = input.control.map(|number| number as f32);
        UnicycleControl { speed_mps, rate_radps }
    }
}

impl Drive for KnownPose<PlanarPose<f32>> {
    fn control(input: &Input) -> PlanarPose<f32> {
        pose(input.pose)
    }
}

fn pose(numbers: [f64; 3]) -> PlanarPose<f32> {
    let [x, y, heading] = numbers.map(|number| number as f32);
    PlanarPose::new(x, y, heading)
}

/// A case whose scans can be measured.
pub trait Case {
    /// Predicts to the next scan and generates its measurements; not measured.
    fn prepare(&mut self);
    /// Processes the prepared scan, with a probe.
    fn scan(&mut self) -> ScanReport<f32>;
    fn record(&mut self, scans: usize) -> Vec<Input>;
    /// Processes inputs, with motion and scans.
    fn play(&mut self, inputs: &[Input]);
    /// Number of components in a map, and in its moving part: means over the particles.
    fn components(&mut self) -> [f64; 2];
}

type RigSensing = Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;

/// A filter in single precision. Its memory is on the heap and is never freed: the filter borrows it until the end of the
/// program, as on a vehicle.
#[derive(Debug)]
pub struct Rig<M: Drive> {
    course: Course,
    slam: ScPhd<'static, M>,
    detector: Detector<RigSensing, ScanRoom<'static, Vector2<f32>>>,
    measurements: Vec<Vector2<f32>>,
}

impl<M: Drive> Rig<M> {
    /// A filter with models of the world, which starts with the map `known`, after this number of scans. Its maps have the memory
    /// types `S` and `V`.
    pub fn new<S, V, const PARTICLES: usize, const CANDIDATES: usize>(
        motion: M,
        births: Births<f32>,
        config: Config<f32>,
        world: World,
        known: &[[f64; 2]],
        scans: usize,
    ) -> Self
    where
        S: MapStorage<Static<Vector2<f32>>> + Send + 'static,
        V: MapStorage<Dynamic<Vector2<f32>>> + Send + 'static,
    {
        let window =
            RangeBearingWindow::full_circle(world.range_max_m as f32, world.detection as f32).expect("the view");
        let noise = [World::RANGE_SIGMA_M, World::BEARING_SIGMA_RAD].map(|sigma| sigma as f32);
        let sensing = Sensing::range_bearing(noise, window, world.clutter_mean() as f32).expect("the models");
        type Memory<S, V, const N: usize, const C: usize> = State<PlanarPose<f32>, N, C, S, V, WAITING>;
        let make = || Box::new(Memory::<S, V, PARTICLES, CANDIDATES>::new());
        let thread = thread::Builder::new().stack_size(STACK_BYTES).spawn(make).expect("a thread");
        let state = thread.join().expect("room for a state");
        let scratch = Box::leak(Box::new(DetectorMemory::<_, MEASUREMENTS>::new()));
        let mut slam = ScPhd::new(motion, config, Box::leak(state)).expect("a configuration that fits");
        let detector = Detector::new(sensing, births).expect("models that fit").over(scratch);
        let course = Course::new(world, 1);
        let components: Vec<Component<Vector2<f32>>> = known.iter().enumerate().map(confirmed).collect();
        slam.reset(pose(course.start()), 1).expect("a finite pose");
        slam.load_map(&components).expect("room for the map");
        let mut rig = Self { course, slam, detector: detector.expect("scratch that fits"), measurements: Vec::new() };
        for _ in 0..scans {
            rig.prepare();
            rig.scan();
        }
        rig
    }

    /// Processes the prepared scan, with a probe.
    pub fn scan_with(&mut self, probe: &mut impl Probe) -> ScanReport<f32> {
        self.slam.scan_with(&mut self.detector, &self.measurements, probe).expect("a scan that fits")
    }

    fn take(&mut self, input: &Input) {
        self.slam.predict(&M::control(input), input.dt_s as f32).expect("a control");
        self.measurements.clear();
        self.measurements.extend(input.measurements.iter().map(|z| Vector2::from(z.map(|number| number as f32))));
    }
}

/// A feature with high existence probability.
fn confirmed((index, place): (usize, &[f64; 2])) -> Component<Vector2<f32>> {
    Component {
        label: index as u32,
        ln_weight: -0.01,
        mean: Vector2::from(place.map(|number| number as f32)),
        covariance: Symmetric::from_diagonal([0.01, 0.01]),
    }
}

impl<M: Drive> Case for Rig<M> {
    fn prepare(&mut self) {
        let input = self.course.advance();
        self.take(&input);
    }

    fn scan(&mut self) -> ScanReport<f32> {
        self.scan_with(&mut ())
    }

    fn record(&mut self, scans: usize) -> Vec<Input> {
        (0..scans).map(|_| self.course.advance()).collect()
    }

    fn play(&mut self, inputs: &[Input]) {
        for input in inputs {
            self.take(input);
            self.scan();
        }
    }

    fn components(&mut self) -> [f64; 2] {
        let (slam, particles) = (&self.slam, self.slam.particles());
        let still: usize = (0..particles).map(|particle| slam.map(particle).count()).sum();
        let moving: usize = (0..particles).map(|particle| slam.moving_map(particle).count()).sum();
        [still, moving].map(|components| components as f64 / particles as f64)
    }
}
