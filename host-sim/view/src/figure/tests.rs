//! Tests of figures of short runs.

use super::*;
use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::dimensions::Planar;
use scphd_run::monte_carlo::Study;
use scphd_run::monte_carlo::made_up::{plan, result};
use scphd_run::session::{self, Filter};
use scphd_worlds::scenario;

#[test]
fn maps_of_a_short_run() {
    let mut log = scenario::thesis_dynamic(1);
    log.scans.truncate(12);
    let mut settings = Settings::for_log(&log);
    settings.filter.particles = 8;
    let run = session::run::<Planar>(&log, &settings, Filter::Core(Precision::F32), 1, &mut |_| ()).unwrap();
    for (figure, text) in [
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
}
