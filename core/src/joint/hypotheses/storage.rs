//! Memory of the hypotheses other than the likeliest one.

use super::super::covariance::joint_numbers;
use super::super::movers::JointMovers;
use super::super::state::{Header, Landmark};
use super::MOST;
use super::causes::Cause;
use super::slot::{Slot, Weight};
use super::tracks::MoversOf;
use crate::{Pose, PositionOf, Real, ScalarOf, TangentOf, Vector};

/// Memory of up to `OTHERS` hypotheses in addition to that in the [`JointState`](crate::JointState), for
/// [`with_hypotheses`](crate::JointSlam::with_hypotheses).
///
/// `FEATURES`, `NUMBERS` and `MEASUREMENTS` must be those of the state, `TRACKS` the capacity of its movers, or 0. In the
/// plane and in single precision, 7 others with 24 features, 16 measurements and 8 tracks take 52 KB. Meant to be a
/// `static`: a new one is all zero.
#[derive(Debug)]
pub struct JointHypotheses<
    P: Pose,
    const OTHERS: usize,
    const FEATURES: usize,
    const NUMBERS: usize,
    const MEASUREMENTS: usize,
    const TRACKS: usize,
> {
    causes: [Cause<ScalarOf<P>>; MEASUREMENTS],
    others: [Hypothesis<P, FEATURES, NUMBERS, MEASUREMENTS, TRACKS>; OTHERS],
}

#[derive(Debug)]
struct Hypothesis<P: Pose, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize, const TRACKS: usize>
{
    weight: Weight<ScalarOf<P>>,
    header: Header<P>,
    landmarks: [Landmark<PositionOf<P>>; FEATURES],
    covariance: [ScalarOf<P>; NUMBERS],
    movers: JointMovers<P, TRACKS>,
    causes: [Cause<ScalarOf<P>>; MEASUREMENTS],
}

impl<
    T: Real,
    P: Pose<Scalar = T>,
    const FEATURES: usize,
    const NUMBERS: usize,
    const MEASUREMENTS: usize,
    const TRACKS: usize,
> Hypothesis<P, FEATURES, NUMBERS, MEASUREMENTS, TRACKS>
{
    const ZERO: Self = Self {
        weight: Weight::NONE,
        header: Header::ZERO,
        landmarks: [Landmark::ZERO; FEATURES],
        covariance: [T::ZERO; NUMBERS],
        movers: JointMovers::new(),
        causes: [Cause::ZERO; MEASUREMENTS],
    };
}

impl<
    T: Real,
    P: Pose<Scalar = T>,
    const OTHERS: usize,
    const FEATURES: usize,
    const NUMBERS: usize,
    const MEASUREMENTS: usize,
    const TRACKS: usize,
> JointHypotheses<P, OTHERS, FEATURES, NUMBERS, MEASUREMENTS, TRACKS>
{
    /// No hypotheses.
    pub const fn new() -> Self {
        const {
            let numbers = joint_numbers(TangentOf::<P>::DIMENSION, PositionOf::<P>::DIMENSION, FEATURES);
            assert!(NUMBERS == numbers, "NUMBERS must be joint_numbers of pose, feature and FEATURES");
            assert!(OTHERS < MOST, "at most 15 hypotheses beside the likeliest");
        }
        Self { causes: [Cause::ZERO; MEASUREMENTS], others: [Hypothesis::ZERO; OTHERS] }
    }

    /// Borrows the causes of the likeliest hypothesis, and the other hypotheses, whose tracks have the tuning of `movers`.
    pub(super) fn borrowed<'s, V: MoversOf<'s, P>>(
        &'s mut self,
        movers: &V,
    ) -> (&'s mut [Cause<T>], [Slot<'s, P, V>; OTHERS]) {
        let others = self.others.each_mut().map(|other| Slot {
            weight: &mut other.weight,
            header: &mut other.header,
            landmarks: &mut other.landmarks,
            numbers: &mut other.covariance,
            movers: movers.over(&mut other.movers),
            causes: &mut other.causes,
        });
        (&mut self.causes, others)
    }
}
