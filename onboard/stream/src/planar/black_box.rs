//! The filters of a planar vehicle that process all records of a black box.

use super::joint::{EightHypotheses, FEATURES, MOVERS, OF_EACH, PlanarJoint};
use super::onboard::{self, Direct, Drive, MEASUREMENTS, PlanarSensing, detector, margin, motion};
use super::{Fix, Odometry, Planar, Sensor};
use crate::black_box::{
    BlackBoxFilter, KIND, Modelled, Observes, Other, Saves, loaded, placed, unreadable, unrestored,
};
use crate::header::Header;
use crate::joint::{Archive, Fixed, OnboardJoint, OptionalParts, Tracks};
use crate::onboard::{Aboard, Capacities, Filter, RamPart, Refusal, Scan, Seen};
use crate::record::{How, Measurements, Part, Place, Record, Which};
use crate::snapshot::Snapshot;
use crate::writer::{OTHERS, Writer};
use core::marker::PhantomData;
use nalgebra::Vector2;
use scphd::diagnostics::{Probe, Stage};
use scphd::models::PlanarPose;
use scphd::snapshot::SaveError;
use scphd::storage::{JointFilter, NoMovers, joint_numbers};
use scphd::{Component, Detector, DetectorMemory, Real};

/// The mixture filter for black boxes of planar vehicles: four detectors, fixes, and all other records.
#[derive(Debug, Clone, Copy)]
pub struct BlackBox;

/// All memory of the mixture filter.
#[derive(Debug)]
pub struct Memory<T: Real> {
    aboard: onboard::Memory<T>,
    others: [DetectorMemory<Vector2<T>, MEASUREMENTS>; OTHERS],
}

impl<T: Real> Modelled<T> for Planar {
    type Motion = Drive<T>;
    type Helm = Direct;
    type Sensing = PlanarSensing<T>;

    fn motion(header: &Header<Self>) -> Result<Drive<T>, scphd::models::ModelError> {
        motion(header, margin(header))
    }

    fn steer(_helm: &mut Direct, _header: &Header<Self>) -> Result<(), scphd::models::ModelError> {
        Ok(())
    }

    fn first(header: &Header<Self>) -> Result<Detector<PlanarSensing<T>>, Refusal> {
        Self::other(&Sensor::first(header))
    }

    fn other(sensor: &Sensor) -> Result<Detector<PlanarSensing<T>>, Refusal> {
        Ok(detector(sensor)?)
    }

    fn observe(filter: &mut impl Observes<PlanarPose<T>>, fix: &Fix) -> Result<(), Refusal> {
        fix.shown(filter)
    }
}

impl<T: Real> Aboard<T> for BlackBox {
    type Kind = Planar;
    type Memory = Memory<T>;
    type Filter<'m>
        = BlackBoxFilter<'m, Planar, T, MEASUREMENTS, OTHERS>
    where
        T: 'm;

    const MEMORY: Memory<T> =
        Memory { aboard: <Planar as Aboard<T>>::MEMORY, others: [const { DetectorMemory::new() }; OTHERS] };
    const CAPACITIES: Capacities = <Planar as Aboard<T>>::CAPACITIES;
    const RAM_PARTS: [RamPart; 6] = <Planar as Aboard<T>>::RAM_PARTS;

    fn start<'m>(header: &Header<Planar>, memory: &'m mut Memory<T>) -> Result<Self::Filter<'m>, Refusal>
    where
        T: 'm,
    {
        let Memory { aboard, others } = memory;
        aboard.state.clear();
        let first = <Planar as Aboard<T>>::start(header, aboard)?;
        Ok(BlackBoxFilter { first, others: others.each_mut().map(Other::in_room) })
    }
}

/// The joint map for black boxes of planar vehicles: four detectors, fixes, scans that update the pose only, and all other
/// records.
#[derive(Debug, Clone, Copy)]
pub struct BlackBoxJoint<
    const ROOM: usize = FEATURES,
    const NUMBERS: usize = { joint_numbers(3, 2, FEATURES) },
    V = NoMovers,
>(PhantomData<V>);

/// [`BlackBoxJoint`] with moving-object tracks.
pub type BlackBoxMovers = BlackBoxJoint<FEATURES, { joint_numbers(3, 2, FEATURES) }, Tracks<MOVERS>>;
/// [`BlackBoxJoint`] with several hypotheses of data association, as [`PlanarHypotheses`](super::PlanarHypotheses).
pub type BlackBoxHypotheses = BlackBoxJoint<OF_EACH, { joint_numbers(3, 2, OF_EACH) }, EightHypotheses>;

/// [`BlackBoxMovers`] with an archive of 256 distant features: every optional part that [`BlackBoxHypotheses`] does not have.
pub type BlackBoxArchive = BlackBoxJoint<FEATURES, { joint_numbers(3, 2, FEATURES) }, Archive<256, MOVERS>>;

/// All memory of the joint map.
#[derive(Debug)]
pub struct JointMemory<A, T: Real, const ROOM: usize> {
    aboard: A,
    features: [Component<Vector2<T>>; ROOM],
}

/// The joint map with all records of a black box.
#[derive(Debug)]
pub struct BlackBoxJointFilter<'m, T: Real, F> {
    first: OnboardJoint<'m, Planar, Direct, F, PlanarSensing<T>>,
    others: [Option<Detector<PlanarSensing<T>>>; OTHERS],
    features: &'m mut [Component<Vector2<T>>],
}

impl<T: Real, V: OptionalParts<Drive<T>, Vector2<T>>, const ROOM: usize, const NUMBERS: usize> Aboard<T>
    for BlackBoxJoint<ROOM, NUMBERS, V>
{
    type Kind = Planar;
    type Memory = JointMemory<<PlanarJoint<ROOM, NUMBERS, V> as Aboard<T>>::Memory, T, ROOM>;
    type Filter<'m>
        = BlackBoxJointFilter<'m, T, V::Filter<'m>>
    where
        T: 'm;

    const MEMORY: Self::Memory =
        JointMemory { aboard: <PlanarJoint<ROOM, NUMBERS, V> as Aboard<T>>::MEMORY, features: [Component::ZERO; ROOM] };
    const CAPACITIES: Capacities = <PlanarJoint<ROOM, NUMBERS, V> as Aboard<T>>::CAPACITIES;
    const RAM_PARTS: [RamPart; 6] = <PlanarJoint<ROOM, NUMBERS, V> as Aboard<T>>::RAM_PARTS;

    fn start<'m>(header: &Header<Planar>, memory: &'m mut Self::Memory) -> Result<Self::Filter<'m>, Refusal>
    where
        T: 'm,
    {
        let JointMemory { aboard, features } = memory;
        let first = <PlanarJoint<ROOM, NUMBERS, V> as Aboard<T>>::start(header, aboard)?;
        Ok(BlackBoxJointFilter { first, others: [const { None }; OTHERS], features })
    }
}

impl<T: Real, F: JointFilter<Motion = Drive<T>>> BlackBoxJointFilter<'_, T, F> {
    fn set(&mut self, which: Which<Planar>, models: &Sensor) -> Result<(), Refusal> {
        let slot = which.beyond_first().and_then(|place| self.others.get_mut(place)).ok_or(Refusal::NotAboard)?;
        *slot = Some(detector(models)?);
        Ok(())
    }

    fn place(&mut self, place: &Place<'_, Planar>) -> Result<(), Refusal> {
        let (pose, covariance, _) = placed(place);
        let filter = &mut self.first.filter;
        Ok(match place.how {
            How::Reset => filter.reset(pose),
            How::ResetWithin => filter.reset_within(pose, &covariance),
            How::Relocate => filter.relocate(pose, &covariance),
            How::Scatter => filter.scatter(&covariance),
        }?)
    }

    /// Continues with the models and the tuning of a head.
    fn retune(&mut self, header: &Header<Planar>) -> Result<(), Refusal> {
        let detector = detector(&Sensor::first(header))?;
        let filter = &mut self.first.filter;
        filter.configure(header.joint.config())?;
        filter.retune(motion(header, 1.0)?)?;
        self.first.detector.adopt(detector);
        Ok(())
    }
}

impl<T: Real, F: JointFilter<Motion = Drive<T>>> Filter<Planar> for BlackBoxJointFilter<'_, T, F> {
    const BLACK_BOX: bool = true;

    fn predict(&mut self, odometry: &Odometry) -> Result<(), Refusal> {
        self.first.predict(odometry)
    }

    fn receive(&mut self, measurements: Measurements<'_, Planar>) -> Scan {
        self.first.receive(measurements)
    }

    fn scan_with(&mut self, scan: Scan, probe: &mut impl Probe) -> Result<Seen, Refusal> {
        let OnboardJoint { filter, detector, measurements, .. } = &mut self.first;
        let detector = match scan.beyond_first {
            None => detector,
            Some(place) => self.others.get_mut(place).and_then(Option::as_mut).ok_or(Refusal::NotAboard)?,
        };
        let measurements = scan.of(measurements)?;
        // A joint map has only one stage.
        probe.enter(Stage::Update);
        let report =
            if scan.localising { filter.localise(detector, measurements) } else { filter.scan(detector, measurements) };
        probe.leave(Stage::Update);
        Ok(self.first.seen(&report?))
    }

    #[inline(never)]
    fn take(&mut self, record: &Record<'_, Planar>) -> Result<(), Refusal> {
        match record {
            Record::Fix(fix) => fix.get().ok_or(Refusal::NotAboard)?.shown(&mut Fixed(&mut self.first.filter)),
            Record::Detector(which, models) => self.set(*which, &models.get()),
            Record::Place(place) => self.place(place),
            Record::Map(features) => {
                let count = loaded(features.clone(), self.features)?;
                self.first.filter.load_map(self.features.get(..count).unwrap_or(&[])).map_err(Refusal::Map)
            }
            Record::Head(head) => self.retune(&head.decode().map_err(unreadable)?),
            Record::Predict(_) | Record::Scan(_) => Err(Refusal::NotAboard),
        }
    }

    #[inline(never)]
    fn restore(&mut self, snapshot: &Snapshot<'_, Planar>) -> Result<(), Refusal> {
        for (which, models) in snapshot.detectors() {
            self.set(which, &models.get())?;
        }
        let source = snapshot.part(Part::Filter).ok_or(Refusal::NotAboard)?;
        self.first.filter.restore(snapshot.user_kind(Part::Filter), source).map(drop).map_err(unrestored)
    }

    fn estimate(&mut self) -> ([f64; 3], usize) {
        self.first.estimate()
    }

    fn estimate_pose(&self) -> ([f64; 3], [f64; 6]) {
        self.first.estimate_pose()
    }

    fn digest(&self) -> u64 {
        self.first.digest()
    }
}

impl<T: Real, F: JointFilter<Motion = Drive<T>>> Saves<Planar> for BlackBoxJointFilter<'_, T, F> {
    fn save<E, S: FnMut(&[u8]) -> Result<(), E>>(&mut self, log: &mut Writer<Planar, S>) -> Result<(), SaveError<E>> {
        log.snapshot(&[Part::Filter], self.digest()).map_err(SaveError::Sink)?;
        log.save(Part::Filter, |sink| self.first.filter.save(KIND, sink)).map(drop)
    }
}
