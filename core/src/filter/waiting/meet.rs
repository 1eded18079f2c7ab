//! Association of delayed births with the measurements of the next scan.

use crate::detection::scan::Scan;
use crate::detection::view::View;
use crate::numerics::vector::applied;
use crate::numerics::work;
use crate::particles::candidate::Candidate;
use crate::{Component, CovarianceOf, MeasurementModel, Pose, PositionOf, Real, Sensor, TangentOf, Vector, Zero};

/// The motion of the vehicle from the pose at the births to the pose of the scan, and the motions of all candidates relative to it.
pub(super) struct Step<'a, X: MeasurementModel> {
    /// The scan from the pose at the end of the motion.
    pub(super) view: View<'a, X>,
    /// Covariance of that pose, if it has one.
    pub(super) pose_covariance: Option<&'a CovarianceOf<X::Pose>>,
    /// Difference of the motion of every candidate from this one.
    pub(super) steps: &'a [TangentOf<X::Pose>],
    /// Maximum of the absolute differences, by coordinate.
    pub(super) spread: TangentOf<X::Pose>,
}

/// Writes the differences of the motions of all candidates, each from the birthplace of its particle, from the motion of the
/// first candidate of particle `own`. Returns the maximum of the absolute differences, by coordinate.
#[inline(never)]
pub(super) fn compare<T: Real, P: Pose<Scalar = T>>(
    own: usize,
    birthplaces: &[P],
    candidates: &[Candidate<P>],
    children: usize,
    steps: &mut [P::Tangent],
) -> P::Tangent {
    let heading = |pose: &P| pose.on_ground()[2];
    let mut most = P::Tangent::ZERO;
    let Some((from, to)) = birthplaces.get(own).zip(candidates.get(own.saturating_mul(children))) else { return most };
    let (own_step, own_heading) = (to.pose.difference(from), heading(from));
    let families = candidates.chunks(children.max(1)).zip(steps.chunks_mut(children.max(1)));
    for (from, (family, steps)) in birthplaces.iter().zip(families) {
        // Motions are compared in the frame of the vehicle, independent of its heading.
        let (sine, cosine) =
            if P::HEADING.is_some() { (own_heading - heading(from)).sin_cos() } else { (T::ZERO, T::ONE) };
        for (candidate, slot) in family.iter().zip(steps) {
            work::round();
            let step = candidate.pose.difference(from);
            let (x, y) = (step.at(0), step.at(1));
            let turned = P::Tangent::with(|k| match k {
                0 => cosine * x - sine * y,
                1 => sine * x + cosine * y,
                _ => step.at(k),
            });
            *slot = turned - own_step;
            most = P::Tangent::with(|k| most.at(k).at_least(slot.at(k).abs()));
        }
    }
    most
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>> Step<'_, X> {
    /// Calls `met_by` for every candidate that may have detected the birth: for which a detection would have at least the weight
    /// below which components are pruned. Returns p_D w, the expected detections of the birth for the other candidates, which would
    /// prune it after a miss; `None` if it would not be pruned, or may be out of view. For a moving birth only the position counts.
    ///
    /// The predicted measurement of another candidate is approximated: this one's, shifted by the difference of the motions.
    #[inline(never)]
    pub(super) fn meet(
        &self,
        birth: &Component<PositionOf<P>>,
        scan: &Scan<'_, X::Measurement>,
        ln_floor: T,
        mut met_by: impl FnMut(usize),
    ) -> Option<T> {
        let view = &self.view;
        let expectation = view.expect_blurred(self.pose_covariance, birth)?;
        if birth.ln_weight + expectation.detection.ln_missed >= ln_floor {
            return None;
        }
        let expected = expectation.expected();
        let by_pose = view.sensor.by_pose(&view.frame, &birth.mean, &expected);
        let moved = |step: &P::Tangent| applied::<X::Measurement, P::Tangent>(&by_pose, step);
        let most_moved = (0..P::Tangent::DIMENSION).fold(X::Measurement::ZERO, |sum, along| {
            let by_step = moved(&P::Tangent::with(|k| if k == along { self.spread.at(k) } else { T::ZERO }));
            X::Measurement::with(|k| sum.at(k) + by_step.at(k).abs())
        });
        let factor = expectation.innovation_factor()?;
        let ln_peak = expectation.ln_detected_weight + factor.ln_peak();
        let headroom = ln_peak - ln_floor - scan.ln_least_reference();
        // The comparison is written so that NaN has no match; a birth of negligible weight has none either.
        if headroom > T::ZERO {
            let farthest = X::Measurement::with(|k| {
                let along = (headroom + headroom) * expectation.innovation_covariance.get(k, k);
                along.sqrt_above() + most_moved.at(k)
            });
            let reach = farthest.at(X::Sensor::SORTED_BY);
            scan.near::<X::Sensor>(&expected.measurement, reach, |(_, measured)| {
                let innovation = view.sensor.innovation(&measured.z, &expected.measurement);
                if innovation.as_slice().iter().zip(farthest.as_slice()).any(|(&apart, &most)| apart.abs() > most) {
                    return;
                }
                let least = ln_floor + measured.ln_reference();
                for (candidate, step) in self.steps.iter().enumerate() {
                    let distance = factor.mahalanobis(&(innovation - moved(step)));
                    if ln_peak - T::from_f64(0.5) * distance >= least {
                        met_by(candidate);
                    }
                }
            });
        }
        Some(expectation.detection.probability * birth.ln_weight.exp())
    }
}
