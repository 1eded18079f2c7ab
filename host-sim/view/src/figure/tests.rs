//! Tests of figures of short runs.

use super::densities::{BANDWIDTH_M, Moment, density, weigh};
use super::*;
use scphd_filters::settings::{Likelihood, Settings};
use scphd_filters::slam::Precision;
use scphd_log::dimensions::Planar;
use scphd_run::monte_carlo::Study;
use scphd_run::monte_carlo::made_up::{plan, result};
use scphd_run::session::{self, Filter};
use scphd_worlds::scenario;

#[test]
fn figure_numbers_are_distinct() {
    for (place, (number, about)) in FIGURES.iter().enumerate() {
        assert!(FIGURES[..place].iter().all(|(other, _)| other != number));
        assert!(!about.contains('\n'));
    }
}

#[test]
fn maps_of_a_short_run() {
    let mut log = scenario::thesis_dynamic(1);
    log.scans.truncate(12);
    let mut settings = Settings::for_log(&log);
    settings.filter.particles = 8;
    let run = session::run::<Planar>(&log, &settings, Filter::Core(Precision::F32), 1, &mut |_| ()).unwrap();
    for (figure, text) in [
        (scenario(&log), "moving landmarks"),
        (measurements(&log), "cumulative measurements"),
        (estimate(&log, &run.record), "estimated static features"),
        (tracks(&log, &settings, &run.record), "true tracks in view"),
    ] {
        assert!(figure.svg().contains(text), "{text}");
    }
}

#[test]
fn errors_of_artificial_runs() {
    let plan = plan(2, 2);
    let results = ["scphd", "rb-single"]
        .iter()
        .flat_map(|filter| (0..2).map(move |run| (*filter, run)))
        .map(|(filter, run)| result(&plan.job(run), filter, 0.0))
        .collect();
    let study = Study { plan: plan.clone(), results };
    assert!(mean_errors(&study).svg().contains("SC-PHD SLAM"));
    assert!(comparison(&study).svg().contains("RB-PHD SLAM, single feature"));
    assert!(long_run("long", &study.results[0]).svg().contains("localization"));
}

#[test]
fn a_density_is_the_kernel_and_integrates_to_the_weights() {
    let peak = density([(1.0, 1.0)].into_iter(), 1.0);
    assert!((peak * BANDWIDTH_M * (2.0 * std::f64::consts::PI).sqrt() - 1.0).abs() < 1e-12);
    let points = [(0.0, 0.25), (0.3, 0.5)];
    let sum: f64 = (-1000..1300).map(|k| density(points.into_iter(), f64::from(k) * 1e-3) * 1e-3).sum();
    assert!((sum - 0.75).abs() < 1e-9, "{sum}");
}

#[test]
fn all_likelihoods_weigh_the_same_candidates() {
    let log = scenario::thesis_compare(1);
    let moment = Moment { scan: 5, particles: 6, samples: 4 };
    let weighed = weigh(&log, &Settings::for_log(&log), &moment, 1).unwrap();
    // There are two predictions before a scan; the candidates of each are drawn separately.
    assert_eq!((weighed.positions.len(), weighed.predicted.len()), (24, 24));
    assert_eq!(weighed.updated[0].0, Likelihood::SingleCluster);
    for (_, weights) in &weighed.updated {
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }
    assert!(densities::figure(&log, &moment, &weighed).svg().contains("RB-PHD, empty map"));
    assert_eq!(weigh(&log, &Settings::for_log(&log), &Moment { scan: 9999, ..moment }, 1), None);
}
