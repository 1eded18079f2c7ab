//! A prediction whose candidates are sampled one by one, by any number of threads.

use crate::filter::state::Memory;
use crate::particles::predict::{child_of, sample};
use crate::particles::short::short_beyond;
use crate::{Candidate, Motion, Noise, Pose, PredictError, Proposal, Real, ScPhd};

/// The data of a prediction that is in progress. Until it is [returned](ScPhd::end_predict) the filter has no candidates.
#[derive(Debug)]
pub struct Samples<'s, P: Pose> {
    /// The memory of all candidates.
    pub candidates: &'s mut [Candidate<P>],
    /// Number of candidates to sample, from the first on, in the order of the random stream.
    pub in_use: usize,
    /// The particles.
    pub selected: &'s mut [Candidate<P>],
    /// Whether each candidate must first be made a [child](ScPhd::child_of) of its particle.
    pub splits: bool,
    /// The random stream at the numbers of the first candidate.
    pub noise: Noise,
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'s, M> {
    /// [`predict`](Self::predict) without the sampling, which the caller does; `None` if there is nothing to sample. Since the last
    /// scan, only predictions may have changed the particles.
    ///
    /// # Errors
    /// As for `predict`.
    #[doc(hidden)]
    pub fn begin_predict(&mut self, control: &M::Control, dt: T) -> Result<Option<Samples<'s, M::Pose>>, PredictError> {
        if !(self.config.proposal == Proposal::Blind && dt > T::ZERO) {
            return self.predict(control, dt).map(|_| None);
        }
        self.check_prediction(control, dt)?;
        let Memory { cursor, candidates, selected, .. } = &mut self.memory;
        let Some(noise) = cursor.noise.clone() else { return Err(PredictError::NotStarted) };
        let splits = !cursor.predicted;
        if splits {
            // After a scan the particles are also in `selected`.
            if cursor.weighed == 0 {
                let particles = candidates.iter().take(cursor.particles);
                selected.iter_mut().zip(particles).for_each(|(slot, particle)| *slot = *particle);
            }
            cursor.children = self.config.samples;
            cursor.predicted = true;
        }
        cursor.wait(dt);
        let (candidates, selected) = (core::mem::take(candidates), core::mem::take(selected));
        Ok(Some(Samples { in_use: cursor.candidates(), candidates, selected, splits, noise }))
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

    /// Takes the candidates back, with the random stream behind the numbers of the last one.
    #[doc(hidden)]
    pub fn end_predict(&mut self, samples: Samples<'s, M::Pose>) {
        self.memory.candidates = samples.candidates;
        self.memory.selected = samples.selected;
        self.memory.cursor.noise = Some(samples.noise);
    }
}
