//! The names in a `ConfigError` are those of the fields, of every number that a configuration has.

use scphd::errors::ConfigError;
use scphd::locate::LocatorConfig;
use scphd::settings::{HypothesesConfig, MovingConfig, Proposal};
use scphd::{Config, JointConfig};
use std::collections::BTreeSet;
use std::fmt::Debug;

/// The paths of all numbers in what `{:#?}` prints of a configuration.
fn numbers(config: &impl Debug) -> BTreeSet<String> {
    let (mut path, mut found) = (Vec::new(), BTreeSet::new());
    for line in format!("{config:#?}").lines() {
        let line = line.trim();
        let (name, rest) = line.split_once(": ").unwrap_or(("", line));
        if rest.ends_with('{') || rest.ends_with('(') {
            path.push(name.to_owned());
        } else if line.starts_with(['}', ')']) {
            path.pop();
        } else if rest.trim_end_matches(',').parse::<f64>().is_ok() {
            let parts = path.iter().map(String::as_str).chain([name]).filter(|part| !part.is_empty());
            found.insert(parts.collect::<Vec<_>>().join("."));
        }
    }
    found
}

/// A number's name, and what spoils it.
type Spoil<C> = (&'static str, fn(&mut C));

/// Spoils one number after the other, and holds the name in the error against it.
fn names_all<C: Clone + Debug>(config: &C, check: impl Fn(&C) -> Result<(), ConfigError>, spoil: &[Spoil<C>]) {
    assert_eq!(check(config), Ok(()));
    for (name, spoil) in spoil {
        let mut spoilt = config.clone();
        spoil(&mut spoilt);
        assert_eq!(check(&spoilt).map_err(|error| error.field), Err(*name));
    }
    let named: BTreeSet<String> = spoil.iter().map(|(name, _)| *name).map(str::to_owned).collect();
    assert_eq!(named, numbers(config));
}

#[test]
fn of_the_mixture() {
    fn informed(config: &mut Config<f64>) -> &mut scphd::settings::Informed<f64> {
        let Proposal::Informed(informed) = &mut config.proposal else { panic!("not informed") };
        informed
    }
    const NAN: f64 = f64::NAN;
    let config = Config { moving: MovingConfig::walkers(), ..Config::informed(4) };
    names_all(
        &config,
        Config::check,
        &[
            ("particles", |config| config.particles = 0),
            ("samples", |config| config.samples = 0),
            ("proposal.rounds", |config| informed(config).rounds = 0),
            ("proposal.sampled_fraction", |config| informed(config).sampled_fraction = NAN),
            ("proposal.min_responsibility", |config| informed(config).min_responsibility = NAN),
            ("resample_threshold", |config| config.resample_threshold = NAN),
            ("prune_weight", |config| config.prune_weight = NAN),
            ("confirming_detections", |config| config.confirming_detections = NAN),
            ("unconfirmed_weight", |config| config.unconfirmed_weight = NAN),
            ("confirmed_weight", |config| config.confirmed_weight = NAN),
            ("merge_distance", |config| config.merge_distance = NAN),
            ("max_components", |config| config.max_components = 0),
            ("extraction_weight", |config| config.extraction_weight = NAN),
            ("moving.velocity_sigma_mps", |config| config.moving.velocity_sigma_mps = NAN),
            ("moving.motion.acceleration_psd", |config| config.moving.motion.acceleration_psd = NAN),
            ("moving.motion.lifetime_s", |config| config.moving.motion.lifetime_s = NAN),
            ("moving.spread_max_m", |config| config.moving.spread_max_m = NAN),
            ("moving.extraction_weight", |config| config.moving.extraction_weight = NAN),
            ("negligible", |config| config.negligible = NAN),
            ("plausible.step_max_s", |config| config.plausible.step_max_s = NAN),
            ("plausible.speed_max_mps", |config| config.plausible.speed_max_mps = NAN),
            ("plausible.turn_rate_max_radps", |config| config.plausible.turn_rate_max_radps = NAN),
            ("plausible.jump_max_m", |config| config.plausible.jump_max_m = NAN),
        ],
    );
}

#[test]
fn of_the_joint_map() {
    const NAN: f64 = f64::NAN;
    names_all(
        &JointConfig::default(),
        JointConfig::check,
        &[
            ("birth_probability_min", |config| config.birth_probability_min = NAN),
            ("gate", |config| config.gate = NAN),
            ("persistence.visible_s", |config| config.persistence.visible_s = NAN),
            ("persistence.occluded_s", |config| config.persistence.occluded_s = NAN),
            ("persistence.lifetime_s", |config| config.persistence.lifetime_s = NAN),
            ("occlusion_factor", |config| config.occlusion_factor = NAN),
            ("least_existence", |config| config.least_existence = NAN),
            ("least_tentative", |config| config.least_tentative = NAN),
            ("extraction_existence", |config| config.extraction_existence = NAN),
            ("merge_distance", |config| config.merge_distance = NAN),
            ("plausible.step_max_s", |config| config.plausible.step_max_s = NAN),
            ("plausible.speed_max_mps", |config| config.plausible.speed_max_mps = NAN),
            ("plausible.turn_rate_max_radps", |config| config.plausible.turn_rate_max_radps = NAN),
            ("plausible.jump_max_m", |config| config.plausible.jump_max_m = NAN),
        ],
    );
}

#[test]
fn of_several_hypotheses() {
    const NAN: f64 = f64::NAN;
    names_all(
        &HypothesesConfig::default(),
        HypothesesConfig::check,
        &[
            ("most", |config| config.most = 0),
            ("joined_sigmas", |config| config.joined_sigmas = NAN),
            ("least_ratio", |config| config.least_ratio = NAN),
            ("least_share", |config| config.least_share = NAN),
        ],
    );
}

#[test]
fn of_the_locator() {
    const NAN: f64 = f64::NAN;
    names_all(
        &LocatorConfig::default(),
        LocatorConfig::check,
        &[
            ("elsewhere", |config| config.elsewhere = NAN),
            ("remains", |config| config.remains = NAN),
            ("new_share", |config| config.new_share = NAN),
            ("inflation", |config| config.inflation = NAN),
            ("gate", |config| config.gate = NAN),
            ("sure", |config| config.sure = NAN),
            ("least_matched", |config| config.least_matched = 0),
            ("least_share", |config| config.least_share = NAN),
            ("trials", |config| config.trials = 0),
            ("searched", |config| config.searched = 0),
        ],
    );
}
