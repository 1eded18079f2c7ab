//! Filters over random worlds, a line for each world. Worlds differ, so that only ratios within a world can be compared, and only
//! their distribution rates a filter.

use scphd_score::moving::median;
use scphd_score::results::OutputError;
use scphd_score::results::json::{self, Format, Summary};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One filter in one world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorldRun {
    /// Name of the world, with its seed.
    pub world: String,
    pub filter: String,
    /// Settings of the run: runs with other settings are not compared with it.
    pub settings: String,
    pub position_rmse_m: f64,
    pub dead_reckoning_rmse_m: f64,
    /// Median over the scans of the NEES of the position divided by its dimension, where P is not singular.
    pub nees_median: Option<f64>,
    /// Mean wall time of a scan step, µs.
    pub scan_us_mean: Option<f64>,
}

impl WorldRun {
    /// Creates the row from the summary of a run; `None` if its log has no truth.
    pub fn of(summary: &Summary, settings: &str) -> Option<Self> {
        Some(Self {
            world: summary.log.clone(),
            filter: summary.filter.clone(),
            settings: settings.to_owned(),
            position_rmse_m: summary.position_rmse_m?,
            dead_reckoning_rmse_m: summary.dead_reckoning_rmse_m?,
            nees_median: summary.nees_median,
            scan_us_mean: summary.scan_us_mean,
        })
    }
}

/// Figures of a filter over all worlds, compared with a reference filter (the yardstick).
/// `docs/results.md` defines the keys.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Standing {
    pub format: Format,
    pub filter: String,
    pub yardstick: String,
    pub worlds: usize,
    pub ratio_median: f64,
    pub ratio_percentile_90: f64,
    pub better_share: f64,
    pub above_one_and_a_half_share: f64,
    pub above_three_share: f64,
    pub above_dead_reckoning: usize,
    pub dead_reckoning_ratio_median: f64,
    pub rmse_median_m: f64,
    pub nees_median: Option<f64>,
    pub consistent_share: f64,
}

/// Bounds of the median NEES divided by the dimension of a consistent run.
const CONSISTENT: core::ops::RangeInclusive<f64> = 0.15..=2.0;

/// The runs of one filter, in the order of `worlds`.
fn runs_of<'a>(runs: &'a [WorldRun], filter: &str, worlds: &[&str]) -> Vec<Option<&'a WorldRun>> {
    worlds.iter().map(|world| runs.iter().find(|run| run.filter == filter && run.world == *world)).collect()
}

/// The standing of `filter` compared with `yardstick`; `None` without a world in which both ran.
pub fn standing(runs: &[WorldRun], filter: &str, yardstick: &str, worlds: &[&str]) -> Option<Standing> {
    let of = runs_of(runs, filter, worlds);
    let beside = runs_of(runs, yardstick, worlds);
    let pairs: Vec<(&WorldRun, &WorldRun)> = of.into_iter().zip(beside).filter_map(|(a, b)| a.zip(b)).collect();
    let mut ratios: Vec<f64> = pairs.iter().map(|(a, b)| a.position_rmse_m / b.position_rmse_m).collect();
    ratios.sort_by(f64::total_cmp);
    let share = |holds: usize| holds as f64 / pairs.len() as f64;
    let nees: Vec<f64> = pairs.iter().filter_map(|(a, _)| a.nees_median).collect();
    Some(Standing {
        format: Format,
        filter: filter.to_owned(),
        yardstick: yardstick.to_owned(),
        worlds: pairs.len(),
        ratio_median: median(&ratios)?,
        ratio_percentile_90: *ratios.get(ratios.len() * 9 / 10)?,
        better_share: share(ratios.iter().filter(|ratio| **ratio < 1.0).count()),
        above_one_and_a_half_share: share(ratios.iter().filter(|ratio| **ratio > 1.5).count()),
        above_three_share: share(ratios.iter().filter(|ratio| **ratio > 3.0).count()),
        above_dead_reckoning: pairs.iter().filter(|(a, _)| a.position_rmse_m > a.dead_reckoning_rmse_m).count(),
        dead_reckoning_ratio_median: median(
            &pairs.iter().map(|(a, _)| a.position_rmse_m / a.dead_reckoning_rmse_m).collect::<Vec<_>>(),
        )?,
        rmse_median_m: median(&pairs.iter().map(|(a, _)| a.position_rmse_m).collect::<Vec<_>>())?,
        nees_median: median(&nees),
        consistent_share: share(nees.iter().filter(|nees| CONSISTENT.contains(nees)).count()),
    })
}

/// A line for each world: dead reckoning, then RMSE and NEES divided by `dimension` of every filter, then the ratio of the first
/// filter's RMSE to each other one's.
pub fn lines(dimension: usize, runs: &[WorldRun], filters: &[String], worlds: &[&str]) -> String {
    let width = worlds.iter().map(|world| world.len()).max().unwrap_or(0).max("world".len());
    let mut text = format!("{:width$}  {:>10}", "world", "odometry");
    for filter in filters {
        text += &format!("  {:>18}", format!("{filter} (NEES/{dimension})"));
    }
    for filter in filters.iter().skip(1) {
        text += &format!("  {:>12}", format!("over {filter}"));
    }
    let columns: Vec<Vec<Option<&WorldRun>>> = filters.iter().map(|filter| runs_of(runs, filter, worlds)).collect();
    for (row, world) in worlds.iter().enumerate() {
        let of: Vec<Option<&WorldRun>> = columns.iter().map(|column| column[row]).collect();
        let reckoning = of.iter().flatten().next().map(|run| format!("{:.3}", run.dead_reckoning_rmse_m));
        text += &format!("\n{world:width$}  {:>10}", reckoning.unwrap_or_else(|| "-".into()));
        for run in &of {
            let cell = run.map_or_else(
                || "-".to_owned(),
                |run| {
                    let nees = run.nees_median.map_or_else(|| "-".to_owned(), |nees| format!("{nees:.2}"));
                    format!("{:.3} ({nees})", run.position_rmse_m)
                },
            );
            text += &format!("  {cell:>18}");
        }
        for other in of.iter().skip(1) {
            let ratio = of[0].zip(*other).map(|(a, b)| format!("{:.2}", a.position_rmse_m / b.position_rmse_m));
            text += &format!("  {:>12}", ratio.unwrap_or_else(|| "-".into()));
        }
    }
    text
}

/// Writes the standings as a JSON list of flat objects.
pub fn write_json(path: &Path, standings: &[Standing]) -> Result<(), OutputError> {
    json::write(path, standings)
}

/// A standing as text, for positions of this dimension.
pub fn told(dimension: usize, standing: &Standing) -> String {
    let percent = |share: f64| 100.0 * share;
    format!(
        "{} over {}, {} worlds: RMSE ratio median {:.2}, 90th percentile {:.2}, above 1.5 in {:.1} %, above 3 in {:.1} %, better in {:.1} %; \
         above dead reckoning in {}, {:.2} of its error in the median; RMSE median {:.3} m; NEES/{dimension} median {}, between \
         0.15 and 2 in {:.1} %",
        standing.filter,
        standing.yardstick,
        standing.worlds,
        standing.ratio_median,
        standing.ratio_percentile_90,
        percent(standing.above_one_and_a_half_share),
        percent(standing.above_three_share),
        percent(standing.better_share),
        standing.above_dead_reckoning,
        standing.dead_reckoning_ratio_median,
        standing.rmse_median_m,
        standing.nees_median.map_or_else(|| "-".to_owned(), |nees| format!("{nees:.2}")),
        percent(standing.consistent_share),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(world: &str, filter: &str, rmse: f64) -> WorldRun {
        WorldRun {
            world: world.into(),
            filter: filter.into(),
            settings: "s".into(),
            position_rmse_m: rmse,
            dead_reckoning_rmse_m: 5.0,
            nees_median: Some(rmse),
            scan_us_mean: None,
        }
    }

    #[test]
    fn ratios_are_within_a_world_for_any_order_of_the_runs() {
        let mut runs = vec![];
        for (world, ours, other) in [("a", 1.0, 2.0), ("b", 6.0, 1.0), ("c", 1.5, 1.0)] {
            runs.push(run(world, "scphd", ours));
            runs.insert(0, run(world, "ekf", other));
        }
        let worlds = ["a", "b", "c", "d"];
        let standing = standing(&runs, "scphd", "ekf", &worlds).unwrap();
        assert_eq!((standing.worlds, standing.ratio_median, standing.ratio_percentile_90), (3, 1.5, 6.0));
        assert_eq!((standing.above_dead_reckoning, standing.rmse_median_m), (1, 1.5));
        assert_eq!(standing.dead_reckoning_ratio_median, 0.3);
        assert!(
            (standing.above_three_share - 1.0 / 3.0).abs() < 1e-12 && (standing.better_share - 1.0 / 3.0).abs() < 1e-12
        );
        assert!((standing.consistent_share - 2.0 / 3.0).abs() < 1e-12);
        // A ratio of 1.5 is not above 1.5.
        assert!((standing.above_one_and_a_half_share - 1.0 / 3.0).abs() < 1e-12);
        let text = lines(3, &runs, &["scphd".into(), "ekf".into()], &worlds);
        assert_eq!(text.lines().count(), 5);
        assert!(text.lines().nth(2).unwrap().trim_end().ends_with("6.00"), "{text}");
        assert!(text.lines().last().unwrap().trim_end().ends_with('-'), "{text}");
    }

    #[test]
    fn without_a_common_world_there_is_no_standing() {
        let runs = [run("a", "scphd", 1.0), run("b", "ekf", 1.0)];
        assert_eq!(standing(&runs, "scphd", "ekf", &["a", "b"]), None);
    }
}
