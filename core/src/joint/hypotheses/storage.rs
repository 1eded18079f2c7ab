//! Memory of the hypotheses other than the likeliest one.

use super::super::covariance::joint_numbers;
use super::super::landmark::Landmark;
use super::super::movers::JointMovers;
use super::super::state::Header;
use super::MOST;
use super::slot::{Slot, Weight};
use super::tracks::MoversOf;
use crate::{Pose, PositionOf, Real, ScalarOf, TangentOf, Vector};

/// Memory of up to `OTHERS` hypotheses in addition to that in the [`JointState`](crate::JointState), for
/// [`with_hypotheses`](crate::JointSlam::with_hypotheses).
///
/// `FEATURES` and `NUMBERS` must be those of the state, `TRACKS` the capacity of its movers, or 0. In the plane and in single
/// precision, 7 others with 24 features and 8 tracks take 51 KB. Meant to be a `static`: a new one is all zero.
#[derive(Debug)]
pub struct JointHypotheses<
    P: Pose,
    const OTHERS: usize,
    const FEATURES: usize,
    const NUMBERS: usize,
    const TRACKS: usize,
> {
    others: [Hypothesis<P, FEATURES, NUMBERS, TRACKS>; OTHERS],
}

#[derive(Debug)]
struct Hypothesis<P: Pose, const FEATURES: usize, const NUMBERS: usize, const TRACKS: usize> {
    weight: Weight<ScalarOf<P>>,
    header: Header<P>,
    landmarks: [Landmark<PositionOf<P>>; FEATURES],
    covariance: [ScalarOf<P>; NUMBERS],
    movers: JointMovers<P, TRACKS>,
}

impl<T: Real, P: Pose<Scalar = T>, const FEATURES: usize, const NUMBERS: usize, const TRACKS: usize>
    Hypothesis<P, FEATURES, NUMBERS, TRACKS>
{
    const ZERO: Self = Self {
        weight: Weight::NONE,
        header: Header::ZERO,
        landmarks: [Landmark::ZERO; FEATURES],
        covariance: [T::ZERO; NUMBERS],
        movers: JointMovers::new(),
    };
}

impl<
    T: Real,
    P: Pose<Scalar = T>,
    const OTHERS: usize,
    const FEATURES: usize,
    const NUMBERS: usize,
    const TRACKS: usize,
> JointHypotheses<P, OTHERS, FEATURES, NUMBERS, TRACKS>
{
    /// No hypotheses.
    pub const fn new() -> Self {
        const {
            let numbers = joint_numbers(TangentOf::<P>::DIMENSION, PositionOf::<P>::DIMENSION, FEATURES);
            assert!(NUMBERS == numbers, "NUMBERS must be joint_numbers of pose, feature and FEATURES");
            assert!(OTHERS < MOST, "at most 15 hypotheses beside the likeliest");
        }
        Self { others: [Hypothesis::ZERO; OTHERS] }
    }

    /// Borrows the hypotheses, whose tracks have the tuning of `movers`.
    pub(super) fn borrowed<'s, V: MoversOf<'s, P>>(&'s mut self, movers: &V) -> [Slot<'s, P, V>; OTHERS] {
        self.others.each_mut().map(|other| Slot {
            weight: &mut other.weight,
            header: &mut other.header,
            landmarks: &mut other.landmarks,
            numbers: &mut other.covariance,
            movers: movers.over(&mut other.movers),
        })
    }
}
