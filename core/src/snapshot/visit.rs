//! Visitors of a state: a digest, or a snapshot.

use crate::map::PageId;
use crate::numerics::fnv::Fnv;
use crate::{Pose, Real, Vector};

/// What walks through all that decides how a filter goes on, in one order.
///
/// A digest need not know how it is stored, as long as the numbers come in the same order; nor what shows in the next report alone.
/// A snapshot keeps that too: it comes by the methods that are named `beside`.
pub(crate) trait Visit {
    /// A count, a name, or the end of something.
    fn word(&mut self, word: u32);
    /// A number.
    fn scalar<T: Real>(&mut self, number: T);
    /// A pose: its coordinates, and what travels with them.
    fn pose<P: Pose>(&mut self, pose: &P);
    /// A word that no digest has.
    fn beside(&mut self, _word: u32) {}
    /// A number that no digest has.
    fn beside_scalar<T: Real>(&mut self, _number: T) {}
    /// What rounding took from x and y. A digest has it only where it is not zero, which it is unless steps are short.
    fn remainder<T: Real>(&mut self, remainder: &[T; 2]) {
        for &number in remainder {
            if number == T::ZERO { self.beside_scalar(number) } else { self.scalar(number) }
        }
    }
    /// A page of so many components, of features that move or stand still. Whether to walk through them.
    fn page(&mut self, _moves: bool, _id: PageId, _components: usize) -> bool {
        true
    }
}

/// What can be walked through.
pub(crate) trait Walk {
    /// Walks through all of it.
    fn walk(&self, visit: &mut impl Visit);
}

/// A digest includes the bits of every number and word.
impl Visit for Fnv {
    fn word(&mut self, word: u32) {
        self.take(word);
    }

    fn scalar<T: Real>(&mut self, number: T) {
        self.take_scalar(number);
    }

    fn pose<P: Pose>(&mut self, pose: &P) {
        pose.coordinates().as_slice().iter().for_each(|&coordinate| self.take_scalar(coordinate));
    }
}

/// A hash of all that a snapshot has.
pub(crate) struct Sealing(Fnv);

impl Sealing {
    /// Of nothing.
    pub(crate) const EMPTY: Self = Self(Fnv::EMPTY);

    /// A count, with all its bits.
    pub(crate) fn count(&mut self, count: usize) {
        let count = count as u64;
        self.0.take(count as u32);
        self.0.take((count >> 32) as u32);
    }

    /// Of all that was taken in.
    pub(crate) fn value(&self) -> u64 {
        self.0.value()
    }
}

impl Visit for Sealing {
    fn word(&mut self, word: u32) {
        self.0.take(word);
    }

    fn scalar<T: Real>(&mut self, number: T) {
        self.0.take_scalar(number);
    }

    fn pose<P: Pose>(&mut self, pose: &P) {
        pose.to_numbers(|number| self.scalar(number));
    }

    fn beside(&mut self, word: u32) {
        self.0.take(word);
    }

    fn beside_scalar<T: Real>(&mut self, number: T) {
        self.0.take_scalar(number);
    }
}
