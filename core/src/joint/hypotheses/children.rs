//! The likeliest children of all hypotheses at one measurement.

use super::MOST;
use super::best::Best;
use super::causes::Cause;
use crate::{LnSum, Real};

/// A hypothesis with a cause of the measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Child<T> {
    /// Place of its parent, later its own.
    pub(super) place: usize,
    pub(super) cause: Cause<T>,
    /// Whether it was joined with a likelier child.
    pub(super) joined: bool,
}

impl<T: Real> Child<T> {
    pub(super) fn new(place: usize, cause: Cause<T>) -> Self {
        Self { place, cause, joined: false }
    }
}

/// The likeliest children with ln of their weights, in descending order.
pub(super) struct Children<T> {
    list: Best<Child<T>, T, MOST>,
    /// The greatest ln weight of the children for which there was no room.
    ln_left_out: T,
}

impl<T: Real> Children<T> {
    /// An empty list for at most `most` children.
    pub(super) fn new(most: usize) -> Self {
        Self { list: Best::new(most, Child::new(0, Cause::NEW)), ln_left_out: T::NEG_INFINITY }
    }

    pub(super) fn add(&mut self, child: Child<T>, ln_weight: T) {
        if let Some(ln) = self.list.add(child, ln_weight) {
            self.ln_left_out = self.ln_left_out.at_least(ln);
        }
    }

    /// Drops the children with less than this ratio of the weight of the likeliest. Returns whether there was no room for
    /// a child above it.
    pub(super) fn prune(&mut self, least_ratio: T) -> bool {
        let Some(&(_, ln_likeliest)) = self.all().first() else { return false };
        let least = ln_likeliest + least_ratio.ln();
        self.list.shorten(self.all().iter().take_while(|&&(_, ln_weight)| ln_weight >= least).count());
        self.ln_left_out >= least && self.ln_left_out > T::NEG_INFINITY
    }

    /// Joins a child with another one, which gets its weight in addition.
    pub(super) fn join(&mut self, number: usize, other: usize) {
        let children = self.list.all_mut();
        let Some((child, ln_weight)) = children.get_mut(number) else { return };
        child.joined = true;
        let ln_weight = *ln_weight;
        if let Some((_, of_other)) = children.get_mut(other) {
            let mut sum = LnSum::of(*of_other);
            sum.add(ln_weight);
            *of_other = sum.ln();
        }
    }

    pub(super) fn all(&self) -> &[(Child<T>, T)] {
        self.list.all()
    }

    pub(super) fn all_mut(&mut self) -> impl Iterator<Item = &mut Child<T>> {
        self.list.all_mut().iter_mut().map(|(child, _)| child)
    }
}
