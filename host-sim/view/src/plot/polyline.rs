//! A curve with thousands of points as a short SVG path near its frame.

use std::fmt::Write;

/// Points that differ by less than this from the last kept one in every coordinate are left out, px, because they are not
/// visible.
const RESOLUTION_PX: f64 = 0.25;

/// An axis-parallel rectangle in pixels, y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rect {
    pub fn width(self) -> f64 {
        self.right - self.left
    }

    pub fn height(self) -> f64 {
        self.bottom - self.top
    }

    /// Extended by `margin` px on every side.
    pub fn grown(self, margin: f64) -> Self {
        Self {
            left: self.left - margin,
            top: self.top - margin,
            right: self.right + margin,
            bottom: self.bottom + margin,
        }
    }

    /// Whether a point is inside, edges included.
    pub fn contains(self, [x, y]: [f64; 2]) -> bool {
        self.left <= x && x <= self.right && self.top <= y && y <= self.bottom
    }
}

/// A curve for drawing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Polyline {
    /// Path data of the lines; empty if there are none.
    pub path: String,
    /// Single points between gaps, which a path would not show.
    pub lone: Vec<[f64; 2]>,
}

/// Splits `points` (px) where they are not finite, thins them and cuts them at `frame`.
pub fn polyline(points: impl IntoIterator<Item = [f64; 2]>, frame: Rect) -> Polyline {
    let mut result = Polyline::default();
    for run in thinned_runs(points) {
        match run[..] {
            [point] if frame.contains(point) => result.lone.push(point),
            [_] => {}
            _ => append_run(&mut result.path, &run, frame),
        }
    }
    result
}

/// Sequences of finite points (px) without gaps, none empty, thinned; the ends of a sequence are kept.
pub fn thinned_runs<const N: usize>(points: impl IntoIterator<Item = [f64; N]>) -> Vec<Vec<[f64; N]>> {
    let mut runs = Vec::new();
    let mut run: Vec<[f64; N]> = Vec::new();
    let mut skipped = None;
    for point in points {
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            run.extend(skipped.take());
            if !run.is_empty() {
                runs.push(std::mem::take(&mut run));
            }
            continue;
        }
        match run.last() {
            Some(last) if near(last, &point) => {
                skipped = Some(point);
            }
            _ => {
                run.push(point);
                skipped = None;
            }
        }
    }
    run.extend(skipped);
    if !run.is_empty() {
        runs.push(run);
    }
    runs
}

/// Whether no coordinate differs visibly.
fn near<const N: usize>(a: &[f64; N], b: &[f64; N]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < RESOLUTION_PX)
}

/// Appends the parts of a sequence inside the frame.
fn append_run(path: &mut String, run: &[[f64; 2]], frame: Rect) {
    let mut pen = None;
    for pair in run.windows(2) {
        let Some((from, to)) = clipped(pair[0], pair[1], frame) else {
            pen = None;
            continue;
        };
        if pen != Some(from) {
            append(path, 'M', from);
        }
        append(path, 'L', to);
        pen = Some(to);
    }
}

/// Appends a command of path data with a resolution of 0.01 px.
pub fn append(path: &mut String, command: char, [x, y]: [f64; 2]) {
    // Writing to a String cannot fail.
    let _ = write!(path, "{command}{x:.2} {y:.2}");
}

/// The part of a segment inside the frame (Liang and Barsky, 1984); ends inside are not changed.
fn clipped(from: [f64; 2], to: [f64; 2], frame: Rect) -> Option<([f64; 2], [f64; 2])> {
    let delta = [to[0] - from[0], to[1] - from[1]];
    let mut enter = 0.0_f64;
    let mut leave = 1.0_f64;
    for (step, room) in [
        (-delta[0], from[0] - frame.left),
        (delta[0], frame.right - from[0]),
        (-delta[1], from[1] - frame.top),
        (delta[1], frame.bottom - from[1]),
    ] {
        if step == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if step < 0.0 {
            enter = enter.max(room / step);
        } else {
            leave = leave.min(room / step);
        }
    }
    if enter > leave {
        return None;
    }
    let at = |t: f64| [from[0] + t * delta[0], from[1] + t * delta[1]];
    let start = if enter > 0.0 { at(enter) } else { from };
    let end = if leave < 1.0 { at(leave) } else { to };
    Some((start, end))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Rect = Rect { left: 0.0, top: 0.0, right: 100.0, bottom: 50.0 };
    const BREAK: [f64; 2] = [f64::NAN, f64::NAN];

    #[test]
    fn gaps_and_single_points() {
        let line =
            polyline([[0.0, 0.0], [10.0, 10.0], BREAK, [20.0, 20.0], BREAK, BREAK, [5.0, 5.0], [6.0, 6.0]], FRAME);
        assert_eq!(line.path, "M0.00 0.00L10.00 10.00M5.00 5.00L6.00 6.00");
        assert_eq!(line.lone, [[20.0, 20.0]]);
    }

    #[test]
    fn curves_are_cut_at_the_frame() {
        let line = polyline([[50.0, 25.0], [150.0, 25.0], [150.0, 40.0], [50.0, 40.0]], FRAME);
        assert_eq!(line.path, "M50.00 25.00L100.00 25.00M100.00 40.00L50.00 40.00");
        let line = polyline([[-10.0, 25.0], [1e300, 25.0]], FRAME);
        assert_eq!(line.path, "M0.00 25.00L100.00 25.00");
        assert_eq!(polyline([[200.0, 0.0], [200.0, 50.0]], FRAME), Polyline::default());
        assert_eq!(polyline([[90.0, -40.0], [140.0, 10.0]], FRAME), Polyline::default());
    }

    #[test]
    fn points_are_thinned_to_visible_ones_with_both_ends() {
        let points = (0..=10_000).map(|i| [f64::from(i) * 0.001, 0.0]);
        let runs = thinned_runs(points);
        assert_eq!(runs.len(), 1);
        assert!(runs[0].len() < 60);
        assert_eq!(runs[0][0], [0.0, 0.0]);
        assert_eq!(*runs[0].last().unwrap(), [10.0, 0.0]);
    }
}
