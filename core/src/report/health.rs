//! Health flags: what an autopilot may want to act on.

use crate::Real;
use core::fmt;
use core::ops::{BitOr, BitOrAssign};

/// A set of conditions, each with one cause.
///
/// ```
/// use scphd::Health;
///
/// let health = Health::PRUNING_TIGHTENED | Health::DEGENERATE;
/// assert!(health.contains(Health::DEGENERATE) && !health.is_good());
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct Health(u16);

/// Mean squared innovations above this are a condition, where they are beyond what is expected by so many standard deviations.
const INNOVATION_HIGH: f64 = 2.0;
const INNOVATION_DEVIATIONS: f64 = 4.5;

impl Health {
    /// Nothing to report.
    pub const GOOD: Self = Self(0);
    /// No candidate explained the scan at all (every weight times likelihood was zero): the weights were left as they
    /// were. The vehicle is lost, or the clutter and birth intensities are both zero.
    pub const UNEXPLAINED_SCAN: Self = Self(1);
    /// The weight of all candidates but one was negligible (`N_eff` below 1.5, with more than one candidate): the pose
    /// hangs on a single sample.
    pub const DEGENERATE: Self = Self(1 << 1);
    /// Some map had so little room (workspace, page list or pool) that components above `prune_weight` were dropped, or left
    /// aside by the informed proposal.
    pub const PRUNING_TIGHTENED: Self = Self(1 << 2);
    /// Some map was left as predicted, because not even its confirmed features found room in its page list or the pool.
    pub const MAP_NOT_UPDATED: Self = Self(1 << 3);
    /// Components were lost that no tightening of the pruning could make room for.
    pub const COMPONENTS_LOST: Self = Self(1 << 4);
    /// Rounding had made some covariance indefinite; it was repaired by adding as little as
    /// possible to its diagonal. A feature born next to the sensor, much longer than wide, is the usual case.
    pub const COVARIANCE_REPAIRED: Self = Self(1 << 5);
    /// Some candidate's pose left the range of the scalar in the prediction; it stayed where it was.
    pub const POSE_REJECTED: Self = Self(1 << 6);
    /// The mean squared innovation of the detections is more than twice what their covariances say, and of few detections more than
    /// four and a half standard deviations beyond it: the noise is set too low, or the vehicle is not where the filter thinks.
    pub const INNOVATION_HIGH: Self = Self(1 << 7);
    /// Predictions since the scan before were refused: the vehicle has moved, and the filter does not know how.
    pub const PREDICTION_REFUSED: Self = Self(1 << 8);
    /// Known landmarks are missed, and measurements come from elsewhere, for so long that it is no chance any more: odds of a
    /// hundred to one that the vehicle is not where it is taken to be.
    pub const DIVERGENCE_SUSPECTED: Self = Self(1 << 9);
    /// The same beyond doubt, with odds of ten thousand to one. It stays until the pose is set (`relocate`, `reset`) or made uncertain
    /// (`scatter`), or until what was known is detected again where it is expected.
    pub const LOST: Self = Self(1 << 10);
    /// Predictions have gone on for eight times as long as it usually takes for a scan to come, and for a second at least.
    pub const INPUT_LOST: Self = Self(1 << 11);
    /// A scrubbing has found what memory faults had left, and mended it: [`Scrubbed::health`](crate::Scrubbed::health).
    pub const STATE_REPAIRED: Self = Self(1 << 12);
    /// Far more is measured than usual that nothing known explains: a burst of clutter, or a place that is all new.
    pub const CLUTTER_HIGH: Self = Self(1 << 13);
    /// Of late a fifth of the detections to be expected of known landmarks is missing: the view is blocked, the sensor is failing, or p_D
    /// is set too high.
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

    /// Every condition there is, in the order of the bits.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::NAMES.iter().map(|(condition, _)| *condition)
    }

    /// No condition at all.
    #[must_use]
    pub fn is_good(self) -> bool {
        self == Self::GOOD
    }

    /// Whether every condition of `other` holds.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The set as bits, for a telemetry field. A condition keeps its bit from release to release.
    #[must_use]
    pub fn bits(self) -> u16 {
        self.0
    }

    /// This condition where it holds, otherwise the empty set.
    pub(crate) fn when(self, holds: bool) -> Self {
        if holds { self } else { Self::GOOD }
    }

    /// The condition of innovations of this mean square over so many coordinates of detections: such a mean is that of χ² by its degrees
    /// of freedom, of variance 2 over their number.
    pub(crate) fn of_innovation<T: Real>(mean: T, coordinates: T) -> Self {
        let real = T::from_f64;
        let bound = T::ONE + real(INNOVATION_DEVIATIONS) * (real(2.0) / coordinates).sqrt();
        // Written so that nothing detected, and NaN, is none.
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
