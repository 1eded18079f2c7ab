//! Visitors of a state: a digest, or a snapshot.

use crate::map::PageId;
use crate::numerics::fnv::Fnv;
use crate::{Pose, Real, Vector};

/// A visitor of all data that determines how a filter continues, in a fixed order.
///
/// A digest depends only on the order of the numbers, not on their storage, and leaves out data that only the next report shows.
/// A snapshot contains that data too: `snapshot_word` and `snapshot_scalar` visit it.
pub(crate) trait Visit {
    /// A count, an identifier, or an end mark.
    fn word(&mut self, word: u32);
    /// A number.
    fn scalar<T: Real>(&mut self, number: T);
    /// A pose: its coordinates and its other data.
    fn pose<P: Pose>(&mut self, pose: &P);
    /// A word that is not part of a digest.
    fn snapshot_word(&mut self, _word: u32) {}
    /// A number that is not part of a digest.
    fn snapshot_scalar<T: Real>(&mut self, _number: T) {}
    /// The rounding errors of x and y. They are part of a digest only if they are not zero, which they are unless steps are short.
    fn remainder<T: Real>(&mut self, remainder: &[T; 2]) {
        for &number in remainder {
            if number == T::ZERO { self.snapshot_scalar(number) } else { self.scalar(number) }
        }
    }
    /// A page with this number of components, of moving or static features. Returns whether its components should be visited.
    fn page(&mut self, _moves: bool, _id: PageId, _components: usize) -> bool {
        true
    }
}

/// Data that can be visited.
pub(crate) trait Walk {
    /// Visits all data.
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

/// A hash of all data that a snapshot contains.
pub(crate) struct Sealing(Fnv);

impl Sealing {
    /// The hash of no data.
    pub(crate) const EMPTY: Self = Self(Fnv::EMPTY);

    /// Adds a count, with all its bits.
    pub(crate) fn count(&mut self, count: usize) {
        let count = count as u64;
        self.0.take(count as u32);
        self.0.take((count >> 32) as u32);
    }

    /// The hash of all data so far.
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

    fn snapshot_word(&mut self, word: u32) {
        self.0.take(word);
    }

    fn snapshot_scalar<T: Real>(&mut self, number: T) {
        self.0.take_scalar(number);
    }
}
