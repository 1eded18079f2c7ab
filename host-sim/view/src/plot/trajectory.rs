//! Trajectory and map: truth, dead reckoning, estimates.

use super::axis::Interval;
use super::chart::{Chart, Colour, Gaussian, Mark};
use super::figure::Figure;
use scphd_filters::kind::Kind;
use scphd_log::dimensions::Dimensions;
use scphd_log::log::{MovingLandmark, TruePose};
use scphd_score::record::Record;
use std::collections::BTreeMap;

/// Least step between rows of the truth that is a gap, in median steps.
const GAP_FACTOR: f64 = 5.0;
/// Greatest extension of the view for dead reckoning, relative to its length.
const DEAD_RECKONING_SHARE: f64 = 0.15;
/// Least and greatest height of a frame, px, for one chart and for several; the latter permits the same scale for a square view
/// from above and from the side.
const HEIGHT_PX: [f64; 2] = [420.0, 1040.0];
const HEIGHTS_PX: [f64; 2] = [180.0, 1240.0];
/// Number of times at which the uncertainty of the pose is shown; a prime, so that they are not at the same places in each lap.
const POSES: usize = 17;
/// A point that makes a gap in a curve.
pub(crate) const BREAK: [f64; 2] = [f64::NAN, f64::NAN];

/// The figure of the trajectories and maps of `runs` over `log`, axes in metres with equal scales; in space from above and from
/// the side.
///
/// The view contains the truth, the estimates and the landmarks; dead reckoning may leave it. Estimated features, with their
/// weight as opacity, and the pose at some times are drawn with ellipses of 95 % probability by the filter's covariance.
pub fn figure<K: Kind>(log: &K::Log, runs: &[(&str, &Record<K>)]) -> Figure {
    let charts = K::LOOKS.iter().map(|&axes| view(axes, log, runs));
    Figure { title: format!("{}: trajectory and map", K::name(log)), charts: charts.collect() }
}

/// The coordinates of a position along two axes.
fn along(axes: [usize; 2], place: &impl AsRef<[f64]>) -> [f64; 2] {
    axes.map(|axis| place.as_ref()[axis])
}

/// One chart with the height of its frame.
fn view<K: Kind>(axes: [usize; 2], log: &K::Log, runs: &[(&str, &Record<K>)]) -> (Chart, f64) {
    let truth = true_path(axes, K::truth(log));
    let landmarks: Vec<[f64; 2]> = K::landmarks(log).iter().map(|place| along(axes, place)).collect();
    let seldom: Vec<[f64; 2]> = K::seldom(log).iter().map(|place| along(axes, place)).collect();
    let moving = K::moving(log).unwrap_or_default();
    let start = along(axes, &K::start(log));
    let reckoned = |(_, record): &(&str, &Record<K>)| {
        record.scans.iter().map(|scan| along(axes, &scan.dead_reckoning)).collect::<Vec<_>>()
    };
    let reckoned = runs.first().map_or_else(Vec::new, reckoned);
    let mut points = vec![start];
    points.extend(truth.iter().chain(&landmarks).chain(&seldom));
    points.extend(moving.iter().map(|row| along(axes, &row.position)));

    let mut marks = Vec::new();
    let width = |index| run_width(index, runs.len());
    if !truth.is_empty() {
        // A wider line is visible on both sides of an estimate that coincides with it.
        marks.push(Mark::line("truth", Colour::TRUTH, truth).wide(width(0) + 1.0));
    }
    if !reckoned.is_empty() {
        marks.push(Mark::dashed("dead reckoning", Colour::DEAD_RECKONING, reckoned.clone()));
    }
    if !seldom.is_empty() {
        marks.push(Mark::crosses("features seldom detected", Colour::PALE, seldom));
    }
    for (index, (label, record)) in runs.iter().enumerate() {
        let path: Vec<[f64; 2]> = record.scans.iter().map(|scan| along(axes, &scan.pose)).collect();
        points.extend(&path);
        marks.push(Mark::line(*label, Colour::of_curve(index), path).wide(width(index)));
    }
    for (index, (label, record)) in runs.iter().enumerate() {
        let poses = poses_at_times(axes, record);
        if !poses.is_empty() {
            // For one run a different colour is available.
            let colour = Colour::of_curve(if runs.len() == 1 { 2 } else { index });
            marks.push(Mark::gaussians(format!("{label}: pose at times, 95 %"), colour, poses));
        }
    }
    for (index, (label, record)) in runs.iter().enumerate() {
        if !record.map.is_empty() {
            let features = record.map.iter().map(|feature| Gaussian {
                mean: along(axes, &feature.mean),
                covariance: axes.map(|row| along(axes, &feature.covariance.as_ref()[row])),
                weight: feature.weight,
            });
            let features: Vec<Gaussian> = features.collect();
            points.extend(features.iter().map(|feature| feature.mean));
            marks.push(Mark::gaussians(format!("{label}: features, 95 %"), Colour::of_curve(index), features));
        }
    }
    for (index, (label, record)) in runs.iter().enumerate() {
        let (tracks, lone) = estimated_tracks(axes, record);
        if !tracks.is_empty() {
            // For one run a second colour is available.
            let colour = Colour::of_curve(if runs.len() == 1 { 1 } else { index });
            marks.push(Mark::dots("", colour, lone));
            marks.push(Mark::line(format!("{label}: moving features"), colour, tracks).wide(1.4));
        }
    }
    if !landmarks.is_empty() {
        marks.push(Mark::crosses("true landmarks", Colour::TRUTH, landmarks));
    }
    if !moving.is_empty() {
        marks.push(Mark::line("moving landmarks", Colour::GREY, moving_tracks(axes, moving)).wide(1.2));
    }
    marks.push(Mark::rings("start", Colour::TRUTH, vec![start]));

    let [x, y] = [0, 1].map(|axis| interval(axis, &points, &reckoned));
    let height = Figure::usual_frame_width() * y.span() / x.span();
    let [x_label, y_label] = axes.map(|axis| format!("{} ({})", K::POSE[axis].0, K::POSE[axis].1));
    let chart = Chart { x_label, y_label, x: Some(x), y: Some(y), equal_scale: true, marks };
    let [least, greatest] = if K::LOOKS.len() == 1 { HEIGHT_PX } else { HEIGHTS_PX };
    (chart, height.clamp(least, greatest))
}

/// The estimated positions of the vehicle at a few evenly spaced scans, and at the last one.
fn poses_at_times<D: Dimensions>(axes: [usize; 2], record: &Record<D>) -> Vec<Gaussian> {
    let last = record.scans.len().saturating_sub(1);
    let mut chosen: Vec<usize> = (1..=POSES).map(|k| k * last / POSES).collect();
    chosen.dedup();
    let scans = chosen.into_iter().filter_map(|scan| record.scans.get(scan));
    let poses = scans.map(|scan| Gaussian {
        mean: along(axes, &scan.pose),
        covariance: axes.map(|row| along(axes, &scan.pose_covariance.as_ref()[row])),
        weight: 1.0,
    });
    poses.collect()
}

/// Width of the curve of run number `index` of `count`, px: each is thinner than those below it, so that all of several
/// coinciding curves are visible.
pub(super) fn run_width(index: usize, count: usize) -> f64 {
    let over_it = count.saturating_sub(index + 1).min(2);
    1.5 + 1.3 * over_it as f64
}

/// Limits of an axis: all points, and dead reckoning up to the share above.
fn interval(axis: usize, points: &[[f64; 2]], reckoned: &[[f64; 2]]) -> Interval {
    let core = Interval::around(points.iter().map(|p| p[axis])).unwrap_or(Interval::UNIT);
    let astray = Interval::around(reckoned.iter().map(|p| p[axis])).unwrap_or(core);
    let allowed = core.padded(DEAD_RECKONING_SHARE);
    core.union(astray).intersection(allowed).padded(0.04)
}

/// The true positions, with gaps where rows are missing.
pub(crate) fn true_path<D: Dimensions>(axes: [usize; 2], truth: &[TruePose<D>]) -> Vec<[f64; 2]> {
    broken(&truth.iter().map(|row| (row.t_s, along(axes, &row.position))).collect::<Vec<_>>())
}

/// A curve through positions at some times, s, in order, with gaps where rows are missing.
fn broken(rows: &[(f64, [f64; 2])]) -> Vec<[f64; 2]> {
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

/// A curve through the estimated moving features of every scan, by label, with gaps where one is not reported; and the features
/// reported for a single scan only, which the curve does not show.
pub(crate) fn estimated_tracks<D: Dimensions>(axes: [usize; 2], record: &Record<D>) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let mut tracks: BTreeMap<u32, Vec<(usize, [f64; 2])>> = BTreeMap::new();
    for (scan, row) in record.scans.iter().enumerate() {
        for feature in &row.moving {
            tracks.entry(feature.id).or_default().push((scan, along(axes, &feature.position)));
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

/// A curve through the tracks of all moving landmarks, with gaps between them and where rows are missing.
pub(crate) fn moving_tracks<D: Dimensions>(axes: [usize; 2], moving: &[MovingLandmark<D>]) -> Vec<[f64; 2]> {
    let mut rows: Vec<&MovingLandmark<D>> = moving.iter().collect();
    // A stable sort: rows of one landmark remain in order of time.
    rows.sort_by_key(|row| row.subject);
    let mut path = Vec::with_capacity(rows.len());
    for track in rows.chunk_by(|before, after| before.subject == after.subject) {
        if !path.is_empty() {
            path.push(BREAK);
        }
        path.extend(broken(&track.iter().map(|row| (row.t_s, along(axes, &row.position))).collect::<Vec<_>>()));
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_log::dimensions::Planar;

    const PLAN: [usize; 2] = [0, 1];

    #[test]
    fn the_curve_of_the_truth_has_gaps_where_rows_are_missing() {
        let rows: Vec<TruePose> = [0.0, 0.2, 0.4, 0.6, 5.0, 5.2]
            .map(|t_s| TruePose { t_s, position: [t_s, 0.0], heading_rad: None })
            .to_vec();
        let path = true_path(PLAN, &rows);
        assert_eq!(path.len(), 7);
        assert!(path[4][0].is_nan());
        assert!(true_path(PLAN, &rows[..0]).is_empty());
        assert_eq!(true_path(PLAN, &rows[..1]).len(), 1);
    }

    #[test]
    fn estimated_tracks_have_gaps_where_a_feature_is_not_reported() {
        let feature = |id, x| scphd_score::record::MovingFeature::<Planar> {
            id,
            weight: 1.0,
            position: [x, 0.0],
            velocity: [0.0; 2],
            covariance: [[0.0; 2]; 2],
        };
        let scan =
            |moving| scphd_score::record::ScanRecord { moving, ..scphd_score::record::ScanRecord::at(0.0, [0.0; 3]) };
        let scans = vec![
            scan(vec![feature(7, 1.0), feature(2, 5.0)]),
            scan(vec![feature(7, 2.0)]),
            scan(vec![]),
            scan(vec![feature(7, 4.0)]),
        ];
        let (path, lone) = estimated_tracks(PLAN, &Record { scans, map: vec![] });
        assert_eq!(path[..2], [[1.0, 0.0], [2.0, 0.0]]);
        assert!(path.len() == 3 && path[2][0].is_nan());
        assert_eq!(lone, [[5.0, 0.0], [4.0, 0.0]]);
    }

    #[test]
    fn tracks_are_separate() {
        let row = |subject, t_s| MovingLandmark { subject, t_s, position: [t_s, subject as f64] };
        let path = moving_tracks::<Planar>(PLAN, &[row(2, 0.0), row(1, 0.0), row(2, 1.0), row(1, 1.0)]);
        assert_eq!(path[..2], [[0.0, 1.0], [1.0, 1.0]]);
        assert!(path[2][0].is_nan());
        assert_eq!(path[3..], [[0.0, 2.0], [1.0, 2.0]]);
        let gap = moving_tracks::<Planar>(PLAN, &[0.0, 1.0, 2.0, 9.0, 10.0].map(|t_s| row(1, t_s)));
        assert!(gap.len() == 6 && gap[3][0].is_nan(), "{gap:?}");
    }
}
