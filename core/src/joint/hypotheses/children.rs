//! The likeliest children of all hypotheses at one measurement.

use super::MOST;
use super::causes::Cause;
use crate::Real;

/// A hypothesis with a cause of the measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Child<T> {
    /// ln of its weight.
    pub(super) ln_weight: T,
    /// Place of its parent, later its own.
    pub(super) place: usize,
    pub(super) cause: Cause<T>,
}

/// The likeliest children, in descending order of weight.
pub(super) struct Children<T> {
    list: [Child<T>; MOST],
    len: usize,
    most: usize,
    /// The greatest ln weight of the children for which there was no room.
    ln_left_out: T,
}

impl<T: Real> Children<T> {
    /// An empty list for at most `most` children.
    pub(super) fn new(most: usize) -> Self {
        let none = Child { ln_weight: T::NEG_INFINITY, place: 0, cause: Cause::NEW };
        Self { list: [none; MOST], len: 0, most: most.min(MOST), ln_left_out: T::NEG_INFINITY }
    }

    pub(super) fn add(&mut self, child: Child<T>) {
        // Written so that NaN is left out.
        if !(child.ln_weight > T::NEG_INFINITY && child.ln_weight < T::INFINITY) {
            return;
        }
        let place = self.all().iter().position(|other| child.ln_weight > other.ln_weight).unwrap_or(self.len);
        if self.len == self.most {
            let last = self.all().last().map_or(child.ln_weight, |last| last.ln_weight.at_most(child.ln_weight));
            self.ln_left_out = self.ln_left_out.at_least(last);
        }
        self.len = (self.len + 1).min(self.most);
        if let Some(behind) = self.list.get_mut(place..self.len)
            && !behind.is_empty()
        {
            behind.rotate_right(1);
            if let Some(slot) = behind.first_mut() {
                *slot = child;
            }
        }
    }

    /// Drops the children with less than this ratio of the weight of the likeliest. Returns whether there was no room for
    /// a child above it.
    pub(super) fn prune(&mut self, least_ratio: T) -> bool {
        let Some(likeliest) = self.all().first() else { return false };
        let least = likeliest.ln_weight + least_ratio.ln();
        self.len = self.all().iter().take_while(|child| child.ln_weight >= least).count();
        self.ln_left_out >= least && self.ln_left_out > T::NEG_INFINITY
    }

    pub(super) fn all(&self) -> &[Child<T>] {
        self.list.get(..self.len).unwrap_or(&[])
    }

    pub(super) fn all_mut(&mut self) -> &mut [Child<T>] {
        self.list.get_mut(..self.len).unwrap_or(&mut [])
    }
}
