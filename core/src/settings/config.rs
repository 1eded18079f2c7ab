//! What a user tunes.

use crate::{ConfigError, ConstantVelocity, Informed, ModelError, Plausible, Proposal, Real};

/// Tuning of the recursion; the models carry their own parameters.
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
    /// N, particles kept between scans (5.7).
    pub particles: usize,
    /// M, samples drawn from every particle by a prediction (5.12).
    pub samples: usize,
    /// Where the samples are drawn from.
    pub proposal: Proposal<T>,
    /// Resample when N_eff falls below this share of the candidates, N·M after a prediction.
    pub resample_threshold: T,
    /// Components below this weight are dropped (Vo & Ma 2006, table II: T).
    pub prune_weight: T,
    /// k: a component is confirmed where it is better known than k measurements taken from the present pose would make it.
    pub confirming_detections: T,
    /// A component that leaves the view is forgotten if it is lighter than this and not confirmed: most of those were born
    /// from clutter, and nothing would ever miss them. Zero: all are kept, as the thesis has it.
    pub unconfirmed_weight: T,
    /// Misses take a confirmed static component no further down than to this weight, its detections included. The intensity remembers no more than the
    /// last few scans, so that a feature seen a hundred times dies of four misses in a row, as at the rim of the view, where
    /// pose and map are not known well enough to tell whether it is in view at all. Zero: it does, as the thesis has it.
    pub confirmed_weight: T,
    /// Squared Mahalanobis distance within which components are merged (Vo & Ma 2006, table II: U).
    pub merge_distance: T,
    /// Greatest number of components that a reduction leaves in view, of each kind (Vo & Ma 2006, table II: J_max); births that wait
    /// for the next one are not counted.
    pub max_components: usize,
    /// Which components are the estimated features.
    pub extraction: Extraction,
    /// Least weight of an estimated static feature. Zero: round(N̂) components, whatever they weigh (5.2.7).
    pub extraction_weight: T,
    /// Features that move.
    pub moving: MovingConfig<T>,
    /// A term of η_z (4.51) below this fraction of what explains the measurement without any feature is left out.
    /// At the default, the precision of the scalar, leaving it out does not change the sum.
    pub negligible: T,
    /// Whether births on measurements that nothing explains wait as measurements until the next scan, and enter the maps only where that
    /// may have seen them again. Most of the components in view are such births of clutter; a filter that need not carry them takes a fifth fewer instructions (docs/performance.md).
    /// Left out are terms of η_z below [`prune_weight`](Self::prune_weight) times what explains the measurement without any feature. For filters of a single sensor: once
    /// scans of a second one have come, births wait no longer. Only with the thesis's likelihood, only births that weigh less than 0.1, and only on
    /// as many measurements of a scan as [`State`](crate::State) has room for, 64 unless its type says otherwise.
    pub births_wait: bool,
    /// What the vehicle can do; predictions beyond it are refused.
    pub plausible: Plausible<T>,
}

/// Which of a map's components are the estimated features: round(N̂) of them unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Extraction {
    /// The heaviest (5.2.7).
    #[default]
    Heaviest,
    /// Those of the highest peaks of the intensity, w (2π)^{−D/2} |P|^{−1/2}. A feature seen many times that the last scan has
    /// missed is light, but its peak is high; two false measurements that happened to agree are heavy and flat.
    Peaks,
    /// All that are [confirmed](Config::confirming_detections) as seen from the present pose, highest peaks first, whatever N̂
    /// is: where features are light for having been missed of late, N̂ falls short of their number.
    Confirmed,
}

/// The part of the tuning that is about features that move.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MovingConfig<T> {
    /// Standard deviation of each coordinate of a new feature's velocity around zero, m/s.
    pub velocity_sigma_mps: T,
    /// How moving features move.
    pub motion: ConstantVelocity<T>,
    /// A component whose position is more uncertain than this, as a standard deviation along any axis, m, is forgotten. It
    /// bounds what becomes of features that move out of view.
    pub spread_max_m: T,
    /// Least weight of an estimated moving feature. What clutter begets moves as well as it stands, and is told apart by
    /// its weight alone.
    pub extraction_weight: T,
}

impl<T: Real> MovingConfig<T> {
    /// Moving features as fast as people.
    #[must_use]
    pub fn walkers() -> Self {
        Self {
            velocity_sigma_mps: T::ONE,
            motion: ConstantVelocity { acceleration_psd: T::from_f64(0.1), lifetime_s: T::from_f64(100.0) },
            spread_max_m: T::from_f64(3.0),
            extraction_weight: T::from_f64(0.5),
        }
    }

    /// The first field that is out of range, if any.
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
            self.spread_max_m > T::ZERO && self.spread_max_m.is_finite(),
            "moving.spread_max_m",
            "finite and positive",
        )
    }
}

impl<T: Real> Config<T> {
    /// A few particles that take the scan in before they are drawn, each a Gaussian: for sensors whose scan tells where the vehicle is
    /// among its features. Nothing is drawn from the Gaussian, so that the same inputs give the same way whatever the seed is.
    ///
    /// ```
    /// use scphd::settings::Proposal;
    /// use scphd::Config;
    ///
    /// let config = Config::<f32>::informed(4);
    /// assert!(matches!(config.proposal, Proposal::Informed(_)) && config.check().is_ok());
    /// ```
    #[must_use]
    pub fn informed(particles: usize) -> Self {
        let proposal = Proposal::Informed(Informed { sampled_fraction: T::ZERO, ..Informed::default() });
        Self { particles, proposal, ..Self::default() }
    }

    /// Many particles, each with so many samples of the motion, that the scan chooses among, as the thesis has it: for sensors whose
    /// scan leaves several places open, such as bearings alone, and for poses that may lie anywhere.
    ///
    /// ```
    /// use scphd::Config;
    ///
    /// assert_eq!(Config::<f32>::blind(32, 2), Config { particles: 32, samples: 2, ..Config::default() });
    /// ```
    #[must_use]
    pub fn blind(particles: usize, samples: usize) -> Self {
        Self { particles, samples, ..Self::default() }
    }

    /// One particle that is certain of its pose: tracking from a known place, with [`KnownPose`](crate::KnownPose).
    #[must_use]
    pub fn tracking() -> Self {
        Self::blind(1, 1)
    }
}

impl<T: Real> Default for Config<T> {
    /// The figures of section 5.3.1. Pruning drops what a false measurement leaves behind after one miss at p_D = 0.95: where it is looked at again and
    /// again, it is most of the map, and improves nothing.
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
            births_wait: false,
            plausible: Plausible::default(),
        }
    }
}

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
            self.confirming_detections >= one && self.confirming_detections.is_finite(),
            "confirming_detections",
            "finite and at least 1",
        )?;
        require(self.confirmed_weight >= zero && self.confirmed_weight <= one, "confirmed_weight", "between 0 and 1")?;
        require(
            self.merge_distance >= zero && self.merge_distance.is_finite(),
            "merge_distance",
            "finite and not negative",
        )?;
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
