//! Trajectory and map: what was true, what odometry alone says, what the filters say.

use super::axis::Interval;
use super::chart::{Chart, Colour, Gaussian, Mark};
use super::figure::Figure;
use crate::log::{Log, MovingLandmark, TruePose};
use crate::record::Record;
use std::collections::BTreeMap;

/// A step in the truth this many times the median step is a gap.
const GAP_FACTOR: f64 = 5.0;
/// How far dead reckoning may push the view beyond everything else, in lengths of the view.
const DEAD_RECKONING_SHARE: f64 = 0.15;
/// Least and greatest height of the frame, px.
const HEIGHT_PX: [f64; 2] = [420.0, 1040.0];
/// A point that breaks a curve.
pub(crate) const BREAK: [f64; 2] = [f64::NAN, f64::NAN];

/// The picture of the trajectories and maps of `runs` over `log`, axes in metres at equal scale.
///
/// The view holds the truth, the estimates and the landmarks; dead reckoning may leave it. Estimated features are
/// drawn with 3-sigma ellipses, more opaque the more they weigh.
pub fn figure(log: &Log, runs: &[(&str, &Record)]) -> Figure {
    let truth = true_path(&log.truth);
    let reckoned = runs.first().map_or_else(Vec::new, |(_, record)| {
        let positions = record.scans.iter().map(|s| s.dead_reckoning);
        positions.map(|p| [p[0], p[1]]).collect()
    });
    let (x, y) = view(log, runs, &truth, &reckoned);

    let mut marks = Vec::new();
    let width = |index| run_width(index, runs.len());
    if !truth.is_empty() {
        // Its rim shows on both sides of an estimate that coincides with it.
        marks.push(Mark::line("truth", Colour::TRUTH, truth).wide(width(0) + 1.0));
    }
    if !reckoned.is_empty() {
        let colour = Colour::DEAD_RECKONING;
        marks.push(Mark::dashed("dead reckoning", colour, reckoned));
    }
    for (index, (label, record)) in runs.iter().enumerate() {
        let path = record.scans.iter().map(|s| [s.pose[0], s.pose[1]]);
        let mark = Mark::line(*label, Colour::of_curve(index), path.collect());
        marks.push(mark.wide(width(index)));
    }
    for (index, (label, record)) in runs.iter().enumerate() {
        if !record.map.is_empty() {
            let features = record.map.iter().map(|feature| Gaussian {
                mean: feature.mean,
                covariance: feature.covariance,
                weight: feature.weight,
            });
            let name = format!("{label}: features, 3σ");
            let colour = Colour::of_curve(index);
            marks.push(Mark::gaussians(name, colour, features.collect()));
        }
    }
    for (index, (label, record)) in runs.iter().enumerate() {
        let (tracks, lone) = estimated_tracks(record);
        if !tracks.is_empty() {
            // One run has a second colour to spare.
            let colour = Colour::of_curve(if runs.len() == 1 { 1 } else { index });
            marks.push(Mark::dots("", colour, lone));
            marks.push(Mark::line(format!("{label}: moving features"), colour, tracks).wide(1.4));
        }
    }
    if !log.landmarks.is_empty() {
        let landmarks = log.landmarks.clone();
        marks.push(Mark::crosses("true landmarks", Colour::TRUTH, landmarks));
    }
    if !log.moving.is_empty() {
        let tracks = moving_tracks(&log.moving);
        marks.push(Mark::line("moving landmarks", Colour::GREY, tracks).wide(1.2));
    }
    let start = [log.initial_pose[0], log.initial_pose[1]];
    marks.push(Mark::rings("start", Colour::TRUTH, vec![start]));

    let height = Figure::usual_frame_width() * y.span() / x.span();
    let chart =
        Chart { x_label: "x (m)".into(), y_label: "y (m)".into(), x: Some(x), y: Some(y), equal_scale: true, marks };
    Figure {
        title: format!("{}: trajectory and map", log.name),
        charts: vec![(chart, height.clamp(HEIGHT_PX[0], HEIGHT_PX[1]))],
    }
}

/// Width of the curve of run number `index` of `count`, px: each is thinner than those it is drawn over, so that
/// coinciding curves all show.
pub(super) fn run_width(index: usize, count: usize) -> f64 {
    let over_it = count.saturating_sub(index + 1).min(2);
    1.5 + 1.3 * over_it as f64
}

/// Limits of x and y.
fn view(log: &Log, runs: &[(&str, &Record)], truth: &[[f64; 2]], reckoned: &[[f64; 2]]) -> (Interval, Interval) {
    let mut points = vec![[log.initial_pose[0], log.initial_pose[1]]];
    points.extend(truth);
    points.extend(&log.landmarks);
    points.extend(log.moving.iter().map(|m| m.position));
    for (_, record) in runs {
        points.extend(record.scans.iter().map(|s| [s.pose[0], s.pose[1]]));
        points.extend(record.map.iter().map(|f| f.mean));
    }
    let interval = |axis: usize| {
        let core = Interval::around(points.iter().map(|p| p[axis])).unwrap_or(Interval::UNIT);
        let astray = Interval::around(reckoned.iter().map(|p| p[axis])).unwrap_or(core);
        let allowed = core.padded(DEAD_RECKONING_SHARE);
        core.union(astray).intersection(allowed).padded(0.04)
    };
    (interval(0), interval(1))
}

/// The true positions, broken where rows are missing.
pub(crate) fn true_path(truth: &[TruePose]) -> Vec<[f64; 2]> {
    broken(&truth.iter().map(|row| (row.t_s, row.position)).collect::<Vec<_>>())
}

/// A curve through what is known at some times, s, in their order, broken where rows are missing: nobody knows what was there.
pub(crate) fn broken(rows: &[(f64, [f64; 2])]) -> Vec<[f64; 2]> {
    let mut steps: Vec<f64> = rows.windows(2).map(|w| w[1].0 - w[0].0).collect();
    steps.sort_by(f64::total_cmp);
    let longest = steps.get(steps.len() / 2).map_or(f64::INFINITY, |median| GAP_FACTOR * median);
    let mut path = Vec::with_capacity(rows.len());
    for (index, &(t_s, point)) in rows.iter().enumerate() {
        if index > 0 && t_s - rows[index - 1].0 > longest {
            path.push(BREAK);
        }
        path.push(point);
    }
    path
}

/// One curve through the estimated moving features of every scan, by their names, broken where one is not reported;
/// and those that are reported for a single scan, which the curve leaves out.
pub(crate) fn estimated_tracks(record: &Record) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let mut tracks: BTreeMap<u32, Vec<(usize, [f64; 2])>> = BTreeMap::new();
    for (scan, row) in record.scans.iter().enumerate() {
        for feature in &row.moving {
            tracks.entry(feature.id).or_default().push((scan, feature.position));
        }
    }
    let (mut path, mut lone) = (Vec::new(), Vec::new());
    for track in tracks.values() {
        for piece in track.chunk_by(|before, after| after.0 == before.0 + 1) {
            match piece {
                [(_, position)] => lone.push(*position),
                piece => path.extend(piece.iter().map(|(_, position)| *position).chain([BREAK])),
            }
        }
    }
    (path, lone)
}

/// One curve through the tracks of all moving landmarks, broken between them and where rows are missing.
pub(crate) fn moving_tracks(moving: &[MovingLandmark]) -> Vec<[f64; 2]> {
    let mut rows: Vec<&MovingLandmark> = moving.iter().collect();
    // Stable: rows of one landmark stay in order of time.
    rows.sort_by_key(|row| row.subject);
    let mut path = Vec::with_capacity(rows.len());
    for track in rows.chunk_by(|before, after| before.subject == after.subject) {
        if !path.is_empty() {
            path.push(BREAK);
        }
        path.extend(broken(&track.iter().map(|row| (row.t_s, row.position)).collect::<Vec<_>>()));
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_breaks_over_gaps() {
        let rows: Vec<TruePose> = [0.0, 0.2, 0.4, 0.6, 5.0, 5.2]
            .map(|t_s| TruePose { t_s, position: [t_s, 0.0], heading_rad: None })
            .to_vec();
        let path = true_path(&rows);
        assert_eq!(path.len(), 7);
        assert!(path[4][0].is_nan());
        assert!(true_path(&[]).is_empty());
        assert_eq!(true_path(&rows[..1]).len(), 1);
    }

    #[test]
    fn estimated_tracks_break_where_a_feature_is_not_reported() {
        let feature = |id, x| crate::record::MovingFeature {
            id,
            weight: 1.0,
            position: [x, 0.0],
            velocity: [0.0; 2],
            covariance: [[0.0; 2]; 2],
        };
        let scan = |moving| crate::record::ScanRecord {
            t_s: 0.0,
            pose: [0.0; 3],
            pose_covariance: [[0.0; 3]; 3],
            dead_reckoning: [0.0; 3],
            true_position: None,
            true_heading_rad: None,
            measurements: 0,
            features_estimated: 0.0,
            n_eff: 1.0,
            scan_us: 0.0,
            moving,
            map_error: None,
            movers: None,
        };
        let scans = vec![
            scan(vec![feature(7, 1.0), feature(2, 5.0)]),
            scan(vec![feature(7, 2.0)]),
            scan(vec![]),
            scan(vec![feature(7, 4.0)]),
        ];
        let (path, lone) = estimated_tracks(&Record { scans, map: vec![] });
        assert_eq!(path[..2], [[1.0, 0.0], [2.0, 0.0]]);
        assert!(path.len() == 3 && path[2][0].is_nan());
        assert_eq!(lone, [[5.0, 0.0], [4.0, 0.0]]);
    }

    #[test]
    fn tracks_are_told_apart() {
        let row = |subject, t_s| MovingLandmark { subject, t_s, position: [t_s, subject as f64] };
        let path = moving_tracks(&[row(2, 0.0), row(1, 0.0), row(2, 1.0), row(1, 1.0)]);
        assert_eq!(path[..2], [[0.0, 1.0], [1.0, 1.0]]);
        assert!(path[2][0].is_nan());
        assert_eq!(path[3..], [[0.0, 2.0], [1.0, 2.0]]);
        let gap = moving_tracks(&[0.0, 1.0, 2.0, 9.0, 10.0].map(|t_s| row(1, t_s)));
        assert!(gap.len() == 6 && gap[3][0].is_nan(), "{gap:?}");
    }
}
