//! The state of the joint filter, in memory of a fixed size.

use super::associations::AssociationRow;
use super::covariance::{Joint, joint_numbers};
use super::landmark::Landmark;
use super::pending::{FeatureRows, Pending, TERMS};
use crate::report::watch::Watch;
use crate::{CovarianceOf, Pose, PositionOf, Real, ScalarOf, Symmetric, Vector, Zero};

/// The state of a [`JointSlam`](super::JointSlam): one Gaussian over the pose and up to `FEATURES` features.
///
/// `P` is the pose, `Z` the measurement with the most dimensions. `NUMBERS` must be [`joint_numbers`] of the dimensions
/// of the pose and of a feature, and of `FEATURES`, which the build checks. A scan has at most `MEASUREMENTS`
/// measurements. The state may be large and is meant to be a `static`.
#[derive(Debug)]
pub struct JointState<P: Pose, Z: Vector, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize> {
    header: Header<P>,
    landmarks: [Landmark<PositionOf<P>>; FEATURES],
    covariance: [ScalarOf<P>; NUMBERS],
    pending: [FeatureRows<P, Z>; FEATURES],
    association_table: [AssociationRow<ScalarOf<P>>; MEASUREMENTS],
}

/// The part of the state that has a fixed size: pose, counts and monitors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Header<P: Pose> {
    pub(super) started: bool,
    pub(super) pose: P,
    /// Rounding errors of x and y in the last [short](crate::particles::short) step, which the next step adds
    /// (compensated summation), m.
    pub(super) remainder: [ScalarOf<P>; 2],
    /// Sum of the corrections of x and y since the covariance was last transformed to the present error frame, m.
    pub(super) moved: [ScalarOf<P>; 2],
    /// Number of landmarks.
    pub(super) len: usize,
    /// Time since the last scan, s.
    pub(super) waited_s: ScalarOf<P>,
    /// W: the covariance that the noise of the steps since the last scan has added to that of the pose.
    pub(super) motion_noise: CovarianceOf<P>,
    /// Predictions refused since the last scan.
    pub(super) refused: usize,
    pub(super) next_label: u32,
    /// Monitor of filter divergence.
    pub(super) watch: Watch<ScalarOf<P>>,
}

impl<T: Real, P: Pose<Scalar = T>> Header<P> {
    /// Of a state without a pose.
    pub(super) const ZERO: Self = Self {
        started: false,
        pose: P::ZERO,
        remainder: [T::ZERO; 2],
        moved: [T::ZERO; 2],
        len: 0,
        waited_s: T::ZERO,
        motion_noise: Symmetric::ZERO,
        refused: 0,
        next_label: 0,
        watch: Watch::ZERO,
    };
}

/// A borrowed state, of any capacity.
#[derive(Debug)]
pub(super) struct Memory<'s, P: Pose, Z: Vector> {
    pub(super) header: &'s mut Header<P>,
    pub(super) landmarks: &'s mut [Landmark<PositionOf<P>>],
    pub(super) joint: Joint<'s, P>,
    pub(super) pending: Pending<'s, P, Z>,
    pub(super) association_table: &'s mut [AssociationRow<ScalarOf<P>>],
}

impl<T, P, Z, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize>
    JointState<P, Z, FEATURES, NUMBERS, MEASUREMENTS>
where
    T: Real,
    P: Pose<Scalar = T>,
    Z: Vector<Scalar = T>,
{
    /// An empty state, without a pose.
    pub const fn new() -> Self {
        const {
            let numbers = joint_numbers(P::Tangent::DIMENSION, P::Position::DIMENSION, FEATURES);
            assert!(NUMBERS == numbers, "NUMBERS must be joint_numbers of pose, feature and FEATURES");
            assert!(FEATURES <= u16::MAX as usize, "at most 65535 features");
            assert!(MEASUREMENTS <= u16::MAX as usize, "at most 65535 measurements");
        }
        Self {
            header: Header::ZERO,
            landmarks: [Landmark::ZERO; FEATURES],
            covariance: [T::ZERO; NUMBERS],
            pending: [[Zero::ZERO; TERMS]; FEATURES],
            association_table: [AssociationRow::ZERO; MEASUREMENTS],
        }
    }

    /// Removes pose and map.
    pub fn clear(&mut self) {
        self.header.started = false;
        self.header.len = 0;
    }

    pub(super) fn memory(&mut self) -> Memory<'_, P, Z> {
        Memory {
            header: &mut self.header,
            landmarks: &mut self.landmarks,
            joint: Joint { numbers: &mut self.covariance },
            pending: Pending::over(&mut self.pending),
            association_table: &mut self.association_table,
        }
    }
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> Memory<'_, P, Z> {
    /// Drops a landmark. The last landmark gets its index.
    pub(super) fn drop_feature(&mut self, index: usize) {
        let last = self.header.len.saturating_sub(1);
        self.joint.replace_by_last(index, self.header.len);
        if let Some(landmark) = self.landmarks.get(last).copied()
            && let Some(dropped) = self.landmarks.get_mut(index)
        {
            *dropped = landmark;
        }
        self.header.len = last;
    }
}
