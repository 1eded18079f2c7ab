//! Archiving of distant landmarks: they are moved from the window to the archive in submaps.

use super::archive::{ANCHORS, Anchor, ArchiveView, Entry, SUBMAP_LEN, Split};
use super::conditioning::Conditioning;
use super::covariance::{Joint, first};
use super::landmark::Landmark;
use super::map_management::TENTATIVE_BELOW;
use super::state::Memory;
use crate::{Linear, Matrix, Pose, PositionOf, Real, Symmetric, TangentOf, Vector, Zero};

/// Least distance of a feature that may be archived, divided by the reach of the detectors.
const BEYOND: f64 = 1.25;

/// Capacity of the window divided by the maximum number of anchors.
const WINDOW_PER_ANCHOR: usize = 3;

/// Anchors are archived too if fewer slots than this are free and no other feature may be archived.
const SPARE: usize = 2;

/// Sufficient number of anchors within reach of a submap: if there are fewer, landmarks become anchors.
const NEAR_ANCHORS: usize = 4;

/// Counts of archiving.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Archiving {
    /// Features that were moved to the archive.
    pub(super) archived: usize,
    /// Features that were lost because the archive was full: the moved ones, or others that they replaced.
    pub(super) evicted: usize,
    /// Distant features that were dropped because they were detected less than twice.
    pub(super) dropped: usize,
    /// Features that were lost because rounding errors had made their covariance invalid.
    pub(super) degenerate: usize,
}

/// Number of features of a submap for this capacity of the window. A submap on trial and as many new features must have
/// free slots at the same time.
pub(super) fn submap_len(window: usize) -> usize {
    SUBMAP_LEN.min(window / 5)
}

/// Squared horizontal distance of a feature from a position, m².
pub(super) fn squared_m<T: Real, D: Vector<Scalar = T>>(from: [T; 2], mean: &D) -> T {
    let [x, y] = from;
    let (dx, dy) = (mean.at(0) - x, mean.at(1) - y);
    dx * dx + dy * dy
}

/// Archives features if the window has few free slots. First it drops distant features that were detected less than
/// twice; then it archives up to two submaps, each around the most distant feature.
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
        // Anchors are archived only if no other feature may be.
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

/// Indices of the landmarks that are the anchors of a submap.
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

/// The anchors of a submap around the landmark `seed`: those nearest to it, or none if the nearest is more distant than `far`. If
/// there are few anchors within reach, the landmarks there with the most detections become anchors, up to the maximum number.
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

/// Marks the landmarks of the window that are anchors of archived submaps.
pub(super) fn mark_anchors<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    view: &ArchiveView<'_, P>,
    memory: &mut Memory<'_, P, Z>,
) {
    let landmarks = memory.landmarks.get_mut(..memory.header.len).unwrap_or(&mut []);
    landmarks.iter_mut().for_each(|landmark| landmark.is_anchor = false);
    let mut last = None;
    for entry in view.entries.iter().take(view.index.len) {
        // The features of a submap have the same anchors, and are mostly stored one after the other.
        if last.replace(entry.submap) == Some(entry.submap) {
            continue;
        }
        for anchor in entry.anchors() {
            let of = landmarks.iter_mut().filter(|landmark| landmark.label == anchor.label);
            of.for_each(|landmark| landmark.is_anchor = true);
        }
    }
}

/// The index of the landmark with the greatest value of `of`.
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

/// A submap that is moved to the archive: its anchors, and the common part of its covariance with and without conditioning on them.
struct Leaving<P: Pose> {
    anchors: [Anchor<P>; ANCHORS],
    anchored: usize,
    given: Common<P>,
    alone: Common<P>,
}

/// The common coordinates y of a submap, given some landmarks: those of the pose, with its position replaced by that of the seed.
struct Common<P: Pose> {
    given: Conditioning<P>,
    seed: usize,
    /// L, a root of the conditional covariance of y, L Lᵀ.
    root: Linear<TangentOf<P>, TangentOf<P>>,
}

impl<T: Real, P: Pose<Scalar = T>> Common<P> {
    fn of(joint: &Joint<'_, P>, seed: usize, indices: &[usize]) -> Self {
        let given = Conditioning::on(joint, indices);
        let own = |row, column| given.covariance(joint, Self::row(seed, row), Self::row(seed, column));
        let root = Symmetric::<TangentOf<P>>::from_fn(own).root();
        Self { given, seed, root }
    }

    /// The row of the joint covariance for coordinate `k` of y.
    fn row(seed: usize, k: usize) -> usize {
        if k < P::Position::DIMENSION { first::<P>(seed) + k } else { k }
    }

    /// A and R of a feature; `None` if rounding errors have made its covariance invalid.
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

    /// Adds one of its features to the archive.
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

/// L⁻¹ v for a [root](Symmetric::root) L. Columns of zeros give zeros.
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

    /// If a feature differs from the seed only by rounding errors, its R is an allowance for rounding relative to its variance.
    #[test]
    fn the_allowance_for_rounding_is_relative_to_the_variance() {
        let mut state = JointState::<PlanarPose<f64>, Vector2<f64>, 3, { joint_numbers(3, 2, 3) }, 8>::new();
        let memory = state.memory();
        let mut joint = memory.joint;
        // Variances of the pose (x, y, heading), the seed, an anchor, and a feature with the same errors as the seed.
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
