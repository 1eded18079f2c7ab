//! The features that are beyond the window: what is kept of each, and where.

use super::existence::Existence;
use crate::numerics::range::is_within_range;
use crate::{Linear, Matrix, Pose, PositionOf, Real, ScalarOf, Symmetric, TangentOf, Vector, Zero};

/// Features that go into the archive together, at most.
pub(super) const SUBMAP_LEN: usize = 8;

/// Landmarks of the window that a page is conditioned on, at most.
pub(super) const ANCHORS: usize = 8;

/// Up to `CAPACITY` features of a joint map that are far from the vehicle, for a [`JointSlam`](super::JointSlam) over a map that is larger
/// than its room: [`with_archive`](super::JointSlam::with_archive).
///
/// A feature in the plane takes 344 bytes in single precision. Meant to be a `static`: a fresh one is all zero.
#[derive(Debug)]
pub struct JointArchive<P: Pose, const CAPACITY: usize> {
    index: Index,
    entries: [Entry<P>; CAPACITY],
}

/// What an archive knows beside its features.
#[derive(Debug, Clone, Copy)]
pub struct Index {
    /// Features there are.
    pub(super) len: usize,
    /// The name of the next page.
    pub(super) next_submap: u32,
    /// The page that was looked for last.
    pub(super) tried: u32,
    /// Time that has passed since the reset, µs.
    pub(super) clock_us: u64,
}

/// An archived feature, given the anchors s of its page: m = mean + Σ_k G_k (s_k − s̄_k) + A u + e, with u ~ N(0, I) shared by all of its page, and
/// e ~ N(0, R) its own.
#[derive(Debug, Clone, Copy)]
pub struct Entry<P: Pose> {
    pub(super) label: u32,
    pub(super) submap: u32,
    /// Where it was when it left the window.
    pub(super) mean: PositionOf<P>,
    /// Its covariance at that time, as A and R without the anchors.
    pub(super) alone: Split<P>,
    /// Anchors that its page has.
    pub(super) anchored: usize,
    /// Those of them that there are.
    pub(super) anchors: [Anchor<P>; ANCHORS],
    /// The same given the anchors; without anchors as it was.
    pub(super) given: Split<P>,
    pub(super) existence: Existence<ScalarOf<P>>,
    pub(super) detections: ScalarOf<P>,
    /// When it came.
    pub(super) since_us: u64,
}

/// A covariance within a page: A_i A_jᵀ of two features, and R_i more of one with itself.
#[derive(Debug, Clone, Copy)]
pub struct Split<P: Pose> {
    /// A.
    pub(super) common: Linear<PositionOf<P>, TangentOf<P>>,
    /// R.
    pub(super) own: Symmetric<PositionOf<P>>,
}

/// A landmark that stays in the window as long as the archive has pages that are conditioned on it.
#[derive(Debug, Clone, Copy)]
pub struct Anchor<P: Pose> {
    pub(super) label: u32,
    /// s̄, where it was when the page left the window.
    pub(super) mean: PositionOf<P>,
    /// G.
    pub(super) gain: Linear<PositionOf<P>, PositionOf<P>>,
}

/// A borrowed archive of whatever capacity.
#[derive(Debug)]
pub struct ArchiveView<'s, P: Pose> {
    pub(super) index: &'s mut Index,
    pub(super) entries: &'s mut [Entry<P>],
    /// How far the vehicle sees, m.
    pub(super) reach_m: ScalarOf<P>,
}

mod sealed {
    pub trait Sealed {}
}

/// Where a joint filter puts the features that are far away: [`NoArchive`], or an [`Archived`].
pub trait Archive<P: Pose>: sealed::Sealed {
    /// To be changed, if there is one.
    #[doc(hidden)]
    fn view(&mut self) -> Option<ArchiveView<'_, P>>;
    /// The features that are in it.
    #[doc(hidden)]
    fn kept(&self) -> &[Entry<P>];
    /// What it knows beside them, if there is one.
    #[doc(hidden)]
    fn index(&self) -> Option<&Index>;
}

/// All features are in the window: what finds no room is lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoArchive;

/// A borrowed [`JointArchive`].
#[derive(Debug)]
pub struct Archived<'s, P: Pose>(ArchiveView<'s, P>);

impl sealed::Sealed for NoArchive {}

impl<P: Pose> Archive<P> for NoArchive {
    fn view(&mut self) -> Option<ArchiveView<'_, P>> {
        None
    }

    fn kept(&self) -> &[Entry<P>] {
        &[]
    }

    fn index(&self) -> Option<&Index> {
        None
    }
}

impl<P: Pose> sealed::Sealed for Archived<'_, P> {}

impl<P: Pose> Archive<P> for Archived<'_, P> {
    fn view(&mut self) -> Option<ArchiveView<'_, P>> {
        let Self(ArchiveView { index, entries, reach_m }) = self;
        Some(ArchiveView { index, entries, reach_m: *reach_m })
    }

    fn kept(&self) -> &[Entry<P>] {
        self.0.entries.get(..self.0.index.len).unwrap_or(&[])
    }

    fn index(&self) -> Option<&Index> {
        Some(self.0.index)
    }
}

impl<P: Pose, const CAPACITY: usize> JointArchive<P, CAPACITY> {
    /// An empty one.
    #[must_use]
    pub const fn new() -> Self {
        Self { index: Index { len: 0, next_submap: 0, tried: 0, clock_us: 0 }, entries: [Entry::ZERO; CAPACITY] }
    }

    pub(super) fn archived(&mut self, reach_m: ScalarOf<P>) -> Archived<'_, P> {
        Archived(ArchiveView { index: &mut self.index, entries: &mut self.entries, reach_m })
    }
}

impl<P: Pose, const CAPACITY: usize> Default for JointArchive<P, CAPACITY> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, P: Pose<Scalar = T>> Entry<P> {
    pub(super) const ZERO: Self = Self {
        label: 0,
        submap: 0,
        mean: <PositionOf<P> as Zero>::ZERO,
        alone: Split::ZERO,
        anchored: 0,
        anchors: [Anchor { label: 0, mean: <PositionOf<P> as Zero>::ZERO, gain: Zero::ZERO }; ANCHORS],
        given: Split::ZERO,
        existence: Existence::NONE,
        detections: T::ZERO,
        since_us: 0,
    };

    /// The anchors of its page.
    pub(super) fn anchors(&self) -> &[Anchor<P>] {
        self.anchors.get(..self.anchored).unwrap_or(&[])
    }

    /// Its covariance when it left the window.
    pub(super) fn covariance(&self) -> Symmetric<PositionOf<P>> {
        Symmetric::from_fn(|row, column| self.alone.with(&self.alone, true, row, column))
    }

    /// The trace of that.
    fn variance(&self) -> T {
        let covariance = self.covariance();
        (0..PositionOf::<P>::DIMENSION).fold(T::ZERO, |sum, k| sum + covariance.get(k, k))
    }

    /// Whether it is what a filter may have put there.
    pub(super) fn is_sound(&self) -> bool {
        let Existence { visible, occluded, absent } = self.existence;
        let numbers = [visible, occluded, absent, self.detections];
        is_within_range(&self.mean)
            && self.alone.is_finite()
            && self.given.is_finite()
            && self.anchored <= ANCHORS
            && self.anchors().iter().all(Anchor::is_sound)
            && numbers.iter().all(|&number| number >= T::ZERO && number.is_finite())
    }
}

impl<T: Real, P: Pose<Scalar = T>> Split<P> {
    pub(super) const ZERO: Self = Self { common: Zero::ZERO, own: Symmetric::ZERO };

    /// An element of the block of two features of a page.
    pub(super) fn with(&self, other: &Self, is_same: bool, row: usize, column: usize) -> T {
        let shared = (0..TangentOf::<P>::DIMENSION)
            .fold(T::ZERO, |sum, k| sum + self.common.at(row, k) * other.common.at(column, k));
        shared + if is_same { self.own.get(row, column) } else { T::ZERO }
    }

    fn is_finite(&self) -> bool {
        self.common.as_slice().iter().all(|x| x.is_finite()) && self.own.is_finite()
    }
}

impl<T: Real, P: Pose<Scalar = T>> Anchor<P> {
    fn is_sound(&self) -> bool {
        is_within_range(&self.mean) && self.gain.as_slice().iter().all(|x| x.is_finite())
    }
}

impl<T: Real, P: Pose<Scalar = T>> ArchiveView<'_, P> {
    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        *self.index = Index { len: 0, next_submap: 0, tried: 0, clock_us: 0 };
    }

    /// Lets time pass. A count of features that no room is for is taken as what there is room for.
    pub(super) fn pass(&mut self, waited_s: T) {
        self.index.len = self.index.len.min(self.entries.len());
        // A number of microseconds that is no number, or negative, is none.
        self.index.clock_us = self.index.clock_us.saturating_add((waited_s.to_f64() * 1e6) as u64);
    }

    /// Puts a feature there. Where there is no room, the least certain goes, or this one does; how many went.
    pub(super) fn put(&mut self, entry: Entry<P>) -> usize {
        if let Some(slot) = self.entries.get_mut(self.index.len) {
            *slot = entry;
            self.index.len += 1;
            return 0;
        }
        let certainty = |entry: &Entry<P>| (entry.existence.total(), -entry.variance());
        let mut least = (certainty(&entry), None);
        for (index, entry) in self.entries.iter().enumerate() {
            let of = certainty(entry);
            if of < least.0 {
                least = (of, Some(index));
            }
        }
        if let (_, Some(index)) = least
            && let Some(slot) = self.entries.get_mut(index)
        {
            *slot = entry;
        }
        1
    }

    /// Drops a feature if it cannot be: the last one takes its place. Whether it did.
    pub(super) fn drop_unsound(&mut self, index: usize) -> bool {
        let known = self.entries.get(..self.index.len).unwrap_or(&[]);
        let (Some(entry), Some(&last)) = (known.get(index), known.last()) else { return false };
        if entry.is_sound() && entry.given.own.factor().is_some() && entry.alone.own.factor().is_some() {
            return false;
        }
        self.index.len -= 1;
        if let Some(slot) = self.entries.get_mut(index) {
            *slot = last;
        }
        true
    }

    /// Takes a page out; the last ones take their places.
    pub(super) fn take_submap(&mut self, submap: u32) {
        let mut at = 0;
        while at < self.index.len {
            if self.entries.get(at).is_some_and(|entry| entry.submap == submap) {
                self.index.len -= 1;
                if let Some(last) = self.entries.get(self.index.len).copied()
                    && let Some(slot) = self.entries.get_mut(at)
                {
                    *slot = last;
                }
            } else {
                at += 1;
            }
        }
    }
}
