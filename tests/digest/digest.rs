//! Reproducibility: a seed determines every bit of the filter's state, in every build profile and on every machine.

use scphd_filters::settings::{
    Extraction, FilterSettings, JointSettings, Likelihood, MovingSettings, Proposal, SensorSettings, Settings,
    VehicleSettings,
};
use scphd_filters::slam::Precision;
use scphd_log::dimensions::Planar;
use scphd_run::session::{self, Filter};
use scphd_worlds::scenario;
use std::f64::consts::PI;
use std::fmt::Write;

/// The committed digests, a line for each case and precision: scenario precision particles samples seed scans digest.
const EXPECTED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../expected/digests.txt");

/// Set to 1 to rewrite the committed digests.
const BLESS: &str = "SCPHD_BLESS";

/// Number of scans: enough for births, merging, pruning and resampling, not too many for an unoptimised build.
const SCANS: usize = 60;
/// Number of scans: enough for different states.
const FEW_SCANS: usize = 15;

struct Case {
    scenario: &'static str,
    settings: Settings,
}

/// The recursion of the thesis, a filter with all extensions, and the first one with births that wait.
fn cases() -> [Case; 3] {
    let mut options = thesis();
    options.filter = FilterSettings {
        particles: 16,
        samples: 1,
        unconfirmed_weight: 0.05,
        confirmed_weight: 0.1,
        confirming_detections: 3.0,
        extraction: Extraction::Confirmed,
        proposal: Proposal::Informed,
        proposal_sampled_fraction: 0.2,
        ..options.filter
    };
    options.moving.birth_intensity = 0.005;
    let mut waiting = thesis();
    waiting.filter.births_wait = true;
    waiting.filter.prune_weight = 2.5e-3;
    waiting.moving.birth_intensity = 0.005;
    [
        Case { scenario: "survey", settings: thesis() },
        Case { scenario: "thesis-dynamic", settings: options },
        Case { scenario: "thesis-dynamic", settings: waiting },
    ]
}

/// All fields are set, so that a changed default does not change a digest.
fn thesis() -> Settings {
    Settings {
        filter: FilterSettings {
            particles: 32,
            samples: 2,
            birth_intensity: 0.01,
            resample_threshold: 0.5,
            prune_weight: 1e-4,
            confirming_detections: 1.0,
            unconfirmed_weight: 0.0,
            confirmed_weight: 0.0,
            extraction: Extraction::Heaviest,
            merge_distance: 4.0,
            max_components: 1000,
            extraction_weight: 0.0,
            proposal: Proposal::Blind,
            proposal_rounds: 3,
            proposal_sampled_fraction: 1.0,
            proposal_min_responsibility: 0.01,
            interval_margin: 1.0,
            births_wait: false,
            likelihood: Likelihood::SingleCluster,
        },
        vehicle: VehicleSettings {
            speed_sigma_mps: 1.0,
            speed_sigma_ratio: 0.0,
            turn_sigma: 0.035,
            turn_sigma_ratio: 0.0,
            noise_interval_s: 0.0,
        },
        sensor: SensorSettings {
            range_sigma_m: 0.25,
            range_sigma_ratio: 0.0,
            bearing_sigma_rad: 0.00875,
            range_min_m: 0.0,
            range_max_m: 15.0,
            range_edge_m: 0.625,
            bearing_min_rad: -PI,
            bearing_max_rad: PI,
            bearing_edge_rad: 0.0,
            detection_near: 0.95,
            detection_far: 0.95,
            clutter_per_scan: 20.0,
            forward_m: 0.0,
            left_m: 0.0,
            yaw_rad: 0.0,
            birth_factor: 1.0,
        },
        sensor_name: String::new(),
        others: Vec::new(),
        moving: MovingSettings {
            birth_intensity: 0.0,
            velocity_sigma_mps: 1.0,
            acceleration_psd: 0.1,
            lifetime_s: 100.0,
            spread_max_m: 3.0,
            extraction_weight: 0.5,
        },
        joint: JointSettings {
            visible_s: 1e9,
            occluded_s: 10.0,
            lifetime_s: 1e9,
            occlusion_factor: 1.0,
            merge_distance: 9.0,
            hypotheses: 1,
        },
        fixes: None,
        calibration: None,
    }
}

/// The digest after this number of scans of the scenario of `scenario_seed`, with a filter of `seed`.
fn digest(case: &Case, precision: Precision, scans: usize, scenario_seed: u64, seed: u64) -> u64 {
    let mut log = scenario::by_name(case.scenario, scenario_seed).expect("a built-in scenario");
    log.scans.truncate(scans);
    let session =
        session::run::<Planar>(&log, &case.settings, Filter::Core(precision), seed, &mut |_| ()).expect("a whole run");
    assert_eq!(session.record.scans.len(), scans);
    session.summary.digest.expect("the filter has a digest")
}

#[test]
fn the_seed_determines_the_state() {
    for case in &cases() {
        let of = |scenario_seed, seed| digest(case, Precision::F32, FEW_SCANS, scenario_seed, seed);
        let first = of(1, 1);
        assert_eq!(of(1, 1), first, "the same seed gave another state");
        assert_ne!(of(1, 2), first, "another seed of the filter gave the same state");
        assert_ne!(of(2, 1), first, "another seed of the scenario gave the same state");
    }
}

#[test]
fn digests_are_the_committed_ones() {
    let seed = 1;
    let mut found = String::new();
    for case in &cases() {
        let Case { scenario, settings: Settings { filter: FilterSettings { particles, samples, .. }, .. } } = case;
        for (name, precision) in [("f32", Precision::F32), ("f64", Precision::F64)] {
            let digest = digest(case, precision, SCANS, seed, seed);
            writeln!(found, "{scenario} {name} {particles} {samples} {seed} {SCANS} {digest:016x}").expect("memory");
        }
    }
    if std::env::var_os(BLESS).is_some_and(|value| value == "1") {
        std::fs::write(EXPECTED, &found).expect("a writable file");
        return;
    }
    let committed = std::fs::read_to_string(EXPECTED).unwrap_or_default();
    // Some systems check text files out with other line endings.
    let committed: Vec<&str> = committed.lines().collect();
    let mut changes = String::new();
    for line in found.lines().filter(|line| !committed.contains(line)) {
        writeln!(changes, "  now       {line}").expect("memory");
    }
    for line in committed.iter().filter(|line| !found.lines().any(|found| found == **line)) {
        writeln!(changes, "  committed {line}").expect("memory");
    }
    assert!(
        changes.is_empty(),
        "digests changed (scenario precision particles samples seed scans digest):\n{changes}\
         If other numbers are what you wanted, run `{BLESS}=1 cargo test -p scphd-digest` and commit \
         {EXPECTED}; if they differ between build profiles or machines, something depends on how it is compiled."
    );
}
