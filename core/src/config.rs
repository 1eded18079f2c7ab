//! What a user tunes.

use crate::Real;

/// Tuning of the recursion; the models carry their own parameters.
///
/// ```
/// use scphd::Config;
///
/// let config = Config { particles: 50, ..Config::<f32>::default() };
/// assert!(config.check().is_ok());
/// let error = Config { merge_distance: f32::NAN, ..config }.check().unwrap_err();
/// assert_eq!(error.field, "merge_distance");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config<T> {
    /// N, particles kept between scans (5.7).
    pub particles: usize,
    /// M, samples drawn from every particle by a prediction (5.12).
    pub samples: usize,
    /// w_b, weight of the feature born from a measurement (5.9), as an intensity in measurement space, in the same
    /// unit as the clutter's κ: 1/(m·rad) for range and bearing. κ = w_b means that a measurement which nothing
    /// explains is a new feature with probability ½.
    pub birth_intensity: T,
    /// Resample when N_eff / N falls below this.
    pub resample_threshold: T,
    /// Components below this weight are dropped (Vo & Ma 2006, table II: T).
    pub prune_weight: T,
    /// Components closer than this squared Mahalanobis distance are merged (Vo & Ma 2006, table II: U).
    pub merge_distance: T,
    /// Greatest number of components kept in view (Vo & Ma 2006, table II: J_max).
    pub max_components: usize,
    /// A term of η_z (4.51) below this fraction of what explains the measurement without any feature is left out.
    /// At the default, the precision of the scalar, leaving it out does not change the sum.
    pub negligible: T,
}

impl<T: Real> Default for Config<T> {
    /// The figures of section 5.3.1, with a birth intensity for about one new feature a scan in a 15 m circle.
    fn default() -> Self {
        Self {
            particles: 32,
            samples: 1,
            birth_intensity: T::from_f64(0.01),
            resample_threshold: T::from_f64(0.5),
            prune_weight: T::from_f64(1e-4),
            merge_distance: T::from_f64(4.0),
            max_components: usize::MAX,
            negligible: T::EPSILON,
        }
    }
}

/// A field of the [`Config`] is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct ConfigError {
    /// The field's name.
    pub field: &'static str,
    /// What it must be.
    pub range: &'static str,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} must be {}", self.field, self.range)
    }
}

impl core::error::Error for ConfigError {}

impl<T: Real> Config<T> {
    /// The first field that is out of range, if any.
    ///
    /// # Errors
    /// Names the field and its range. NaN is out of every range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let require = |holds, field, range| if holds { Ok(()) } else { Err(ConfigError { field, range }) };
        let (zero, one) = (T::ZERO, T::ONE);
        require(self.particles >= 1, "particles", "at least 1")?;
        require(self.samples >= 1, "samples", "at least 1")?;
        require(
            self.birth_intensity >= zero && self.birth_intensity.is_finite(),
            "birth_intensity",
            "finite and not negative",
        )?;
        require(
            self.resample_threshold >= zero && self.resample_threshold <= one,
            "resample_threshold",
            "between 0 and 1",
        )?;
        require(self.prune_weight > zero && self.prune_weight < one, "prune_weight", "above 0 and below 1")?;
        require(
            self.merge_distance >= zero && self.merge_distance.is_finite(),
            "merge_distance",
            "finite and not negative",
        )?;
        require(self.max_components >= 1, "max_components", "at least 1")?;
        require(
            self.negligible > zero && self.negligible <= self.prune_weight,
            "negligible",
            "above 0 and at most prune_weight",
        )
    }
}
