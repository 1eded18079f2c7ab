//! Memory scrubbing of a joint map: a check of the state in slices between steps, which repairs damage by memory faults.
//!
//! Every covariance is limited by its two variances: |P_ab|² ≤ P_aa P_bb (Cauchy and Schwarz). If one covariance
//! violates this bound, it was damaged, or one of the two variances; a damaged variance violates the bound with many
//! covariances. A damaged feature is removed, which leaves the covariances of all others unchanged. The pose cannot be
//! removed: its variances are increased, which is conservative.

use super::archive::{Archive, ArchiveView};
use super::covariance::{Joint, first};
use super::filter::JointSlam;
use super::landmark::Landmark;
use super::movers::{Movers, Tracks};
use super::state::Memory;
use crate::filter::scrub::{Scrubbed, Scrubber};
use crate::numerics::range::is_within_range;
use crate::snapshot::visit::{Sealing, Visit};
use crate::{Flaw, Motion, Pose, Real, Symmetric, TangentOf, Vector};

/// Factor by which rounding errors may make the square of a covariance greater than the product of its variances.
const ROUNDING: f64 = 1.05;
/// Factor by which rounding errors may change the sum of the existence probabilities of a feature.
const GREATEST_PROBABILITY: f64 = 1.001;

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, A, V>
{
    /// Checks `parts` parts of the state and repairs values that the filter cannot have produced, as
    /// [`ScPhd::scrub`](crate::ScPhd::scrub) does: for memory without error correction, between steps, when there is
    /// time. One part is the pose with its covariance, or a feature with its row of the joint covariance, or an
    /// archived feature, or a moving-object track. Valid data is unchanged to the bit. With n features, one feature
    /// takes about 2 n (3 + 2 n) comparisons in the worst case, and in the plane 6 + 4 n if it is valid.
    ///
    /// An invalid feature is removed, and is initiated again when it is detected again. A variance of the pose that contradicts its
    /// covariances is increased until it agrees. A value that was changed to another valid value is not found; to find it, compare
    /// [seals](Self::seal) or [digests](Self::digest), or go back to a [snapshot](Self::save).
    ///
    /// # Errors
    /// Damage that cannot be repaired: invalid counts or times, or a pose out of range. [Restore](Self::restore) a
    /// snapshot, or [reset](Self::reset).
    pub fn scrub(&mut self, scrubber: &mut Scrubber, parts: usize) -> Result<Scrubbed, Flaw> {
        let memory = &mut self.memory;
        let mut scrubbed = Scrubbed::default();
        if !memory.header.started {
            return Ok(scrubbed);
        }
        memory.check_known()?;
        let mut view = self.archive.view();
        if let Some(view) = &view
            && view.index.len > view.entries.len()
        {
            return Err(Flaw::Cursor);
        }
        let mut tracks = self.movers.tracks();
        if let Some(tracks) = &mut tracks {
            if tracks.common.len > tracks.movers.len() {
                return Err(Flaw::Cursor);
            }
            scrubbed.widened |= tracks.mend_doubt(memory);
        }
        let behind = |view: &Option<ArchiveView<'_, M::Pose>>, tracks: &Option<Tracks<'_, M::Pose>>| {
            let archived = view.as_ref().map_or(0, |view| view.index.len);
            (archived, archived + tracks.as_ref().map_or(0, |tracks| tracks.common.len))
        };
        let parts = parts.min(1 + memory.header.len + behind(&view, &tracks).1);
        for _ in 0..parts {
            let features = memory.header.len;
            match scrubber.next {
                0 => scrubbed.widened |= memory.mend_pose_block()?,
                part if part <= features => scrubbed.features += memory.mend_feature(part - 1),
                part => {
                    let (archived, index) = (behind(&view, &tracks).0, part - 1 - features);
                    let dropped = match index.checked_sub(archived) {
                        None => view.as_mut().is_some_and(|view| view.drop_unsound(index)),
                        Some(mover) => tracks.as_mut().is_some_and(|tracks| tracks.drop_unsound(mover)),
                    };
                    scrubbed.features += usize::from(dropped);
                }
            }
            scrubber.next += 1;
            if scrubber.next > memory.header.len + behind(&view, &tracks).1 {
                (scrubber.next, scrubbed.round) = (0, true);
            }
        }
        Ok(scrubbed)
    }

    /// A hash of the data that is small and vital: the pose with its covariance, the counts, the time since the last
    /// scan, the next label and the divergence monitor. If a vehicle computes it after a step and gets another value
    /// before the next step, memory has failed in between, even where scrubbing cannot find it.
    pub fn seal(&self) -> u64 {
        let mut seal = Sealing::EMPTY;
        let Memory { header, joint, .. } = &self.memory;
        header.walk(&mut seal);
        seal.count(header.len);
        joint.used(0).iter().for_each(|&number| seal.scalar(number));
        if let Some(index) = self.archive.index() {
            seal.count(index.len);
            seal.word(index.next_submap);
        }
        if let Some((common, _)) = self.movers.common() {
            seal.count(common.len);
            common.process_noise.as_lower().iter().for_each(|&number| seal.scalar(number));
        }
        seal.value()
    }
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> Memory<'_, P, Z> {
    /// Limits an invalid number of features to the capacity: every step must end, even with damaged memory.
    pub(super) fn clamp(&mut self) {
        self.header.len = self.header.len.min(self.landmarks.len());
    }

    /// Checks the number of features, the time since the last scan, and the pose.
    fn check_known(&self) -> Result<(), Flaw> {
        let header = &*self.header;
        if header.len > self.landmarks.len() || !(header.waited_s >= T::ZERO && header.waited_s.is_finite()) {
            return Err(Flaw::Cursor);
        }
        let moved = header.moved.iter().chain(header.motion_noise.as_lower()).all(|number| number.is_finite());
        let pose = header.pose.is_finite() && is_within_range(&header.pose.coordinates());
        if moved && pose { Ok(()) } else { Err(Flaw::Pose) }
    }

    /// Increases the variances of the pose that contradict its covariances with the features, and sets the covariances
    /// of its coordinates to zero if they are invalid. Returns whether the covariance was changed.
    fn mend_pose_block(&mut self) -> Result<bool, Flaw> {
        let Self { header, joint, .. } = self;
        let mut widened = false;
        for k in 0..TangentOf::<P>::DIMENSION {
            widened |= joint.mend_pose_variance(k, header.len)?;
        }
        Ok(joint.part_pose_coordinates() || widened)
    }

    /// Drops a feature with invalid numbers, or the features whose covariances with it violate the bound. Returns the
    /// number of dropped features.
    fn mend_feature(&mut self, index: usize) -> usize {
        let sound = self.landmarks.get(index).is_some_and(Landmark::is_sound) && self.joint.block_is_sound(index);
        if !sound {
            self.drop_feature(index);
            return 1;
        }
        let mut dropped = 0;
        // Each iteration drops a feature, or is the last one.
        for _ in 0..self.header.len {
            let features = self.header.len;
            let Some(other) = (0..features).find(|&other| other != index && self.joint.is_torn(index, other)) else {
                break;
            };
            // The feature that violates the bound with more of the others is dropped; of two with equal numbers, the
            // one with fewer detections.
            let [here, there] = [index, other].map(|of| (self.joint.torn_from(of, features), self.detections(of)));
            let at_fault = if here.0 > there.0 || here.0 == there.0 && here.1 < there.1 { index } else { other };
            self.drop_feature(at_fault);
            dropped += 1;
            if at_fault == index {
                return dropped;
            }
            // This feature was the last one, and now has the index of the dropped one.
            if index == self.header.len {
                return dropped;
            }
        }
        if (0..TangentOf::<P>::DIMENSION).any(|k| self.joint.is_torn_from_pose(index, k)) {
            self.drop_feature(index);
            dropped += 1;
        }
        dropped
    }

    fn detections(&self, index: usize) -> T {
        self.landmarks.get(index).map_or(T::ZERO, |landmark| landmark.detections)
    }
}

impl<T: Real, P: Pose<Scalar = T>> Tracks<'_, P> {
    /// Replaces an invalid process noise of the tracks by the covariance of the pose, of which it is a part. Returns
    /// whether it was replaced.
    fn mend_doubt<Z: Vector<Scalar = T>>(&mut self, memory: &Memory<'_, P, Z>) -> bool {
        if self.common.is_sound() {
            return false;
        }
        self.common.process_noise = Symmetric::from_fn(|row, column| memory.joint.get(row, column));
        true
    }
}

impl<T: Real, D: Vector<Scalar = T>> Landmark<D> {
    /// Whether the probabilities sum to one, and all numbers are valid.
    fn is_sound(&self) -> bool {
        let all = self.existence.total() + self.existence.absent;
        let greatest = T::from_f64(GREATEST_PROBABILITY);
        self.may_be() && all <= greatest && all * greatest >= T::ONE
    }
}

impl<T: Real, P: Pose<Scalar = T>> Joint<'_, P> {
    /// Whether two coordinates satisfy |P_ab|² ≤ P_aa P_bb, with an allowance for rounding errors. The comparison is
    /// written so that NaN does not.
    fn may_share(&self, one: usize, other: usize) -> bool {
        let common = self.get(one, other);
        common * common <= self.get(one, one) * self.get(other, other) * T::from_f64(ROUNDING)
    }

    /// The coordinates of a feature.
    fn of(feature: usize) -> impl Iterator<Item = usize> {
        first::<P>(feature)..first::<P>(feature + 1)
    }

    /// Whether the covariance of a feature with itself is valid.
    fn block_is_sound(&self, feature: usize) -> bool {
        let usable = |variance: T| variance > T::ZERO && variance < T::INFINITY;
        Self::of(feature).all(|coordinate| usable(self.get(coordinate, coordinate)))
            && Self::of(feature).all(|one| Self::of(feature).all(|other| self.may_share(one, other)))
    }

    /// Whether the covariance of two features violates the bound.
    fn is_torn(&self, feature: usize, other: usize) -> bool {
        Self::of(feature).any(|one| Self::of(other).any(|two| !self.may_share(one, two)))
    }

    /// The number of other features with which a feature violates the bound.
    fn torn_from(&self, feature: usize, features: usize) -> usize {
        (0..features).filter(|&other| other != feature && self.is_torn(feature, other)).count()
    }

    /// Whether the covariance of a feature with coordinate `k` of the pose violates the bound.
    fn is_torn_from_pose(&self, feature: usize, k: usize) -> bool {
        Self::of(feature).any(|coordinate| !self.may_share(coordinate, k))
    }

    /// Sets the variance of coordinate `k` of the pose to twice the least value that its covariances with the features
    /// allow, if it is invalid, or if it violates the bound with at least two features and with more than half of them.
    /// Returns whether it was changed; an error if no covariance gives a positive value.
    fn mend_pose_variance(&mut self, k: usize, features: usize) -> Result<bool, Flaw> {
        let variance = self.get(k, k);
        let torn = (0..features).filter(|&feature| self.is_torn_from_pose(feature, k)).count();
        let usable = variance >= T::ZERO && variance < T::INFINITY;
        if usable && (torn < 2 || 2 * torn <= features) {
            return Ok(false);
        }
        let mut least = T::ZERO;
        for coordinate in (0..features).flat_map(Self::of) {
            let (common, own) = (self.get(coordinate, k), self.get(coordinate, coordinate));
            let says = common * common / own;
            if own > T::ZERO && says > least && says < T::INFINITY {
                least = says;
            }
        }
        if !(least > T::ZERO) {
            return Err(Flaw::Pose);
        }
        self.set(k, k, least + least);
        Ok(true)
    }

    /// If the covariance of the pose is invalid, sets the covariances of its coordinates to zero and multiplies their
    /// variances by the number n of coordinates: n D − P is positive semidefinite for every P with the diagonal D.
    /// Returns whether the covariance was changed.
    fn part_pose_coordinates(&mut self) -> bool {
        let coordinates = || 0..TangentOf::<P>::DIMENSION;
        let may_be = coordinates().all(|row| coordinates().take(row).all(|column| self.may_share(row, column)));
        let certain = coordinates().any(|k| self.get(k, k) == T::ZERO);
        let raised = T::from_f64(ROUNDING);
        let block = Symmetric::<TangentOf<P>>::from_fn(|row, column| {
            self.get(row, column) * if row == column { raised } else { T::ONE }
        });
        if may_be && (certain || block.factor().is_some()) {
            return false;
        }
        let times = T::from_usize(TangentOf::<P>::DIMENSION);
        for row in coordinates() {
            coordinates().take(row).for_each(|column| self.set(row, column, T::ZERO));
            self.set(row, row, self.get(row, row) * times);
        }
        true
    }
}
