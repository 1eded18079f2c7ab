//! The tuning of the joint filter.

use super::Persistence;
use crate::{ConfigError, Plausible, Real};

/// Tuning of a [`JointSlam`](super::JointSlam). The default is what the simulator takes for a recorded log that says nothing of landmarks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct JointConfig<T> {
    /// A measurement gives birth where nothing but clutter and births explains at least this share of it.
    pub birth_share: T,
    /// A squared Mahalanobis distance: a measurement farther off says nothing of a feature.
    pub gate: T,
    /// How landmarks hide and vanish: by default as [posts](Persistence::posts) do.
    pub persistence: Persistence<T>,
    /// The share of p_D that is left where a nearer detection stands before a feature
    /// ([`Sensor::hides`](crate::Sensor::hides)): posts are narrow, and do not hide all.
    pub behind: T,
    /// A feature is dropped where the probability that it is there falls below this.
    pub least_existence: T,
    /// A feature in view that was detected less than twice is dropped below this one. Most of what is born is clutter; but the first
    /// detection of a landmark ties it to where the vehicle was then, and a miss or two need not make an end of that. See
    /// [`strict`](Self::strict).
    pub least_tentative: T,
    /// A feature is part of the estimated map if it is there, in sight or hidden, with at least this probability, and was detected twice.
    pub extraction_existence: T,
    /// A squared Mahalanobis distance: two features closer than this to each other, and nearer than one measurement could tell,
    /// are one.
    pub merge_distance: T,
    /// What no vehicle does.
    pub plausible: Plausible<T>,
}

impl<T: Real> Default for JointConfig<T> {
    fn default() -> Self {
        let real = T::from_f64;
        Self {
            birth_share: real(0.3),
            gate: real(25.0),
            persistence: Persistence::posts(),
            behind: real(0.3),
            least_existence: real(1e-3),
            least_tentative: real(1e-3),
            extraction_existence: real(0.5),
            merge_distance: real(9.0),
            plausible: Plausible::default(),
        }
    }
}

impl<T: Real> JointConfig<T> {
    /// The default, but that what is missed goes sooner, and what was detected once and is missed goes at once: where clutter is so dense that
    /// it would fill the map, and for the map that a [`Locator`](crate::locate::Locator) lays over another one.
    #[must_use]
    pub fn strict() -> Self {
        Self { least_existence: T::from_f64(0.01), least_tentative: T::from_f64(0.1), ..Self::default() }
    }

    /// The field that is out of range, if any.
    ///
    /// # Errors
    /// Distances must be finite and not negative, probabilities and shares between 0 and 1, times and limits of
    /// plausibility positive.
    pub fn check(&self) -> Result<(), ConfigError> {
        let amounts = [(self.gate, "gate"), (self.merge_distance, "merge_distance")];
        if let Some((_, field)) = amounts.into_iter().find(|&(amount, _)| !(amount >= T::ZERO && amount.is_finite())) {
            return Err(ConfigError { field, range: "finite and not negative" });
        }
        let probabilities = [
            (self.birth_share, "birth_share"),
            (self.behind, "behind"),
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
