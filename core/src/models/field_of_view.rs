//! Field of view of a sensor: p_D(m | x) (section 5.2.3).

use super::ModelError;
use crate::{Bounds, Vector};

/// The probability of detection of a feature from a pose, p_D(m | x) of (5.15).
///
/// `F` is the frame of the sensor ([`Sensor::Frame`](super::Sensor::Frame)), `D` the position of a feature, `Z` its measurement.
/// Several cores may call it at the same time.
pub trait FieldOfView<F, D: Vector, Z: Vector>: Sync {
    /// Checks the parameters of the model. [`Detector::new`](crate::Detector::new) and
    /// [`Detector::retune`](crate::Detector::retune) call it.
    ///
    /// # Errors
    /// Names the first parameter out of range, and its range. No errors by default.
    fn check(&self) -> Result<(), ModelError> {
        Ok(())
    }

    /// p_D of a feature at `feature`, whose predicted measurement is `expected`: in [0, 1); zero out of view.
    fn detection_probability(&self, frame: &F, feature: &D, expected: &Z) -> D::Scalar;

    /// A cheap test of the position, without a predicted measurement: `false` only if p_D is zero. It excludes most features that
    /// are out of view but in the bounding box of the view.
    #[inline]
    fn may_see(&self, _frame: &F, _feature: &D) -> bool {
        true
    }

    /// A box that contains all positions with p_D > 0.
    fn bounds(&self, frame: &F) -> Bounds<D>;
}
