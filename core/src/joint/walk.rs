//! Traversal of all data of the joint filter that influences later results, and restoring it from a snapshot.

use super::archive::{Anchor, ArchiveView, Entry, Index, Split};
use super::covariance::used;
use super::existence::Existence;
use super::landmark::Landmark;
use super::movers::{Common, Mover, Movers, Tracks};
use super::state::{Header, Memory};
use crate::numerics::range::is_within_range;
use crate::report::watch::Watch;
use crate::snapshot::read::Reader;
use crate::snapshot::visit::Visit;
use crate::{Component, Flaw, Linear, Matrix, Pose, PositionOf, Real, ScalarOf, Symmetric, Vector, Zero};

/// One joint Gaussian with its map, without the working memory.
#[derive(Clone, Copy)]
pub(super) struct Estimate<'e, P: Pose> {
    pub(super) header: &'e Header<P>,
    pub(super) landmarks: &'e [Landmark<PositionOf<P>>],
    /// The joint covariance.
    pub(super) numbers: &'e [ScalarOf<P>],
}

impl<T: Real, P: Pose<Scalar = T>> Estimate<'_, P> {
    /// The joint covariance of so many features.
    pub(super) fn used(&self, features: usize) -> &[T] {
        used::<P>(self.numbers, features)
    }

    /// Visits the state.
    pub(super) fn walk(&self, visit: &mut impl Visit) {
        let Self { header, landmarks, .. } = self;
        header.walk(visit);
        for landmark in landmarks.iter().take(header.len) {
            visit.word(landmark.label);
            landmark.mean.as_slice().iter().for_each(|&coordinate| visit.scalar(coordinate));
            let Existence { visible, occluded, absent } = landmark.existence;
            [visible, occluded, absent, landmark.detections].into_iter().for_each(|number| visit.scalar(number));
            landmark.moved.as_slice().iter().for_each(|&by| visit.snapshot_scalar(by));
        }
        self.used(header.len).iter().for_each(|&number| visit.scalar(number));
    }

    /// Checks all numbers of the state, at a cost that is linear in its size. The error is the first flaw that is found.
    pub(super) fn audit(&self) -> Result<(), Flaw> {
        let Self { header, landmarks, .. } = self;
        let landmarks = landmarks.get(..header.len).ok_or(Flaw::Cursor)?;
        if !(header.waited_s >= T::ZERO && header.waited_s.is_finite()) {
            return Err(Flaw::Cursor);
        }
        let finite = |numbers: &[T]| numbers.iter().all(|number| number.is_finite());
        let pose = header.pose.is_finite()
            && is_within_range(&header.pose.coordinates())
            && finite(&header.moved)
            && finite(header.motion_noise.as_lower());
        if !(pose && finite(self.used(0))) {
            return Err(Flaw::Pose);
        }
        if landmarks.iter().all(Landmark::may_be) && finite(self.used(header.len)) {
            Ok(())
        } else {
            Err(Flaw::Component)
        }
    }
}

impl<T: Real, P: Pose<Scalar = T>> Header<P> {
    /// Visits the pose, and all other data of the header.
    pub(super) fn walk(&self, visit: &mut impl Visit) {
        visit.word(u32::from(self.started));
        visit.pose(&self.pose);
        visit.remainder(&self.remainder);
        visit.scalar(self.waited_s);
        visit.word(self.next_label);
        visit.snapshot_word(u32::try_from(self.refused).unwrap_or(u32::MAX));
        self.watch.walk(visit);
        self.moved.iter().chain(self.motion_noise.as_lower()).for_each(|&number| visit.snapshot_scalar(number));
    }
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> Memory<'_, P, Z> {
    pub(super) fn estimate(&self) -> Estimate<'_, P> {
        let Self { header, landmarks, joint, .. } = self;
        Estimate { header, landmarks, numbers: joint.numbers }
    }

    /// Reads the state from a snapshot with this number of features. The caller must audit the result.
    pub(super) fn fill<S, E>(&mut self, features: usize, from: &mut Reader<'_, S, E>)
    where
        S: FnMut(usize, &mut [u8]) -> Result<(), E>,
    {
        let Self { header, landmarks, joint, .. } = self;
        header.len = features.min(landmarks.len());
        header.started = from.word() != 0;
        header.pose = from.pose();
        header.remainder = core::array::from_fn(|_| from.scalar());
        header.waited_s = from.scalar();
        header.next_label = from.word();
        header.refused = from.word() as usize;
        header.watch = Watch::next(from);
        header.moved = core::array::from_fn(|_| from.scalar());
        header.motion_noise = Symmetric::from_fn(|_, _| from.scalar());
        for landmark in landmarks.iter_mut().take(header.len) {
            let (label, mean) = (from.word(), from.vector());
            let existence = Existence { visible: from.scalar(), occluded: from.scalar(), absent: from.scalar() };
            *landmark =
                Landmark { label, mean, existence, detections: from.scalar(), moved: from.vector(), ..Landmark::ZERO };
        }
        joint.used_mut(header.len).iter_mut().for_each(|number| *number = from.scalar());
    }
}

impl<T: Real, D: Vector<Scalar = T>> Landmark<D> {
    /// Whether all numbers are valid.
    pub(super) fn may_be(&self) -> bool {
        let Existence { visible, occluded, absent } = self.existence;
        let numbers = [visible, occluded, absent, self.detections];
        is_within_range(&self.mean)
            && self.moved.as_slice().iter().all(|by| by.is_finite())
            && numbers.iter().all(|&number| number >= T::ZERO && number.is_finite())
    }
}

/// Visits an archive.
pub(super) fn walk_archive<P: Pose>(entries: &[Entry<P>], index: &Index, visit: &mut impl Visit) {
    visit.word(index.next_submap);
    visit.word(index.tried);
    halves(index.clock_us).into_iter().for_each(|half| visit.word(half));
    for entry in entries {
        visit.word(entry.label);
        visit.word(entry.submap);
        halves(entry.since_us).into_iter().for_each(|half| visit.word(half));
        entry.mean.as_slice().iter().for_each(|&coordinate| visit.scalar(coordinate));
        for Split { common, own } in [&entry.alone, &entry.given] {
            common.as_slice().iter().chain(own.as_lower()).for_each(|&number| visit.scalar(number));
        }
        visit.word(entry.anchored as u32);
        for Anchor { label, mean, gain } in entry.anchors() {
            visit.word(*label);
            mean.as_slice().iter().chain(gain.as_slice()).for_each(|&number| visit.scalar(number));
        }
        let Existence { visible, occluded, absent } = entry.existence;
        [visible, occluded, absent, entry.detections].into_iter().for_each(|number| visit.scalar(number));
    }
}

/// Reads an archive from a snapshot with this number of features. The caller must audit the result.
pub(super) fn fill_archive<T: Real, P: Pose<Scalar = T>, S: FnMut(usize, &mut [u8]) -> Result<(), E>, E>(
    view: &mut ArchiveView<'_, P>,
    features: usize,
    from: &mut Reader<'_, S, E>,
) {
    let ArchiveView { index, entries, .. } = view;
    index.len = features.min(entries.len());
    (index.next_submap, index.tried) = (from.word(), from.word());
    index.clock_us = whole([from.word(), from.word()]);
    for entry in entries.iter_mut().take(index.len) {
        let (label, submap) = (from.word(), from.word());
        let since_us = whole([from.word(), from.word()]);
        let mean = from.vector();
        let mut split = || {
            let common = by_columns::<P::Tangent, P::Position>(|| from.vector());
            Split { common, own: Symmetric::from_fn(|_, _| from.scalar()) }
        };
        let (alone, given) = (split(), split());
        let anchored = from.word() as usize;
        let mut anchors = Entry::<P>::ZERO.anchors;
        for anchor in anchors.iter_mut().take(anchored) {
            let (label, mean) = (from.word(), from.vector());
            *anchor = Anchor { label, mean, gain: by_columns::<P::Position, P::Position>(|| from.vector()) };
        }
        let existence = Existence { visible: from.scalar(), occluded: from.scalar(), absent: from.scalar() };
        let detections = from.scalar();
        *entry = Entry { label, submap, mean, alone, anchored, anchors, given, existence, detections, since_us };
    }
}

/// A matrix that is stored column by column.
fn by_columns<C: Vector, R: Vector<Scalar = C::Scalar>>(mut next: impl FnMut() -> R) -> Linear<R, C> {
    let mut columns = C::Array::<R>::ZERO;
    columns.as_mut().iter_mut().for_each(|column| *column = next());
    Matrix::with(|row, column| columns.as_ref().get(column).map_or(R::Scalar::ZERO, |column| column.at(row)))
}

/// Checks all numbers of an archive, at a cost that is linear in its size.
pub(super) fn audit_archive<P: Pose>(entries: &[Entry<P>]) -> Result<(), Flaw> {
    if entries.iter().all(Entry::is_sound) { Ok(()) } else { Err(Flaw::Component) }
}

/// Visits the tracks.
pub(super) fn walk_movers<P: Pose>(movers: &[Mover<P>], common: &Common<P>, visit: &mut impl Visit) {
    common.process_noise.as_lower().iter().for_each(|&number| visit.scalar(number));
    for Mover { component: Component { label, ln_weight, mean, covariance, .. }, .. } in movers {
        visit.word(*label);
        visit.scalar(*ln_weight);
        mean.as_slice().iter().chain(covariance.as_lower()).for_each(|&number| visit.scalar(number));
    }
}

/// Reads the tracks from a snapshot with this number of tracks. The caller must audit the result.
pub(super) fn fill_movers<T: Real, P: Pose<Scalar = T>, S: FnMut(usize, &mut [u8]) -> Result<(), E>, E>(
    tracks: &mut Tracks<'_, P>,
    movers: usize,
    from: &mut Reader<'_, S, E>,
) {
    tracks.common.len = movers.min(tracks.movers.len());
    tracks.common.process_noise = Symmetric::from_fn(|_, _| from.scalar());
    for mover in tracks.kept_mut() {
        let (label, ln_weight, mean) = (from.word(), from.scalar(), from.vector());
        let covariance = Symmetric::from_fn(|_, _| from.scalar());
        *mover = Mover::new(Component { label, ln_weight, mean, covariance });
    }
}

/// Checks all numbers of the tracks, at a cost that is linear in their number.
pub(super) fn audit_movers<T: Real, P: Pose<Scalar = T>>(movers: &impl Movers<P>) -> Result<(), Flaw> {
    if movers.common().is_some_and(|(common, _)| !common.is_sound()) {
        return Err(Flaw::Pose);
    }
    if movers.kept().iter().all(Mover::is_sound) { Ok(()) } else { Err(Flaw::Component) }
}

/// The lower and the upper half of a number.
fn halves(whole: u64) -> [u32; 2] {
    [whole as u32, (whole >> 32) as u32]
}

fn whole([low, high]: [u32; 2]) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}
