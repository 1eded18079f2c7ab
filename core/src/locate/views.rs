//! The poses from which the vehicle has scanned since the search began.

use crate::{PlanarPose, Pose, Real};

/// Capacity for poses.
pub(super) const VIEWS: usize = 12;
/// A turn by more than this begins a new pose, rad.
const TURN_RAD: f64 = 0.4;

/// A pose with a number of scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View<T> {
    pub(super) pose: PlanarPose<T>,
    pub(super) scans: T,
}

/// The poses, in the order of time.
#[derive(Debug)]
pub(super) struct Views<T> {
    of: [View<T>; VIEWS],
    len: usize,
    /// Their spacing: in m, and in heading as a multiple of `TURN_RAD`.
    spacing_m: T,
    turns: T,
}

impl<T: Real> Views<T> {
    pub(super) const NONE: Self = Self {
        of: [View { pose: PlanarPose::ZERO, scans: T::ZERO }; VIEWS],
        len: 0,
        spacing_m: T::ZERO,
        turns: T::ZERO,
    };

    /// No poses, with this spacing for those to come.
    pub(super) fn clear(&mut self, spacing_m: T) {
        (self.len, self.spacing_m, self.turns) = (0, spacing_m, T::ONE);
    }

    pub(super) fn all(&self) -> &[View<T>] {
        self.of.get(..self.len).unwrap_or(&[])
    }

    /// Adds a scan. If the memory is full, every second pose is removed and the spacing doubled: fewer misses are then expected, so
    /// that the evidence is weaker.
    pub(super) fn add(&mut self, pose: &PlanarPose<T>) {
        let turn = T::from_f64(TURN_RAD) * self.turns;
        let last = self.len.checked_sub(1).and_then(|last| self.of.get_mut(last));
        if let Some(view) = last {
            let turned = crate::wrap(pose.heading_rad - view.pose.heading_rad).abs();
            if view.pose.distance_m(pose) < self.spacing_m && turned < turn {
                view.scans += T::ONE;
                return;
            }
        }
        if self.len == VIEWS {
            for kept in 0..VIEWS / 2 {
                if let Some(view) = self.of.get(2 * kept).copied()
                    && let Some(slot) = self.of.get_mut(kept)
                {
                    *slot = view;
                }
            }
            self.len = VIEWS / 2;
            self.spacing_m += self.spacing_m;
            self.turns += T::from_f64(0.5);
        }
        if let Some(slot) = self.of.get_mut(self.len) {
            *slot = View { pose: *pose, scans: T::ONE };
            self.len += 1;
        }
    }
}
