//! A landmark of a joint map.

use super::existence::Existence;
use crate::{Real, Vector};

/// One landmark of a joint map.
#[derive(Debug, Clone, Copy)]
pub struct Landmark<D: Vector> {
    /// Identifies the landmark in all scans.
    pub(super) label: u32,
    /// Mean of the position, m.
    pub(super) mean: D,
    /// Sum of the corrections of the mean since the covariance was last transformed to the present error frame, m.
    pub(super) moved: D,
    /// Probabilities that it exists and is visible, that it exists and is occluded, and that it does not exist.
    pub(super) existence: Existence<D::Scalar>,
    /// Number of detections so far: the sum of the association probabilities.
    pub(super) detections: D::Scalar,
    /// p_D in the present scan, 0 out of view.
    pub(super) detection: D::Scalar,
    /// Whether archived submaps are conditioned on it.
    pub(super) is_anchor: bool,
    /// Index of the measurement of the present scan that it caused, or [`NONE`](super::movers::NONE); only with several
    /// hypotheses.
    pub(super) measurement: u16,
    /// Scratch of the present scan: first ln of the peak of its innovation's density, then Σ a ν over its associations. With
    /// several hypotheses first ln of the probability that neither it nor the track of the same object is detected, then the
    /// probability that it caused its measurement, and not the track.
    pub(super) scratch: D::Scalar,
}

impl<T: Real, D: Vector<Scalar = T>> Landmark<D> {
    /// With several hypotheses: whether it, or the track of the same object, may have caused one of the next measurements.
    pub(super) fn may_be_cause(&self) -> bool {
        self.measurement == super::movers::NONE && self.scratch < T::ZERO
    }

    pub(super) const ZERO: Self = Self {
        label: 0,
        mean: D::ZERO,
        moved: D::ZERO,
        existence: Existence::NONE,
        detections: T::ZERO,
        detection: T::ZERO,
        is_anchor: false,
        measurement: 0,
        scratch: T::ZERO,
    };
}
