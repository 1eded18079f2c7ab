//! The figures of a study, a JSON object for each filter.

use super::run::{Curve, RunResult};
use super::statistics::{consistent_share, mean, standard_deviation, whole};
use super::study::Study;
use crate::session::Filter;
use scphd_filters::settings::Likelihood;
use scphd_score::moving::MovingScore;
use scphd_score::results::OutputError;
use scphd_score::results::json::{self, Format};
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// The figures of one filter in a study; unknown ones are `null`.
///
/// Means are over runs and scans: first over the scans of a run, then over the runs. The map error is OSPA of order 1
/// and cut-off 10 m at every scan, moving features included. Moving figures are over all runs together.
/// `docs/results.md` defines the keys.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Overview {
    pub scenario: String,
    pub filter: String,
    pub runs: usize,
    pub particles: u64,
    pub samples: u64,
    pub position_error_mean_m: Option<f64>,
    pub position_error_final_m: Option<f64>,
    pub heading_error_mean_deg: Option<f64>,
    pub dead_reckoning_error_mean_m: Option<f64>,
    pub dead_reckoning_error_final_m: Option<f64>,
    pub ospa_first_third_m: Option<f64>,
    pub ospa_last_third_m: Option<f64>,
    pub moving_hit_rate: Option<f64>,
    pub moving_position_error_median_m: Option<f64>,
    pub false_moving_tracks_per_scan: Option<f64>,
    pub nees_mean: Option<f64>,
    pub nees_within_95: Option<f64>,
    pub scan_us_mean: Option<f64>,
}

impl Overview {
    /// Computes the figures of the runs of one filter; `None` without runs.
    pub fn of(scenario: &str, results: &[&RunResult]) -> Option<Self> {
        let first = results.first()?;
        let over = |curve, part: fn(&[Option<f64>]) -> Option<f64>| {
            mean(results.iter().filter_map(|result| part(result.series.curve(curve))))
        };
        let nees: Vec<&[Option<f64>]> = results.iter().map(|result| result.nees.as_slice()).collect();
        let mut moving = MovingScore::default();
        for score in results.iter().filter_map(|result| result.moving.as_ref()) {
            moving.add(score);
        }
        Some(Self {
            scenario: scenario.into(),
            filter: first.filter.clone(),
            runs: results.len(),
            particles: first.particles,
            samples: first.samples,
            position_error_mean_m: over(Curve::PositionError, whole),
            position_error_final_m: over(Curve::PositionError, last),
            heading_error_mean_deg: over(Curve::HeadingError, whole),
            dead_reckoning_error_mean_m: over(Curve::DeadReckoningError, whole),
            dead_reckoning_error_final_m: over(Curve::DeadReckoningError, last),
            ospa_first_third_m: over(Curve::OspaFar, |values| whole(&values[..values.len() / 3])),
            ospa_last_third_m: over(Curve::OspaFar, last_third),
            moving_hit_rate: moving.hit_rate(),
            moving_position_error_median_m: moving.position_error_median_m(),
            false_moving_tracks_per_scan: moving.false_per_scan(),
            nees_mean: mean(results.iter().filter_map(|result| whole(&result.nees))),
            nees_within_95: consistent_share(&nees, first.dimension),
            scan_us_mean: mean(results.iter().filter_map(|result| result.scan_us_mean)),
        })
    }
}

fn last_third(values: &[Option<f64>]) -> Option<f64> {
    whole(&values[values.len() - values.len() / 3..])
}

fn last(values: &[Option<f64>]) -> Option<f64> {
    values.iter().copied().flatten().next_back()
}

/// The figures of every filter of a study, in the plan's order.
pub fn overviews(study: &Study) -> Vec<Overview> {
    let filters = study.plan.filters.iter();
    filters.filter_map(|filter| Overview::of(&study.plan.scenario, &study.of_filter(filter))).collect()
}

/// An overview in the format of the file.
#[derive(Serialize)]
struct Written {
    format: Format,
    #[serde(flatten)]
    overview: Overview,
    /// Settings of this filter with the first input.
    settings: Value,
}

/// Writes one object, or a list for several filters.
pub fn write_json(path: &Path, study: &Study) -> Result<(), OutputError> {
    let written = |overview: Overview| {
        let place = study.plan.filters.iter().position(|filter| *filter == overview.filter);
        if let Some(own) = place.and_then(|place| study.plan.variants.get(place)) {
            return Written { format: Format, overview, settings: toml::from_str(own).unwrap_or_default() };
        }
        // The plan has the settings without each filter's likelihood.
        let mut settings: Value = toml::from_str(&study.plan.settings).unwrap_or_default();
        if let Some(likelihood) = likelihood_of(&overview.filter)
            && let Some(filter) = settings.get_mut("filter").and_then(Value::as_object_mut)
        {
            filter.insert("likelihood".into(), json::settings(&likelihood));
        }
        Written { format: Format, overview, settings }
    };
    let written: Vec<Written> = overviews(study).into_iter().map(written).collect();
    match &written[..] {
        [one] => json::write(path, one),
        several => json::write(path, several),
    }
}

/// The likelihood of a filter with this [name](Filter::name); only the reference has one.
fn likelihood_of(filter: &str) -> Option<Likelihood> {
    let all = [Likelihood::SingleCluster, Likelihood::RbEmpty, Likelihood::RbSingle, Likelihood::RbMulti];
    all.into_iter().find(|&likelihood| Filter::Reference.name(likelihood) == filter)
}

/// Standard deviations over runs of the mean of a run; `None` for less than two runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Standard deviation of the position error, m.
    pub position_m: Option<f64>,
    /// Standard deviation of the map error over the last third of the scans, m.
    pub ospa_m: Option<f64>,
}

impl Spread {
    /// Computes the standard deviations over the runs of one filter.
    pub fn of(results: &[&RunResult]) -> Self {
        let over = |curve, part: fn(&[Option<f64>]) -> Option<f64>| {
            let means = results.iter().filter_map(|result| part(result.series.curve(curve)));
            standard_deviation(&means.collect::<Vec<f64>>())
        };
        Self { position_m: over(Curve::PositionError, whole), ospa_m: over(Curve::OspaFar, last_third) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monte_carlo::made_up::{plan, result};
    use scphd_shared_data::Folder;

    #[test]
    fn figures_of_made_up_runs() {
        let plan = plan(3, 3);
        let runs: Vec<RunResult> = (0..3).map(|run| result(&plan.job(run), "scphd", 0.0)).collect();
        let overview = Overview::of("made up", &runs.iter().collect::<Vec<_>>()).unwrap();
        let close = |value: Option<f64>, expected: f64| assert!((value.unwrap() - expected).abs() < 1e-12, "{value:?}");
        // Scans 1 to 5 add a third each; runs 0 to 2 add 0.1 each; a curve adds its index.
        close(overview.position_error_mean_m, 1.0 + 0.1);
        close(overview.position_error_final_m, 5.0 / 3.0 + 0.1);
        close(overview.heading_error_mean_deg, 1.0 + 1.1);
        close(overview.ospa_first_third_m, 1.0 / 3.0 + 6.1);
        close(overview.ospa_last_third_m, 1.5 + 6.1);
        close(overview.moving_hit_rate, 0.5);
        close(overview.moving_position_error_median_m, 1.0 / 7.0);
        // Four scans of 1 plus a tenth of the run's number, and one of 20.
        close(overview.nees_mean, (4.0 * 1.1 + 20.0) / 5.0);
        close(overview.nees_within_95, 0.8);
        close(overview.scan_us_mean, 101.0);
        assert_eq!(Overview::of("nothing", &[]), None);
        let json = serde_json::to_string(&overview).unwrap();
        let mut at = 0;
        for key in "scenario filter runs particles samples position_error_mean_m position_error_final_m \
            heading_error_mean_deg dead_reckoning_error_mean_m dead_reckoning_error_final_m ospa_first_third_m \
            ospa_last_third_m moving_hit_rate moving_position_error_median_m false_moving_tracks_per_scan nees_mean \
            nees_within_95 scan_us_mean"
            .split(' ')
        {
            let found = json.find(&format!("\"{key}\":")).unwrap_or_else(|| panic!("{key}"));
            assert!(found >= at, "{key} is out of order");
            at = found;
        }
        assert_eq!(json.matches(':').count(), 18);
    }

    #[test]
    fn the_file_has_its_format_and_the_settings_of_each_filter() {
        let folder = Folder::new("overview");
        let path = folder.0.join("study.json");
        let plan = plan(3, 3);
        let results = ["scphd", "rb-single"]
            .iter()
            .flat_map(|filter| (0..3).map(|run| result(&plan.job(run), filter, 0.0)).collect::<Vec<_>>());
        let mut study = Study { plan: plan.clone(), results: results.collect() };
        write_json(&path, &study).unwrap();
        let read = || -> Value { serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap() };
        let both = read();
        assert_eq!((&both[0]["format"], &both[0]["runs"]), (&2.into(), &3.into()));
        assert_eq!(both[0]["settings"]["filter"]["likelihood"], "single-cluster");
        assert_eq!(both[1]["settings"]["filter"]["likelihood"], "rb-single");
        study.plan.variants = vec!["[filter]\nparticles = 7\n".into(), "[filter]\nparticles = 8\n".into()];
        write_json(&path, &study).unwrap();
        assert_eq!(
            (&read()[0]["settings"]["filter"]["particles"], &read()[1]["settings"]["filter"]["particles"]),
            (&7.into(), &8.into())
        );
        study.plan.variants.clear();
        study.plan.filters.truncate(1);
        write_json(&path, &study).unwrap();
        assert_eq!(read(), both[0]);
    }
}
