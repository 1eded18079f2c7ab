//! The tuning of the mixtures.

use crate::reason::Reason;
use crate::{scphd_plausible, scphd_status};
use scphd::Config;
use scphd::models::ConstantVelocity;
use scphd::settings::{Extraction, Informed, MovingConfig, Proposal};

/// Samples are drawn from the motion.
pub const SCPHD_PROPOSAL_BLIND: u32 = 1;
/// Samples are drawn from a Gaussian that the scan has been taken into.
pub const SCPHD_PROPOSAL_INFORMED: u32 = 2;

/// The estimated features are the heaviest components (5.2.7).
pub const SCPHD_EXTRACTION_HEAVIEST: u32 = 1;
/// They are the highest peaks of the intensity.
pub const SCPHD_EXTRACTION_PEAKS: u32 = 2;

/// The tuning of a mixture: `Config` of the library, whose documentation says more of each field. Do not fill it in by hand, but by
/// `scphd_plane_blind` and its like.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_tuning {
    /// Particles kept between scans.
    pub particles: u32,
    /// Samples of each in a prediction.
    pub samples: u32,
    /// `SCPHD_PROPOSAL_...`
    pub proposal: u32,
    /// Informed: linearisations, 1 to 16.
    pub informed_rounds: u32,
    /// Informed: share of the covariance that is drawn from, 0 to 1.
    pub informed_sampled_fraction: f32,
    /// Informed: a component speaks for a measurement of which it explains this share.
    pub informed_min_responsibility: f32,
    /// Resampled where N_eff / N is below.
    pub resample_threshold: f32,
    /// Components below this weight are dropped.
    pub prune_weight: f32,
    /// A component is confirmed where it is better known than by so many measurements.
    pub confirming_detections: f32,
    /// One that leaves the view lighter than this, not confirmed, is forgotten. 0: none is.
    pub unconfirmed_weight: f32,
    /// Misses take a confirmed component no further down. 0: they do.
    pub confirmed_weight: f32,
    /// Squared Mahalanobis distance within which components are merged.
    pub merge_distance: f32,
    /// `SCPHD_EXTRACTION_...`
    pub extraction: u32,
    /// Least weight of an estimated feature.
    pub extraction_weight: f32,
    /// Not 0: births that nothing explains wait for the next scan. For filters of a single sensor.
    pub births_wait: u32,
    /// Moving features: standard deviation of a new one's velocity, m/s, along each axis.
    pub moving_velocity_sigma_mps: f32,
    /// Moving features: power spectral density of their acceleration, m^2/s^3.
    pub moving_acceleration_psd: f32,
    /// Moving features: mean time until one vanishes, s.
    pub moving_lifetime_s: f32,
    /// Moving features: one less certain than this, m, is forgotten.
    pub moving_spread_max_m: f32,
    /// Moving features: least weight of an estimated one.
    pub moving_extraction_weight: f32,
    /// What no vehicle does.
    pub plausible: scphd_plausible,
}

impl scphd_tuning {
    /// A tuning of the library, of which this interface knows all that it chooses.
    pub(crate) fn of(config: &Config<f32>) -> Self {
        let (proposal, informed) = match config.proposal {
            Proposal::Blind => (SCPHD_PROPOSAL_BLIND, Informed { sampled_fraction: 0.0, ..Informed::default() }),
            Proposal::Informed(informed) => (SCPHD_PROPOSAL_INFORMED, informed),
        };
        let moving = &config.moving;
        Self {
            particles: u32::try_from(config.particles).unwrap_or(u32::MAX),
            samples: u32::try_from(config.samples).unwrap_or(u32::MAX),
            proposal,
            informed_rounds: u32::try_from(informed.rounds).unwrap_or(u32::MAX),
            informed_sampled_fraction: informed.sampled_fraction,
            informed_min_responsibility: informed.min_responsibility,
            resample_threshold: config.resample_threshold,
            prune_weight: config.prune_weight,
            confirming_detections: config.confirming_detections,
            unconfirmed_weight: config.unconfirmed_weight,
            confirmed_weight: config.confirmed_weight,
            merge_distance: config.merge_distance,
            extraction: match config.extraction {
                Extraction::Peaks => SCPHD_EXTRACTION_PEAKS,
                Extraction::Heaviest | Extraction::Confirmed => SCPHD_EXTRACTION_HEAVIEST,
            },
            extraction_weight: config.extraction_weight,
            births_wait: u32::from(config.births_wait),
            moving_velocity_sigma_mps: moving.velocity_sigma_mps,
            moving_acceleration_psd: moving.motion.acceleration_psd,
            moving_lifetime_s: moving.motion.lifetime_s,
            moving_spread_max_m: moving.spread_max_m,
            moving_extraction_weight: moving.extraction_weight,
            plausible: scphd_plausible::of(config.plausible),
        }
    }

    /// The tuning for the library, which checks the ranges of the numbers.
    pub(crate) fn config(&self, reason: &mut Reason<'_>) -> Result<Config<f32>, scphd_status> {
        let proposal = match self.proposal {
            SCPHD_PROPOSAL_BLIND => Proposal::Blind,
            SCPHD_PROPOSAL_INFORMED => Proposal::Informed(Informed {
                rounds: self.informed_rounds as usize,
                sampled_fraction: self.informed_sampled_fraction,
                min_responsibility: self.informed_min_responsibility,
            }),
            _ => return Err(reason.field("proposal", "one of SCPHD_PROPOSAL_...")),
        };
        let extraction = match self.extraction {
            SCPHD_EXTRACTION_HEAVIEST => Extraction::Heaviest,
            SCPHD_EXTRACTION_PEAKS => Extraction::Peaks,
            _ => return Err(reason.field("extraction", "one of SCPHD_EXTRACTION_...")),
        };
        Ok(Config {
            particles: self.particles as usize,
            samples: self.samples as usize,
            proposal,
            resample_threshold: self.resample_threshold,
            prune_weight: self.prune_weight,
            confirming_detections: self.confirming_detections,
            unconfirmed_weight: self.unconfirmed_weight,
            confirmed_weight: self.confirmed_weight,
            merge_distance: self.merge_distance,
            extraction,
            extraction_weight: self.extraction_weight,
            births_wait: self.births_wait != 0,
            moving: MovingConfig {
                velocity_sigma_mps: self.moving_velocity_sigma_mps,
                motion: ConstantVelocity {
                    acceleration_psd: self.moving_acceleration_psd,
                    lifetime_s: self.moving_lifetime_s,
                },
                spread_max_m: self.moving_spread_max_m,
                extraction_weight: self.moving_extraction_weight,
            },
            plausible: self.plausible.limits(),
            ..Config::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tunings_of_the_library_come_back_as_they_were() {
        for config in [Config::blind(32, 2), Config::informed(4), Config::tracking()] {
            let back = scphd_tuning::of(&config).config(&mut Reason::none()).unwrap();
            assert_eq!(back, config);
        }
    }
}
