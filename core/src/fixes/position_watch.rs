//! Monitor of rejected positions, for a filter in the plane.

use super::FixRule;
use super::refused_way::RefusedWay;
use super::waited::Waited;
use crate::{Fix, ModelError, PlanarPose, PoseEstimate, PositionFix, Real};
use nalgebra::Vector2;

/// Multiple of the rule's time that a slow vehicle gets, until its path determines the rotation.
const PATIENCE_OF_THE_SLOW: f64 = 4.0;

/// Decides, from positions of one receiver that are rejected by their gate, whether the fixes are wrong or the filter has diverged.
///
/// A fix beyond its gate is rejected. If the filter has diverged (a wrong start, wheel slip, a false loop closure), all later fixes
/// are rejected too, and the filter would never recover. From the first rejected fix on, the monitor therefore stores sums over the
/// predicted and the measured positions of the antenna. After the time and the number of the [rule](FixRule) it aligns the two
/// paths by a rotation and a translation. If the residuals are within three standard deviations of the fixes, after a change of
/// scale between ½ and 2 because odometry may have a scale error, the filter is wrong, and the aligned pose is that of the vehicle.
/// The rotation is used if the path is long enough to determine it to 0.1 rad, for which a slow vehicle gets four times the time; a
/// vehicle that stands still keeps its heading. If the paths do not fit, as for a receiver with multipath between buildings or one
/// that repeats its last position, the sums are reset, and the next rejected fix starts new ones. An accepted fix resets them.
///
/// The memory is a fixed number of sums, at any rate of fixes.
///
/// ```
/// use scphd::fixes::{FixRule, PositionWatch};
/// use scphd::models::{PlanarPose, PositionFix};
/// use scphd::numerics::Symmetric;
/// use scphd::PoseEstimate;
/// use nalgebra::Vector2;
///
/// let gps = PositionFix::new(0.5_f32)?.gated(25.0)?; // five standard deviations
/// let mut watch = PositionWatch::new(FixRule::default())?;
/// // The vehicle drives at 2 m/s along x, 30 m from the pose that the filter estimates.
/// let back = (0..8).find_map(|second| {
///     let (x, certain) = (2.0 * second as f32, Symmetric::from_diagonal([0.01; 3]));
///     let estimate = PoseEstimate { mean: PlanarPose::new(x, 0.0, 0.0), covariance: certain };
///     watch.refused(&gps, &Vector2::new(x, 30.0), &estimate, 1.0)
/// });
/// // After 7 s: slam.relocate(back.mean, &back.covariance)
/// let back = back.unwrap();
/// assert!((back.mean.y_m - 30.0).abs() < 1e-3 && back.mean.heading_rad.abs() < 1e-3);
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionWatch<T> {
    rule: FixRule<T>,
    waited: Waited<T>,
    way: RefusedWay<T>,
}

impl<T: Real> PositionWatch<T> {
    /// A monitor with this rule.
    ///
    /// # Errors
    /// Names the parameter of the rule that is out of range.
    pub fn new(rule: FixRule<T>) -> Result<Self, ModelError> {
        Ok(Self { rule: rule.check()?, waited: Waited::NONE, way: RefusedWay::NONE })
    }

    /// To be called when a fix was accepted: the fixes rejected before were wrong.
    pub fn accepted(&mut self) {
        (self.waited, self.way) = (Waited::NONE, RefusedWay::NONE);
    }

    /// To be called when a fix of this receiver was rejected, with the estimate of the filter at its time, and the time since the
    /// previous fix of the receiver, s. If the filter has diverged, returns the pose and covariance for `relocate`, and resets the
    /// monitor. A fix that is not finite is ignored.
    pub fn refused(
        &mut self,
        fix: &PositionFix<T>,
        measured: &Vector2<T>,
        estimate: &PoseEstimate<PlanarPose<T>>,
        elapsed_s: T,
    ) -> Option<PoseEstimate<PlanarPose<T>>> {
        let expected = fix.expect(&estimate.mean)?;
        if !expected.iter().chain(measured.iter()).all(|number| number.is_finite()) {
            return None;
        }
        self.waited.refuse(elapsed_s);
        self.way.add([expected.x, expected.y], [measured.x, measured.y]);
        if !self.waited.is_over(&self.rule) {
            return None;
        }
        let sigma_m = fix.noise().get(0, 0).sqrt();
        let longest_s = self.rule.patience_s * T::from_f64(PATIENCE_OF_THE_SLOW);
        if self.waited.lasted_s < longest_s && self.way.tells_soon(sigma_m) {
            return None;
        }
        let back = self.way.laid_over(sigma_m, estimate);
        self.accepted();
        back
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pose, Symmetric};

    fn estimate(pose: PlanarPose<f64>) -> PoseEstimate<PlanarPose<f64>> {
        PoseEstimate { mean: pose, covariance: Symmetric::from_diagonal([0.01, 0.01, 0.0004]) }
    }

    /// A vehicle on a circle of radius 20 m at 2 m/s, once a second.
    fn driven(second: u32) -> PlanarPose<f64> {
        let angle = 0.1 * f64::from(second);
        PlanarPose::new(20.0 * angle.sin(), 20.0 * (1.0 - angle.cos()), angle)
    }

    fn told(
        fix: &PositionFix<f64>,
        seconds: u32,
        pose: impl Fn(u32) -> PlanarPose<f64>,
        measured: impl Fn(u32) -> Vector2<f64>,
    ) -> Option<(u32, PoseEstimate<PlanarPose<f64>>)> {
        let mut watch = PositionWatch::new(FixRule::default()).unwrap();
        (0..seconds).find_map(|second| {
            watch.refused(fix, &measured(second), &estimate(pose(second)), 1.0).map(|back| (second, back))
        })
    }

    #[test]
    fn a_rotated_and_shifted_path_is_aligned_with_the_fixes() {
        let fix = PositionFix::new(0.3).unwrap().mounted(0.7, -0.2).unwrap();
        let (turn, shift) = (0.8_f64, Vector2::new(1400.0, -3.0));
        let truly = |pose: PlanarPose<f64>| {
            let (s, c) = turn.sin_cos();
            PlanarPose::new(
                c * pose.x_m - s * pose.y_m + shift.x,
                s * pose.x_m + c * pose.y_m + shift.y,
                pose.heading_rad + turn,
            )
        };
        let (when, back) = told(&fix, 20, driven, |second| fix.expect(&truly(driven(second))).unwrap()).unwrap();
        // 7 s after the first fix.
        assert_eq!(when, 7);
        assert!(back.mean.difference(&truly(driven(7))).norm() < 1e-9, "{back:?}");
        // Σ |p − p̄|² over the positions of the antenna gives the variance of the rotation.
        let places: std::vec::Vec<_> = (0..8).map(|second| fix.expect(&driven(second)).unwrap()).collect();
        let middle = places.iter().sum::<Vector2<f64>>() / 8.0;
        let spread: f64 = places.iter().map(|place| (place - middle).norm_squared()).sum();
        assert!((back.covariance.get(2, 2) - 0.09 / spread).abs() < 1e-12, "{back:?}");
        let arm = nalgebra::Rotation2::new(turn) * (Vector2::new(driven(7).x_m, driven(7).y_m) - middle);
        assert!((back.covariance.get(0, 0) - 0.09 - arm.y * arm.y * 0.09 / spread).abs() < 1e-9, "{back:?}");
    }

    #[test]
    fn a_vehicle_at_rest_keeps_its_heading() {
        let fix = PositionFix::new(0.5).unwrap();
        let at = PlanarPose::new(1.0, 2.0, 0.5);
        let (_, back) = told(&fix, 20, |_| at, |_| Vector2::new(40.0, -7.0)).unwrap();
        assert!(back.mean.difference(&PlanarPose::new(40.0, -7.0, 0.5)).norm() < 1e-12, "{back:?}");
        let variances = [0, 1, 2].map(|k| back.covariance.get(k, k));
        assert!((variances[0] - 0.25).abs() < 1e-12 && variances[2] == 0.0004, "{back:?}");
    }

    /// At 0.5 m/s a path of 7 s does not determine the rotation from fixes of 1.5 m. Keeping the heading would then keep its error.
    #[test]
    fn a_slow_vehicle_gets_time_until_its_path_determines_the_rotation() {
        let fix = PositionFix::new(1.5).unwrap();
        let slow = |second: u32| PlanarPose::new(0.5 * f64::from(second), 0.0, 0.0);
        let truly = |second: u32| Vector2::new(-0.5 * f64::from(second), 20.0);
        let (when, back) = told(&fix, 60, slow, truly).unwrap();
        assert!((15..=28).contains(&when), "{when}");
        let right = PlanarPose::new(-0.5 * f64::from(when), 20.0, core::f64::consts::PI);
        assert!(back.mean.difference(&right).norm() < 1e-6, "{back:?}");
    }

    #[test]
    fn inconsistent_fixes_are_never_right() {
        let fix = PositionFix::new(0.5).unwrap();
        // A receiver that repeats its last position while the vehicle moves; one that jumps; one that moves ten times as fast.
        assert_eq!(told(&fix, 60, driven, |_| Vector2::new(500.0, 0.0)), None);
        assert_eq!(told(&fix, 60, driven, |second| Vector2::new(f64::from(second * 37 % 11) * 20.0, 300.0)), None);
        let fast = |second| Vector2::new(500.0 + 10.0 * driven(second).x_m, 10.0 * driven(second).y_m);
        assert_eq!(told(&fix, 60, driven, fast), None);
        // An error that lasts less than seven seconds is ignored.
        assert_eq!(told(&fix, 7, driven, |second| fix.expect(&driven(second)).unwrap().add_scalar(50.0)), None);
        assert_eq!(told(&fix, 60, driven, |_| Vector2::new(f64::NAN, 0.0)), None);
    }

    #[test]
    fn an_accepted_fix_resets_the_sums_and_few_fixes_are_not_enough() {
        let fix = PositionFix::new(0.5).unwrap();
        let mut watch = PositionWatch::new(FixRule::default()).unwrap();
        let refused = |watch: &mut PositionWatch<f64>, second: u32, elapsed_s| {
            let off = fix.expect(&driven(second)).unwrap().add_scalar(50.0);
            watch.refused(&fix, &off, &estimate(driven(second)), elapsed_s)
        };
        for second in 0..100 {
            assert_eq!(refused(&mut watch, second, 1.0), None);
            if second % 6 == 5 {
                watch.accepted();
            }
        }
        watch.accepted();
        // One fix in 10 s: four are not enough, however long they take; a time of NaN counts as zero.
        for second in 0..4 {
            assert_eq!(refused(&mut watch, second, 10.0), None);
        }
        assert!(refused(&mut watch, 4, f64::NAN).is_some());
    }

    #[test]
    fn rules_are_checked() {
        assert_eq!(PositionWatch::new(FixRule { patience_s: f64::NAN, fewest: 5 }).unwrap_err().field, "patience_s");
        assert_eq!(PositionWatch::new(FixRule { patience_s: 1.0_f32, fewest: 2 }).unwrap_err().field, "fewest");
        let for_ever = FixRule { patience_s: f64::INFINITY, ..FixRule::default() };
        assert!(PositionWatch::new(for_ever).is_ok());
    }
}
