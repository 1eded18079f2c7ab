//! Figures in space: 7.5 to 7.7.

use crate::plot::trajectory::{self, Parts};
use crate::plot::{Chart, Colour, Figure, Interval, Mark};
use scphd_log::dimensions::Underwater;
use scphd_log::underwater::Log;
use scphd_score::record::{Record, ScanRecord};

/// Height of a chart over time, px.
const ERRORS_PX: f64 = 300.0;

/// Runs with their names for the legend.
type Runs<'a> = [(&'a str, &'a Record<Underwater>)];

/// 7.5: the trajectory of each run, dead reckoning and the truth, a chart for each run.
pub fn trajectories(log: &Log, runs: &Runs<'_>) -> Figure {
    each(log, runs, "trajectories", Parts { ways: true, maps: false })
}

/// 7.5, from above and from the side: trajectory and map of each run.
pub fn plan_and_section(log: &Log, runs: &Runs<'_>) -> Figure {
    trajectory::figure::<Underwater>(log, runs)
}

/// 7.6: the features of each run and the true ones, a chart for each run.
pub fn space_maps(log: &Log, runs: &Runs<'_>) -> Figure {
    each(log, runs, "estimated features", Parts { ways: false, maps: true })
}

/// A view from above for each run.
fn each(log: &Log, runs: &Runs<'_>, what: &str, parts: Parts) -> Figure {
    let plan = |run| trajectory::view::<Underwater>([0, 1], log, std::slice::from_ref(run), parts);
    Figure { title: format!("{}: {what}", log.name), charts: runs.iter().map(plan).collect() }
}

/// 7.7: squared position error of each run over time.
pub fn squared_errors(log: &Log, runs: &Runs<'_>) -> Figure {
    let squared = |scan: &ScanRecord<Underwater>| scan.position_error_m().map_or(f64::NAN, |error| error * error);
    let marks = runs.iter().enumerate().map(|(index, (label, record))| {
        let points = record.scans.iter().map(|scan| [scan.t_s, squared(scan)]);
        Mark::line(*label, Colour::of_curve(index), points.collect())
    });
    let mut chart = Chart {
        x_label: "time (s)".into(),
        y_label: "squared position error (m²)".into(),
        marks: marks.collect(),
        ..Chart::default()
    };
    // From zero, so that heights can be compared.
    chart.y = Interval::new(0.0, chart.limits().1.high());
    Figure { title: format!("{}: squared position error", log.name), charts: vec![(chart, ERRORS_PX)] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Shape;
    use scphd_worlds::underwater::by_name;

    #[test]
    fn the_curve_of_the_truth_has_gaps_where_rows_are_missing() {
        let mut log = by_name("girona-tank", 1).unwrap();
        let drawn = |log: &Log| -> Vec<usize> {
            let record = Record { scans: Vec::new(), map: Vec::new() };
            let figure = plan_and_section(log, &[("run", &record)]);
            let breaks = |chart: &Chart| {
                let truth = chart.marks.iter().find(|mark| mark.label == "truth").unwrap();
                let Shape::Line { points, .. } = &truth.shape else { panic!("a line") };
                points.iter().filter(|point| point[0].is_nan()).count()
            };
            figure.charts.iter().map(|(chart, _)| breaks(chart)).collect()
        };
        assert_eq!(drawn(&log), [0, 0]);
        // Ten seconds without a fix.
        let start_s = log.truth[0].t_s;
        log.truth.retain(|row| !(20.0..30.0).contains(&(row.t_s - start_s)));
        assert_eq!(drawn(&log), [1, 1]);
    }
}
