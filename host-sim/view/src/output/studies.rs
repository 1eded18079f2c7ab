//! The tables of a Monte Carlo study: its runs, and their means and standard deviations.

use super::csv::{Cell, Columns, write_rows};
use scphd_run::monte_carlo::overview::Overview;
use scphd_run::monte_carlo::{Band, Curve, RunResult, Study, band};
use scphd_score::results::OutputError;
use std::path::Path;

type Figure = fn(&Overview) -> Option<f64>;

/// `runs.csv`: a row for each run, with its figures.
fn run_columns() -> Columns<(RunResult, Overview)> {
    let mut columns = Columns::new()
        .with("filter", |(run, _): &(RunResult, Overview)| Cell::from(run.filter.as_str()))
        .with("run", |(run, _)| run.run)
        .with("log", |(run, _)| Cell::from(run.log.as_str()))
        .with("scenario_seed", |(run, _)| run.scenario_seed as usize)
        .with("filter_seed", |(run, _)| run.filter_seed as usize);
    let figures: [(&str, Figure); 9] = [
        ("position_error_mean_m", |run| run.position_error_mean_m),
        ("position_error_final_m", |run| run.position_error_final_m),
        ("heading_error_mean_deg", |run| run.heading_error_mean_deg),
        ("dead_reckoning_error_mean_m", |run| run.dead_reckoning_error_mean_m),
        ("ospa_first_third_m", |run| run.ospa_first_third_m),
        ("ospa_last_third_m", |run| run.ospa_last_third_m),
        ("moving_hit_rate", |run| run.moving_hit_rate),
        ("moving_position_error_median_m", |run| run.moving_position_error_median_m),
        ("false_moving_tracks_per_scan", |run| run.false_moving_tracks_per_scan),
    ];
    for (name, figure) in figures {
        columns = columns.with(name, move |(_, run)| figure(run));
    }
    columns
}

/// Writes into the existing folder `dir`: `series-FILTER.csv` for each filter (mean and standard deviation over the runs of every
/// curve, a row for each scan), and `runs.csv` (a row for each run).
pub fn write_tables(dir: &Path, study: &Study) -> Result<(), OutputError> {
    for filter in &study.plan.filters {
        let results = study.of_filter(filter);
        let bands = Curve::ALL.map(|curve| band(&results, curve));
        let names = Curve::ALL.iter().flat_map(|curve| [curve.name().to_owned(), format!("{}_sigma", curve.name())]);
        let header: Vec<String> = std::iter::once("t_s".to_owned()).chain(names).collect();
        let mut times: Vec<f64> = bands.iter().flatten().map(|band| band.t_s).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let rows = times.into_iter().map(|t_s| {
            let at = |bands: &[Band]| bands.iter().find(|band| band.t_s == t_s).map(|band| (band.mean, band.sigma));
            let values =
                bands.iter().flat_map(|bands| at(bands).map_or([None; 2], |(mean, sigma)| [Some(mean), Some(sigma)]));
            std::iter::once(Some(t_s)).chain(values).collect::<Vec<Option<f64>>>()
        });
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        write_rows(&dir.join(format!("series-{filter}.csv")), &header, rows)?;
    }
    let row = |result: &RunResult| Some((result.clone(), Overview::of(&result.log, &[result])?));
    let rows: Vec<_> = study.results.iter().filter_map(row).collect();
    run_columns().write(&dir.join("runs.csv"), rows.iter())
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_run::monte_carlo::made_up::{plan, result};
    use scphd_shared_data::Folder;

    #[test]
    fn tables_have_a_row_for_each_scan_and_for_each_run() {
        let folder = Folder::new("studies");
        let mut plan = plan(3, 3);
        plan.filters.truncate(1);
        let results = (0..3).map(|run| result(&plan.job(run), "scphd", 0.0)).collect();
        let study = Study { plan, results };
        write_tables(&folder.0, &study).unwrap();
        assert_eq!(folder.names(), ["runs.csv", "series-scphd.csv"]);
        let series = std::fs::read_to_string(folder.0.join("series-scphd.csv")).unwrap();
        assert!(series.starts_with("t_s,position_error_m,position_error_m_sigma,heading_error_deg,"), "{series}");
        assert_eq!(series.lines().count(), 6);
        let runs = std::fs::read_to_string(folder.0.join("runs.csv")).unwrap();
        assert_eq!(runs.lines().count(), 4);
        assert!(runs.starts_with("filter,run,log,scenario_seed,filter_seed,position_error_mean_m,"), "{runs}");
        assert!(runs.contains("\nscphd,2,made up,7,7,"), "{runs}");
    }
}
