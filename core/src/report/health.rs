//! Health flags: warnings that an autopilot can react to.

use crate::Real;
use core::fmt;
use core::ops::{BitOr, BitOrAssign};

/// A set of warnings, each with one cause.
///
/// ```
/// use scphd::Health;
///
/// let health = Health::PRUNING_TIGHTENED | Health::DEGENERATE;
/// assert!(health.contains(Health::DEGENERATE) && !health.is_good());
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct Health(u16);

/// INNOVATION_HIGH: the mean squared innovation is above the first value, and above its expectation by the second number of
/// standard deviations.
const INNOVATION_HIGH: f64 = 2.0;
const INNOVATION_DEVIATIONS: f64 = 4.5;

impl Health {
    /// No warning.
    pub const GOOD: Self = Self(0);
    /// No candidate explains the scan: every product of weight and likelihood is zero. The weights are unchanged. The vehicle is
    /// lost, or clutter and birth intensities are both zero.
    pub const UNEXPLAINED_SCAN: Self = Self(1);
    /// The weight of all candidates but one is negligible (`N_eff` below 1.5, with more than one candidate): the estimated pose
    /// depends on a single sample.
    pub const DEGENERATE: Self = Self(1 << 1);
    /// A map had so little memory (workspace, page list or pool) that components above `prune_weight` were removed, or that the
    /// informed proposal left some out.
    pub const PRUNING_TIGHTENED: Self = Self(1 << 2);
    /// A map remains as predicted, because not even its confirmed features fit into its page list or the pool.
    pub const MAP_NOT_UPDATED: Self = Self(1 << 3);
    /// Components were discarded because there was no memory for them even with the highest pruning threshold.
    pub const COMPONENTS_LOST: Self = Self(1 << 4);
    /// Rounding errors made a covariance indefinite; it was repaired by adding the least possible amount to its diagonal. The usual
    /// case is a feature that was initiated near the sensor, whose uncertainty ellipse is much longer than wide.
    pub const COVARIANCE_REPAIRED: Self = Self(1 << 5);
    /// The predicted pose of a candidate was out of the range of the scalar; the candidate was not moved.
    pub const POSE_REJECTED: Self = Self(1 << 6);
    /// The mean squared innovation of the detections is more than twice the value expected from their covariances; for few
    /// detections, it is also more than four and a half standard deviations above it. The noise is set too low, or the estimated
    /// pose is wrong.
    pub const INNOVATION_HIGH: Self = Self(1 << 7);
    /// Predictions since the last scan were refused: the vehicle has moved, and the filter does not know how.
    pub const PREDICTION_REFUSED: Self = Self(1 << 8);
    /// Known landmarks are missed, and other measurements appear, for longer than chance explains: the odds are a hundred to one
    /// that the estimated pose is wrong.
    pub const DIVERGENCE_SUSPECTED: Self = Self(1 << 9);
    /// As [`DIVERGENCE_SUSPECTED`](Self::DIVERGENCE_SUSPECTED), with odds of ten thousand to one. The flag stays set until the pose
    /// is set (`relocate`, `reset`) or made uncertain (`scatter`), or until known landmarks are detected again where they are
    /// expected.
    pub const LOST: Self = Self(1 << 10);
    /// There has been no scan for eight times the usual interval and for at least a second, while predictions continue.
    pub const INPUT_LOST: Self = Self(1 << 11);
    /// Memory scrubbing found and repaired damage: [`Scrubbed::health`](crate::Scrubbed::health).
    pub const STATE_REPAIRED: Self = Self(1 << 12);
    /// Far more measurements than usual come from no known landmark: a burst of clutter, or an area that is not mapped yet.
    pub const CLUTTER_HIGH: Self = Self(1 << 13);
    /// Recently a fifth of the expected detections of known landmarks is missing: the view is blocked, the sensor is failing, or
    /// p_D is set too high.
    pub const DETECTIONS_LOW: Self = Self(1 << 14);

    const NAMES: [(Self, &'static str); 15] = [
        (Self::UNEXPLAINED_SCAN, "UNEXPLAINED_SCAN"),
        (Self::DEGENERATE, "DEGENERATE"),
        (Self::PRUNING_TIGHTENED, "PRUNING_TIGHTENED"),
        (Self::MAP_NOT_UPDATED, "MAP_NOT_UPDATED"),
        (Self::COMPONENTS_LOST, "COMPONENTS_LOST"),
        (Self::COVARIANCE_REPAIRED, "COVARIANCE_REPAIRED"),
        (Self::POSE_REJECTED, "POSE_REJECTED"),
        (Self::INNOVATION_HIGH, "INNOVATION_HIGH"),
        (Self::PREDICTION_REFUSED, "PREDICTION_REFUSED"),
        (Self::DIVERGENCE_SUSPECTED, "DIVERGENCE_SUSPECTED"),
        (Self::LOST, "LOST"),
        (Self::INPUT_LOST, "INPUT_LOST"),
        (Self::STATE_REPAIRED, "STATE_REPAIRED"),
        (Self::CLUTTER_HIGH, "CLUTTER_HIGH"),
        (Self::DETECTIONS_LOW, "DETECTIONS_LOW"),
    ];

    /// All warnings, in the order of the bits.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::NAMES.iter().map(|(condition, _)| *condition)
    }

    /// Whether there is no warning.
    pub fn is_good(self) -> bool {
        self == Self::GOOD
    }

    /// Whether all warnings of `other` are set.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The set as bits, for a telemetry field. The bit of a warning is the same in every release.
    pub fn bits(self) -> u16 {
        self.0
    }

    /// This flag if `holds`, otherwise the empty set.
    pub(crate) fn when(self, holds: bool) -> Self {
        if holds { self } else { Self::GOOD }
    }

    /// INNOVATION_HIGH for this mean square over this number of coordinates of detections: the mean is χ² divided by its degrees
    /// of freedom, with a variance of 2 over their number.
    pub(crate) fn of_innovation<T: Real>(mean: T, coordinates: T) -> Self {
        let real = T::from_f64;
        let bound = T::ONE + real(INNOVATION_DEVIATIONS) * (real(2.0) / coordinates).sqrt();
        // The comparison is written so that no detections, and NaN, give no flag.
        Self::INNOVATION_HIGH.when(mean > bound.at_least(real(INNOVATION_HIGH)))
    }
}

impl BitOr for Health {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Health {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

impl fmt::Debug for Health {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set()
            .entries(Self::NAMES.iter().filter(|(flag, _)| self.contains(*flag)).map(|(_, name)| name))
            .finish()
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Health {
    fn format(&self, f: defmt::Formatter<'_>) {
        let mut separator = "";
        defmt::write!(f, "{{");
        for (_, name) in Self::NAMES.iter().filter(|(flag, _)| self.contains(*flag)) {
            defmt::write!(f, "{=str}{=str}", separator, name);
            separator = ", ";
        }
        defmt::write!(f, "}}");
    }
}
