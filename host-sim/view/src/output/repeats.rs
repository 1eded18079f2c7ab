//! Many runs on a terminal: a row for each log, with means and standard deviations over its runs.

use super::table::{decimals, ruled};
use comfy_table::Row;
use scphd_run::monte_carlo::{mean, standard_deviation};
use scphd_score::chi_squared;
use scphd_score::results::json::Summary;

/// Figures of a row: name with the unit, and number of decimals.
const FIGURES: [(&str, usize); 8] = [
    ("dead reckoning\nRMSE (m)", 3),
    ("position RMSE\nmean (m)", 3),
    ("RMSE\nstd dev (m)", 3),
    ("RMSE\nleast (m)", 3),
    ("RMSE\ngreatest (m)", 3),
    ("heading\nRMSE (deg)", 3),
    ("GOSPA\n(m)", 3),
    ("scan\n(µs)", 1),
];

/// The runs of every log as text without a newline at the end. For several logs the mean of their rows follows.
///
/// The standard deviation is that of a sample (divisor one less than the number of runs). A run without a figure does not count
/// in it.
pub fn render(logs: &[&[Summary]]) -> String {
    let figures: Vec<_> = logs.iter().map(|runs| figures(runs)).collect();
    let mut rows: Vec<Row> = logs
        .iter()
        .zip(&figures)
        .map(|(runs, figures)| row(runs.first().map_or("", |run| &run.log), &runs.len().to_string(), figures))
        .collect();
    if logs.len() > 1 {
        let over_logs: [_; FIGURES.len()] = std::array::from_fn(|k| mean(known(&figures, |row| row[k])));
        rows.push(row("mean over logs", "", &over_logs));
    }
    let names = FIGURES.map(|(name, _)| name.to_owned());
    ruled(Row::from(["log", "runs"].map(String::from).into_iter().chain(names).collect::<Vec<_>>()), rows.into_iter())
}

/// Consistency of the filter's covariance over the runs of a scenario, each with different noise: NEES of the position divided by
/// its dimension at the last scan, mean over the runs, with the two-sided 95 % bounds of χ² for this number of runs. `None` for
/// fewer than two runs with truth.
pub fn consistency(runs: &[Summary], dimension: usize) -> Option<String> {
    let last = known(runs, |run| run.nees_final);
    let nees = mean(last.iter().copied()).filter(|_| last.len() > 1)?;
    let [low, high] = chi_squared::bounds_of_mean(dimension, last.len());
    let verdict = if (low..=high).contains(&nees) { "within" } else { "not within" };
    Some(format!(
        "{}: NEES/dim at the last scan, mean of {} runs: {}, {verdict} {low:.2} to {high:.2} (95 % of χ²)",
        runs.first().map_or("", |run| &run.log),
        last.len(),
        decimals(Some(nees), 2)
    ))
}

/// The figures of one log, in the order of [`FIGURES`].
fn figures(runs: &[Summary]) -> [Option<f64>; FIGURES.len()] {
    let position = known(runs, |run| run.position_rmse_m);
    [
        mean(known(runs, |run| run.dead_reckoning_rmse_m)),
        mean(position.iter().copied()),
        standard_deviation(&position),
        position.iter().copied().reduce(f64::min),
        position.iter().copied().reduce(f64::max),
        mean(known(runs, |run| run.heading_rmse_deg)),
        mean(known(runs, |run| run.gospa_m)),
        mean(known(runs, |run| run.scan_us_mean)),
    ]
}

fn row(log: &str, runs: &str, figures: &[Option<f64>; FIGURES.len()]) -> Row {
    let shown = figures.iter().zip(FIGURES).map(|(&value, (_, digits))| decimals(value, digits));
    Row::from([log, runs].map(String::from).into_iter().chain(shown).collect::<Vec<_>>())
}

fn known<I>(items: &[I], figure: impl Fn(&I) -> Option<f64>) -> Vec<f64> {
    items.iter().filter_map(figure).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_score::results::json::made_up as summary;

    #[test]
    fn consistency_over_runs_is_reported() {
        let run = |nees: f64| Summary { nees_final: Some(nees), ..summary() };
        // The bounds for ten values in two dimensions are 9.59/20 and 34.17/20.
        let text = |nees: f64| consistency(&[nees; 10].map(run), 2).unwrap();
        let expected = "circle: NEES/dim at the last scan, mean of 10 runs: 1.00, within 0.48 to 1.71 (95 % of χ²)";
        assert_eq!(text(1.0), expected);
        assert!(text(1.8).contains("1.80, not within"));
        assert_eq!(consistency(&[run(1.0)], 2), None);
    }

    #[test]
    fn statistics_of_runs_and_logs() {
        let run = |position: f64| Summary { position_rmse_m: Some(position), ..summary() };
        let one = [run(1.0), run(2.0), run(3.0)];
        let other = [run(5.0)];
        let text = render(&[&one, &other]);
        println!("{text}");
        let cells = |name: &str| -> Vec<&str> {
            let line = text.lines().find(|line| line.trim_start().starts_with(name)).unwrap();
            line.trim_start().strip_prefix(name).unwrap().split_whitespace().collect()
        };
        assert_eq!(cells("circle"), ["3", "12.500", "2.000", "1.000", "1.000", "3.000", "–", "3.000", "812.3"]);
        assert_eq!(cells("mean over logs")[..3], ["12.500", "3.500", "1.000"]);
        assert!(text.lines().all(|line| line.chars().count() <= 132));
        assert!(!render(&[&one]).contains("mean over logs"));
    }
}
