//! Archiving of distant landmarks: they leave the window for the archive in submaps (pages).

use super::archive::{ANCHORS, Anchor, ArchiveView, Entry, SUBMAP_LEN, Split};
use super::conditioning::Conditioning;
use super::covariance::{Joint, first};
use super::map_management::TENTATIVE_BELOW;
use super::state::{Landmark, Memory};
use crate::{Linear, Matrix, Pose, PositionOf, Real, Symmetric, TangentOf, Vector, Zero};

/// Only what is farther off than this many times the vehicle sees may go.
const BEYOND: f64 = 1.25;

/// A window has room for one anchor in so many features.
const WINDOW_PER_ANCHOR: usize = 3;

/// Free places of the window below which anchors go.
const SPARE: usize = 2;

/// Anchors within reach of a page that are enough.
const NEAR_ANCHORS: usize = 4;

/// What archiving did.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Archiving {
    /// Features that went into the archive.
    pub(super) archived: usize,
    /// Features that the archive has no room for: those, or others in their place.
    pub(super) evicted: usize,
    /// Features that were hardly there and far away.
    pub(super) dropped: usize,
    /// Features whose covariance rounding had spoilt.
    pub(super) degenerate: usize,
}

/// Features of a page in a window of so many: a page and as many births must find room at once.
pub(super) fn submap_len(window: usize) -> usize {
    SUBMAP_LEN.min(window / 5)
}

/// How far from there a feature is on the ground, squared, m².
pub(super) fn squared_m<T: Real, D: Vector<Scalar = T>>(from: [T; 2], mean: &D) -> T {
    let [x, y] = from;
    let (dx, dy) = (mean.at(0) - x, mean.at(1) - y);
    dx * dx + dy * dy
}

/// Makes room where there is little: first of what was seen once and is far away, then by pages of what is farthest.
pub(super) fn archive_distant<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    view: &mut ArchiveView<'_, P>,
    memory: &mut Memory<'_, P, Z>,
) -> Archiving {
    let mut archived = Archiving::default();
    let window = memory.landmarks.len();
    let submap = submap_len(window);
    let little = |memory: &Memory<'_, P, Z>| window - memory.header.len.min(window) < 2 * submap;
    let beyond_m = view.reach_m * T::from_f64(BEYOND);
    let [x, y, _] = memory.header.pose.on_ground();
    let beyond = |landmark: &Landmark<P::Position>| squared_m([x, y], &landmark.mean) > beyond_m * beyond_m;
    if !little(memory) {
        return archived;
    }
    for index in (0..memory.header.len).rev() {
        let Some(landmark) = memory.landmarks.get(index) else { continue };
        if landmark.detections < T::from_f64(TENTATIVE_BELOW) && !landmark.is_anchor && beyond(landmark) {
            memory.drop_feature(index);
            archived.dropped += 1;
        }
    }
    for _ in 0..2 {
        if !little(memory) {
            break;
        }
        let far = |landmark: &Landmark<P::Position>| squared_m([x, y], &landmark.mean);
        // Where nothing else may go, anchors go.
        let others =
            memory.landmarks.iter().take(memory.header.len).any(|landmark| beyond(landmark) && !landmark.is_anchor);
        if !others && window - memory.header.len.min(window) >= SPARE {
            break;
        }
        let is_free = |landmark: &Landmark<P::Position>| beyond(landmark) && !(others && landmark.is_anchor);
        let Some(seed) = most(memory, |_, landmark| is_free(landmark).then(|| far(landmark))) else { break };
        let Some(mean) = memory.landmarks.get(seed).map(|landmark| landmark.mean) else { break };
        let around = [mean.at(0), mean.at(1)];
        let within = |landmark: &Landmark<P::Position>| {
            let squared = squared_m(around, &landmark.mean);
            (squared < view.reach_m * view.reach_m).then_some(-squared)
        };
        if let Some(landmark) = memory.landmarks.get_mut(seed) {
            landmark.is_anchor = false;
        }
        let anchors = anchors(
            memory,
            seed,
            within,
            |landmark| squared_m(around, &landmark.mean),
            view.reach_m * T::from_f64(3.0),
        );
        let mut members = [seed; SUBMAP_LEN];
        let mut count = 1;
        for _ in 1..submap {
            let chosen = members.get(..count).unwrap_or(&[]);
            let near = |index: usize, landmark: &Landmark<P::Position>| {
                let other = is_free(landmark) && !chosen.contains(&index) && !anchors.indices().contains(&index);
                within(landmark).filter(|_| other)
            };
            let Some(index) = most(memory, near) else { break };
            if let Some(slot) = members.get_mut(count) {
                *slot = index;
            }
            count += 1;
        }
        let members = members.get_mut(..count).unwrap_or(&mut []);
        let name = view.index.next_submap;
        view.index.next_submap = name.wrapping_add(1);
        let submap = Leaving::of(memory, seed, anchors.indices());
        members.iter().for_each(|&index| submap.put(view, memory, index, name, &mut archived));
        members.sort_unstable();
        members.iter().rev().for_each(|&index| memory.drop_feature(index));
    }
    archived
}

/// Places of the window.
struct Chosen {
    indices: [usize; ANCHORS],
    len: usize,
}

impl Chosen {
    fn indices(&self) -> &[usize] {
        self.indices.get(..self.len).unwrap_or(&[])
    }

    fn add(&mut self, index: usize) {
        if let Some(slot) = self.indices.get_mut(self.len) {
            *slot = index;
            self.len += 1;
        }
    }
}

/// The anchors of a page around a feature: those that there are nearest to it. Where few are within reach, as long as the window has room for more,
/// what is known best there becomes one.
fn anchors<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &mut Memory<'_, P, Z>,
    seed: usize,
    within: impl Fn(&Landmark<P::Position>) -> Option<T>,
    distance: impl Fn(&Landmark<P::Position>) -> T,
    far: T,
) -> Chosen {
    let known = || memory.landmarks.iter().take(memory.header.len);
    let room = (memory.landmarks.len() / WINDOW_PER_ANCHOR)
        .saturating_sub(known().filter(|landmark| landmark.is_anchor).count());
    let near = known().filter(|landmark| landmark.is_anchor && within(landmark).is_some()).count();
    for _ in 0..NEAR_ANCHORS.saturating_sub(near).min(room) {
        let index = most(memory, |index, landmark| {
            let other = index != seed && !landmark.is_anchor && landmark.existence.total() >= T::from_f64(0.5);
            within(landmark)
                .filter(|_| other && landmark.detections >= T::from_f64(TENTATIVE_BELOW))
                .map(|_| landmark.detections)
        });
        let Some(landmark) = index.and_then(|index| memory.landmarks.get_mut(index)) else { break };
        landmark.is_anchor = true;
    }
    let mut chosen = Chosen { indices: [0; ANCHORS], len: 0 };
    for _ in 0..ANCHORS {
        let other =
            |index: usize, landmark: &Landmark<P::Position>| landmark.is_anchor && !chosen.indices().contains(&index);
        let index = most(memory, |index, landmark| other(index, landmark).then(|| -distance(landmark)));
        let Some(index) = index else { break };
        let is_near = memory.landmarks.get(index).is_some_and(|landmark| distance(landmark) <= far * far);
        if chosen.len == 0 && !is_near {
            break;
        }
        chosen.add(index);
    }
    chosen
}

/// Marks the features of the window that pages are conditioned on.
pub(super) fn mark_anchors<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    view: &ArchiveView<'_, P>,
    memory: &mut Memory<'_, P, Z>,
) {
    let landmarks = memory.landmarks.get_mut(..memory.header.len).unwrap_or(&mut []);
    landmarks.iter_mut().for_each(|landmark| landmark.is_anchor = false);
    let mut last = None;
    for entry in view.entries.iter().take(view.index.len) {
        // The features of a page have the same anchors, and mostly follow each other.
        if last.replace(entry.submap) == Some(entry.submap) {
            continue;
        }
        for anchor in entry.anchors() {
            let of = landmarks.iter_mut().filter(|landmark| landmark.label == anchor.label);
            of.for_each(|landmark| landmark.is_anchor = true);
        }
    }
}

/// The feature with the most of something.
fn most<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &Memory<'_, P, Z>,
    of: impl Fn(usize, &Landmark<P::Position>) -> Option<T>,
) -> Option<usize> {
    let mut best = None;
    for (index, landmark) in memory.landmarks.iter().take(memory.header.len).enumerate() {
        if let Some(value) = of(index, landmark)
            && best.is_none_or(|(_, known)| value > known)
        {
            best = Some((index, value));
        }
    }
    best.map(|(index, _)| index)
}

/// A page that leaves the window.
struct Leaving<P: Pose> {
    anchors: [Anchor<P>; ANCHORS],
    anchored: usize,
    given: Common<P>,
    alone: Common<P>,
}

/// What a page has in common: its seed's position and the heading, given some features.
struct Common<P: Pose> {
    given: Conditioning<P>,
    seed: usize,
    /// A root of their covariance.
    root: Linear<TangentOf<P>, TangentOf<P>>,
}

impl<T: Real, P: Pose<Scalar = T>> Common<P> {
    fn of(joint: &Joint<'_, P>, seed: usize, indices: &[usize]) -> Self {
        let given = Conditioning::on(joint, indices);
        let own = |row, column| given.covariance(joint, Self::row(seed, row), Self::row(seed, column));
        let root = Symmetric::<TangentOf<P>>::from_fn(own).root();
        Self { given, seed, root }
    }

    /// The rows of the joint covariance that make it up.
    fn row(seed: usize, k: usize) -> usize {
        if k < P::Position::DIMENSION { first::<P>(seed) + k } else { k }
    }

    /// The covariance of a feature; `None` where rounding has spoilt it.
    fn split(&self, joint: &Joint<'_, P>, index: usize) -> Option<Split<P>> {
        let (given, at) = (&self.given, first::<P>(index));
        let mut rows = <PositionOf<P> as Vector>::Array::<TangentOf<P>>::ZERO;
        for (d, row) in rows.as_mut().iter_mut().enumerate() {
            let with = TangentOf::<P>::with(|k| given.covariance(joint, at + d, Self::row(self.seed, k)));
            *row = whitened::<T, TangentOf<P>>(&self.root, &with);
        }
        let common: Linear<PositionOf<P>, TangentOf<P>> =
            Matrix::with(|d, k| rows.as_ref().get(d).map_or(T::ZERO, |row| row.at(k)));
        let rounding = T::EPSILON * T::from_f64(64.0);
        let own = Symmetric::<PositionOf<P>>::from_fn(|row, column| {
            let shared =
                (0..TangentOf::<P>::DIMENSION).fold(T::ZERO, |sum, k| sum + common.at(row, k) * common.at(column, k));
            let least = if row == column { joint.get(at + row, at + row) * rounding } else { T::ZERO };
            given.covariance(joint, at + row, at + column) - shared + least
        });
        let (own, _) = own.kept_positive_definite()?;
        Some(Split { common, own })
    }
}

impl<T: Real, P: Pose<Scalar = T>> Leaving<P> {
    fn of<Z: Vector<Scalar = T>>(memory: &Memory<'_, P, Z>, seed: usize, indices: &[usize]) -> Self {
        let mut anchors = Entry::<P>::ZERO.anchors;
        let of_indices = indices.iter().filter_map(|&index| memory.landmarks.get(index));
        let of_indices = anchors.iter_mut().zip(of_indices).map(|(anchor, landmark)| {
            (anchor.label, anchor.mean) = (landmark.label, landmark.mean);
        });
        let anchored = of_indices.count();
        let [given, alone] = [indices, &[]].map(|indices| Common::of(&memory.joint, seed, indices));
        Self { anchors, anchored, given, alone }
    }

    /// Puts one of its features into the archive.
    fn put<Z: Vector<Scalar = T>>(
        &self,
        view: &mut ArchiveView<'_, P>,
        memory: &Memory<'_, P, Z>,
        index: usize,
        submap: u32,
        archived: &mut Archiving,
    ) {
        let joint = &memory.joint;
        let Some(landmark) = memory.landmarks.get(index).copied() else { return };
        let (Some(given), Some(alone)) = (self.given.split(joint, index), self.alone.split(joint, index)) else {
            archived.degenerate += 1;
            return;
        };
        let mut anchors = self.anchors;
        self.given.given.fill(joint, index, anchors.get_mut(..self.anchored).unwrap_or(&mut []));
        let Landmark { label, mean, existence, detections, .. } = landmark;
        let (since_us, anchored) = (view.index.clock_us, self.anchored);
        let entry = Entry { label, submap, mean, alone, anchored, anchors, given, existence, detections, since_us };
        archived.evicted += view.put(entry);
        archived.archived += 1;
    }
}

/// L⁻¹ v for a [root](Symmetric::root), whose columns of zeros give zero.
pub(super) fn whitened<T: Real, V: Vector<Scalar = T>>(root: &Linear<V, V>, v: &V) -> V {
    let mut y = V::ZERO;
    for k in 0..V::DIMENSION {
        let rest = (0..k).fold(v.at(k), |rest, j| rest - root.at(k, j) * y.at(j));
        if let Some(slot) = y.as_mut_slice().get_mut(k)
            && root.at(k, k) > T::ZERO
        {
            *slot = rest / root.at(k, k);
        }
    }
    y
}

#[cfg(test)]
mod tests {
    use super::Common;
    use crate::{JointState, PlanarPose, joint_numbers};
    use nalgebra::Vector2;

    /// A feature that differs from its seed by rounding alone keeps a variance: a share of its own, that rounding may have taken.
    #[test]
    fn rounding_is_relative_to_the_own_variance() {
        let mut state = JointState::<PlanarPose<f64>, Vector2<f64>, 3, { joint_numbers(3, 2, 3) }, 8>::new();
        let memory = state.memory();
        let mut joint = memory.joint;
        // Of heading, seed, an anchor, and a feature with the errors of the seed.
        let variances = [0.01, 0.01, 0.001, 0.02, 0.03, 0.5, 0.5, 0.02, 0.03];
        for (row, variance) in variances.into_iter().enumerate() {
            (0..=row).for_each(|column| joint.set(row, column, if column == row { variance } else { 0.0 }));
        }
        joint.set(7, 3, 0.02);
        joint.set(8, 4, 0.03);
        let split = Common::of(&joint, 0, &[1]).split(&joint, 2).unwrap();
        for (k, variance) in [0.02, 0.03].into_iter().enumerate() {
            let expected = f64::EPSILON * 64.0 * variance;
            assert!((split.own.get(k, k) / expected - 1.0).abs() < 0.1, "{:?}", split.own);
        }
    }
}
