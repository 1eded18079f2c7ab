//! Everything that the joint filter knows, in memory of a size that its type tells.

use super::associations::AssociationRow;
use super::covariance::{Joint, RowsOf, joint_numbers};
use super::existence::Existence;
use crate::report::watch::Watch;
use crate::{Pose, PositionOf, Real, ScalarOf, Symmetric, TangentOf, Vector, Zero};

/// One feature of a joint map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Landmark<D: Vector> {
    /// Names the feature.
    pub(super) label: u32,
    /// Where it is, m.
    pub(super) mean: D,
    /// How far corrections have moved it since the covariance was last turned, m.
    pub(super) moved: D,
    /// Whether it is there.
    pub(super) existence: Existence<D::Scalar>,
    /// Detections of it so far, each by its share.
    pub(super) detections: D::Scalar,
    /// p_D in the scan at hand, 0 out of view.
    pub(super) detection: D::Scalar,
    /// Whether pages of the archive are conditioned on it.
    pub(super) is_anchor: bool,
    /// Σ a ν over the measurements of the scan at hand that it may have caused.
    pub(super) claimed: D::Scalar,
}

/// The state of a [`JointSlam`](super::JointSlam): one Gaussian over the pose and up to `FEATURES` features.
///
/// `P` is the pose, `Z` the widest measurement. `NUMBERS` is [`joint_numbers`] of the dimensions of the pose and of a feature, and
/// `FEATURES`, which the build checks; `MEASUREMENTS` of a scan there is room for. Meant to be a `static`: it may be large, and a
/// fresh one is all zero but for its counts.
#[derive(Debug)]
pub struct JointState<P: Pose, Z: Vector, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize> {
    known: Known<P>,
    landmarks: [Landmark<PositionOf<P>>; FEATURES],
    covariance: [ScalarOf<P>; NUMBERS],
    common: [RowsOf<PositionOf<P>, Z>; FEATURES],
    explained: [AssociationRow<ScalarOf<P>>; MEASUREMENTS],
}

/// What is not an array.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known<P: Pose> {
    pub(super) started: bool,
    pub(super) pose: P,
    /// What rounding took from its x and y in the last [short](crate::particles::short) step, m.
    pub(super) remainder: [ScalarOf<P>; 2],
    /// How far corrections have moved it on the ground since the covariance was last turned, m.
    pub(super) moved: [ScalarOf<P>; 2],
    /// Features there are.
    pub(super) len: usize,
    /// Summed dt since the last scan, s.
    pub(super) waited_s: ScalarOf<P>,
    /// What the noise of the steps since the last scan has added to the covariance of the pose.
    pub(super) walked: Symmetric<TangentOf<P>>,
    /// Predictions refused since the last scan.
    pub(super) refused: usize,
    pub(super) next_label: u32,
    /// Whether the vehicle is where it is taken to be.
    pub(super) watch: Watch<ScalarOf<P>>,
}

/// A state of whatever capacity, borrowed.
#[derive(Debug)]
pub(super) struct Memory<'s, P: Pose, Z: Vector> {
    pub(super) known: &'s mut Known<P>,
    pub(super) landmarks: &'s mut [Landmark<PositionOf<P>>],
    pub(super) joint: Joint<'s, P>,
    pub(super) common: &'s mut [RowsOf<PositionOf<P>, Z>],
    pub(super) explained: &'s mut [AssociationRow<ScalarOf<P>>],
}

impl<T, P, Z, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize>
    JointState<P, Z, FEATURES, NUMBERS, MEASUREMENTS>
where
    T: Real,
    P: Pose<Scalar = T>,
    Z: Vector<Scalar = T>,
{
    /// A state that has not been started.
    #[must_use]
    pub const fn new() -> Self {
        const {
            let numbers = joint_numbers(P::Tangent::DIMENSION, P::Position::DIMENSION, FEATURES);
            assert!(NUMBERS == numbers, "NUMBERS must be joint_numbers of pose, feature and FEATURES");
            assert!(FEATURES <= u16::MAX as usize, "at most 65535 features");
        }
        let known = Known {
            started: false,
            pose: P::ZERO,
            remainder: [T::ZERO; 2],
            moved: [T::ZERO; 2],
            len: 0,
            waited_s: T::ZERO,
            walked: Symmetric::ZERO,
            refused: 0,
            next_label: 0,
            watch: Watch::ZERO,
        };
        Self {
            known,
            landmarks: [Landmark::ZERO; FEATURES],
            covariance: [T::ZERO; NUMBERS],
            common: [Zero::ZERO; FEATURES],
            explained: [AssociationRow::ZERO; MEASUREMENTS],
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.known.started = false;
        self.known.len = 0;
    }

    pub(super) fn memory(&mut self) -> Memory<'_, P, Z> {
        Memory {
            known: &mut self.known,
            landmarks: &mut self.landmarks,
            joint: Joint { numbers: &mut self.covariance },
            common: &mut self.common,
            explained: &mut self.explained,
        }
    }
}

impl<T, P, Z, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize> Default
    for JointState<P, Z, FEATURES, NUMBERS, MEASUREMENTS>
where
    T: Real,
    P: Pose<Scalar = T>,
    Z: Vector<Scalar = T>,
{
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> Memory<'_, P, Z> {
    /// Drops a feature; the last one takes its place.
    pub(super) fn drop_feature(&mut self, place: usize) {
        let last = self.known.len.saturating_sub(1);
        self.joint.replace_by_last(place, self.known.len);
        if let Some(slot) = self.landmarks.get(last).copied()
            && let Some(dropped) = self.landmarks.get_mut(place)
        {
            *dropped = slot;
        }
        self.known.len = last;
    }
}

impl<T: Real, D: Vector<Scalar = T>> Landmark<D> {
    pub(super) const ZERO: Self = Self {
        label: 0,
        mean: D::ZERO,
        moved: D::ZERO,
        existence: Existence::NONE,
        detections: T::ZERO,
        detection: T::ZERO,
        is_anchor: false,
        claimed: T::ZERO,
    };
}
