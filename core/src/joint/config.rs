//! The tuning of the joint filter.

use super::Persistence;
use crate::{ConfigError, Plausible, Real};

/// Tuning of a [`JointSlam`](super::JointSlam). The default is that of the simulator for a recorded log without
/// information on its landmarks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct JointConfig<T> {
    /// A measurement becomes a new feature if the probability that it comes from clutter or a new feature is at least this.
    pub birth_probability_min: T,
    /// Association gate: a squared Mahalanobis distance beyond which a measurement cannot come from a feature.
    pub gate: T,
    /// Occlusion and survival of landmarks: by default those of [posts](Persistence::posts).
    pub persistence: Persistence<T>,
    /// Factor of p_D of a feature behind a nearer detection ([`Sensor::occludes`](crate::Sensor::occludes)). It is
    /// above 0 because posts are narrow and do not occlude everything behind them.
    pub occlusion_factor: T,
    /// A feature is removed when its existence probability falls below this.
    pub least_existence: T,
    /// The same for a feature in view that was detected less than twice. Most new features are clutter; but the first
    /// detection of a landmark correlates it with the pose of the vehicle at that time, and this information is lost if
    /// one or two misses remove the feature. See [`strict`](Self::strict).
    pub least_tentative: T,
    /// A feature is part of the estimated map if its existence probability, visible or occluded, is at least this, and
    /// if it was detected twice.
    pub extraction_existence: T,
    /// A squared Mahalanobis distance: two features are merged if they are closer than this, and so close that one
    /// measurement could not distinguish them.
    pub merge_distance: T,
    /// Limits of the motion, beyond which a prediction is refused.
    pub plausible: Plausible<T>,
}

impl<T: Real> Default for JointConfig<T> {
    fn default() -> Self {
        let real = T::from_f64;
        Self {
            birth_probability_min: real(0.3),
            gate: real(25.0),
            persistence: Persistence::posts(),
            occlusion_factor: real(0.3),
            least_existence: real(1e-3),
            least_tentative: real(1e-3),
            extraction_existence: real(0.5),
            merge_distance: real(9.0),
            plausible: Plausible::default(),
        }
    }
}

impl<T: Real> JointConfig<T> {
    /// The default, but missed features are removed sooner, and a feature that was detected once and is then missed is
    /// removed at once. It is meant for clutter so dense that it would fill the map, and for the map that a
    /// [`Locator`](crate::locate::Locator) matches with another one.
    pub fn strict() -> Self {
        Self { least_existence: T::from_f64(0.01), least_tentative: T::from_f64(0.1), ..Self::default() }
    }

    /// The field that is out of range, if any.
    ///
    /// # Errors
    /// Distances must be finite and not negative, probabilities and factors between 0 and 1, times and limits of
    /// plausibility positive.
    pub fn check(&self) -> Result<(), ConfigError> {
        let amounts = [(self.gate, "gate"), (self.merge_distance, "merge_distance")];
        if let Some((_, field)) = amounts.into_iter().find(|(amount, _)| !amount.is_amount()) {
            return Err(ConfigError { field, range: "finite and not negative" });
        }
        let probabilities = [
            (self.birth_probability_min, "birth_probability_min"),
            (self.occlusion_factor, "occlusion_factor"),
            (self.least_existence, "least_existence"),
            (self.least_tentative, "least_tentative"),
            (self.extraction_existence, "extraction_existence"),
        ];
        if let Some((_, field)) =
            probabilities.into_iter().find(|&(probability, _)| !(probability >= T::ZERO && probability <= T::ONE))
        {
            return Err(ConfigError { field, range: "between 0 and 1" });
        }
        self.persistence.check()?;
        self.plausible.check()
    }
}
