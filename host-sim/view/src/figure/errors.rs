//! Figures over time: 5.5, 5.6b and c, 5.8.

use crate::plot::study::{column, curve, parts, position};
use crate::plot::{Chart, Colour, Figure, Mark};
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

/// 5.6b and c: pose error and that of dead reckoning, and the map error with its parts, for one long run.
pub fn long_run(name: &str, run: &RunResult) -> Figure {
    let filters = [("estimate", vec![run])];
    let mut pose = position(&filters);
    pose.marks.rotate_right(1);
    let alone = curve(&filters, Curve::PositionError, "position error (m)");
    let line = |curve: Curve| -> Vec<[f64; 2]> {
        let times = run.series.t_s.iter().zip(run.series.curve(curve));
        times.map(|(&t_s, value)| [t_s, value.unwrap_or(f64::NAN)]).collect()
    };
    let ospa = Chart {
        y_label: "OSPA, c = 10 m (m)".into(),
        marks: vec![
            Mark::line("OSPA", Colour::of_curve(0), line(Curve::OspaFar)),
            Mark::line("localization", Colour::of_curve(1), line(Curve::OspaFarLocalization)).wide(1.2),
            Mark::line("cardinality", Colour::of_curve(2), line(Curve::OspaFarCardinality)).wide(1.2),
        ],
        ..Chart::default()
    };
    column(format!("{name}: errors of one run"), vec![pose, alone, ospa])
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
