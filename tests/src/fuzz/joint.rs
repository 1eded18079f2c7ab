//! Sessions of a joint map with two detectors, with or without an archive, with or without moving features.

use super::counts::count;
use super::draw::Draw;
use super::fixes::{Placed, observe};
use super::scans::seen;
use super::session::Seeded;
use super::worlds::{Car, Diver, Drawn, FeatureOf, Listener, Models, ModelsOf, Rover, Tracker, World};
use super::{Failure, Operations, Run, Watch, named, require};
use nalgebra::{Vector2, Vector4};
use scphd::diagnostics::Scrubber;
use scphd::errors::{ScanError, SetupError};
use scphd::models::{MeasurementModel, Pose};
use scphd::numerics::{Symmetric, Vector};
use scphd::settings::{MovingConfig, Persistence, Plausible};
use scphd::snapshot::{RestoreError, SliceEnd, from_slice};
use scphd::storage::{Archive, JointArchive, JointMovers, Movers, joint_numbers};
use scphd::{Births, Component, Detector, JointConfig, JointReport, JointSlam, JointState, PoseEstimate, Real};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::marker::PhantomData;

/// A vehicle with two sensors of different types.
pub(super) trait Vehicle {
    const NAME: &'static str;
    type Scalar: Real;
    type Pose: Placed<Scalar = Self::Scalar> + Drawn;
    type First: World<Scalar = Self::Scalar, Pose = Self::Pose>;
    type Second: World<Scalar = Self::Scalar, Pose = Self::Pose>;
    /// The measurement type with more coordinates.
    type Widest: Vector<Scalar = Self::Scalar>;
}

macro_rules! vehicles {
    ($($(#[$about:meta])* $name:ident: $first:ident and $second:ident, $widest:ident;)*) => {$(
        $(#[$about])*
        pub(super) struct $name<T>(PhantomData<T>);

        impl<T: Real> Vehicle for $name<T> {
            const NAME: &'static str = concat!(stringify!($first), " and ", stringify!($second));
            type Scalar = T;
            type Pose = <$first<T> as World>::Pose;
            type First = $first<T>;
            type Second = $second<T>;
            type Widest = $widest<T>;
        }
    )*};
}

vehicles! {
    /// Range and bearing, and bearings only, which give no births.
    Robot: Rover and Tracker, Vector2;
    /// As `Robot`, with an Ackermann vehicle.
    Truck: Car and Rover, Vector2;
    /// A stereo camera and a sonar.
    Submarine: Diver and Listener, Vector4;
    /// As `Submarine`, with the sonar first.
    Glider: Listener and Diver, Vector4;
}

type MotionOf<V> = <<V as Vehicle>::First as World>::Motion;
type FirstOf<V> = <<V as Vehicle>::First as World>::Sensing;
type SecondOf<V> = <<V as Vehicle>::Second as World>::Sensing;
type FeatureIn<V> = FeatureOf<<V as Vehicle>::First>;
type Slam<'s, V, A, W> = JointSlam<'s, MotionOf<V>, <V as Vehicle>::Widest, A, W>;

/// A random configuration; out of range if one of its numbers is hostile.
pub(super) fn config<T: Real>(draw: &mut Draw) -> JointConfig<T> {
    let number = T::from_f64;
    let plain = if draw.chance(0.5) { JointConfig::default() } else { JointConfig::strict() };
    JointConfig {
        birth_probability_min: draw.real(0.0, 1.0),
        gate: draw.real(1.0, 40.0),
        persistence: if draw.chance(0.5) {
            Persistence::FOR_EVER
        } else {
            Persistence {
                visible_s: number(draw.magnitude(0.1, 1e3)),
                occluded_s: number(draw.magnitude(0.1, 1e3)),
                lifetime_s: if draw.chance(0.5) { T::INFINITY } else { number(draw.magnitude(1.0, 1e4)) },
            }
        },
        occlusion_factor: draw.real(0.0, 1.0),
        least_existence: if draw.chance(0.1) { T::ZERO } else { number(draw.magnitude(1e-4, 0.5)) },
        extraction_existence: draw.real(0.0, 1.0),
        merge_distance: draw.real(0.0, 12.0),
        plausible: if draw.chance(0.8) { Plausible::default() } else { Plausible::ANYTHING },
        ..plain
    }
}

/// A random detector, or the error that refuses it.
fn detector<W: World>(draw: &mut Draw, sensing: W::Sensing) -> Result<Detector<W::Sensing>, SetupError> {
    let of_static = if draw.chance(0.1) { 0.0 } else { draw.magnitude(1e-6, 0.5) };
    let of_static = W::Scalar::from_f64(draw.spoilt(of_static));
    // Ignored by a filter without movers.
    let births = Births { of_static, of_moving: of_static * W::Scalar::from_f64(0.5) };
    let detector = Detector::new(sensing, births)?;
    Ok(if draw.chance(0.5) { detector.mounted(W::Pose::mounting(draw)?)? } else { detector })
}

/// The parts of a filter and its detectors.
struct Design<V: Vehicle> {
    motion: MotionOf<V>,
    config: JointConfig<V::Scalar>,
    first: Detector<FirstOf<V>>,
    second: Detector<SecondOf<V>>,
    reach_m: V::Scalar,
}

impl<V: Vehicle> Design<V> {
    fn draw(draw: &mut Draw) -> Result<Self, SetupError> {
        let Models { motion, sensing }: ModelsOf<V::First> = V::First::models(draw)?;
        let other: ModelsOf<V::Second> = V::Second::models(draw)?;
        let config = config(draw);
        config.check()?;
        let (first, second) = (detector::<V::First>(draw, sensing)?, detector::<V::Second>(draw, other.sensing)?);
        Ok(Self { motion, config, first, second, reach_m: V::Scalar::from_f64(draw.even(2.0, 30.0)) })
    }
}

/// A saved state and its digest.
struct Saved {
    bytes: Vec<u8>,
    digest: u64,
}

struct Session<V: Vehicle> {
    features: usize,
    archive: usize,
    measurements: usize,
    landmarks: Vec<FeatureIn<V>>,
    saved: Vec<Saved>,
    scrubber: Scrubber,
    told: String,
}

/// The continuation after an operation.
enum Next {
    Go,
    /// Another filter continues with the same state.
    TakeOver,
}

/// Runs a session with a state of these capacities; an archive of size zero is none.
pub(super) fn run<V: Vehicle, const F: usize, const N: usize, const M: usize, const A: usize>(
    seeded: Seeded,
    operations: &Operations<'_>,
    watch: &Watch,
) -> Result<(), Failure> {
    let mut state = Box::new(JointState::<V::Pose, V::Widest, F, N, M>::new());
    let mut archive = Box::new(JointArchive::<V::Pose, A>::new());
    let mut movers = Box::new(JointMovers::<V::Pose, MOVERS>::new());
    let moves = seeded.seed.is_multiple_of(2);
    let mut session = Session::<V> {
        features: F,
        archive: A,
        measurements: M,
        landmarks: Vec::new(),
        saved: Vec::new(),
        scrubber: Scrubber::new(),
        told: String::new(),
    };
    let mut setup = Draw::new(seeded.seed, seeded.hostility);
    let mut calm = Draw::new(seeded.seed, 0.0);
    let mut design = |draw: &mut Draw| loop {
        // A refused design is drawn again, sooner or later without hostile numbers.
        let drawn = Design::<V>::draw(if draw.chance(0.9) { draw } else { &mut calm });
        count("set up", &drawn);
        if let Ok(design) = drawn {
            break design;
        }
    };
    let mut left = operations.indices.iter().copied().peekable();
    let mut first = true;
    while left.peek().is_some() {
        let Design { motion, config, first: eye, second: other, reach_m } = design(&mut setup);
        let slam = JointSlam::new(motion, config, &mut *state);
        let slam = slam.map_err(|error| Failure { operation: 0, what: format!("checked and refused: {error}") })?;
        let mut eyes = (eye, other);
        let mut go = |done: &mut StepOf<'_, V>| {
            for index in left.by_ref() {
                watch.at(seeded.seed, index);
                let mut draw = seeded.draw(index);
                session.told.clear();
                let next = done(&mut session, &mut eyes, &mut draw, first);
                first = false;
                if operations.tell {
                    println!("  {index}: {}", session.told);
                }
                if let Next::TakeOver = next.map_err(|what| Failure { operation: index, what })? {
                    break;
                }
            }
            Ok(())
        };
        let fails = |error: SetupError| Failure { operation: 0, what: format!("{error}") };
        match (A, moves) {
            (0, false) => {
                let mut slam = slam;
                go(&mut |session, eyes, draw, first| session.step(&mut slam, eyes, draw, first))?;
            }
            (0, true) => {
                let mut slam = slam.with_movers(&mut movers, MovingConfig::walkers()).map_err(fails)?;
                go(&mut |session, eyes, draw, first| session.step(&mut slam, eyes, draw, first))?;
            }
            (_, false) => {
                let mut slam = slam.with_archive(&mut archive, reach_m).map_err(fails)?;
                go(&mut |session, eyes, draw, first| session.step(&mut slam, eyes, draw, first))?;
            }
            (_, true) => {
                let slam = slam.with_movers(&mut movers, MovingConfig::walkers()).map_err(fails)?;
                let mut slam = slam.with_archive(&mut archive, reach_m).map_err(fails)?;
                go(&mut |session, eyes, draw, first| session.step(&mut slam, eyes, draw, first))?;
            }
        }
    }
    Ok(())
}

/// Runs an operation; the flag is set for the first one.
type StepOf<'a, V> = dyn FnMut(&mut Session<V>, &mut Eyes<V>, &mut Draw, bool) -> Result<Next, String> + 'a;
type Eyes<V> = (Detector<FirstOf<V>>, Detector<SecondOf<V>>);

/// Whether a number is finite and not negative, as required of probabilities.
fn sound<T: Real>(number: T) -> bool {
    number >= T::ZERO && number.is_finite()
}

/// A random covariance, usually positive definite.
fn covariance<T: Real, D: Vector<Scalar = T>>(draw: &mut Draw) -> Symmetric<D> {
    let variance = draw.magnitude(1e-6, 4.0);
    Symmetric::from_fn(|row, column| T::from_f64(draw.spoilt(if row == column { variance } else { 0.2 * variance })))
}

impl<T: Real, V: Vehicle<Scalar = T>> Session<V> {
    /// Runs an operation, and checks the whole state.
    fn step<A: Archive<V::Pose>, W: Movers<V::Pose>>(
        &mut self,
        slam: &mut Slam<'_, V, A, W>,
        eyes: &mut Eyes<V>,
        draw: &mut Draw,
        first: bool,
    ) -> Result<Next, String> {
        // The first operation is usually a reset.
        let kind = if first && draw.chance(0.95) { 0 } else { 3 + draw.below(197) };
        let here = slam.estimate_pose().map(|pose| pose.mean);
        let near = here.unwrap_or(V::Pose::ZERO);
        match kind {
            0..12 => self.set_pose(slam, draw, &near)?,
            12..84 => self.predict(slam, draw, &near)?,
            84..124 => {
                let eye = &eyes.0;
                let z = seen::<V::First, _>(draw, eye, &self.landmarks, here, self.measurements);
                self.scan("scan", slam, &z, |slam| slam.scan(eye, &z))?;
            }
            124..138 => {
                let eye = &eyes.1;
                let z = seen::<V::Second, _>(draw, eye, &self.landmarks, here, self.measurements);
                self.scan("scan of the other", slam, &z, |slam| slam.scan(eye, &z))?;
            }
            138..148 => {
                let eye = &eyes.0;
                let z = seen::<V::First, _>(draw, eye, &self.landmarks, here, self.measurements);
                let map = slam.features().count();
                self.scan("localise", slam, &z, |slam| slam.localise(eye, &z))?;
                require(slam.features().count() == map, || "localising changed the map".into())?;
            }
            148..158 => self.observe(slam, &eyes.0, draw, &near)?,
            158..163 => self.load_map(slam, draw, &near)?,
            163..168 => self.retune(slam, eyes, draw)?,
            168..174 => self.save(slam)?,
            174..180 => self.restore(slam, draw)?,
            180..188 => self.scrub(slam, draw)?,
            188..198 => self.estimate(slam)?,
            _ => {
                self.tell(format_args!("take the state over"));
                return Ok(Next::TakeOver);
            }
        }
        self.check(slam).map(|()| Next::Go)
    }

    fn tell(&mut self, what: std::fmt::Arguments<'_>) {
        let _ = self.told.write_fmt(what);
    }

    fn set_pose<A: Archive<V::Pose>, W: Movers<V::Pose>>(
        &mut self,
        slam: &mut Slam<'_, V, A, W>,
        draw: &mut Draw,
        near: &V::Pose,
    ) -> Result<(), String> {
        let before = slam.digest();
        let (pose, doubt) = (V::Pose::drawn(draw), covariance(draw));
        let moved = draw.chance(0.5);
        let pose = if moved { pose } else { *near };
        let (name, outcome) = match draw.below(8) {
            0..3 => ("reset", slam.reset(pose)),
            3 => ("reset within", slam.reset_within(pose, &doubt)),
            4..6 => ("relocate", slam.relocate(pose, &doubt)),
            _ => ("scatter", slam.scatter(&doubt)),
        };
        count(name, &outcome);
        self.tell(format_args!("{name}({pose:?}, {doubt:?}): {outcome:?}"));
        if outcome.is_ok() {
            if name != "scatter" && moved {
                self.landmarks = (0..8).map(|_| V::First::feature(draw, &pose)).collect();
            }
            return Ok(());
        }
        require(slam.digest() == before, || "a refused pose changed the state".into())
    }

    fn predict<A: Archive<V::Pose>, W: Movers<V::Pose>>(
        &mut self,
        slam: &mut Slam<'_, V, A, W>,
        draw: &mut Draw,
        near: &V::Pose,
    ) -> Result<(), String> {
        let control = V::First::control(draw, near);
        let dt: T = if draw.chance(0.05) { draw.real(0.0, 60.0) } else { draw.real(0.0, 0.2) };
        let outcome = slam.predict(&control, dt);
        count("predict", &outcome);
        self.tell(format_args!("predict({control:?}, {dt}): {outcome:?}"));
        let Ok(report) = outcome else { return Ok(()) };
        require(report.candidates == 1 && report.rejected <= 1, || format!("{report:?}"))
    }

    fn scan<A: Archive<V::Pose>, W: Movers<V::Pose>, Y: Vector<Scalar = T>>(
        &mut self,
        name: &'static str,
        slam: &mut Slam<'_, V, A, W>,
        measurements: &[Y],
        scan: impl FnOnce(&mut Slam<'_, V, A, W>) -> Result<JointReport<T>, ScanError>,
    ) -> Result<(), String> {
        let (before, held) = (slam.digest(), slam.held());
        let outcome = scan(slam);
        count(name, &outcome);
        let listed: Vec<_> = measurements.iter().map(Vector::as_slice).collect();
        self.tell(format_args!("{name}({listed:?}): {outcome:?}"));
        let Ok(report) = outcome else {
            return require(slam.digest() == before, || "a refused scan changed the state".into());
        };
        let told = || format!("{report:?} of {held} held before");
        require(report.measurements == measurements.len(), told)?;
        require(report.features <= self.features && report.in_view <= held + self.archive, told)?;
        require(report.births + report.no_birth <= report.measurements, told)?;
        let most = T::from_usize(report.measurements) * T::from_f64(PROBABLE);
        require(sound(report.detections) && report.detections <= most, told)?;
        require(sound(report.expected_detections) && sound(report.innovation), told)?;
        require(report.ln_evidence < T::INFINITY, told)?;
        let grown = held + report.births + report.reactivated;
        require(slam.held() <= grown, told)
    }

    fn observe<A: Archive<V::Pose>, W: Movers<V::Pose>>(
        &mut self,
        slam: &mut Slam<'_, V, A, W>,
        eye: &Detector<FirstOf<V>>,
        draw: &mut Draw,
        near: &V::Pose,
    ) -> Result<(), String> {
        let before = slam.digest();
        let outcome = observe::<T, V::First>(draw, eye.sensing().sensor(), near, slam);
        count("observe", &outcome);
        self.tell(format_args!("observe: {outcome:?}"));
        match outcome {
            Ok(report) if report.accepted => require(sound(report.distance), || format!("{report:?}")),
            _ => require(slam.digest() == before, || "a fix that was left out changed the state".into()),
        }
    }

    fn load_map<A: Archive<V::Pose>, W: Movers<V::Pose>>(
        &mut self,
        slam: &mut Slam<'_, V, A, W>,
        draw: &mut Draw,
        near: &V::Pose,
    ) -> Result<(), String> {
        let map: Vec<Component<FeatureIn<V>>> = (0..draw.below(self.features + 2))
            .map(|index| Component {
                label: if draw.chance(0.05) { draw.word() as u32 } else { index as u32 / 2 },
                ln_weight: draw.real(-4.0, 1.0),
                mean: V::First::feature(draw, near),
                covariance: covariance(draw),
            })
            .collect();
        let before = slam.digest();
        let outcome = slam.load_map(&map);
        count("load a map", &outcome);
        self.tell(format_args!("load_map({map:?}): {outcome:?}"));
        if outcome.is_ok() {
            self.landmarks.extend(map.iter().take(4).map(|component| component.mean));
            let beyond = self.landmarks.len().saturating_sub(12);
            self.landmarks.drain(..beyond);
            return require(slam.held() == map.len(), || format!("{} held of {}", slam.held(), map.len()));
        }
        require(slam.digest() == before, || "a refused map changed the state".into())
    }

    fn retune<A: Archive<V::Pose>, W: Movers<V::Pose>>(
        &mut self,
        slam: &mut Slam<'_, V, A, W>,
        eyes: &mut Eyes<V>,
        draw: &mut Draw,
    ) -> Result<(), String> {
        let before = slam.digest();
        match draw.below(3) {
            0 => {
                let drawn = V::First::models(draw);
                if let Ok(Models { motion, sensing }) = drawn {
                    count("retune", &slam.retune(motion));
                    count("retune a detector", &eyes.0.retune(sensing));
                }
            }
            1 => {
                let drawn = V::Second::models(draw);
                if let Ok(Models { sensing, .. }) = drawn {
                    count("retune a detector", &eyes.1.retune(sensing));
                }
            }
            _ => count("configure", &slam.configure(config(draw))),
        }
        self.tell(format_args!("retune"));
        require(slam.digest() == before, || "retuning changed the state".into())
    }

    fn save<A: Archive<V::Pose>, W: Movers<V::Pose>>(&mut self, slam: &Slam<'_, V, A, W>) -> Result<(), String> {
        let mut bytes = Vec::new();
        let outcome = slam.save(KIND, |piece| {
            bytes.extend_from_slice(piece);
            Ok::<(), SliceEnd>(())
        });
        count("save", &outcome);
        self.tell(format_args!("save: {outcome:?}"));
        match outcome {
            Ok(len) => {
                require(len == bytes.len(), || format!("{len} bytes told, {} written", bytes.len()))?;
                // Keeps only the last snapshots.
                self.saved.truncate(3);
                self.saved.insert(0, Saved { bytes, digest: slam.digest() });
                Ok(())
            }
            Err(error) => require(slam.estimate_pose().is_none(), || format!("a sound state is not saved: {error}")),
        }
    }

    /// Restores a snapshot, or attempts to with a part of it or with another kind.
    fn restore<A: Archive<V::Pose>, W: Movers<V::Pose>>(
        &mut self,
        slam: &mut Slam<'_, V, A, W>,
        draw: &mut Draw,
    ) -> Result<(), String> {
        if self.saved.is_empty() {
            return Ok(());
        }
        let Saved { bytes, digest } = &self.saved[draw.below(self.saved.len())];
        let before = slam.digest();
        let (cut, kind) = match draw.below(6) {
            0 => (draw.below(bytes.len()), KIND),
            1 => (bytes.len(), KIND + 1),
            _ => (bytes.len(), KIND),
        };
        let whole = cut == bytes.len() && kind == KIND;
        let outcome: Result<usize, RestoreError<SliceEnd>> = slam.restore(kind, from_slice(&bytes[..cut]));
        count("restore", &outcome);
        let _ = self.told.write_fmt(format_args!("restore {cut} of {} bytes: {outcome:?}", bytes.len()));
        require(outcome.is_ok() == whole, || "a snapshot is taken that is none, or none that is one".into())?;
        require(slam.digest() == if whole { *digest } else { before }, || "another state than was saved".into())
    }

    fn scrub<A: Archive<V::Pose>, W: Movers<V::Pose>>(
        &mut self,
        slam: &mut Slam<'_, V, A, W>,
        draw: &mut Draw,
    ) -> Result<(), String> {
        let (before, seal) = (slam.digest(), slam.seal());
        let outcome = slam.scrub(&mut self.scrubber, 1 + draw.below(2 * self.features + 4));
        count("scrub", &outcome);
        self.tell(format_args!("scrub: {outcome:?}"));
        match outcome {
            Ok(scrubbed) if scrubbed.is_clean() => {
                require((slam.digest(), slam.seal()) == (before, seal), || "scrubbing changed what is sound".into())
            }
            Ok(_) => Ok(()),
            // An invalid variance, which the next scan repairs.
            Err(_) => Ok(()),
        }
    }

    fn estimate<A: Archive<V::Pose>, W: Movers<V::Pose>>(&mut self, slam: &Slam<'_, V, A, W>) -> Result<(), String> {
        self.tell(format_args!("estimate"));
        count::<_, ()>("estimate", &Ok(()));
        let mut labels = BTreeSet::new();
        for feature in slam.features() {
            let told = || format!("estimated {feature:?}");
            require(feature.mean.as_slice().iter().all(|x| x.is_finite()) && feature.covariance.is_finite(), told)?;
            require(feature.ln_weight <= T::from_f64(PROBABLE.ln()), told)?;
            require(labels.insert(feature.label), || format!("two features have the label {}", feature.label))?;
            let existence = slam.existence(feature.label);
            require(existence.is_some_and(|existence| existence <= T::from_f64(PROBABLE)), || {
                format!("{existence:?}")
            })?;
        }
        Ok(())
    }

    /// Checks the whole state.
    fn check<A: Archive<V::Pose>, W: Movers<V::Pose>>(&self, slam: &Slam<'_, V, A, W>) -> Result<(), String> {
        slam.audit().map_err(|flaw| format!("{flaw}"))?;
        require(slam.held() <= self.features + self.archive, || format!("{} held", slam.held()))?;
        let Some(PoseEstimate { mean, covariance }) = slam.estimate_pose() else {
            return Ok(());
        };
        for mover in slam.moving() {
            let told = || format!("moving {mover:?}");
            require(mover.mean.as_slice().iter().all(|x| x.is_finite()) && mover.covariance.is_finite(), told)?;
            require(mover.ln_weight <= T::from_f64(PROBABLE.ln()), told)?;
        }
        let expected = slam.expected_features();
        let most = T::from_usize(slam.held()) * T::from_f64(PROBABLE);
        require(sound(expected) && expected <= most, || format!("{expected} features of {}", slam.held()))?;
        require(mean.is_finite() && covariance.is_finite(), || format!("the pose is {mean:?} ± {covariance:?}"))
    }
}

/// Number of moving features, if there are any.
const MOVERS: usize = 6;
/// Upper limit of a sum of probabilities divided by its nominal value.
const PROBABLE: f64 = 1.002;
/// Vehicle type in the snapshots of these sessions.
const KIND: u32 = 41;

/// The kinds of sessions: a vehicle, a scalar, and capacities for features, measurements and archived features.
macro_rules! sessions {
    ($choice:expr; $($vehicle:ident $t:ident $k:literal $d:literal: $(($f:literal $m:literal $a:literal))*;)*) => {{
        let mut kinds: Vec<(String, fn(Seeded, &Operations<'_>, &Watch) -> Result<(), Failure>)> = Vec::new();
        $($(
            kinds.push((
                format!(
                    "joint map, {}, {}: {} features, {} measurements, {} in the archive",
                    <$vehicle<$t> as Vehicle>::NAME, stringify!($t), $f, $m, $a,
                ),
                run::<$vehicle<$t>, $f, { joint_numbers($k, $d, $f) }, $m, $a>,
            ));
        )*)*
        kinds.swap_remove($choice % kinds.len())
    }};
}

pub(super) fn kind_of(seed: u64) -> (String, Run) {
    let (seeded, mut draw) = Seeded::of(seed, 0x107);
    let (name, run) = sessions!(draw.below(1 << 20);
        Robot f32 3 2: (1 1 0) (1 4 2) (2 4 0) (5 8 0) (8 16 12) (24 24 0) (12 24 40);
        Robot f64 3 2: (1 1 1) (4 8 0) (8 16 20);
        Truck f32 3 2: (3 8 0) (16 24 0) (10 24 30);
        Truck f64 3 2: (6 12 0);
        Submarine f32 5 3: (1 1 0) (6 12 0) (8 12 16);
        Submarine f64 5 3: (4 8 0);
        Glider f32 5 3: (2 4 4) (8 16 0);
        Glider f64 5 3: (5 8 8);
    );
    named(&name, seeded, run)
}
