//! What all detectors have in common: their handle is made over memory of their kind.

use crate::reason::Reason;
use crate::{scphd_mounting, scphd_status};
use scphd::models::{MeasurementModel, Pose, ScalarOf};
use scphd::{Births, Detector};

/// What a detector is made of, beside its memory.
pub(crate) struct Parts<'a, X: MeasurementModel> {
    pub(crate) sensing: X,
    pub(crate) births: Births<ScalarOf<X::Pose>>,
    pub(crate) mounting: &'a scphd_mounting,
}

impl<X: MeasurementModel<Pose: Pose<Scalar = f32>>> Parts<'_, X> {
    /// The detector, without memory yet.
    pub(crate) fn detector(self, reason: &mut Reason<'_>) -> Result<Detector<X>, scphd_status> {
        let mounting = self.mounting.mounting(reason)?;
        let detector = Detector::new(self.sensing, self.births).map_err(|error| reason.model(error))?;
        match mounting {
            Some(mounting) => detector.mounted(mounting).map_err(|error| reason.model(error)),
            None => Ok(detector),
        }
    }
}
