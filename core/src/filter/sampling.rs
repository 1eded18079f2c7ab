//! A prediction whose candidates are sampled one by one, by any number of threads.

use crate::filter::state::Memory;
use crate::particles::predict::{child_of, grow, sample};
use crate::particles::short::short_beyond;
use crate::{Candidate, CovarianceOf, Motion, Noise, Pose, PredictError, Proposal, Real, ScPhd};
use core::mem::take;

/// The data of a prediction that is in progress. Until it is [returned](ScPhd::end_predict) the filter has no candidates.
#[derive(Debug)]
pub struct Samples<'s, P: Pose> {
    /// The memory of all candidates.
    pub candidates: &'s mut [Candidate<P>],
    /// Number of candidates to sample, from the first on, in the order of the random stream.
    pub in_use: usize,
    /// The particles.
    pub selected: &'s mut [Candidate<P>],
    /// The covariance of every particle's pose.
    pub pose_covariances: &'s mut [CovarianceOf<P>],
    /// Whether each candidate must first be made a [child](ScPhd::child_of) of its particle.
    pub splits: bool,
    /// The random stream at the numbers of the first candidate.
    pub noise: Noise,
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'s, M> {
    /// [`predict`](Self::predict) without the [sampling](Self::sample) or, for an informed proposal, the motion of the
    /// [particles](Self::grow), which the caller does; `None` if there is no motion. Since the last scan, only predictions may have
    /// changed the particles.
    ///
    /// # Errors
    /// As for `predict`.
    #[doc(hidden)]
    pub fn begin_predict(&mut self, control: &M::Control, dt: T) -> Result<Option<Samples<'s, M::Pose>>, PredictError> {
        self.check_prediction(control, dt)?;
        let Memory { cursor, candidates, selected, pose_covariances, .. } = &mut self.memory;
        let Some(noise) = cursor.noise.clone() else { return Err(PredictError::NotStarted) };
        if !(dt > T::ZERO) {
            return Ok(None);
        }
        let splits = self.config.proposal == Proposal::Blind && !cursor.predicted;
        if splits {
            // After a scan the particles are also in `selected`.
            if cursor.weighed == 0 {
                let particles = candidates.iter().take(cursor.particles);
                selected.iter_mut().zip(particles).for_each(|(slot, particle)| *slot = *particle);
            }
            cursor.children = self.config.samples;
        }
        cursor.predicted = true;
        cursor.wait(dt);
        let (candidates, selected, pose_covariances) = (take(candidates), take(selected), take(pose_covariances));
        Ok(Some(Samples { in_use: cursor.candidates(), candidates, selected, pose_covariances, splits, noise }))
    }

    /// One of the candidates that a particle is split into (5.13).
    #[doc(hidden)]
    pub fn child_of(&self, particle: &Candidate<M::Pose>) -> Candidate<M::Pose> {
        child_of(particle, T::from_usize(self.config.samples).ln())
    }

    /// Samples the motion of one candidate (5.12), with its own numbers of the random stream.
    #[doc(hidden)]
    pub fn sample(&self, candidate: &mut Candidate<M::Pose>, control: &M::Control, dt: T, noise: &mut Noise) {
        sample(&self.motion, candidate, control, dt, short_beyond(&self.motion, control, dt), noise);
    }

    /// Moves one particle without noise and increases the covariance of its pose, for an informed proposal.
    #[doc(hidden)]
    pub fn grow(
        &self,
        particle: &mut Candidate<M::Pose>,
        pose_covariance: &mut CovarianceOf<M::Pose>,
        control: &M::Control,
        dt: T,
    ) {
        grow(&self.motion, particle, pose_covariance, control, dt, short_beyond(&self.motion, control, dt));
    }

    /// Takes the candidates back, with the random stream behind the numbers of the last one.
    #[doc(hidden)]
    pub fn end_predict(&mut self, samples: Samples<'s, M::Pose>) {
        self.memory.candidates = samples.candidates;
        self.memory.selected = samples.selected;
        self.memory.pose_covariances = samples.pose_covariances;
        self.memory.cursor.noise = Some(samples.noise);
    }
}
