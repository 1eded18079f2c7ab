//! The archive of distant features, and the data of an archived feature. The window is the map of the state, with the
//! features near the vehicle.

use super::existence::Existence;
use crate::numerics::range::is_within_range;
use crate::{Linear, Matrix, Pose, PositionOf, Real, ScalarOf, Symmetric, TangentOf, Vector, Zero};

/// Maximum number of features of a submap. They are archived together.
pub(super) const SUBMAP_LEN: usize = 8;

/// Maximum number of anchors of a submap: landmarks of the window on which its distribution is conditioned.
pub(super) const ANCHORS: usize = 8;

/// An archive of up to `CAPACITY` distant features, for a [`JointSlam`](super::JointSlam) whose map has more features
/// than its state can store: [`with_archive`](super::JointSlam::with_archive).
///
/// A feature in the plane takes 344 bytes in single precision. The archive is meant to be a `static`: a new one is all zero.
#[derive(Debug)]
pub struct JointArchive<P: Pose, const CAPACITY: usize> {
    index: Index,
    entries: [Entry<P>; CAPACITY],
}

/// The data of an archive other than its features.
#[derive(Debug, Clone, Copy)]
pub struct Index {
    /// Number of archived features.
    pub(super) len: usize,
    /// Identifier of the next submap.
    pub(super) next_submap: u32,
    /// Identifier of the submap that was last proposed for re-activation.
    pub(super) tried: u32,
    /// Time since the reset, µs.
    pub(super) clock_us: u64,
}

/// An archived feature, given the anchors s of its submap: m = mean + Σ_k G_k (s_k − s̄_k) + A u + e, with u ~ N(0, I)
/// common to all features of the submap, and e ~ N(0, R) of this feature alone.
#[derive(Debug, Clone, Copy)]
pub struct Entry<P: Pose> {
    pub(super) label: u32,
    pub(super) submap: u32,
    /// Mean of the position when the feature was archived, m.
    pub(super) mean: PositionOf<P>,
    /// A and R of the covariance at that time, without conditioning on the anchors.
    pub(super) alone: Split<P>,
    /// Number of anchors of the submap.
    pub(super) anchored: usize,
    /// The anchors, of which the first `anchored` are valid.
    pub(super) anchors: [Anchor<P>; ANCHORS],
    /// A and R of the covariance given the anchors. They equal `alone` if there are no anchors.
    pub(super) given: Split<P>,
    pub(super) existence: Existence<ScalarOf<P>>,
    pub(super) detections: ScalarOf<P>,
    /// Time at which the feature was archived, µs since the reset.
    pub(super) since_us: u64,
}

/// The covariance of the features of a submap: A_i A_jᵀ for the features i and j, plus R_i if i = j.
#[derive(Debug, Clone, Copy)]
pub struct Split<P: Pose> {
    /// A: the part that is correlated with the other features of the submap.
    pub(super) common: Linear<PositionOf<P>, TangentOf<P>>,
    /// R: the part of this feature alone.
    pub(super) own: Symmetric<PositionOf<P>>,
}

/// A landmark of the window on which the distributions of submaps are conditioned. It is archived itself only if no
/// other landmark can be archived.
#[derive(Debug, Clone, Copy)]
pub struct Anchor<P: Pose> {
    pub(super) label: u32,
    /// s̄: mean of its position when the submap was archived, m.
    pub(super) mean: PositionOf<P>,
    /// G: gain from the displacement of the anchor to that of the feature.
    pub(super) gain: Linear<PositionOf<P>, PositionOf<P>>,
}

/// A borrowed archive of any capacity.
#[derive(Debug)]
pub struct ArchiveView<'s, P: Pose> {
    pub(super) index: &'s mut Index,
    pub(super) entries: &'s mut [Entry<P>],
    /// Greatest horizontal range of all detectors, m.
    pub(super) reach_m: ScalarOf<P>,
}

mod sealed {
    pub trait Sealed {}
}

/// Whether a joint filter archives distant features: [`NoArchive`] or [`Archived`].
pub trait Archive<P: Pose>: sealed::Sealed {
    /// The archive, mutable, if there is one.
    #[doc(hidden)]
    fn view(&mut self) -> Option<ArchiveView<'_, P>>;
    /// The archived features.
    #[doc(hidden)]
    fn kept(&self) -> &[Entry<P>];
    /// The data other than the features, if there is an archive.
    #[doc(hidden)]
    fn index(&self) -> Option<&Index>;
}

/// No archive: if the state is full, the least likely feature is discarded.
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
    /// An empty archive.
    pub const fn new() -> Self {
        Self { index: Index { len: 0, next_submap: 0, tried: 0, clock_us: 0 }, entries: [Entry::ZERO; CAPACITY] }
    }

    pub(super) fn archived(&mut self, reach_m: ScalarOf<P>) -> Archived<'_, P> {
        Archived(ArchiveView { index: &mut self.index, entries: &mut self.entries, reach_m })
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

    /// The anchors of its submap.
    pub(super) fn anchors(&self) -> &[Anchor<P>] {
        self.anchors.get(..self.anchored).unwrap_or(&[])
    }

    /// The covariance of the position when the feature was archived.
    pub(super) fn covariance(&self) -> Symmetric<PositionOf<P>> {
        Symmetric::from_fn(|row, column| self.alone.with(&self.alone, true, row, column))
    }

    /// The trace of that covariance.
    fn variance(&self) -> T {
        let covariance = self.covariance();
        (0..PositionOf::<P>::DIMENSION).fold(T::ZERO, |sum, k| sum + covariance.get(k, k))
    }

    /// Whether all numbers are valid, so that a filter can have stored them.
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

    /// Element (`row`, `column`) of the covariance of two features of a submap; `is_same` if both are the same feature.
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
    /// Removes all features.
    pub(super) fn clear(&mut self) {
        *self.index = Index { len: 0, next_submap: 0, tried: 0, clock_us: 0 };
    }

    /// Advances the clock by the time since the last scan. An invalid number of features is limited to the capacity.
    pub(super) fn pass(&mut self, waited_s: T) {
        self.index.len = self.index.len.min(self.entries.len());
        // NaN and negative times convert to zero.
        self.index.clock_us = self.index.clock_us.saturating_add((waited_s.to_f64() * 1e6) as u64);
    }

    /// Adds a feature. In a full archive it replaces the least certain feature, or is discarded if no feature is less
    /// certain. Returns the number of features that were lost.
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

    /// Removes a feature with invalid numbers; the last feature gets its index. Returns whether it was removed.
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

    /// Removes the features of a submap; the last features get their indices.
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
