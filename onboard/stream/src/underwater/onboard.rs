//! The filter of an underwater vehicle on board, and its capacities.

use super::fix::Of;
use super::{AuvModels, Fix, Models, Navigation, Underwater};
use crate::Parameters;
use crate::black_box::{KIND, Saves, loaded, placed, unrestored};
use crate::head::Head;
use crate::onboard::{Aboard, Capacities, Filter, Ram, RamPart, Refusal, Scan, Seen, lower, moved, zero};
use crate::record::{How, Measurements, Part, Place, Record};
use crate::snapshot::Snapshot;
use crate::writer::Writer;
use nalgebra::{Vector1, Vector3, Vector4};
use scphd::diagnostics::Probe;
use scphd::models::{Auv, AuvPose, HeadingFix, HeightFix, Pose, Sensing, StereoCamera, StereoFrustum, UniformClutter};
use scphd::navigation::Navigator;
use scphd::numerics::Vector;
use scphd::snapshot::SaveError;
use scphd::storage::{MapMemory, NoMoving, ScanRoom, Static};
use scphd::{Births, Component, Detector, DetectorMemory, PoseEstimate, Real, ScPhd, State};
use scphd_vehicle::{self as vehicle, Description, Setting};

const PARTICLES: usize = 64;
const CANDIDATES: usize = 64;
/// The rest of 512 KiB in single precision.
const PAGES: usize = 976;
const MAP_PAGES: usize = 128;
/// Maximum number of pairs in an image.
pub const MEASUREMENTS: usize = 96;
const VIEW: usize = 512;
/// Capacity of an estimated map, features.
const FEATURES: usize = 640;

/// State of a filter with these capacities, without moving features.
type AuvState<T, const PARTICLES: usize, const CANDIDATES: usize, const PAGES: usize, const VIEW: usize> = State<
    AuvPose<T>,
    PARTICLES,
    CANDIDATES,
    MapMemory<Static<Vector3<T>>, PARTICLES, PAGES, MAP_PAGES, VIEW>,
    NoMoving,
>;

type OnboardState<T> = AuvState<T, PARTICLES, CANDIDATES, PAGES, VIEW>;

/// The working memory of the detector.
type Scratch<T> = DetectorMemory<Vector4<T>, MEASUREMENTS>;

/// The models of the camera.
pub(super) type StereoSensing<T> = Sensing<StereoCamera<T>, StereoFrustum<T>, UniformClutter<T>>;

/// All memory of the filter on board: its state, the working memory of its detector, a received scan, and a map.
#[derive(Debug)]
pub struct Memory<T: Real> {
    state: OnboardState<T>,
    scratch: Scratch<T>,
    measurements: [Vector4<T>; MEASUREMENTS],
    features: [Component<Vector3<T>>; FEATURES],
}

/// The increase of the size of the state with these increases of the capacities.
macro_rules! price {
    ($particles:expr, $candidates:expr, $pages:expr, $view:expr) => {
        size_of::<
            AuvState<T, { PARTICLES + $particles }, { CANDIDATES + $candidates }, { PAGES + $pages }, { VIEW + $view }>,
        >() - size_of::<OnboardState<T>>()
    };
}

/// Use of the RAM, from the cost of each capacity: the size of a state with eight more of it.
const fn ram<T: Real>() -> Ram {
    let candidates = price!(0, 8, 0, 0) / 8;
    let particles = price!(8, 8, 0, 0) / 8 - candidates;
    Ram {
        total: size_of::<Memory<T>>(),
        state: size_of::<OnboardState<T>>() + size_of::<Scratch<T>>(),
        particles: particles * PARTICLES + candidates * CANDIDATES,
        pages: price!(0, 0, 8, 0) / 8 * PAGES,
        moving_pages: 0,
        scratch: size_of::<Scratch<T>>() + price!(0, 0, 0, 8) / 8 * VIEW,
    }
}

/// A mixture for streams of underwater vehicles, with memory for its inputs and outputs; with `BOX` it processes all records of a
/// black box.
#[derive(Debug)]
pub struct Onboard<'m, T: Real, const BOX: bool> {
    filter: ScPhd<'m, Auv<T>>,
    detector: Detector<StereoSensing<T>, ScanRoom<'m, Vector4<T>>>,
    navigator: Navigator<f64>,
    measurements: &'m mut [Vector4<T>],
    features: &'m mut [Component<Vector3<T>>],
}

/// The mixture filter for black boxes of underwater vehicles.
#[derive(Debug, Clone, Copy)]
pub struct BlackBox;

/// Declares the filter on board, and that of a black box.
macro_rules! on_board {
    ($($name:ident: $black_box:literal;)+) => {$(
        impl<T: Real> Aboard<T> for $name {
            type Kind = Underwater;
            type Memory = Memory<T>;
            type Filter<'m>
                = Onboard<'m, T, $black_box>
            where
                T: 'm;

            const MEMORY: Memory<T> = Memory {
                state: State::new(),
                scratch: DetectorMemory::new(),
                measurements: [zero(); MEASUREMENTS],
                features: [Component::ZERO; FEATURES],
            };
            const CAPACITIES: Capacities = Capacities {
                candidates: CANDIDATES,
                particles: PARTICLES,
                components: MAP_PAGES * scphd::storage::PAGE_LEN,
                components_in_all: PAGES * scphd::storage::PAGE_LEN,
                measurements: MEASUREMENTS,
            };
            const RAM_PARTS: [RamPart; 6] = ram::<T>().parts();

            fn start<'m>(
                head: &impl Parameters<Underwater>,
                memory: &'m mut Memory<T>,
            ) -> Result<Self::Filter<'m>, Refusal>
            where
                T: 'm,
            {
                Onboard::start(head, memory)
            }
        }
    )+};
}

on_board! {
    Underwater: false;
    BlackBox: true;
}

/// The mean, and the lower triangle of the covariance.
pub(super) fn told<T: Real>(pose: Option<PoseEstimate<AuvPose<T>>>) -> ([f64; 5], [f64; 15]) {
    let Some(pose) = pose else { return ([0.0; 5], [0.0; 15]) };
    let mean = pose.mean.coordinates();
    (core::array::from_fn(|k| mean.at(k).to_f64()), lower::<Underwater, _>(pose.covariance.as_lower()))
}

/// The tuning, the seed, the motion model and the detector of a head.
type Parts<T> = (vehicle::Filter<T>, u64, Auv<T>, Detector<StereoSensing<T>>);

/// Not inlined, so that the description is on the stack only here.
#[inline(never)]
pub(super) fn parts<T: Real>(head: &impl Parameters<Underwater>, models: &Models) -> Result<Parts<T>, Refusal> {
    let mut description = Description::robot();
    head.describe(&mut description)?;
    let AuvModels { motion, sensing } = models.of_filter()?;
    let [sensor, ..] = description.sensors;
    let births = sensor.map_or(Births::NONE, |sensor| sensor.births);
    Ok((description.filter, description.start.seed, motion, Detector::new(sensing, births)?))
}

/// The refusal of a head of another filter.
pub(super) fn other_filter() -> Refusal {
    Refusal::Part { number: Setting::FILTER.number() }
}

impl<'m, T: Real, const BOX: bool> Onboard<'m, T, BOX> {
    fn start(head: &impl Parameters<Underwater>, memory: &'m mut Memory<T>) -> Result<Self, Refusal> {
        let Memory { state, scratch, measurements, features } = memory;
        let models = head.models();
        let (vehicle::Filter::Mixture(config), seed, motion, detector) = parts(head, &models)? else {
            return Err(other_filter());
        };
        // The memory may be of an earlier replay, of another number of particles. An empty state needs no check.
        state.clear();
        let mut filter = ScPhd::reborrow(motion, config, state)?;
        let detector = detector.over(scratch)?;
        filter.check(&detector)?;
        filter.reset(models.start(), seed)?;
        Ok(Self { filter, detector, navigator: models.navigator()?, measurements, features })
    }

    #[inline(never)]
    fn taken(&mut self, record: &Record<'_, Underwater>) -> Result<(), Refusal> {
        match record {
            Record::Fix(fix) => self.observe(&fix.get().ok_or(Refusal::NotAboard)?),
            Record::Place(place) => self.place(place),
            Record::Map(features) => {
                let count = loaded(features.clone(), self.features)?;
                self.filter.load_map(self.features.get(..count).unwrap_or(&[])).map_err(Refusal::Map)
            }
            Record::Head(head) => self.retune(head),
            Record::Detector(..) | Record::Predict(_) | Record::Scan(_) => Err(Refusal::NotAboard),
        }
    }

    #[inline(never)]
    fn restored(&mut self, snapshot: &Snapshot<'_, Underwater>) -> Result<(), Refusal> {
        if let Some(source) = snapshot.part(Part::Navigator) {
            self.navigator.restore(snapshot.user_kind(Part::Navigator), source).map_err(unrestored)?;
        }
        let source = snapshot.part(Part::Filter).ok_or(Refusal::NotAboard)?;
        self.filter.restore(snapshot.user_kind(Part::Filter), source).map(drop).map_err(unrestored)
    }

    fn place(&mut self, place: &Place<'_, Underwater>) -> Result<(), Refusal> {
        let (pose, covariance, seed) = placed(place);
        Ok(match place.how {
            How::Reset => self.filter.reset(pose, seed),
            How::ResetWithin => self.filter.reset_within(pose, &covariance, seed),
            How::Relocate => self.filter.relocate(pose, &covariance),
            How::Scatter => self.filter.scatter(&covariance),
        }?)
    }

    /// Continues with the models and the tuning of a head.
    fn retune(&mut self, head: &Head<'_, Underwater>) -> Result<(), Refusal> {
        let models = head.models();
        let (vehicle::Filter::Mixture(config), _, motion, detector) = parts(head, &models)? else {
            return Err(other_filter());
        };
        // Checks the noise first: a refused head changes nothing.
        models.navigator()?;
        self.filter.check(&detector)?;
        self.filter.configure(config)?;
        self.filter.retune(motion)?;
        self.navigator.retune(models.velocity_noise())?;
        self.detector.adopt(detector);
        Ok(())
    }

    fn observe(&mut self, fix: &Fix) -> Result<(), Refusal> {
        let [value, sigma, gate] = [fix.value, fix.sigma, fix.gate].map(T::from_f64);
        let report = match fix.of {
            Of::Heading => self.filter.observe(&HeadingFix::new(sigma)?.gated(gate)?, &Vector1::new(value)),
            Of::Height => self.filter.observe(&HeightFix::new(sigma)?.gated(gate)?, &Vector1::new(value)),
        };
        report.map(drop).map_err(Refusal::Observe)
    }
}

impl<T: Real, const BOX: bool> Filter<Underwater> for Onboard<'_, T, BOX> {
    const BLACK_BOX: bool = BOX;

    fn predict(&mut self, input: &Navigation) -> Result<(), Refusal> {
        if let Some((control, dt)) = input.control(&mut self.navigator).map_err(Refusal::Predict)? {
            moved(self.filter.predict(&control, dt))?;
        }
        Ok(())
    }

    fn receive(&mut self, measurements: Measurements<'_, Underwater>) -> Scan {
        Scan::received(measurements, self.measurements)
    }

    fn scan_with(&mut self, scan: Scan, probe: &mut impl Probe) -> Result<Seen, Refusal> {
        if !scan.is_plain() {
            return Err(Refusal::NotAboard);
        }
        let measurements = scan.of(self.measurements)?;
        Ok(Seen::of(&self.filter.scan_with(&mut self.detector, measurements, probe)?))
    }

    fn take(&mut self, record: &Record<'_, Underwater>) -> Result<(), Refusal> {
        if BOX { self.taken(record) } else { Err(Refusal::NotAboard) }
    }

    fn restore(&mut self, snapshot: &Snapshot<'_, Underwater>) -> Result<(), Refusal> {
        if BOX { self.restored(snapshot) } else { Err(Refusal::NotAboard) }
    }

    fn estimate(&mut self) -> ([f64; 5], usize) {
        let map = self.filter.estimate_map(&self.detector, self.features);
        (told(self.filter.estimate_pose()).0, map.features)
    }

    fn estimate_pose(&self) -> ([f64; 5], [f64; 15]) {
        told(self.filter.estimate_pose())
    }

    fn digest(&self) -> u64 {
        self.filter.digest()
    }
}

impl<T: Real> Saves<Underwater> for Onboard<'_, T, true> {
    fn save<E, F: FnMut(&[u8]) -> Result<(), E>>(
        &mut self,
        log: &mut Writer<Underwater, F>,
    ) -> Result<(), SaveError<E>> {
        log.snapshot(&[Part::Filter, Part::Navigator], self.digest()).map_err(SaveError::Sink)?;
        log.save(Part::Filter, |sink| self.filter.save(KIND, sink))?;
        log.save(Part::Navigator, |sink| self.navigator.save(KIND, sink)).map(drop)
    }
}
