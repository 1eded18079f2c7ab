//! From settings to the core's configuration.

use crate::settings::{self, FilterSettings};
use scphd::{Adaptive, Config, Extraction, Informed, Likelihood, Online, Proposal, Real, Reduction};

/// What the settings let a detector learn.
pub(crate) fn online_of<T: Real>(filter: &FilterSettings) -> Online<T> {
    Online {
        detection_memory: T::from_f64(filter.detection_memory),
        clutter_memory: T::from_f64(filter.clutter_memory),
    }
}

/// The recursion that the settings describe, for static features.
pub(crate) fn config_of<T: Real>(filter: &FilterSettings) -> Config<T> {
    let real = T::from_f64;
    Config {
        particles: filter.particles,
        samples: filter.samples,
        resample_threshold: real(filter.resample_threshold),
        regularisation: real(filter.regularisation),
        adaptive: (filter.adaptive_error > 0.0).then(|| Adaptive {
            error: real(filter.adaptive_error),
            risk: real(filter.adaptive_risk),
            least: filter.adaptive_least,
            cell_m: real(filter.adaptive_cell_m),
            cell_rad: real(filter.adaptive_cell_rad),
        }),
        prune_weight: real(filter.prune_weight),
        confirming_detections: real(filter.confirming_detections),
        unconfirmed_weight: real(filter.unconfirmed_weight),
        confirmed_weight: real(filter.confirmed_weight),
        proposal: match filter.proposal {
            settings::Proposal::Blind => Proposal::Blind,
            settings::Proposal::Informed => Proposal::Informed(Informed {
                rounds: filter.proposal_rounds,
                drawn: real(filter.proposal_drawn),
                least_share: real(filter.proposal_least_share),
            }),
        },
        likelihood: match filter.likelihood {
            settings::Likelihood::SingleCluster => Likelihood::SingleCluster,
            settings::Likelihood::RbEmpty => Likelihood::EmptyMap,
            settings::Likelihood::RbSingle => Likelihood::SingleFeature,
            settings::Likelihood::RbMulti => Likelihood::MultiFeature,
        },
        reduction: match filter.reduction {
            settings::Reduction::Greedy => Reduction::Greedy { merge_distance: real(filter.merge_distance) },
            settings::Reduction::Runnalls => Reduction::Runnalls { merge_cost: real(filter.merge_cost) },
        },
        max_components: filter.max_components,
        extraction: match filter.extraction {
            settings::Extraction::Heaviest => Extraction::Heaviest,
            settings::Extraction::Peaks => Extraction::Peaks,
            settings::Extraction::Confirmed => Extraction::Confirmed,
        },
        extraction_weight: real(filter.extraction_weight),
        ..Config::default()
    }
}
