//! The joint map of a planar vehicle on board.

use super::onboard::{Direct, Drive, MEASUREMENTS, PlanarSensing, detector, motion, start};
use super::{Planar, Sensor};
use crate::header::Header;
use crate::joint::{self, Hypotheses, JointMemory, OnboardJoint, OptionalParts, Tracks};
use crate::onboard::{Aboard, Capacities, RamPart, Refusal};
use core::marker::PhantomData;
use nalgebra::Vector2;
use scphd::models::PlanarPose;
use scphd::storage::{NoMovers, joint_numbers};
use scphd::{JointSlam, JointState, Real};

/// Capacity of the joint map, features.
pub(super) const FEATURES: usize = if cfg!(feature = "small-pools") { 16 } else { 64 };

/// Capacity of the smaller map, features.
const FEW: usize = 40;
/// Capacity for moving-object tracks of both.
pub(super) const MOVERS: usize = 64;

/// The filter with a joint map, for streams of planar vehicles: with capacity for `ROOM` features, and optional parts `V`.
#[derive(Debug, Clone, Copy)]
pub struct PlanarJoint<
    const ROOM: usize = FEATURES,
    const NUMBERS: usize = { joint_numbers(3, 2, FEATURES) },
    V = NoMovers,
>(PhantomData<V>);

/// [`PlanarJoint`] with moving-object tracks.
pub type PlanarJointMovers = PlanarJoint<FEATURES, { joint_numbers(3, 2, FEATURES) }, Tracks<MOVERS>>;
/// [`PlanarJoint`] with capacity for 40 features.
pub type PlanarJoint40 = PlanarJoint<FEW, { joint_numbers(3, 2, FEW) }>;
/// [`PlanarJoint40`] with moving-object tracks.
pub type PlanarJoint40Movers = PlanarJoint<FEW, { joint_numbers(3, 2, FEW) }, Tracks<MOVERS>>;

/// Capacity of each of several hypotheses, features.
pub(super) const OF_EACH: usize = 24;

/// [`PlanarJoint`] with eight hypotheses of data association, each with capacity for 24 features and 8 moving-object tracks.
pub type PlanarHypotheses = PlanarJoint<OF_EACH, { joint_numbers(3, 2, OF_EACH) }, EightHypotheses>;
/// Its hypotheses.
pub(super) type EightHypotheses = Hypotheses<7, OF_EACH, { joint_numbers(3, 2, OF_EACH) }, MEASUREMENTS, 8>;

/// Its memory.
pub type Memory<T, const ROOM: usize, const NUMBERS: usize, V> = JointMemory<
    JointState<PlanarPose<T>, Vector2<T>, ROOM, NUMBERS, MEASUREMENTS>,
    <V as OptionalParts<Drive<T>, Vector2<T>>>::Memory,
    Vector2<T>,
    MEASUREMENTS,
>;

/// The joint map with optional parts `V`.
pub(super) type OnboardPlanar<'m, T, V = NoMovers> =
    OnboardJoint<'m, Planar, Direct, <V as OptionalParts<Drive<T>, Vector2<T>>>::Filter<'m>, PlanarSensing<T>>;

impl<T: Real, V: OptionalParts<Drive<T>, Vector2<T>>, const ROOM: usize, const NUMBERS: usize> Aboard<T>
    for PlanarJoint<ROOM, NUMBERS, V>
{
    type Kind = Planar;
    type Memory = Memory<T, ROOM, NUMBERS, V>;
    type Filter<'m>
        = OnboardPlanar<'m, T, V>
    where
        T: 'm;

    const MEMORY: Self::Memory = JointMemory::with(JointState::new(), V::MEMORY);
    const CAPACITIES: Capacities = joint::capacities(ROOM, MEASUREMENTS);
    const RAM_PARTS: [RamPart; 6] = <Self::Memory>::RAM_PARTS;

    fn start<'m>(header: &Header<Planar>, memory: &'m mut Self::Memory) -> Result<Self::Filter<'m>, Refusal>
    where
        T: 'm,
    {
        let JointMemory { state, parts, measurements } = memory;
        let map = JointSlam::new(motion(header, 1.0)?, header.joint.config(), state)?;
        let detector = detector(&Sensor::first(header))?;
        OnboardJoint::start::<_, V>(map, (parts, header), (detector, Direct), (measurements, ROOM), start(header))
    }
}
