//! What comes near again leaves the archive for the window.

use super::archive::{Entry, PAGE, Shelf};
use super::covariance::{Joint, first};
use super::existence::Persistence;
use super::park::{squared_m, whitened};
use super::state::{Memory, Slot};
use crate::numerics::vector::applied;
use crate::{Linear, Matrix, Pose, PositionOf, Real, Symmetric, TangentOf, Vector, Zero};

/// ω of covariance intersection: the pose becomes uncertain by a factor 1/ω, and what a page has in common by 1/(1 − ω). Chosen on
/// worlds that the tests do not have.
const SHARE: f64 = 0.95;

/// Pages on trial in one scan, at most.
const TRIALS: usize = 2;

/// Pages of the archive in the window, for the scan to tell whether the vehicle sees them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trial {
    visits: [Visit; TRIALS],
    count: usize,
}

/// A page on trial.
#[derive(Debug, Clone, Copy)]
struct Visit {
    page: u32,
    /// Where its features are in the archive.
    entries: [usize; PAGE],
    count: usize,
    /// Features of the window before them.
    before: usize,
    /// Whether the scan has seen something of it.
    seen: bool,
}

/// Puts pages that the vehicle may see behind the window's features, as far as there is room for them: independent of everything but
/// themselves.
pub(super) fn visit<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    shelf: &mut Shelf<'_, P>,
    persistence: &Persistence<T>,
    memory: &mut Memory<'_, P, Z>,
) -> Trial {
    let none = Visit { page: 0, entries: [0; PAGE], count: 0, before: 0, seen: false };
    let mut trial = Trial { visits: [none; TRIALS], count: 0 };
    let window = memory.slots.len();
    let (first, mut last) = (shelf.index.tried, None);
    for _ in 0..TRIALS {
        let Some(page) = next(shelf, &memory.known.pose, first, last) else { break };
        last = Some(page);
        let members = shelf.entries.iter().take(shelf.index.len).enumerate().filter(|(_, entry)| entry.page == page);
        let mut visit = Visit { page, before: memory.known.len, ..none };
        visit.count = visit.entries.iter_mut().zip(members).map(|(slot, (place, _))| *slot = place).count();
        shelf.index.tried = page;
        if visit.before + visit.count > window {
            continue;
        }
        for &at in visit.entries.iter().take(visit.count) {
            let Some(entry) = shelf.entries.get(at) else { break };
            let place = memory.known.len;
            let passed_s = T::from_f64(shelf.index.clock_us.saturating_sub(entry.since_us) as f64 * 1e-6);
            if let Some(slot) = memory.slots.get_mut(place) {
                let existence = entry.existence.after(&persistence.over(passed_s));
                let (label, mean, detections) = (entry.label, entry.mean, entry.detections);
                *slot = Slot { label, mean, existence, detections, ..Slot::ZERO };
            }
            visit.put(shelf, memory, entry, place);
            memory.known.len += 1;
        }
        if let Some(slot) = trial.visits.get_mut(trial.count) {
            *slot = visit;
            trial.count += 1;
        }
    }
    trial
}

impl Trial {
    /// Takes the pages that the scan of so many measurements has seen into the window for good, and sends the others away: how many features came, and
    /// whether a page went.
    pub(super) fn judge<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
        &mut self,
        shelf: &mut Shelf<'_, P>,
        memory: &mut Memory<'_, P, Z>,
        measurements: usize,
    ) -> (usize, bool) {
        let (mut recalled, mut refused) = (0, false);
        for visit in self.visits.iter_mut().take(self.count) {
            visit.seen = visit.is_seen(memory, measurements);
            refused |= !visit.seen;
            if visit.seen {
                visit.admit(shelf, memory);
                recalled += visit.count;
            }
        }
        for visit in self.visits.iter().take(self.count).rev().filter(|visit| !visit.seen) {
            (visit.before..visit.before + visit.count).rev().for_each(|place| memory.drop_feature(place));
        }
        for visit in self.visits.iter().take(self.count).filter(|visit| visit.seen) {
            shelf.take_page(visit.page);
        }
        (recalled, refused)
    }
}

impl Visit {
    /// Whether its features have half the detections that were expected of them, and half a detection in all.
    fn is_seen<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
        &self,
        memory: &Memory<'_, P, Z>,
        measurements: usize,
    ) -> bool {
        let places = self.before..self.before + self.count;
        let claims = memory.explained.iter().take(measurements).flat_map(|explained| explained.claims());
        let shares = claims.filter(|claim| places.contains(&usize::from(claim.feature))).map(|claim| claim.share);
        let seen = shares.fold(T::ZERO, |sum, share| sum + share);
        let members = memory.slots.iter().skip(self.before).take(self.count);
        let expected = members.fold(T::ZERO, |sum, slot| sum + slot.detection * slot.existence.in_sight);
        let half = T::from_f64(0.5);
        seen >= expected.at_least(T::ONE) * half
    }

    /// The pages whose anchors are all in the window have their covariances with everything. What another page and the pose have in common is not
    /// known: both are made as uncertain as it takes for that not to matter.
    fn admit<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
        &self,
        shelf: &Shelf<'_, P>,
        memory: &mut Memory<'_, P, Z>,
    ) {
        let entries = || self.entries.iter().take(self.count).filter_map(|&at| shelf.entries.get(at));
        if entries().next().is_none_or(|entry| !entry.anchors().is_empty() && is_anchored(entry, memory, self.before)) {
            return;
        }
        let share = T::from_f64(SHARE);
        memory.joint.doubt_pose(T::ONE / share, memory.known.len);
        let factor = T::ONE / (T::ONE - share);
        for (one, a) in entries().enumerate() {
            for (other, b) in entries().take(one + 1).enumerate() {
                memory.joint.put_block(self.before + one, self.before + other, |row, column| {
                    let own = if one == other { a.alone.own.get(row, column) } else { T::ZERO };
                    a.alone.with(&b.alone, false, row, column) * factor + own
                });
            }
        }
    }

    /// Sets the covariances of a feature of the page with all that there is before it.
    fn put<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
        &self,
        shelf: &Shelf<'_, P>,
        memory: &mut Memory<'_, P, Z>,
        entry: &Entry<P>,
        place: usize,
    ) {
        let anchored = !entry.anchors().is_empty() && is_anchored(entry, memory, self.before);
        if anchored {
            let known = memory.slots.get(..self.before).unwrap_or(&[]);
            let mut moved = PositionOf::<P>::ZERO;
            let of = entry.anchors().iter().filter_map(|anchor| {
                known.iter().position(|slot| slot.label == anchor.label).map(|place| (place, anchor.gain))
            });
            memory.joint.add_of(of, place);
            for anchor in entry.anchors() {
                if let Some(slot) = known.iter().find(|slot| slot.label == anchor.label) {
                    moved += applied::<PositionOf<P>, PositionOf<P>>(&anchor.gain, &(slot.mean - anchor.mean));
                }
            }
            if let Some(slot) = memory.slots.get_mut(place) {
                slot.mean += moved;
            }
        } else {
            memory.joint.put_alone(place);
        }
        for (other, &at) in (self.before..=place).zip(&self.entries) {
            let Some(of) = shelf.entries.get(at) else { break };
            memory.joint.add_block(place, other, |row, column| {
                if anchored {
                    entry.given.with(&of.given, other == place, row, column)
                } else {
                    entry.alone.with(&of.alone, other == place, row, column)
                }
            });
        }
    }
}

/// Whether all anchors of a page are among the first features of the window.
fn is_anchored<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    entry: &Entry<P>,
    memory: &Memory<'_, P, Z>,
    window: usize,
) -> bool {
    let is_known = |label: u32| memory.slots.iter().take(window).any(|slot| slot.label == label);
    entry.anchors().iter().all(|anchor| is_known(anchor.label))
}

/// The next page in turn, from behind `first` on, that has a feature in reach, and comes after the `last` one of this scan.
fn next<T: Real, P: Pose<Scalar = T>>(shelf: &Shelf<'_, P>, pose: &P, first: u32, last: Option<u32>) -> Option<u32> {
    let [x, y, _] = pose.on_ground();
    let reach = shelf.reach_m * shelf.reach_m;
    let turn = |page: u32| page.wrapping_sub(first.wrapping_add(1));
    let mut best: Option<u32> = None;
    for entry in shelf.entries.iter().take(shelf.index.len) {
        let later = last.is_none_or(|last| turn(entry.page) > turn(last));
        if later && squared_m([x, y], &entry.mean) <= reach && best.is_none_or(|best| turn(entry.page) < turn(best)) {
            best = Some(entry.page);
        }
    }
    best
}

impl<T: Real, P: Pose<Scalar = T>> Joint<'_, P> {
    /// Makes the pose more uncertain by a factor, and with it what the features have in common with it, and nothing else:
    /// P ← P + (factor − 1) P_·x P_xx⁻¹ P_x·.
    pub(super) fn doubt_pose(&mut self, factor: T, features: usize) {
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

/// L⁻ᵀ y for a [root](Symmetric::root), whose columns of zeros give zero.
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
