//! True tracks of moving landmarks, with interpolation.

use crate::dimensions::{Coordinates, Dimensions, Planar};
use crate::log::MovingLandmark;
use std::collections::BTreeMap;

/// Greatest interval between two rows of a track for interpolation, s. Over a longer one it may have turned.
pub const MAX_GAP_S: f64 = 1.0;

/// The tracks of all moving landmarks.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracks<D: Dimensions = Planar> {
    /// Time (s) and position (m) of the rows of each subject, in order of time.
    rows: BTreeMap<i64, Vec<(f64, D::Position)>>,
}

impl<D: Dimensions> Tracks<D> {
    /// The tracks in the rows of a log, in any order.
    pub fn new(moving: &[MovingLandmark<D>]) -> Self {
        let mut rows: BTreeMap<i64, Vec<(f64, D::Position)>> = BTreeMap::new();
        for row in moving {
            rows.entry(row.subject).or_default().push((row.t_s, row.position));
        }
        for track in rows.values_mut() {
            track.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        Self { rows }
    }

    /// Subject and position (m) of every landmark with a track at `t_s`, interpolated linearly between two rows at most
    /// [`MAX_GAP_S`] apart.
    pub fn at(&self, t_s: f64) -> impl Iterator<Item = (i64, D::Position)> {
        self.rows.iter().filter_map(move |(&subject, track)| Some((subject, position(track, t_s)?)))
    }
}

fn position<P: Coordinates>(track: &[(f64, P)], t_s: f64) -> Option<P> {
    let after = track.partition_point(|row| row.0 <= t_s);
    let &(before_s, before) = track.get(after.checked_sub(1)?)?;
    if before_s == t_s {
        return Some(before);
    }
    let &(next_s, next) = track.get(after)?;
    let gap_s = next_s - before_s;
    let f = (t_s - before_s) / gap_s;
    let (before, next) = (before.as_ref(), next.as_ref());
    (gap_s <= MAX_GAP_S).then(|| P::with(|k| before[k] + f * (next[k] - before[k])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_rows_and_none_in_gaps() {
        let row = |subject, t_s, x: f64| MovingLandmark { subject, t_s, position: [x, -x] };
        let tracks: Tracks = Tracks::new(&[row(7, 1.0, 4.0), row(2, 0.0, 0.0), row(7, 0.0, 0.0), row(7, 2.5, 9.0)]);
        let at = |t_s| tracks.at(t_s).collect::<Vec<_>>();
        assert_eq!(at(0.0), [(2, [0.0, 0.0]), (7, [0.0, 0.0])]);
        assert_eq!(at(0.25), [(7, [1.0, -1.0])]);
        assert_eq!(at(1.0), [(7, [4.0, -4.0])]);
        assert!(at(1.1).is_empty(), "a gap of 1.5 s");
        assert_eq!(at(2.5), [(7, [9.0, -9.0])]);
        assert!(at(2.6).is_empty() && at(-0.1).is_empty());
    }
}
