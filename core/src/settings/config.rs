//! The tuning of a filter.

use crate::{ConfigError, ConstantVelocity, Informed, ModelError, Plausible, Proposal, Real};

/// Tuning of the recursion of a [`ScPhd`](crate::ScPhd); the models have their own parameters.
///
/// ```
/// use scphd::Config;
///
/// let config = Config { particles: 50, ..Config::<f32>::default() };
/// assert!(config.check().is_ok());
/// let error = Config { prune_weight: f32::NAN, ..config }.check().unwrap_err();
/// assert_eq!(error.field, "prune_weight");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config<T> {
    /// N, the number of particles after a scan (5.7).
    pub particles: usize,
    /// M, the number of samples that a prediction draws from every particle (5.12).
    pub samples: usize,
    /// Proposal density of the samples.
    pub proposal: Proposal<T>,
    /// Resampling threshold: resample if N_eff is below this fraction of the number of candidates, which is N·M after a prediction.
    pub resample_threshold: T,
    /// Pruning threshold: components with a smaller weight are removed (Vo & Ma 2006, table II: T).
    pub prune_weight: T,
    /// k: a component is confirmed if its covariance is smaller than k measurements from the present pose would give.
    pub confirming_detections: T,
    /// A component that leaves the field of view is removed if its weight is below this and it is not confirmed: most such
    /// components come from clutter, and out of view no missed detection would ever remove them. Zero: all are kept, as in the
    /// thesis.
    pub unconfirmed_weight: T,
    /// Lower limit of the weight of a confirmed static component after missed detections, for the sum of all its terms. Without
    /// this limit the weight depends only on the last few scans: a feature that was detected a hundred times is removed after four
    /// consecutive misses, for example at the edge of the field of view, if the errors of pose and map leave open whether it is in
    /// view. Zero: no limit, as in the thesis.
    pub confirmed_weight: T,
    /// Merging threshold: components are merged within this squared Mahalanobis distance (Vo & Ma 2006, table II: U).
    pub merge_distance: T,
    /// Maximum number of components in view after the reduction, for each kind (Vo & Ma 2006, table II: J_max), without the births
    /// that are delayed until the next scan.
    pub max_components: usize,
    /// Which components are extracted as estimated features.
    pub extraction: Extraction,
    /// Minimum weight of an estimated static feature. Zero: round(N̂) components of any weight (5.2.7).
    pub extraction_weight: T,
    /// Tuning of moving features.
    pub moving: MovingConfig<T>,
    /// A term of η_z (4.51) is left out if it is below this fraction of the clutter and birth terms of the measurement. The default
    /// is the precision of the scalar, so that the sum does not change.
    pub negligible: T,
    /// Whether births are delayed: a measurement that comes from no known feature is stored until the next scan, of this or another
    /// sensor, and becomes a component only if that scan may have detected it again, or does not see its place. Most components in
    /// view are births from clutter; without them a filter takes a quarter fewer instructions (docs/performance.md). In exchange,
    /// terms of η_z below [`prune_weight`](Self::prune_weight) times the clutter and birth terms of the measurement are left out.
    /// Only births with a weight below 0.1 are delayed, and only as many measurements of a scan as [`State`](crate::State) has
    /// memory for: 64, unless its type says otherwise. The default is `true`; the recursion of the thesis is that with `false`.
    pub births_wait: bool,
    /// Limits of the motion; predictions beyond them are refused.
    pub plausible: Plausible<T>,
}

/// Which components of a map are the estimated features. There are round(N̂) of them, except for [`Confirmed`](Self::Confirmed).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Extraction {
    /// The components with the greatest weights (5.2.7).
    #[default]
    Heaviest,
    /// The components with the highest peaks of the intensity, w (2π)^{−D/2} |P|^{−1/2}. A feature that was detected many times and
    /// missed in the last scan has a small weight but a high peak; two false measurements that agree by chance have a great weight
    /// but a large covariance.
    Peaks,
    /// All [confirmed](Config::confirming_detections) components, as seen from the present pose, highest peaks first, whatever N̂
    /// is: after missed detections the weights are small, and N̂ is less than the number of features.
    Confirmed,
}

/// Tuning of moving features.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MovingConfig<T> {
    /// Standard deviation of each coordinate of a new feature's velocity, whose mean is zero, m/s.
    pub velocity_sigma_mps: T,
    /// Motion model of moving features.
    pub motion: ConstantVelocity<T>,
    /// A component is removed if the standard deviation of its position along any axis exceeds this, m. It limits how long moving
    /// features out of view are predicted.
    pub spread_max_m: T,
    /// Minimum weight of an estimated moving feature. Components that come from clutter may move or be static; only their small
    /// weight distinguishes them.
    pub extraction_weight: T,
}

impl<T: Real> MovingConfig<T> {
    /// Moving features with the speed of people.
    pub fn walkers() -> Self {
        Self {
            velocity_sigma_mps: T::ONE,
            motion: ConstantVelocity { acceleration_psd: T::from_f64(0.1), lifetime_s: T::from_f64(100.0) },
            spread_max_m: T::from_f64(3.0),
            extraction_weight: T::from_f64(0.5),
        }
    }

    /// Checks all fields.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let require = |holds, field, range| if holds { Ok(()) } else { Err(ConfigError { field, range }) };
        require(
            self.velocity_sigma_mps >= T::from_f64(1e-6) && self.velocity_sigma_mps <= T::from_f64(1e6),
            "moving.velocity_sigma_mps",
            "between 1e-6 and 1e6: beyond, its square leaves the range of single precision",
        )?;
        let names = ["moving.motion.acceleration_psd", "moving.motion.lifetime_s"];
        self.motion.check_as(names).map_err(|ModelError { field, range }| ConfigError { field, range })?;
        require(
            self.extraction_weight >= T::ZERO && self.extraction_weight <= T::ONE,
            "moving.extraction_weight",
            "between 0 and 1",
        )?;
        require(
            self.spread_max_m > T::ZERO && self.spread_max_m.is_amount(),
            "moving.spread_max_m",
            "finite and positive",
        )
    }
}

impl<T: Real> Config<T> {
    /// Few particles with the informed proposal: each is a Gaussian that is updated with the scan before sampling. For sensors
    /// whose scan determines the pose of the vehicle among its features. The samples are the means of the Gaussians, without
    /// randomness, so that the estimate does not depend on the seed.
    ///
    /// ```
    /// use scphd::settings::Proposal;
    /// use scphd::Config;
    ///
    /// let config = Config::<f32>::informed(4);
    /// assert!(matches!(config.proposal, Proposal::Informed(_)) && config.check().is_ok());
    /// ```
    pub fn informed(particles: usize) -> Self {
        let proposal = Proposal::Informed(Informed { sampled_fraction: T::ZERO, ..Informed::default() });
        Self { particles, proposal, ..Self::default() }
    }

    /// Many particles with the blind proposal: each draws `samples` samples of the motion, which the scan then weights, as in the
    /// thesis. For sensors whose scan leaves the pose ambiguous, such as bearings only, and for multimodal densities of the pose.
    ///
    /// ```
    /// use scphd::Config;
    ///
    /// assert_eq!(Config::<f32>::blind(32, 2), Config { particles: 32, samples: 2, ..Config::default() });
    /// ```
    pub fn blind(particles: usize, samples: usize) -> Self {
        Self { particles, samples, ..Self::default() }
    }

    /// One particle with a known pose: tracking with [`KnownPose`](crate::KnownPose).
    pub fn tracking() -> Self {
        Self::blind(1, 1)
    }
}

impl<T: Real> Default for Config<T> {
    /// The values of section 5.3.1. Pruning removes births of false measurements after one miss at p_D = 0.95: in areas that are
    /// observed repeatedly these are most of the map, and do not improve the estimate.
    fn default() -> Self {
        Self {
            particles: 32,
            samples: 1,
            proposal: Proposal::Blind,
            resample_threshold: T::from_f64(0.5),
            prune_weight: T::from_f64(2.5e-3),
            confirming_detections: T::ONE,
            unconfirmed_weight: T::ZERO,
            confirmed_weight: T::ZERO,
            merge_distance: T::from_f64(4.0),
            max_components: usize::MAX,
            extraction: Extraction::Heaviest,
            extraction_weight: T::ZERO,
            moving: MovingConfig::walkers(),
            negligible: T::EPSILON,
            births_wait: true,
            plausible: Plausible::default(),
        }
    }
}

impl<T: Real> Config<T> {
    /// Checks all fields, and returns the first that is out of range.
    ///
    /// # Errors
    /// Names the field and its range. NaN is out of every range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let require = |holds, field, range| if holds { Ok(()) } else { Err(ConfigError { field, range }) };
        let (zero, one) = (T::ZERO, T::ONE);
        require(self.particles >= 1, "particles", "at least 1")?;
        require(self.samples >= 1, "samples", "at least 1")?;
        require(
            self.resample_threshold >= zero && self.resample_threshold <= one,
            "resample_threshold",
            "between 0 and 1",
        )?;
        require(self.prune_weight > zero && self.prune_weight < one, "prune_weight", "above 0 and below 1")?;
        require(
            self.unconfirmed_weight >= zero && self.unconfirmed_weight <= one,
            "unconfirmed_weight",
            "between 0 and 1",
        )?;
        require(
            self.confirming_detections >= one && self.confirming_detections.is_amount(),
            "confirming_detections",
            "finite and at least 1",
        )?;
        require(self.confirmed_weight >= zero && self.confirmed_weight <= one, "confirmed_weight", "between 0 and 1")?;
        require(self.merge_distance.is_amount(), "merge_distance", "finite and not negative")?;
        require(self.max_components >= 1, "max_components", "at least 1")?;
        require(
            self.extraction_weight >= zero && self.extraction_weight <= one,
            "extraction_weight",
            "between 0 and 1",
        )?;
        if let Proposal::Informed(informed) = self.proposal {
            require((1..=16).contains(&informed.rounds), "proposal.rounds", "1 to 16")?;
            require(
                informed.sampled_fraction >= zero && informed.sampled_fraction <= one,
                "proposal.sampled_fraction",
                "between 0 and 1",
            )?;
            require(
                informed.min_responsibility > zero && informed.min_responsibility < one,
                "proposal.min_responsibility",
                "above 0 and below 1",
            )?;
        }
        self.moving.check()?;
        require(
            self.negligible > zero && self.negligible <= self.prune_weight,
            "negligible",
            "above 0 and at most prune_weight",
        )?;
        self.plausible.check()
    }
}
