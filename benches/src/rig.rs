//! A filter in a world, ready for its next scan.

use crate::world::{Course, Input, World};
use nalgebra::Vector2;
use scphd::{
    Births, Component, Config, Detector, DetectorMemory, Dynamic, KnownPose, MapStorage, Motion, PlanarPose, Probe,
    RangeBearing, RangeBearingWindow, ScPhd, ScanReport, Sensing, State, Static, Symmetric, Unicycle, UnicycleControl,
    UniformClutter,
};
use scphd_sim::session::with_roomy_stack;

/// Room for measurements.
pub const MEASUREMENTS: usize = 256;

/// A motion model that a course can control.
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

/// Something whose scans can be measured.
pub trait Case {
    /// Motion up to the next scan, and its measurements; not measured.
    fn prepare(&mut self);
    /// The scan that was prepared, watched by a probe.
    fn scan(&mut self) -> ScanReport<f32>;
    /// The next inputs.
    fn record(&mut self, scans: usize) -> Vec<Input>;
    /// Goes through inputs, motion and scans.
    fn play(&mut self, inputs: &[Input]);
    /// Components of a particle's map, and of its moving part: means over the particles.
    fn components(&mut self) -> [f64; 2];
}

type RigSensing = Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;

/// A filter in single precision, its memory on the heap.
#[derive(Debug)]
pub struct Rig<M, S, V, const PARTICLES: usize, const CANDIDATES: usize> {
    course: Course,
    motion: M,
    sensing: RigSensing,
    births: Births<f32>,
    config: Config<f32>,
    state: Box<State<PlanarPose<f32>, PARTICLES, CANDIDATES, S, V>>,
    scratch: Box<DetectorMemory<Vector2<f32>, MEASUREMENTS>>,
    measurements: Vec<Vector2<f32>>,
}

impl<M, S, V, const PARTICLES: usize, const CANDIDATES: usize> Rig<M, S, V, PARTICLES, CANDIDATES>
where
    M: Drive,
    S: MapStorage<Static<Vector2<f32>>> + Send,
    V: MapStorage<Dynamic<Vector2<f32>>> + Send,
{
    /// A filter with models that fit the world, which starts with the map `known`, and has seen as many scans.
    ///
    /// # Panics
    /// The filter refuses the world.
    #[must_use]
    pub fn new(
        motion: M,
        births: Births<f32>,
        config: Config<f32>,
        world: World,
        known: &[[f64; 2]],
        scans: usize,
    ) -> Self {
        let window =
            RangeBearingWindow::full_circle(world.range_max_m as f32, world.detection as f32).expect("the view");
        let noise = [World::RANGE_SIGMA_M, World::BEARING_SIGMA_RAD].map(|sigma| sigma as f32);
        let sensing = Sensing {
            sensor: RangeBearing::new(noise[0], noise[1]).expect("the sensor's noise"),
            field_of_view: window,
            clutter: UniformClutter::of_scan(world.clutter_mean() as f32, window.measure()).expect("the clutter"),
        };
        let state = with_roomy_stack(|| Box::new(State::new())).expect("a thread");
        let course = Course::new(world, 1);
        let start = pose(course.start());
        let scratch = Box::new(DetectorMemory::new());
        let mut rig = Self { course, motion, sensing, births, config, state, scratch, measurements: Vec::new() };
        let components: Vec<Component<Vector2<f32>>> = known.iter().enumerate().map(confirmed).collect();
        let mut filter = rig.filter();
        filter.reset(start, 1).expect("a finite pose");
        filter.load_map(&components).expect("room for the map");
        for _ in 0..scans {
            rig.prepare();
            rig.scan();
        }
        rig
    }

    fn filter(&mut self) -> ScPhd<'_, M> {
        ScPhd::new(self.motion, self.config, &mut *self.state).expect("a configuration that fits")
    }

    /// The scan that was prepared, watched by a probe.
    ///
    /// # Panics
    /// The filter refuses the scan.
    pub fn scan_with(&mut self, probe: &mut impl Probe) -> ScanReport<f32> {
        let detector = Detector::new(self.sensing, self.births).expect("models that fit");
        let mut detector = detector.over(&mut self.scratch).expect("scratch that fits");
        let mut filter = ScPhd::new(self.motion, self.config, &mut *self.state).expect("a configuration that fits");
        filter.scan_with(&mut detector, &self.measurements, probe).expect("a scan that fits")
    }

    fn take(&mut self, input: &Input) {
        self.filter().predict(&M::control(input), input.dt_s as f32).expect("a control");
        self.measurements.clear();
        self.measurements.extend(input.measurements.iter().map(|z| Vector2::from(z.map(|number| number as f32))));
    }
}

/// A feature that has been seen often.
fn confirmed((index, place): (usize, &[f64; 2])) -> Component<Vector2<f32>> {
    Component {
        label: index as u32,
        ln_weight: -0.01,
        mean: Vector2::from(place.map(|number| number as f32)),
        covariance: Symmetric::from_diagonal([0.01, 0.01]),
    }
}

impl<M, S, V, const PARTICLES: usize, const CANDIDATES: usize> Case for Rig<M, S, V, PARTICLES, CANDIDATES>
where
    M: Drive,
    S: MapStorage<Static<Vector2<f32>>> + Send,
    V: MapStorage<Dynamic<Vector2<f32>>> + Send,
{
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
        let particles = self.config.particles;
        let filter = self.filter();
        let still: usize = (0..particles).map(|particle| filter.map(particle).count()).sum();
        let moving: usize = (0..particles).map(|particle| filter.moving_map(particle).count()).sum();
        [still, moving].map(|components| components as f64 / particles as f64)
    }
}
