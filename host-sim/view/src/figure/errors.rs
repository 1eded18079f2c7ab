//! Figures over time: 5.5 and 5.8.

use crate::plot::Figure;
use crate::plot::study::{column, curve, parts, position};
use scphd_run::monte_carlo::{Curve, RunResult, Study};

/// The results of every filter of a study with the name for the legend.
fn named(study: &Study) -> Vec<(&str, Vec<&RunResult>)> {
    let name = |filter: &'_ str| match filter {
        "scphd" => "SC-PHD SLAM",
        "rb-single" => "RB-PHD SLAM, single feature",
        "rb-multi" => "RB-PHD SLAM, several features",
        "rb-empty" => "RB-PHD SLAM, empty map",
        _ => "reference",
    };
    study.plan.filters.iter().map(|filter| (name(filter), study.of_filter(filter))).collect()
}

/// 5.5: mean pose error and that of dead reckoning, and mean map error.
pub fn mean_errors(study: &Study) -> Figure {
    let filters = named(study);
    let charts = vec![
        position(&filters),
        curve(&filters, Curve::HeadingError, "heading error (deg)"),
        curve(&filters, Curve::OspaFar, "OSPA, c = 10 m (m)"),
    ];
    column(format!("{}: means of {} runs, ±1σ", study.plan.scenario, study.plan.runs), charts)
}

/// 5.8: pose error and map error with its parts, for every filter, with ±1σ.
pub fn comparison(study: &Study) -> Figure {
    let filters = named(study);
    // The two filters of the thesis have a chart of their own, because the others may have far larger errors.
    let pair = &filters[..filters.len().min(2)];
    let mut charts = vec![curve(pair, Curve::PositionError, "position error (m)")];
    if filters.len() > pair.len() {
        charts.push(curve(&filters, Curve::PositionError, "position error (m)"));
    }
    charts.extend(parts(&filters));
    column(format!("{}: means of {} runs, ±1σ", study.plan.scenario, study.plan.runs), charts)
}
