//! A prediction whose candidates are moved one by one, by any number of threads.

use crate::filter::state::Memory;
use crate::particles::predict::{child_of, sample};
use crate::particles::short::short_beyond;
use crate::{Candidate, Motion, Noise, Pose, PredictError, Proposal, Real, ScPhd};

/// What the samples of a prediction are drawn with, until they are [given back](ScPhd::end_predict): there are no candidates meanwhile.
#[derive(Debug)]
pub struct Samples<'s, P: Pose> {
    /// The memory of all candidates.
    pub candidates: &'s mut [Candidate<P>],
    /// So many of them, from the first on, are to move, one after the other along the stream.
    pub in_use: usize,
    /// The particles.
    pub selected: &'s mut [Candidate<P>],
    /// Whether each candidate is to be made a [child](ScPhd::child_of) of its particle first.
    pub splits: bool,
    /// The random stream, from the first one's numbers on.
    pub noise: Noise,
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'s, M> {
    /// [`predict`](Self::predict) but for the samples, which are lent; `None` where none is drawn. Since the last scan nothing but predictions
    /// may have changed the particles.
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
            // A scan leaves the particles among the selected ones, too.
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

    /// Moves one of the candidates (5.12), with the numbers of the stream that are its own.
    #[doc(hidden)]
    pub fn sample(&self, candidate: &mut Candidate<M::Pose>, control: &M::Control, dt: T, noise: &mut Noise) {
        sample(&self.motion, candidate, control, dt, short_beyond(&self.motion, control, dt), noise);
    }

    /// Takes the candidates back, with the stream as it is behind the last one's numbers.
    #[doc(hidden)]
    pub fn end_predict(&mut self, samples: Samples<'s, M::Pose>) {
        self.memory.candidates = samples.candidates;
        self.memory.selected = samples.selected;
        self.memory.cursor.noise = Some(samples.noise);
    }
}
