//! Monitor of rejected headings, for a filter in the plane.

use super::FixRule;
use super::rule::LOOSE;
use super::waited::Waited;
use crate::{Fix, HeadingFix, ModelError, PlanarPose, PoseEstimate, Real, Symmetric, wrap};
use nalgebra::Vector1;

/// Decides, from headings of one compass that are rejected by their gate, whether the headings are wrong or the filter has
/// diverged: as [`PositionWatch`](crate::fixes::PositionWatch) does for positions. Headings agree with each other if they differ
/// from those of the filter by the same angle, within three standard deviations of their noise.
///
/// ```
/// use scphd::fixes::{FixRule, HeadingWatch};
/// use scphd::models::{HeadingFix, PlanarPose};
/// use scphd::numerics::Symmetric;
/// use scphd::PoseEstimate;
/// use nalgebra::Vector1;
///
/// let compass = HeadingFix::new(0.05_f32)?.gated(25.0)?;
/// let mut watch = HeadingWatch::new(FixRule::default())?;
/// let estimate = PoseEstimate { mean: PlanarPose::new(3.0, 4.0, 0.5), covariance: Symmetric::from_diagonal([0.01; 3]) };
/// let back = (0..8).find_map(|_| watch.refused(&compass, &Vector1::new(2.0), &estimate, 1.0)).unwrap();
/// assert!((back.mean.heading_rad - 2.0).abs() < 1e-6 && back.mean.x_m == 3.0);
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadingWatch<T> {
    rule: FixRule<T>,
    waited: Waited<T>,
    /// Innovation of the first rejected heading, rad.
    first: T,
    /// Σ and Σ² of the differences from the first innovation.
    sums: [T; 2],
}

impl<T: Real> HeadingWatch<T> {
    /// A monitor with this rule.
    ///
    /// # Errors
    /// Names the parameter of the rule that is out of range.
    pub fn new(rule: FixRule<T>) -> Result<Self, ModelError> {
        Ok(Self { rule: rule.check()?, waited: Waited::NONE, first: T::ZERO, sums: [T::ZERO; 2] })
    }

    /// To be called when a heading was accepted: the headings rejected before were wrong.
    pub fn accepted(&mut self) {
        (self.waited, self.sums) = (Waited::NONE, [T::ZERO; 2]);
    }

    /// To be called when a heading was rejected, with arguments and result as for
    /// [`PositionWatch::refused`](crate::fixes::PositionWatch::refused). The position in the result is that of the estimate.
    pub fn refused(
        &mut self,
        fix: &HeadingFix<PlanarPose<T>>,
        measured: &Vector1<T>,
        estimate: &PoseEstimate<PlanarPose<T>>,
        elapsed_s: T,
    ) -> Option<PoseEstimate<PlanarPose<T>>> {
        let expected = fix.expect(&estimate.mean)?;
        if !(expected.x.is_finite() && measured.x.is_finite()) {
            return None;
        }
        let off = fix.innovation(measured, &expected).x;
        if self.waited.refused == 0 {
            self.first = off;
        }
        self.waited.refuse(elapsed_s);
        let from_first = wrap(off - self.first);
        let [sum, squares] = self.sums;
        self.sums = [sum + from_first, squares + from_first * from_first];
        if !self.waited.is_over(&self.rule) {
            return None;
        }
        let count = T::from_usize(usize::from(self.waited.refused));
        let [sum, squares] = self.sums;
        let spread = (squares - sum * sum / count).at_least(T::ZERO) / (count - T::ONE);
        let variance = fix.noise().get(0, 0);
        let turn = self.first + sum / count;
        self.accepted();
        if !(spread <= variance * T::from_f64(LOOSE * LOOSE)) {
            return None;
        }
        let PlanarPose { x_m, y_m, heading_rad } = estimate.mean;
        let covariance = Symmetric::from_fn(|row, column| match (row, column) {
            (2, 2) => variance.at_least(spread),
            (2, _) => T::ZERO,
            _ => estimate.covariance.get(row, column),
        });
        Some(PoseEstimate { mean: PlanarPose::new(x_m, y_m, wrap(heading_rad + turn)), covariance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(measured: impl Fn(u32) -> f64) -> Option<(u32, PoseEstimate<PlanarPose<f64>>)> {
        let compass = HeadingFix::new(0.05).unwrap();
        let mut watch = HeadingWatch::new(FixRule::default()).unwrap();
        (0..60).find_map(|second| {
            let covariance = Symmetric::from_diagonal([0.04, 0.09, 1e-6]);
            let estimate = PoseEstimate { mean: PlanarPose::new(1.0, 2.0, 0.1 * f64::from(second)), covariance };
            watch.refused(&compass, &Vector1::new(measured(second)), &estimate, 1.0).map(|back| (second, back))
        })
    }

    #[test]
    fn headings_with_a_constant_offset_are_right() {
        // Across the cut at π.
        let (when, back) =
            told(|second| 3.1 + 0.1 * f64::from(second) + if second % 2 == 0 { 0.02 } else { -0.02 }).unwrap();
        assert_eq!(when, 7);
        let expected = wrap(0.7 + 3.1);
        assert!((back.mean.heading_rad - expected).abs() < 1e-9, "{back:?}");
        let variances = [0, 1, 2].map(|k| back.covariance.get(k, k));
        assert!(variances[0] == 0.04 && variances[1] == 0.09 && (variances[2] - 0.0025).abs() < 1e-12, "{back:?}");
    }

    #[test]
    fn a_constant_heading_of_a_turning_vehicle_is_wrong() {
        assert_eq!(told(|_| 2.0), None);
        assert_eq!(told(|_| f64::NAN), None);
    }
}
