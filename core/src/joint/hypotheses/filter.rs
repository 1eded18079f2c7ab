//! The filter with several hypotheses.

use super::super::archive::NoArchive;
use super::super::filter::JointSlam;
use super::super::movers::Movers;
use super::super::walk::Estimate;
use super::config::HypothesesConfig;
use super::slot::{Slot, Weight};
use super::storage::JointHypotheses;
use super::tracks::MoversOf;
use crate::models::require;
use crate::{LnSum, Motion, Pose, PoseEstimate, Real, ScalarOf, SetupError, Symmetric, Vector};

/// SLAM with several hypotheses of data association, each a joint map: made of a [`JointSlam`] by
/// [`with_hypotheses`](JointSlam::with_hypotheses). It is for vehicles that drive too long without landmarks to know which
/// one they detect next; otherwise one hypothesis is as accurate and takes a fraction of the time.
///
/// ```
/// use nalgebra::Vector2;
/// # use scphd::models::{ControlNoise, PlanarPose, Step, Unicycle};
/// use scphd::settings::HypothesesConfig;
/// use scphd::storage::{JointHypotheses, joint_numbers};
/// use scphd::{JointConfig, JointSlam, JointState};
///
/// const NUMBERS: usize = joint_numbers(3, 2, 24);
/// let mut state = Box::new(JointState::<PlanarPose<f32>, Vector2<f32>, 24, NUMBERS, 16>::new());
/// // Seven more hypotheses, without moving objects.
/// let mut others = Box::new(JointHypotheses::<PlanarPose<f32>, 7, 24, NUMBERS, 0>::new());
/// # let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02))?;
/// let slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
/// let mut slam = slam.with_hypotheses(&mut others, HypothesesConfig::default())?;
/// slam.reset(PlanarPose::new(0.0, 0.0, 0.0))?;
/// assert_eq!(slam.hypotheses(), 1);
/// assert_eq!(slam.likeliest().features().count(), 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MultiHypothesisSlam<'s, M: Motion, Z: Vector, V, const OTHERS: usize> {
    /// The filter with the likeliest hypothesis, except while another one is processed.
    pub(super) slam: JointSlam<'s, M, Z, NoArchive, V>,
    pub(super) others: [Slot<'s, M::Pose, V>; OTHERS],
    pub(super) config: HypothesesConfig<ScalarOf<M::Pose>>,
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: MoversOf<'s, M::Pose>>
    JointSlam<'s, M, Z, NoArchive, V>
{
    /// This filter with several hypotheses of data association. They belong to the state: pass both from the start, and
    /// again whenever the filter is constructed anew. Call [`with_movers`](Self::with_movers) before.
    ///
    /// # Errors
    /// The configuration is out of range, or the capacities are not those of the state and its movers.
    pub fn with_hypotheses<const OTHERS: usize, const FEATURES: usize, const NUMBERS: usize, const TRACKS: usize>(
        mut self,
        hypotheses: &'s mut JointHypotheses<M::Pose, OTHERS, FEATURES, NUMBERS, TRACKS>,
        config: HypothesesConfig<T>,
    ) -> Result<MultiHypothesisSlam<'s, M, Z, V, OTHERS>, SetupError> {
        config.check()?;
        require(self.memory.landmarks.len() == FEATURES, "FEATURES", "those of the state")?;
        let tracks = self.movers.tracks().map(|tracks| tracks.movers.len());
        require(tracks.is_none_or(|tracks| tracks == TRACKS), "TRACKS", "the capacity of the movers")?;
        let others = hypotheses.borrowed(&self.movers);
        Ok(MultiHypothesisSlam { slam: self, others, config })
    }
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    MultiHypothesisSlam<'s, M, Z, V, OTHERS>
{
    /// The filter with the likeliest hypothesis: its map, its moving objects, its pose.
    pub fn likeliest(&self) -> &JointSlam<'s, M, Z, NoArchive, V> {
        &self.slam
    }

    /// Number of hypotheses.
    pub fn hypotheses(&self) -> usize {
        self.alive().count()
    }

    /// The mean pose of all hypotheses and its covariance; `None` before the first reset.
    pub fn estimate_pose(&self) -> Option<PoseEstimate<M::Pose>> {
        let likeliest = self.slam.estimate_pose()?;
        if self.hypotheses() == 1 {
            return Some(likeliest);
        }
        let ln_all = self.ln_all();
        let share = |place| (self.ln_weight(place) - ln_all).exp();
        let mean =
            M::Pose::mean(self.alive().filter_map(|place| Some((share(place), self.estimate_of(place)?.header.pose))));
        let mut covariance = Symmetric::ZERO;
        for place in self.alive() {
            let Some(estimate) = self.estimate_of(place) else { continue };
            let off = estimate.header.pose.difference(&mean);
            let of_pose = estimate.pose_covariance();
            let own = Symmetric::from_fn(|row, column| of_pose.get(row, column) + off.at(row) * off.at(column));
            covariance = covariance.plus(&own.scaled(share(place)));
        }
        Some(PoseEstimate { mean, covariance })
    }

    /// Probability of the likeliest hypothesis.
    pub fn share(&self) -> T {
        (-self.ln_all()).exp()
    }

    /// Number of places that hypotheses may have.
    pub(super) fn places(&self) -> usize {
        self.config.most.min(1 + OTHERS)
    }

    /// The place of the likeliest, 0, and of all others that are in use.
    pub(super) fn alive(&self) -> impl Iterator<Item = usize> + '_ {
        let others = self.others.iter().enumerate();
        core::iter::once(0).chain(others.filter(|(_, other)| other.weight.alive).map(|(index, _)| index + 1))
    }

    /// ln of the weight of a hypothesis relative to the likeliest.
    pub(super) fn ln_weight(&self, place: usize) -> T {
        place.checked_sub(1).and_then(|index| self.others.get(index)).map_or(T::ZERO, |other| other.weight.ln)
    }

    /// ln of the sum of all weights.
    pub(super) fn ln_all(&self) -> T {
        let mut sum = LnSum::EMPTY;
        self.alive().for_each(|place| sum.add(self.ln_weight(place)));
        sum.ln()
    }

    /// The hypothesis at a place.
    pub(super) fn estimate_of(&self, place: usize) -> Option<Estimate<'_, M::Pose>> {
        match place.checked_sub(1) {
            None => Some(self.slam.memory.estimate()),
            Some(index) => self.others.get(index).map(Slot::estimate),
        }
    }

    pub(super) fn drop_others(&mut self) {
        self.others.iter_mut().for_each(|other| *other.weight = Weight::NONE);
    }

    /// Drops hypotheses that memory faults have made invalid, and those for which the tuning has no place.
    pub(super) fn drop_unsound(&mut self) {
        let places = self.places();
        for (index, other) in self.others.iter_mut().enumerate() {
            if index + 1 >= places || !(other.weight.is_sound() && other.header.started) {
                *other.weight = Weight::NONE;
            }
        }
    }

    /// Calls `work` with the filter over the hypothesis of this place.
    pub(super) fn with<Y>(
        &mut self,
        place: usize,
        work: impl FnOnce(&mut JointSlam<'s, M, Z, NoArchive, V>) -> Y,
    ) -> Y {
        self.exchange(place);
        let result = work(&mut self.slam);
        self.exchange(place);
        result
    }

    // Not inlined, so that its code exists once.
    #[inline(never)]
    fn exchange(&mut self, place: usize) {
        let Self { slam, others, .. } = self;
        if let Some(other) = place.checked_sub(1).and_then(|index| others.get_mut(index)) {
            other.exchange(&mut slam.memory, &mut slam.movers);
        }
    }

    /// Copies a hypothesis to another place.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.exchange(from);
        // The likeliest is now in the place of the other one.
        let to = if to == 0 { from } else { to };
        let Self { slam, others, .. } = self;
        if let Some(other) = to.checked_sub(1).and_then(|index| others.get_mut(index)) {
            other.copy(&slam.memory.estimate(), &slam.movers);
        }
        self.exchange(from);
    }
}
