//! Conversion of settings to the core's configuration.

use crate::settings::{self, FilterSettings};
use scphd::settings::{Extraction, Informed, Proposal};
use scphd::{Config, Real};

/// The configuration of the recursion for static features.
pub(crate) fn config_of<T: Real>(filter: &FilterSettings) -> Config<T> {
    let real = T::from_f64;
    Config {
        particles: filter.particles,
        samples: filter.samples,
        resample_threshold: real(filter.resample_threshold),
        prune_weight: real(filter.prune_weight),
        confirming_detections: real(filter.confirming_detections),
        unconfirmed_weight: real(filter.unconfirmed_weight),
        confirmed_weight: real(filter.confirmed_weight),
        proposal: match filter.proposal {
            settings::Proposal::Blind => Proposal::Blind,
            settings::Proposal::Informed => Proposal::Informed(Informed {
                rounds: filter.proposal_rounds,
                sampled_fraction: real(filter.proposal_sampled_fraction),
                min_responsibility: real(filter.proposal_min_responsibility),
            }),
        },
        merge_distance: real(filter.merge_distance),
        max_components: filter.max_components,
        extraction: match filter.extraction {
            settings::Extraction::Heaviest => Extraction::Heaviest,
            settings::Extraction::Peaks => Extraction::Peaks,
            settings::Extraction::Confirmed => Extraction::Confirmed,
        },
        extraction_weight: real(filter.extraction_weight),
        births_wait: filter.births_wait,
        ..Config::default()
    }
}
