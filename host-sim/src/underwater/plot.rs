//! Pictures of runs in space: plan and section, errors over time, and figures 7.5 to 7.7 of the thesis.

use super::log::Log;
use super::record::{Record, distance, position};
use crate::plot::trajectory::broken;
use crate::plot::{Chart, Colour, Figure, Gaussian, Interval, Mark};

/// Least and greatest height of a frame, px; the greatest lets a plan of a square tank have the scale of its section.
const HEIGHT_PX: [f64; 2] = [180.0, 1240.0];
/// Height of a chart over time, px.
const ERRORS_PX: f64 = 300.0;

/// A pair of axes that the map is looked at along: x and y from above, x and z from the side.
#[derive(Debug, Clone, Copy)]
struct Look {
    axes: [usize; 2],
    labels: [&'static str; 2],
}

const PLAN: Look = Look { axes: [0, 1], labels: ["x (m)", "y (m)"] };
const SECTION: Look = Look { axes: [0, 2], labels: ["x (m)", "z (m)"] };

impl Look {
    fn at(self, point: [f64; 3]) -> [f64; 2] {
        self.axes.map(|axis| point[axis])
    }
}

/// Trajectories and maps of `runs` over `log`: plan above, section below, both at equal scale.
///
/// The view holds the truth, the estimates and the features; dead reckoning may leave it. Estimated features are drawn with
/// 3-sigma ellipses, more opaque the more they weigh.
#[must_use]
pub fn figure(log: &Log, runs: &[(&str, &Record)]) -> Figure {
    let charts = [PLAN, SECTION].map(|look| view(look, log, runs, Parts { ways: true, maps: true }));
    Figure { title: format!("{}: trajectory and map", log.name), charts: charts.to_vec() }
}

/// 7.5: the trajectory of each run beside dead reckoning and the truth, one chart a run.
#[must_use]
pub fn trajectories(log: &Log, runs: &[(&str, &Record)]) -> Figure {
    let charts = runs.iter().map(|run| view(PLAN, log, std::slice::from_ref(run), Parts { ways: true, maps: false }));
    Figure { title: format!("{}: trajectories", log.name), charts: charts.collect() }
}

/// 7.6: the features of each run over the true ones, one chart a run.
#[must_use]
pub fn maps(log: &Log, runs: &[(&str, &Record)]) -> Figure {
    let charts = runs.iter().map(|run| view(PLAN, log, std::slice::from_ref(run), Parts { ways: false, maps: true }));
    Figure { title: format!("{}: estimated features", log.name), charts: charts.collect() }
}

/// 7.7: squared position error of every run over time.
#[must_use]
pub fn squared_errors(log: &Log, runs: &[(&str, &Record)]) -> Figure {
    let squared = |record: &Record| curve(record, |error| error * error);
    let marks = runs.iter().enumerate();
    let marks = marks.map(|(index, (label, record))| Mark::line(*label, Colour::of_curve(index), squared(record)));
    let chart = Chart {
        x_label: "time (s)".into(),
        y_label: "squared position error (m²)".into(),
        marks: marks.collect(),
        ..Chart::default()
    };
    Figure { title: format!("{}: squared position error", log.name), charts: vec![(from_zero(chart), ERRORS_PX)] }
}

/// Position error of every run and of dead reckoning over time.
#[must_use]
pub fn errors(log: &Log, runs: &[(&str, &Record)]) -> Figure {
    let mut marks: Vec<Mark> = runs
        .iter()
        .enumerate()
        .map(|(index, (label, record))| Mark::line(*label, Colour::of_curve(index), curve(record, |error| error)))
        .collect();
    let alone = Chart { y_label: "position error (m)".into(), marks: marks.clone(), ..Chart::default() };
    if let Some((_, record)) = runs.first() {
        let reckoned = record.frames.iter().map(|frame| {
            [frame.t_s, frame.true_position.map_or(f64::NAN, |truth| distance(frame.dead_reckoning, truth))]
        });
        marks.push(Mark::dashed("dead reckoning", Colour::DEAD_RECKONING, reckoned.collect()));
    }
    let both = Chart { x_label: "time (s)".into(), y_label: "position error (m)".into(), marks, ..Chart::default() };
    let charts = vec![(from_zero(alone), ERRORS_PX), (from_zero(both), ERRORS_PX)];
    Figure { title: format!("{}: position error", log.name), charts }
}

/// Position error of a run over time.
fn curve(record: &Record, of: fn(f64) -> f64) -> Vec<[f64; 2]> {
    let error = |frame| Some(of(distance(position(frame), frame.true_position?)));
    record.frames.iter().map(|frame| [frame.t_s, error(frame).unwrap_or(f64::NAN)]).collect()
}

/// Starts at zero, so that heights compare.
fn from_zero(mut chart: Chart) -> Chart {
    let (_, y) = chart.limits();
    chart.y = Interval::new(0.0, y.high());
    chart
}

/// What a chart shows beside the truth.
#[derive(Debug, Clone, Copy)]
struct Parts {
    ways: bool,
    maps: bool,
}

/// One chart with the height of its frame.
fn view(look: Look, log: &Log, runs: &[(&str, &Record)], parts: Parts) -> (Chart, f64) {
    let truth = broken(&log.truth.iter().map(|row| (row.t_s, look.at(row.position))).collect::<Vec<_>>());
    let landmarks = log.landmarks.iter().map(|landmark| look.at(landmark.position));
    let mut points: Vec<[f64; 2]> = truth.iter().copied().chain(landmarks).collect();
    points.push(look.at(log.start.0));
    let mut marks = Vec::new();
    if parts.maps {
        // The seldom ones first, so that they lie below.
        for (label, colour, stable) in
            [("features seldom detected", Colour::PALE, false), ("true features", Colour::GREY, true)]
        {
            let features = log.landmarks.iter().filter(|landmark| landmark.is_stable() == stable);
            let features: Vec<[f64; 2]> = features.map(|landmark| look.at(landmark.position)).collect();
            if !features.is_empty() {
                marks.push(Mark::crosses(label, colour, features));
            }
        }
    }
    if parts.ways {
        marks.push(Mark::line("truth", Colour::TRUTH, truth).wide(2.5));
        if let Some((_, record)) = runs.first() {
            let reckoned = record.frames.iter().map(|frame| look.at(frame.dead_reckoning)).collect();
            marks.push(Mark::dashed("dead reckoning", Colour::DEAD_RECKONING, reckoned));
        }
    }
    for (index, (label, record)) in runs.iter().enumerate() {
        let colour = Colour::of_curve(index);
        if parts.ways {
            let way: Vec<[f64; 2]> = record.frames.iter().map(|frame| look.at(position(frame))).collect();
            points.extend(&way);
            marks.push(Mark::line(*label, colour, way));
        }
        if parts.maps && !record.map.is_empty() {
            let features = record.map.iter().map(|feature| Gaussian {
                mean: look.at(feature.mean),
                covariance: look.axes.map(|row| look.axes.map(|column| feature.covariance[row][column])),
                weight: feature.weight,
            });
            let features: Vec<Gaussian> = features.collect();
            points.extend(features.iter().map(|feature| feature.mean));
            marks.push(Mark::gaussians(format!("{label}: features, 3σ"), colour, features));
        }
    }
    marks.push(Mark::rings("start", Colour::TRUTH, vec![look.at(log.start.0)]));
    let interval =
        |axis: usize| Interval::around(points.iter().map(|point| point[axis])).unwrap_or(Interval::UNIT).padded(0.04);
    let (x, y) = (interval(0), interval(1));
    let height = Figure::usual_frame_width() * y.span() / x.span();
    let chart = Chart {
        x_label: look.labels[0].into(),
        y_label: look.labels[1].into(),
        x: Some(x),
        y: Some(y),
        equal_scale: true,
        marks,
    };
    (chart, height.clamp(HEIGHT_PX[0], HEIGHT_PX[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Shape;
    use crate::underwater::by_name;

    #[test]
    fn the_truth_breaks_over_gaps() {
        let mut log = by_name("girona-tank", 1).unwrap();
        let drawn = |log: &Log| -> Vec<usize> {
            let record = Record { frames: Vec::new(), map: Vec::new() };
            let figure = figure(log, &[("run", &record)]);
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
