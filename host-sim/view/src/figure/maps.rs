//! Figures in the plane: 5.4.

use crate::plot::trajectory::{BREAK, estimated_tracks, true_path};
use crate::plot::{Chart, Colour, Figure, Gaussian, Interval, Mark};
use scphd_filters::settings::Settings;
use scphd_log::dimensions::Planar;
use scphd_log::log::Log;
use scphd_log::truth;
use scphd_run::map_truth::MapTruth;
use scphd_score::record::Record;
use std::collections::BTreeMap;

/// The axes of a view from above.
const PLAN: [usize; 2] = [0, 1];
/// Margin around the data, relative to their extent.
const AIR: f64 = 0.04;
/// Least and greatest height of a frame, px.
const HEIGHT_PX: [f64; 2] = [420.0, 1040.0];

/// 5.4a: the final map and the trajectory with the true ones.
pub fn estimate(log: &Log, record: &Record) -> Figure {
    let path = record.scans.iter().map(|scan| [scan.pose[0], scan.pose[1]]).collect();
    let features = record.map.iter().map(|feature| Gaussian {
        mean: feature.mean,
        covariance: feature.covariance,
        weight: feature.weight,
    });
    let marks = vec![
        // A wider line is visible on both sides of an estimate that coincides with it.
        Mark::line("true trajectory", Colour::TRUTH, true_path(PLAN, &log.truth)).wide(3.0),
        Mark::line("estimated trajectory", Colour::of_curve(0), path).wide(1.4),
        Mark::gaussians("estimated static features, 95 %", Colour::of_curve(0), features.collect()),
        Mark::crosses("true landmarks", Colour::TRUTH, log.landmarks.clone()),
        Mark::rings("start", Colour::TRUTH, vec![start(log)]),
    ];
    plane(format!("{}: map and trajectory estimate", log.name), marks, &[])
}

/// 5.4b: estimated moving features, and the true tracks while they are in view.
pub fn tracks(log: &Log, settings: &Settings, record: &Record) -> Figure {
    let (all, lone) = estimated_tracks(PLAN, record);
    let truth = in_view(log, settings);
    let marks = vec![
        Mark::line("true tracks in view", Colour::TRUTH, truth.clone()).wide(4.5),
        Mark::dots("", Colour::of_curve(1), lone),
        Mark::line("estimated moving features", Colour::of_curve(1), all),
        Mark::crosses("static landmarks", Colour::GREY, log.landmarks.clone()),
    ];
    // Estimates far away do not change the scale.
    let mut points = truth;
    points.extend(&log.landmarks);
    plane(format!("{}: tracks of moving features", log.name), marks, &points)
}

/// The true tracks while they are in view, with gaps elsewhere.
fn in_view(log: &Log, settings: &Settings) -> Vec<[f64; 2]> {
    let mut truth = MapTruth::<Planar>::new(log, settings);
    let mut tracks: BTreeMap<i64, Vec<[f64; 2]>> = BTreeMap::new();
    for scan in &log.scans {
        let pose = truth::at(&log.truth, scan.t_s);
        let movers = truth.at(scan.t_s, pose.as_ref()).map_or_else(Vec::new, |map| map.movers);
        for track in tracks.iter_mut().filter(|(subject, _)| !movers.iter().any(|(there, _)| there == *subject)) {
            track.1.push(BREAK);
        }
        for (subject, position) in movers {
            tracks.entry(subject).or_default().push(position);
        }
    }
    tracks.into_values().flat_map(|track| track.into_iter().chain([BREAK])).collect()
}

fn start(log: &Log) -> [f64; 2] {
    [log.initial_pose[0], log.initial_pose[1]]
}

/// A map with equal scales whose limits contain `points` or, without points, all marks.
fn plane(title: String, marks: Vec<Mark>, points: &[[f64; 2]]) -> Figure {
    let mut chart =
        Chart { x_label: "x (m)".into(), y_label: "y (m)".into(), equal_scale: true, marks, ..Chart::default() };
    let (x, y) = chart.limits();
    let around = |axis: usize, limits: Interval| Interval::around(points.iter().map(|p| p[axis])).unwrap_or(limits);
    let (x, y) = (around(0, x).padded(AIR), around(1, y).padded(AIR));
    (chart.x, chart.y) = (Some(x), Some(y));
    let height = Figure::usual_frame_width() * y.span() / x.span();
    Figure { title, charts: vec![(chart, height.clamp(HEIGHT_PX[0], HEIGHT_PX[1]))] }
}
