//! The figures of a Monte Carlo study.

use super::table::{decimals, ruled};
use scphd_run::monte_carlo::Study;
use scphd_run::monte_carlo::compare::comparisons;
use scphd_run::monte_carlo::overview::{Overview, Spread, overviews};

/// The figures as text, a column for each filter, followed by comparisons of the first filter with each other one.
pub fn render(study: &Study) -> String {
    type Figure = (&'static str, fn(&Overview, &Spread) -> String);
    const FIGURES: [Figure; 18] = [
        ("runs", |o, _| o.runs.to_string()),
        ("particles × samples", |o, _| format!("{} × {}", o.particles, o.samples)),
        ("position error, mean (m)", |o, _| decimals(o.position_error_mean_m, 3)),
        ("  std dev over runs (m)", |_, spread| decimals(spread.position_m, 3)),
        ("position error, final (m)", |o, _| decimals(o.position_error_final_m, 3)),
        ("heading error, mean (deg)", |o, _| decimals(o.heading_error_mean_deg, 3)),
        ("dead reckoning, mean (m)", |o, _| decimals(o.dead_reckoning_error_mean_m, 3)),
        ("dead reckoning, final (m)", |o, _| decimals(o.dead_reckoning_error_final_m, 3)),
        ("error / dead reckoning", |o, _| {
            let ratio = o.position_error_mean_m.zip(o.dead_reckoning_error_mean_m).map(|(a, b)| a / b);
            decimals(ratio, 3)
        }),
        ("OSPA (c 10 m), first third (m)", |o, _| decimals(o.ospa_first_third_m, 3)),
        ("OSPA (c 10 m), last third (m)", |o, _| decimals(o.ospa_last_third_m, 3)),
        ("  std dev over runs (m)", |_, spread| decimals(spread.ospa_m, 3)),
        ("position errors (NEES/dim), mean", |o, _| decimals(o.nees_mean, 2)),
        ("  scans within 95 % of χ² (%)", |o, _| decimals(o.nees_within_95.map(|share| 100.0 * share), 1)),
        ("movers found in 10 scans", |o, _| decimals(o.moving_hit_rate, 3)),
        ("  median error (m)", |o, _| decimals(o.moving_position_error_median_m, 3)),
        ("  false tracks a scan", |o, _| decimals(o.false_moving_tracks_per_scan, 3)),
        ("scan, mean (µs)", |o, _| decimals(o.scan_us_mean, 1)),
    ];
    let overviews = overviews(study);
    let spreads: Vec<Spread> =
        overviews.iter().map(|overview| Spread::of(&study.of_filter(&overview.filter))).collect();
    let row = |name: &str, show: &dyn Fn(&Overview, &Spread) -> String| {
        let columns = overviews.iter().zip(&spreads).map(|(overview, spread)| show(overview, spread));
        comfy_table::Row::from(std::iter::once(name.to_owned()).chain(columns).collect::<Vec<String>>())
    };
    let header = row("", &|overview, _| overview.filter.clone());
    // The names of several logs would be too long for a column.
    let mut text = format!("{}\n", study.plan.scenario);
    text.push_str(&ruled(header, FIGURES.iter().map(|(name, show)| row(name, show))));
    for comparison in comparisons(study) {
        text.push('\n');
        text.push_str(&comparison.to_string());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_run::monte_carlo::made_up::of_two_filters;

    #[test]
    fn a_table_with_a_comparison() {
        let text = render(&of_two_filters());
        println!("{text}");
        assert!(text.contains("scphd") && text.contains("4 × 2"));
        let spreads: Vec<&str> = text.lines().filter(|line| line.contains("std dev over runs")).collect();
        assert_eq!(spreads.len(), 2, "{text}");
        for line in spreads {
            assert_eq!(line.split_whitespace().rev().take(2).collect::<Vec<_>>(), ["0.100"; 2], "{line}");
        }
        assert!(text.contains("better than rb-single in 3 of 3 runs"), "{text}");
    }
}
