//! Where the sensor sees: p_D(m | x) (section 5.2.3).

use super::ModelError;
use crate::{Bounds, Vector};

/// The probability of detection of a feature from a pose, p_D(m | x) of (5.15).
///
/// `F` is the frame of the sensor ([`Sensor::Frame`](super::Sensor::Frame)), `D` where a feature is, `Z` what is measured of it.
/// Several cores may ask it at the same time.
pub trait FieldOfView<F, D: Vector, Z: Vector>: Sync {
    /// The parameter that the model cannot work with, if any: asked by [`Detector::new`](crate::Detector::new) and
    /// [`Detector::retune`](crate::Detector::retune).
    ///
    /// # Errors
    /// Names the parameter and its range. None unless the model says otherwise.
    fn check(&self) -> Result<(), ModelError> {
        Ok(())
    }

    /// p_D of a feature at `feature`, whose expected measurement is `expected`: in [0, 1); zero outside the view.
    fn detection_probability(&self, frame: &F, feature: &D, expected: &Z) -> D::Scalar;

    /// Whether p_D may be above zero there, by a test that takes less than what is to be expected of a feature: never `false`
    /// where it is. Most of what is out of view, but in the box around it, is passed over by it.
    #[inline]
    fn may_see(&self, _frame: &F, _feature: &D) -> bool {
        true
    }

    /// A box that holds every position with p_D > 0.
    fn bounds(&self, frame: &F) -> Bounds<D>;
}
