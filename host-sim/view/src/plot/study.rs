//! Errors of many runs over time: means with ±1σ bands.

use super::axis::Interval;
use super::chart::{Chart, Colour, Mark};
use super::figure::Figure;
use scphd_run::monte_carlo::{Band, Curve, RunResult, Study, band};

const HEIGHT_PX: f64 = 300.0;

/// The figure of a study: position and heading error, and the map error with both cut-offs.
pub fn figure(study: &Study) -> Figure {
    let filters: Vec<(&str, Vec<&RunResult>)> =
        study.plan.filters.iter().map(|filter| (filter.as_str(), study.of_filter(filter))).collect();
    let mut charts = vec![position(&filters), curve(&filters, Curve::HeadingError, "heading error (deg)")];
    charts.push(curve(&filters, Curve::OspaFar, "OSPA, c = 10 m (m)"));
    charts.push(curve(&filters, Curve::OspaNear, "OSPA, c = 1 m (m)"));
    charts.retain(Chart::has_data);
    column(format!("{}: means of {} runs, ±1σ", study.plan.scenario, study.plan.runs), charts)
}

pub fn column(title: String, mut charts: Vec<Chart>) -> Figure {
    if let Some(last) = charts.last_mut() {
        last.x_label = "time (s)".into();
    }
    Figure { title, charts: charts.into_iter().map(|chart| (chart, HEIGHT_PX)).collect() }
}

/// Position error of every filter, and that of dead reckoning, which is the same for all, each with its band.
pub fn position(filters: &[(&str, Vec<&RunResult>)]) -> Chart {
    let mut chart = curve(filters, Curve::PositionError, "position error (m)");
    if let Some((_, results)) = filters.first() {
        let reckoned = band(results, Curve::DeadReckoningError);
        if let Some(mark) = spread(&reckoned, Colour::DEAD_RECKONING) {
            chart.marks.insert(0, mark);
        }
        chart.marks.push(Mark::dashed("dead reckoning", Colour::DEAD_RECKONING, line(&reckoned)));
    }
    spanning(chart)
}

/// Mean and band of a curve for every filter.
pub fn curve(filters: &[(&str, Vec<&RunResult>)], curve: Curve, y_label: &str) -> Chart {
    let bands: Vec<Vec<Band>> = filters.iter().map(|(_, results)| band(results, curve)).collect();
    let mut marks: Vec<Mark> =
        bands.iter().enumerate().filter_map(|(index, bands)| spread(bands, Colour::of_curve(index))).collect();
    for (index, ((label, _), bands)) in filters.iter().zip(&bands).enumerate() {
        marks.push(Mark::line(*label, Colour::of_curve(index), line(bands)));
    }
    spanning(Chart { y_label: y_label.into(), marks, ..Chart::default() })
}

/// A map error with its parts for every filter: the total as a thick line with its band, the parts as thin lines.
pub fn parts(filters: &[(&str, Vec<&RunResult>)]) -> Vec<Chart> {
    vec![
        curve(filters, Curve::OspaFar, "OSPA, c = 10 m (m)"),
        curve(filters, Curve::OspaFarLocalization, "localization (m)"),
        curve(filters, Curve::OspaFarCardinality, "cardinality (m)"),
    ]
}

/// The area within ±1σ; `None` if it is zero.
fn spread(bands: &[Band], colour: Colour) -> Option<Mark> {
    // Errors are not negative, for any σ.
    let rows = bands.iter().map(|band| [band.t_s, (band.mean - band.sigma).max(0.0), band.mean + band.sigma]);
    bands.iter().any(|band| band.sigma > 0.0).then(|| Mark::band("", colour, rows.collect()))
}

fn line(bands: &[Band]) -> Vec<[f64; 2]> {
    bands.iter().map(|band| [band.t_s, band.mean]).collect()
}

/// Limits from zero, so that heights can be compared.
fn spanning(mut chart: Chart) -> Chart {
    chart.y = None;
    let (_, y) = chart.limits();
    chart.y = Interval::new(0.0, y.high());
    chart
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_run::monte_carlo::made_up::of_two_filters;

    #[test]
    fn every_filter_has_a_curve_and_a_band() {
        let figure = figure(&of_two_filters());
        assert_eq!(figure.charts.len(), 4);
        let position = &figure.charts[0].0;
        let names: Vec<&str> = position.marks.iter().map(|mark| &mark.label[..]).collect();
        assert_eq!(names, ["", "", "", "scphd", "rb-single", "dead reckoning"]);
        assert_eq!(position.y.unwrap().low(), 0.0);
        assert!(figure.svg().contains("means of 3 runs, ±1σ"));
    }
}
