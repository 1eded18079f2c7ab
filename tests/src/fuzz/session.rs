//! Sessions of a mixture: random operations from the first reset on, with a check of the whole state after each.

use super::counts::count;
use super::draw::Draw;
use super::fixes::{Placed, observe};
use super::scans::seen;
use super::tuning::{Room, births, config};
use super::worlds::{Drawn, FeatureOf, MeasurementOf, Models, ModelsOf, World};
use super::{Failure, Operations, Watch, require};
use scphd::diagnostics::Scrubber;
use scphd::errors::SetupError;
use scphd::models::{MeasurementModel, Mounting, Pose, TangentOf};
use scphd::numerics::{Symmetric, Vector};
use scphd::snapshot::{RestoreError, SliceEnd, from_slice};
use scphd::storage::{Draft, Dynamic, Executor, MapStorage, ScanRoom, Static, UpdateMemory};
use scphd::{
    Births, Component, Config, Detector, DetectorMemory, MapEstimate, PoseEstimate, Real, ScPhd, ScanReport, State,
};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Parameters of a session.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seeded {
    pub(super) seed: u64,
    /// Probability that a number is hostile.
    pub(super) hostility: f64,
}

impl Seeded {
    /// The session of a seed, and random numbers for the choice of its kind.
    pub(super) fn of(seed: u64, target: u64) -> (Self, Draw) {
        let mut draw = Draw::new(seed ^ target, 0.0);
        let hostility = [0.0, 0.0, 1e-4, 1e-3, 1e-2, 0.1][draw.below(6)];
        (Self { seed, hostility }, draw)
    }

    /// The random numbers of an operation. They are independent of earlier operations, so that those can be left out.
    pub(super) fn draw(&self, operation: usize) -> Draw {
        Draw::new(self.seed.wrapping_add((operation as u64 + 1).wrapping_mul(0xd1b5_4a32_d192_ed03)), self.hostility)
    }
}

/// Number of maps that are updated at a time.
const DRAFTS: usize = 3;

/// An executor that runs the jobs in reverse order.
struct Backwards;

impl Executor for Backwards {
    fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync) {
        let mut jobs: Vec<J> = jobs.collect();
        while let Some(job) = jobs.pop() {
            work(job);
        }
    }
}

type Eye<W, R> = Detector<<W as World>::Sensing, R>;

struct Filter<'s, W: World> {
    slam: ScPhd<'s, W::Motion>,
    eye: Eye<W, ScanRoom<'s, MeasurementOf<W>>>,
    drafts: [Draft<'s, FeatureOf<W>>; DRAFTS],
}

impl<W: World> Filter<'_, W> {
    fn digest(&self) -> u64 {
        self.slam.digest()
    }
}

/// The parts of a filter and its detector.
struct Design<W: World> {
    models: ModelsOf<W>,
    mounting: Option<Mounting<W::Scalar>>,
    births: Births<W::Scalar>,
    tuning: Config<W::Scalar>,
}

impl<W: World> Design<W> {
    /// A random design, or the error that refuses it.
    fn draw(draw: &mut Draw, room: Room) -> Result<Self, SetupError> {
        let tuning = config(draw, room);
        let models = W::models(draw)?;
        let mounting = if draw.chance(0.5) { Some(W::Pose::mounting(draw)?) } else { None };
        let design = Self { models, mounting, births: births(draw, room), tuning };
        design.tuning.check()?;
        design.detector()?;
        Ok(design)
    }

    fn detector(&self) -> Result<Eye<W, ()>, SetupError> {
        let detector = Detector::new(self.models.sensing, self.births)?;
        Ok(match self.mounting {
            Some(mounting) => detector.mounted(mounting)?,
            None => detector,
        })
    }

    /// Builds the filter in this memory.
    fn build<
        's,
        const N: usize,
        const C: usize,
        const M: usize,
        SM: MapStorage<Static<FeatureOf<W>>>,
        VM: MapStorage<Dynamic<FeatureOf<W>>>,
    >(
        &self,
        state: &'s mut State<W::Pose, N, C, SM, VM>,
        scratch: &'s mut DetectorMemory<MeasurementOf<W>, M, 2>,
        updates: &'s mut UpdateMemory<State<W::Pose, N, C, SM, VM>, DRAFTS>,
    ) -> Result<Filter<'s, W>, SetupError> {
        let slam = ScPhd::new(self.models.motion, self.tuning, state)?;
        let eye = self.detector()?.over(scratch)?;
        slam.check(&eye)?;
        Ok(Filter { slam, eye, drafts: updates.drafts() })
    }
}

struct Session<W: World> {
    room: Room,
    /// Landmarks that can be detected again.
    landmarks: Vec<FeatureOf<W>>,
    /// The last snapshot and the digest of its filter; `None` after another filter took over, whose digest may differ.
    saved: Option<(Vec<u8>, Option<u64>)>,
    scrubber: Scrubber,
    /// Description of the last operation.
    told: String,
}

/// The continuation after an operation.
enum Next {
    Go,
    /// Another filter continues with the same state.
    TakeOver,
}

/// Runs a session with a state of these capacities.
pub(super) fn run<
    W: World<Pose: Placed>,
    const N: usize,
    const C: usize,
    const M: usize,
    SM: MapStorage<Static<FeatureOf<W>>>,
    VM: MapStorage<Dynamic<FeatureOf<W>>>,
>(
    seeded: Seeded,
    operations: &Operations<'_>,
    watch: &Watch,
) -> Result<(), Failure> {
    let mut state = Box::new(State::<W::Pose, N, C, SM, VM>::new());
    let mut scratch = Box::new(DetectorMemory::<MeasurementOf<W>, M, 2>::new());
    let mut updates = Box::new(UpdateMemory::<State<W::Pose, N, C, SM, VM>, DRAFTS>::new());
    let room = Room { particles: N, candidates: C, measurements: M, moving: VM::PARTICLES > 0 };
    let mut session =
        Session::<W> { room, landmarks: Vec::new(), saved: None, scrubber: Scrubber::new(), told: String::new() };
    let mut setup = Draw::new(seeded.seed, seeded.hostility);
    let mut calm = Draw::new(seeded.seed, 0.0);
    let mut design = loop {
        // A refused design is drawn again, sooner or later without hostile numbers.
        let (draw, calm_one) = if setup.chance(0.9) { (&mut setup, false) } else { (&mut calm, true) };
        let drawn = Design::<W>::draw(draw, room);
        count("set up", &drawn);
        match drawn {
            Ok(design) => break design,
            Err(SetupError::Model(error)) if calm_one => panic!("plausible models are refused: {error}"),
            Err(_) => (),
        }
    };
    let mut left = operations.indices.iter().copied().peekable();
    let mut count = 0;
    let mut next = None;
    while left.peek().is_some() {
        // If the new filter does not fit the state it is refused, and the previous one continues.
        if let Some(other) = next.take()
            && Design::build(&other, &mut state, &mut scratch, &mut updates).is_ok()
        {
            design = other;
        }
        let mut filter = match design.build(&mut state, &mut scratch, &mut updates) {
            Ok(filter) => filter,
            // Births of the models beyond the capacity of an update, before there is a filter.
            Err(_) if count == 0 => return Ok(()),
            Err(error) => {
                return Err(Failure { operation: 0, what: format!("the state it left is refused: {error}") });
            }
        };
        for index in left.by_ref() {
            watch.at(seeded.seed, index);
            let mut draw = seeded.draw(index);
            session.told.clear();
            let done = session.operate(&mut filter, &mut draw, count);
            count += 1;
            if operations.tell {
                println!("  {index}: {}", session.told);
            }
            let failed = |what| Failure { operation: index, what };
            let done = done.and_then(|done| session.check(&mut filter).map(|()| done));
            if let Next::TakeOver = done.map_err(failed)? {
                let (motion, sensing) = (*filter.slam.motion(), *filter.eye.sensing());
                let models = Models { motion, sensing };
                let (mounting, births) = (filter.eye.mounting().copied(), births(&mut draw, room));
                let tuning = config(&mut draw, room);
                session.saved = session.saved.take().map(|(bytes, _)| (bytes, None));
                next = Some(Design { models, mounting, births, tuning });
                break;
            }
        }
    }
    Ok(())
}

/// Vehicle type in the snapshots of these sessions.
const KIND: u32 = 40;

/// A sink that appends to a vector.
fn into_vec(bytes: &mut Vec<u8>) -> impl FnMut(&[u8]) -> Result<(), SliceEnd> {
    |piece| {
        bytes.extend_from_slice(piece);
        Ok(())
    }
}

/// Greatest difference of a sum of weights from one.
fn tolerance<T: Real>() -> f64 {
    if T::EPSILON.to_f64() > 1e-10 { 1e-5 } else { 1e-12 }
}

impl<T: Real, W: World<Scalar = T, Pose: Placed>> Session<W> {
    fn operate(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw, count: usize) -> Result<Next, String> {
        // The first operation is usually a reset.
        let kind = if count == 0 && draw.chance(0.95) { 0 } else { 3 + draw.below(97) };
        match kind {
            0..5 => self.reset(filter, draw)?,
            5..40 => self.predict(filter, draw)?,
            40..74 => self.scan(filter, draw)?,
            74..77 => self.load_map(filter, draw)?,
            77..79 => self.change_models(filter, draw),
            79..82 => self.place(filter, draw)?,
            82..86 => self.observe(filter, draw)?,
            86..88 => self.save(filter)?,
            88..90 => self.restore(filter, draw)?,
            90..93 => self.scrub(filter, draw)?,
            93..98 => self.estimate(filter, draw)?,
            _ => {
                self.tell(format_args!("take the state over"));
                return Ok(Next::TakeOver);
            }
        }
        Ok(Next::Go)
    }

    fn tell(&mut self, what: std::fmt::Arguments<'_>) {
        let _ = self.told.write_fmt(what);
    }

    fn reset(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) -> Result<(), String> {
        let (before, pose, seed) = (filter.digest(), W::Pose::drawn(draw), draw.word());
        let outcome = filter.slam.reset(pose, seed);
        count("reset", &outcome);
        self.tell(format_args!("reset({pose:?}, {seed}): {outcome:?}"));
        if outcome.is_ok() {
            self.landmarks = (0..8).map(|_| W::feature(draw, &pose)).collect();
            return Ok(());
        }
        require(filter.digest() == before, || "a refused reset changed the state".into())
    }

    fn predict(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) -> Result<(), String> {
        let from = filter.slam.candidates().first().map_or(W::Pose::ZERO, |candidate| candidate.pose);
        let control = W::control(draw, &from);
        let dt: T = if draw.chance(0.05) { draw.real(0.0, 60.0) } else { draw.real(0.0, 0.2) };
        let outcome = filter.slam.predict(&control, dt);
        count("predict", &outcome);
        self.tell(format_args!("predict({control:?}, {dt}): {outcome:?}"));
        let Ok(report) = outcome else { return Ok(()) };
        require(report.candidates == filter.slam.candidates().len() && report.rejected <= report.candidates, || {
            format!("{report:?} of {} candidates", filter.slam.candidates().len())
        })
    }

    fn scan(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) -> Result<(), String> {
        let here = filter.slam.estimate_pose().map(|pose| pose.mean);
        let measurements = seen::<W, _>(draw, &filter.eye, &self.landmarks, here, self.room.measurements);
        let before = filter.digest();
        let outcome = if draw.chance(0.5) {
            filter.slam.scan_on(&mut filter.eye, &measurements, &Backwards, &mut filter.drafts, &mut ())
        } else {
            filter.slam.scan(&mut filter.eye, &measurements)
        };
        count("scan", &outcome);
        let listed: Vec<_> = measurements.iter().map(Vector::as_slice).collect();
        self.tell(format_args!("scan({listed:?}): {outcome:?}"));
        match outcome {
            Ok(report) => sound_report(&report),
            Err(_) => require(filter.digest() == before, || "a refused scan changed the state".into()),
        }
    }

    fn load_map(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) -> Result<(), String> {
        let from = filter.slam.candidates().first().map_or(W::Pose::ZERO, |candidate| candidate.pose);
        let map: Vec<Component<FeatureOf<W>>> = (0..draw.below(20))
            .map(|index| {
                let mean = W::feature(draw, &from);
                let length = draw.magnitude(1e-4, 5.0);
                Component {
                    label: if draw.chance(0.05) { draw.word() as u32 } else { index as u32 },
                    ln_weight: draw.real(-4.0, 1.0),
                    mean,
                    covariance: Symmetric::from_fn(|row, column| {
                        let plausible = if row == column { length } else { 0.3 * length };
                        T::from_f64(draw.spoilt(plausible))
                    }),
                }
            })
            .collect();
        let before = filter.digest();
        let outcome = filter.slam.load_map(&map);
        count("load a map", &outcome);
        self.tell(format_args!("load_map({map:?}): {outcome:?}"));
        if outcome.is_ok() {
            self.landmarks.extend(map.iter().take(4).map(|component| component.mean));
            let beyond = self.landmarks.len().saturating_sub(12);
            self.landmarks.drain(..beyond);
            return Ok(());
        }
        require(filter.digest() == before, || "a refused map changed the state".into())
    }

    fn change_models(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) {
        let drawn = W::models(draw);
        self.tell(format_args!("change the models: {drawn:?}"));
        if let Ok(models) = drawn {
            let outcome = (filter.slam.retune(models.motion), filter.eye.retune(models.sensing));
            count("retune", &outcome.0);
            count("retune a detector", &outcome.1);
            self.tell(format_args!(": {outcome:?}"));
        }
    }

    /// Sets the pose, or adds to its uncertainty.
    fn place(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) -> Result<(), String> {
        let (before, pose, seed) = (filter.digest(), W::Pose::drawn(draw), draw.word());
        let variance = draw.magnitude(1e-6, 4.0);
        let doubt: Symmetric<TangentOf<W::Pose>> = Symmetric::from_fn(|row, column| {
            T::from_f64(draw.spoilt(if row == column { variance } else { 0.2 * variance }))
        });
        let (name, outcome) = match draw.below(3) {
            0 => ("reset within", filter.slam.reset_within(pose, &doubt, seed)),
            1 => ("relocate", filter.slam.relocate(pose, &doubt)),
            _ => ("scatter", filter.slam.scatter(&doubt)),
        };
        count(name, &outcome);
        self.tell(format_args!("{name}({pose:?}, {doubt:?}): {outcome:?}"));
        require(outcome.is_ok() || filter.digest() == before, || "a refused pose changed the state".into())
    }

    fn observe(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) -> Result<(), String> {
        let before = filter.digest();
        let near = filter.slam.candidates().first().map_or(W::Pose::ZERO, |candidate| candidate.pose);
        let sensor = *filter.eye.sensing().sensor();
        let outcome = observe::<T, W>(draw, &sensor, &near, &mut filter.slam);
        count("observe", &outcome);
        self.tell(format_args!("observe: {outcome:?}"));
        match outcome {
            Ok(report) if report.accepted => {
                require(report.distance >= T::ZERO && report.n_eff >= T::from_f64(0.999), || format!("{report:?}"))
            }
            _ => require(filter.digest() == before, || "a fix that was left out changed the state".into()),
        }
    }

    fn save(&mut self, filter: &mut Filter<'_, W>) -> Result<(), String> {
        let mut bytes = Vec::new();
        let outcome = filter.slam.save(KIND, into_vec(&mut bytes));
        count("save", &outcome);
        self.tell(format_args!("save: {outcome:?}"));
        if let Err(error) = outcome {
            let started = !filter.slam.candidates().is_empty();
            return require(!started, || format!("a sound state is not saved: {error}"));
        }
        self.saved = Some((bytes, Some(filter.slam.digest())));
        Ok(())
    }

    /// Restores a snapshot, or attempts to with a part of it or with another kind.
    fn restore(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) -> Result<(), String> {
        let Some((bytes, saved)) = self.saved.clone() else { return Ok(()) };
        let before = filter.digest();
        let (cut, kind) = match draw.below(6) {
            0 => (draw.below(bytes.len()), KIND),
            1 => (bytes.len(), KIND + 1),
            _ => (bytes.len(), KIND),
        };
        let whole = cut == bytes.len() && kind == KIND;
        let outcome = filter.slam.restore(kind, from_slice(&bytes[..cut]));
        count("restore", &outcome);
        self.tell(format_args!("restore {cut} of {} bytes: {outcome:?}", bytes.len()));
        match outcome {
            // The configuration may have been changed since.
            Err(RestoreError::Setup(_)) => require(filter.digest() == before, || "refused, and not as before".into()),
            Err(error) => {
                require(!whole, || format!("what was saved is refused: {error}"))?;
                require(filter.digest() == before, || "a refused snapshot changed the state".into())
            }
            Ok(_) => {
                require(whole, || "a snapshot was taken that is none".into())?;
                let same = saved.is_none_or(|saved| filter.slam.digest() == saved);
                require(same, || "another state than was saved".into())
            }
        }
    }

    fn scrub(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) -> Result<(), String> {
        let (before, seal) = (filter.digest(), filter.slam.seal());
        let outcome = filter.slam.scrub(&mut self.scrubber, 1 + draw.below(40));
        count("scrub", &outcome);
        self.tell(format_args!("scrub: {outcome:?}"));
        match outcome {
            Ok(scrubbed) if scrubbed.is_clean() => {
                let same = (filter.digest(), filter.slam.seal()) == (before, seal);
                require(same, || "scrubbing changed what is sound".into())
            }
            Ok(_) => Ok(()),
            Err(flaw) => Err(format!("what is sound cannot be mended: {flaw}")),
        }
    }

    fn estimate(&mut self, filter: &mut Filter<'_, W>, draw: &mut Draw) -> Result<(), String> {
        self.tell(format_args!("estimate"));
        count::<_, ()>("estimate", &Ok(()));
        let before = filter.digest();
        let mut features = vec![Component::ZERO; draw.below(40)];
        let map = filter.slam.estimate_map(&filter.eye, &mut features);
        sound_estimate(&map, &features)?;
        let mut features = vec![Component::ZERO; draw.below(40)];
        let map = filter.slam.estimate_moving(&mut features);
        sound_estimate(&map, &features)?;
        require(filter.digest() == before, || "an estimate changed the state".into())
    }

    /// Checks the whole state.
    fn check(&self, filter: &mut Filter<'_, W>) -> Result<(), String> {
        filter.slam.audit().map_err(|flaw| {
            let odd = |ln_weight: T, sound: bool| !(ln_weight.is_finite() && sound);
            let maps = 0..filter.slam.particles();
            let still = maps.clone().flat_map(|particle| filter.slam.map(particle));
            let still: Vec<_> = still.filter(|c| odd(c.ln_weight, c.covariance.factor().is_some())).collect();
            let moving = maps.flat_map(|particle| filter.slam.moving_map(particle));
            let moving: Vec<_> = moving.filter(|c| odd(c.ln_weight, c.covariance.factor().is_some())).collect();
            format!("{flaw}: {still:?} {moving:?}")
        })?;
        let candidates = filter.slam.candidates();
        if candidates.is_empty() {
            return require(filter.slam.estimate_pose().is_none(), || "a pose before the first reset".into());
        }
        let total: f64 = candidates.iter().map(|candidate| candidate.ln_weight.to_f64().exp()).sum();
        require((total - 1.0).abs() <= tolerance::<T>(), || format!("weights sum to {total}"))?;
        require(filter.slam.waited_s() >= T::ZERO && filter.slam.waited_s().is_finite(), || "time runs away".into())?;
        require(
            filter.slam.heaviest() < filter.slam.particles() && filter.slam.particles() <= self.room.particles,
            || format!("{} of {} particles is the heaviest", filter.slam.heaviest(), filter.slam.particles()),
        )?;
        require(filter.slam.ln_likelihoods().iter().all(|ln_l| *ln_l < T::INFINITY), || {
            "a likelihood is infinite".into()
        })?;
        let Some(PoseEstimate { mean, covariance }) = filter.slam.estimate_pose() else {
            return Err("no pose".into());
        };
        require(mean.is_finite() && covariance.is_finite(), || format!("the pose is {mean:?} ± {covariance:?}"))?;
        require((0..TangentOf::<W::Pose>::DIMENSION).all(|k| covariance.get(k, k) >= T::ZERO), || {
            format!("the pose varies by {covariance:?}")
        })?;
        for particle in 0..filter.slam.particles() {
            own_tags(filter.slam.map(particle))?;
            own_tags(filter.slam.moving_map(particle))?;
        }
        Ok(())
    }
}

/// Checks that labels are unique among components of one kind in a map.
fn own_tags<'c, N: Vector>(map: impl Iterator<Item = &'c Component<N>>) -> Result<(), String> {
    let mut labels = BTreeSet::new();
    for component in map {
        require(labels.insert(component.label), || format!("two components have the label {}", component.label))?;
    }
    Ok(())
}

fn sound_report<T: Real>(report: &ScanReport<T>) -> Result<(), String> {
    let told = || format!("{report:?}");
    let finite = |number: T| number >= T::ZERO && number.is_finite();
    require(report.ln_evidence < T::INFINITY, told)?;
    require(finite(report.pruned_mass) && finite(report.innovation), told)?;
    let candidates = T::from_usize(report.candidates);
    let most = candidates * (T::ONE + T::from_f64(1e-3));
    require(report.n_eff >= T::from_f64(0.999) && report.n_eff <= most, told)?;
    require(report.particles >= 1 && report.survivors >= 1 && report.survivors <= report.particles, told)?;
    require(report.maps_updated + report.not_updated == report.survivors, told)?;
    require(report.pages_used <= report.peak.pages && report.peak.pages <= report.pages, told)?;
    require(report.moving_pages_used <= report.moving_peak.pages, told)?;
    require(report.moving_peak.pages <= report.moving_pages, told)?;
    require(finite(report.expected_detections) && finite(report.detections), told)
}

fn sound_estimate<T: Real, N: Vector<Scalar = T>>(
    map: &MapEstimate<T>,
    features: &[Component<N>],
) -> Result<(), String> {
    let expected = map.expected_features;
    require(expected >= T::ZERO && expected.is_finite(), || format!("{map:?}"))?;
    require(map.features <= features.len(), || format!("{map:?} in {}", features.len()))?;
    for feature in &features[..map.features] {
        let finite = feature.ln_weight.is_finite() && feature.mean.as_slice().iter().all(|x| x.is_finite());
        require(finite && feature.covariance.factor().is_some(), || format!("estimated {feature:?}"))?;
    }
    Ok(())
}
