//! The poses from which the vehicle has scanned since the search began.

use crate::{PlanarPose, Pose, Real};

/// Places that are remembered.
pub(super) const VIEWS: usize = 12;
/// A vehicle that has turned by more looks elsewhere, rad.
const TURN_RAD: f64 = 0.4;

/// A place from where some scans were made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View<T> {
    pub(super) pose: PlanarPose<T>,
    pub(super) scans: T,
}

/// The places, in the order of time.
#[derive(Debug)]
pub(super) struct Views<T> {
    of: [View<T>; VIEWS],
    len: usize,
    /// How far apart they are, m, and by how much of `TURN_RAD`.
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

    /// None, and such a distance between those to come.
    pub(super) fn clear(&mut self, spacing_m: T) {
        (self.len, self.spacing_m, self.turns) = (0, spacing_m, T::ONE);
    }

    pub(super) fn all(&self) -> &[View<T>] {
        self.of.get(..self.len).unwrap_or(&[])
    }

    /// One scan from there. Where there is no room, every other place is forgotten and the rest stand farther apart: then fewer
    /// landmarks are missed, and the map is believed less.
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
