//! The joint maps of a planar vehicle on board.

use super::onboard::{MEASUREMENTS, Memory, Noise, OnBoard};
use super::{Planar, onboard};
use crate::Parameters;
use crate::onboard::{Aboard, Capacities, Ram, RamPart, Refusal};
use scphd::Real;
use scphd::models::{CalibratedPose, PlanarPose, ScalarOf};
use scphd::storage::{JointArchive, JointHypotheses, JointMovers, joint_numbers};
use scphd_vehicle::{Backing, JointBacking};

/// Capacity of the joint map, features.
const FEATURES: usize = if cfg!(feature = "small-pools") { 16 } else { 64 };
/// Capacity of the smaller map, features.
const FEW: usize = 40;
/// Capacity of each of several hypotheses, features.
const OF_EACH: usize = 24;
/// Capacity for moving-object tracks.
const MOVERS: usize = 64;

type Pose<T> = PlanarPose<T>;
type Room<P, M, A, H, const FEATURES: usize, const NUMBERS: usize> =
    JointBacking<P, M, A, H, FEATURES, NUMBERS, MEASUREMENTS, Noise<ScalarOf<P>>>;
type Plain<T> = Room<Pose<T>, (), (), (), FEATURES, { joint_numbers(3, 2, FEATURES) }>;
type Movers<T> = Room<Pose<T>, JointMovers<Pose<T>, MOVERS>, (), (), FEATURES, { joint_numbers(3, 2, FEATURES) }>;
type Few<T> = Room<Pose<T>, (), (), (), FEW, { joint_numbers(3, 2, FEW) }>;
type FewMovers<T> = Room<Pose<T>, JointMovers<Pose<T>, MOVERS>, (), (), FEW, { joint_numbers(3, 2, FEW) }>;
type Archive<T> = Room<
    Pose<T>,
    JointMovers<Pose<T>, MOVERS>,
    JointArchive<Pose<T>, 256>,
    (),
    FEATURES,
    { joint_numbers(3, 2, FEATURES) },
>;
type Calibrated<T> = Room<CalibratedPose<T>, (), (), (), FEATURES, { joint_numbers(6, 2, FEATURES) }>;
type Others<T> = JointHypotheses<Pose<T>, 7, OF_EACH, { joint_numbers(3, 2, OF_EACH) }, 8>;
type Hypotheses<T> = Room<Pose<T>, JointMovers<Pose<T>, 8>, (), Others<T>, OF_EACH, { joint_numbers(3, 2, OF_EACH) }>;

/// Declares filters on board. Those of a black box have room for a loaded map.
macro_rules! on_board {
    ($($(#[$about:meta])* $name:ident: $room:ident, $features:expr, $black_box:literal;)+) => {$(
        $(#[$about])*
        #[derive(Debug, Clone, Copy)]
        pub struct $name;

        impl<T: Real> Aboard<T> for $name {
            type Kind = Planar;
            type Memory = Memory<$room<T>, T, { if $black_box { $features } else { 0 } }>;
            type Filter<'m>
                = OnBoard<'m, <$room<T> as Backing<T>>::Slam<'m>, T, $black_box>
            where
                T: 'm;

            const MEMORY: Self::Memory = Memory::with(JointBacking::new());
            const CAPACITIES: Capacities = Capacities {
                candidates: 1,
                particles: 1,
                components: $features,
                components_in_all: $features,
                measurements: onboard::MEASUREMENTS,
            };
            const RAM_PARTS: [RamPart; 6] = Ram::of_joint(size_of::<Self::Memory>(), size_of::<$room<T>>()).parts();

            fn start<'m>(
                head: &impl Parameters<Planar>,
                memory: &'m mut Self::Memory,
            ) -> Result<Self::Filter<'m>, Refusal>
            where
                T: 'm,
            {
                memory.start(head, $features)
            }
        }
    )+};
}

on_board! {
    /// The joint map.
    PlanarJoint: Plain, FEATURES, false;
    /// [`PlanarJoint`] with moving-object tracks.
    PlanarJointMovers: Movers, FEATURES, false;
    /// [`PlanarJoint`] with capacity for 40 features.
    PlanarJoint40: Few, FEW, false;
    /// [`PlanarJoint40`] with moving-object tracks.
    PlanarJoint40Movers: FewMovers, FEW, false;
    /// Eight hypotheses of data association, each with capacity for 24 features and 8 moving-object tracks.
    PlanarHypotheses: Hypotheses, OF_EACH, false;
    /// The joint map for black boxes: fixes, scans that update the pose only, and all other records.
    BlackBoxJoint: Plain, FEATURES, true;
    /// [`BlackBoxJoint`] with moving-object tracks.
    BlackBoxMovers: Movers, FEATURES, true;
    /// [`BlackBoxMovers`] with an archive of 256 distant features.
    BlackBoxArchive: Archive, FEATURES, true;
    /// [`BlackBoxJoint`] with several hypotheses of data association, as [`PlanarHypotheses`].
    BlackBoxHypotheses: Hypotheses, OF_EACH, true;
    /// [`BlackBoxJoint`] that calibrates its odometry.
    BlackBoxCalibrated: Calibrated, FEATURES, true;
}
