//! Re-activation of submaps: archived submaps that may be in view are put on trial, and the scan decides which of them
//! return to the window.

use super::archive::{ArchiveView, Entry, SUBMAP_LEN};
use super::archiving::{squared_m, whitened};
use super::covariance::{Joint, first};
use super::existence::Persistence;
use super::landmark::Landmark;
use super::state::Memory;
use crate::numerics::vector::applied;
use crate::{Linear, Matrix, Pose, PositionOf, Real, Symmetric, TangentOf, Vector, Zero};

/// ω of covariance intersection: the covariance of the pose is multiplied by 1/ω, and the common part of the covariance
/// of a submap by 1/(1 − ω). The value was chosen on worlds that the tests do not use.
const SHARE: f64 = 0.95;

/// Maximum number of submaps on trial in a scan.
const CANDIDATES: usize = 2;

/// Submaps on trial: their features are in the window, and the scan decides whether the vehicle detects them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidates {
    candidates: [Candidate; CANDIDATES],
    count: usize,
}

/// A submap on trial.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    submap: u32,
    /// Indices of its features in the archive.
    entries: [usize; SUBMAP_LEN],
    count: usize,
    /// Number of features of the window before them.
    before: usize,
    /// Whether the scan has confirmed it.
    seen: bool,
}

/// Appends submaps that may be in view to the features of the window, as far as there is room. Their covariances follow
/// from those of their anchors; if an anchor is not in the window, they are independent of it.
pub(super) fn propose<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    view: &mut ArchiveView<'_, P>,
    persistence: &Persistence<T>,
    memory: &mut Memory<'_, P, Z>,
) -> Candidates {
    let none = Candidate { submap: 0, entries: [0; SUBMAP_LEN], count: 0, before: 0, seen: false };
    let mut found = Candidates { candidates: [none; CANDIDATES], count: 0 };
    let window = memory.landmarks.len();
    let (first, mut last) = (view.index.tried, None);
    for _ in 0..CANDIDATES {
        let Some(submap) = next(view, &memory.header.pose, first, last) else { break };
        last = Some(submap);
        let members = view.entries.iter().take(view.index.len).enumerate().filter(|(_, entry)| entry.submap == submap);
        let mut candidate = Candidate { submap, before: memory.header.len, ..none };
        candidate.count = candidate.entries.iter_mut().zip(members).map(|(slot, (index, _))| *slot = index).count();
        view.index.tried = submap;
        if candidate.before + candidate.count > window {
            continue;
        }
        for &at in candidate.entries.iter().take(candidate.count) {
            let Some(entry) = view.entries.get(at) else { break };
            let index = memory.header.len;
            let passed_s = T::from_f64(view.index.clock_us.saturating_sub(entry.since_us) as f64 * 1e-6);
            if let Some(landmark) = memory.landmarks.get_mut(index) {
                let existence = entry.existence.after(&persistence.over(passed_s));
                let (label, mean, detections) = (entry.label, entry.mean, entry.detections);
                *landmark = Landmark { label, mean, existence, detections, ..Landmark::ZERO };
            }
            candidate.put(view, memory, entry, index);
            memory.header.len += 1;
        }
        if let Some(slot) = found.candidates.get_mut(found.count) {
            *slot = candidate;
            found.count += 1;
        }
    }
    found
}

impl Candidates {
    /// Keeps the submaps in the window that the scan, with this number of measurements, has confirmed, and removes them from the
    /// archive. Removes the others from the window. Returns the number of re-activated features, and whether a submap was removed.
    pub(super) fn accept<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
        &mut self,
        view: &mut ArchiveView<'_, P>,
        memory: &mut Memory<'_, P, Z>,
        measurements: usize,
    ) -> (usize, bool) {
        let (mut reactivated, mut refused) = (0, false);
        for candidate in self.candidates.iter_mut().take(self.count) {
            candidate.seen = candidate.is_seen(memory, measurements);
            refused |= !candidate.seen;
            if candidate.seen {
                candidate.insert(view, memory);
                reactivated += candidate.count;
            }
        }
        for candidate in self.candidates.iter().take(self.count).rev().filter(|candidate| !candidate.seen) {
            (candidate.before..candidate.before + candidate.count).rev().for_each(|index| memory.drop_feature(index));
        }
        for candidate in self.candidates.iter().take(self.count).filter(|candidate| candidate.seen) {
            view.take_submap(candidate.submap);
        }
        (reactivated, refused)
    }
}

impl Candidate {
    /// Whether the scan confirms the submap: Σ s over its features is at least ½, and at least half of the expected
    /// detections Σ p_D v.
    fn is_seen<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
        &self,
        memory: &Memory<'_, P, Z>,
        measurements: usize,
    ) -> bool {
        let indices = self.before..self.before + self.count;
        let associations = memory.association_table.iter().take(measurements).flat_map(|row| row.associations());
        let probabilities = associations
            .filter(|association| indices.contains(&usize::from(association.feature)))
            .map(|association| association.probability);
        let seen = probabilities.fold(T::ZERO, |sum, probability| sum + probability);
        let members = memory.landmarks.iter().skip(self.before).take(self.count);
        let expected = members.fold(T::ZERO, |sum, landmark| sum + landmark.detection * landmark.existence.visible);
        let half = T::from_f64(0.5);
        seen >= expected.at_least(T::ONE) * half
    }

    /// Completes the covariances of a confirmed submap. With all anchors in the window they are complete. Without them, the
    /// correlation with the pose is unknown: split covariance intersection makes both uncertain enough for every correlation.
    fn insert<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
        &self,
        view: &ArchiveView<'_, P>,
        memory: &mut Memory<'_, P, Z>,
    ) {
        let entries = || self.entries.iter().take(self.count).filter_map(|&at| view.entries.get(at));
        if entries().next().is_none_or(|entry| !entry.anchors().is_empty() && is_anchored(entry, memory, self.before)) {
            return;
        }
        let probability = T::from_f64(SHARE);
        memory.joint.inflate_pose(T::ONE / probability, memory.header.len);
        let factor = T::ONE / (T::ONE - probability);
        for (one, a) in entries().enumerate() {
            for (other, b) in entries().take(one + 1).enumerate() {
                memory.joint.put_block(self.before + one, self.before + other, |row, column| {
                    let own = if one == other { a.alone.own.get(row, column) } else { T::ZERO };
                    a.alone.with(&b.alone, false, row, column) * factor + own
                });
            }
        }
    }

    /// Sets the covariances of a feature of the submap with all features before it, and corrects its mean by the
    /// displacement of the anchors.
    fn put<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
        &self,
        view: &ArchiveView<'_, P>,
        memory: &mut Memory<'_, P, Z>,
        entry: &Entry<P>,
        index: usize,
    ) {
        let anchored = !entry.anchors().is_empty() && is_anchored(entry, memory, self.before);
        if anchored {
            let window = memory.landmarks.get(..self.before).unwrap_or(&[]);
            let mut moved = PositionOf::<P>::ZERO;
            let of = entry.anchors().iter().filter_map(|anchor| {
                window.iter().position(|landmark| landmark.label == anchor.label).map(|index| (index, anchor.gain))
            });
            memory.joint.add_of(of, index);
            for anchor in entry.anchors() {
                if let Some(landmark) = window.iter().find(|landmark| landmark.label == anchor.label) {
                    moved += applied::<PositionOf<P>, PositionOf<P>>(&anchor.gain, &(landmark.mean - anchor.mean));
                }
            }
            if let Some(landmark) = memory.landmarks.get_mut(index) {
                landmark.mean += moved;
            }
        } else {
            memory.joint.put_alone(index);
        }
        for (other, &at) in (self.before..=index).zip(&self.entries) {
            let Some(of) = view.entries.get(at) else { break };
            memory.joint.add_block(index, other, |row, column| {
                if anchored {
                    entry.given.with(&of.given, other == index, row, column)
                } else {
                    entry.alone.with(&of.alone, other == index, row, column)
                }
            });
        }
    }
}

/// Whether all anchors of a submap are among the first `window` landmarks.
fn is_anchored<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    entry: &Entry<P>,
    memory: &Memory<'_, P, Z>,
    window: usize,
) -> bool {
    let is_known = |label: u32| memory.landmarks.iter().take(window).any(|landmark| landmark.label == label);
    entry.anchors().iter().all(|anchor| is_known(anchor.label))
}

/// The next submap with a feature within reach, in the cyclic order of identifiers that starts after `first`. It comes
/// after `last`, the submap that this scan has tried before.
fn next<T: Real, P: Pose<Scalar = T>>(
    view: &ArchiveView<'_, P>,
    pose: &P,
    first: u32,
    last: Option<u32>,
) -> Option<u32> {
    let [x, y, _] = pose.on_ground();
    let reach = view.reach_m * view.reach_m;
    let turn = |submap: u32| submap.wrapping_sub(first.wrapping_add(1));
    let mut best: Option<u32> = None;
    for entry in view.entries.iter().take(view.index.len) {
        let later = last.is_none_or(|last| turn(entry.submap) > turn(last));
        if later && squared_m([x, y], &entry.mean) <= reach && best.is_none_or(|best| turn(entry.submap) < turn(best)) {
            best = Some(entry.submap);
        }
    }
    best
}

impl<T: Real, P: Pose<Scalar = T>> Joint<'_, P> {
    /// Multiplies the covariance of the pose by a factor, and increases that of the features by the part that follows
    /// from it: P ← P + (factor − 1) P_·x P_xx⁻¹ P_x·.
    pub(super) fn inflate_pose(&mut self, factor: T, features: usize) {
        let root = Symmetric::<TangentOf<P>>::from_fn(|row, column| self.get(row, column)).root();
        let with_pose = |joint: &Self, row: usize| TangentOf::<P>::with(|k| joint.get(row, k));
        let (pose, all) = (P::Tangent::DIMENSION, first::<P>(features));
        for row in pose..all {
            let explained =
                back_substituted::<T, P::Tangent>(&root, &whitened::<T, P::Tangent>(&root, &with_pose(self, row)));
            for column in pose..=row {
                let grown = explained.dot(&with_pose(self, column)) * (factor - T::ONE);
                self.set(row, column, self.get(row, column) + grown);
            }
        }
        for row in 0..all {
            (0..pose.min(row + 1)).for_each(|column| self.set(row, column, self.get(row, column) * factor));
        }
    }
}

/// L⁻ᵀ y for a [root](Symmetric::root) L. Columns of zeros give zeros.
fn back_substituted<T: Real, V: Vector<Scalar = T>>(root: &Linear<V, V>, y: &V) -> V {
    let mut w: V = Zero::ZERO;
    for k in (0..V::DIMENSION).rev() {
        let rest = (k + 1..V::DIMENSION).fold(y.at(k), |rest, j| rest - root.at(j, k) * w.at(j));
        if let Some(slot) = w.as_mut_slice().get_mut(k)
            && root.at(k, k) > T::ZERO
        {
            *slot = rest / root.at(k, k);
        }
    }
    w
}
