//! Traversal of the delayed births, for digests and snapshots, and their validity check.

use crate::filter::waiting::memory::{Awaited, Awaiting, Birthplace, Waiting, are_below, words_for};
use crate::numerics::range::is_within_range;
use crate::snapshot::read::Reader;
use crate::snapshot::visit::Visit;
use crate::{Pose, Real, Symmetric};

impl<T: Real, P: Pose<Scalar = T>> Waiting<'_, P> {
    /// Whether there is data to store.
    pub(crate) fn is_anything(&self) -> bool {
        self.awaiting.len > 0 || self.awaiting.several
    }

    /// Visits the delayed births of the first `particles` particles, if any.
    pub(crate) fn walk(&self, particles: usize, visit: &mut impl Visit) {
        if !self.is_anything() {
            return;
        }
        let Awaiting { len, several, first_label, sensor } = *self.awaiting;
        let words = [u32::from(len), u32::from(several), first_label, sensor as u32, (sensor >> 32) as u32];
        words.into_iter().for_each(|word| visit.word(word));
        for awaited in self.awaited.iter().take(usize::from(len)) {
            awaited.z.iter().for_each(|&coordinate| visit.scalar(coordinate));
            visit.scalar(awaited.ln_reference);
        }
        let words = words_for(usize::from(len));
        for (particle, birthplace) in self.birthplaces.iter().take(particles).enumerate().filter(|_| len > 0) {
            for births in self.noted.births(particle).iter().take(words) {
                visit.word(*births as u32);
                visit.word((births >> 32) as u32);
            }
            self.weights(particle).iter().for_each(|&weight| visit.scalar(weight));
            visit.pose(&birthplace.pose);
            birthplace.covariance.as_lower().iter().for_each(|&x| visit.scalar(x));
        }
    }

    /// Restores what [`walk`](Self::walk) has written. Data beyond the capacity is left out, which an audit detects.
    pub(crate) fn fill<S, E>(&mut self, particles: usize, from: &mut Reader<'_, S, E>)
    where
        S: FnMut(usize, &mut [u8]) -> Result<(), E>,
    {
        let [len, several, first_label, low, high] = core::array::from_fn(|_| from.word());
        let sensor = u64::from(low) | u64::from(high) << 32;
        *self.awaiting =
            Awaiting { len: len.min(u32::from(u16::MAX)) as u16, several: several != 0, first_label, sensor };
        for slot in self.awaited.iter_mut().take(len as usize) {
            let z = core::array::from_fn(|_| from.scalar());
            *slot = Awaited { z, ln_reference: from.scalar(), missed: [T::ZERO; 2] };
        }
        let words = words_for(len as usize);
        let notes = self.noted.weights.iter_mut().zip(self.noted.births.chunks_mut(self.noted.words.max(1)));
        for ((weights, births), birthplace) in
            notes.zip(self.birthplaces.iter_mut()).take(particles).filter(|_| len > 0)
        {
            for births in births.iter_mut().take(words) {
                *births = u64::from(from.word()) | u64::from(from.word()) << 32;
            }
            *weights = core::array::from_fn(|_| from.scalar());
            *birthplace = Birthplace { pose: from.pose(), covariance: Symmetric::from_fn(|_, _| from.scalar()) };
        }
    }

    /// Whether the delayed births of the first `particles` particles are valid.
    pub(crate) fn is_sound(&self, particles: usize) -> bool {
        let len = usize::from(self.awaiting.len);
        let awaited = self.awaited.get(..len);
        awaited.is_some_and(|awaited| awaited.iter().all(Awaited::is_sound))
            && (0..particles.min(self.noted.weights.len())).all(|particle| self.is_sound_for(particle))
    }

    /// Removes all delayed births if they are invalid. Returns whether they were.
    pub(crate) fn mend(&mut self, particles: usize) -> bool {
        if self.is_sound(particles) {
            return false;
        }
        self.forget();
        true
    }

    fn is_sound_for(&self, particle: usize) -> bool {
        let Some(birthplace) = self.birthplaces.get(particle) else { return false };
        let (births, len) = (self.noted.births(particle), usize::from(self.awaiting.len));
        let most = T::from_usize(self.awaited.len());
        are_below(births, len)
            && self.weights(particle).iter().all(|&weight| weight >= T::ZERO && weight <= most)
            && (births.iter().all(|&word| word == 0)
                || birthplace.pose.is_finite()
                    && is_within_range(&birthplace.pose.coordinates())
                    && birthplace.covariance.is_finite())
    }
}

impl<T: Real> Awaited<T> {
    fn is_sound(&self) -> bool {
        self.z.iter().all(|coordinate| coordinate.is_finite()) && self.ln_reference.is_finite()
    }
}

#[cfg(test)]
impl<T: Real, P: Pose<Scalar = T>> Waiting<'_, P> {
    /// Whether there are delayed births.
    pub(crate) fn waits(&self) -> bool {
        self.awaiting.len > 0
    }

    /// Number of words and scalars in a snapshot, for a pose with three numbers and tangent coordinates.
    pub(crate) fn documented(&self, particles: usize) -> [usize; 2] {
        let len = usize::from(self.awaiting.len);
        let particles = if len > 0 { particles } else { 0 };
        if self.is_anything() { [5 + 2 * words_for(len) * particles, 5 * len + 11 * particles] } else { [0; 2] }
    }
}

#[cfg(any(test, feature = "flips"))]
impl Waiting<'_, crate::PlanarPose<f32>> {
    /// All data of the first `particles` particles' delayed births that a memory fault may change.
    pub(crate) fn words(&mut self, particles: usize, each: &mut crate::numerics::flip::Each<'_>) {
        use crate::numerics::flip::{Word, of_symmetric};
        let Awaiting { len, several, first_label, sensor } = &mut *self.awaiting;
        let (known, part) = (usize::from(*len), "waiting births");
        each(part, Word::Short(len));
        each(part, Word::Truth(several));
        each(part, Word::Long(first_label));
        each(part, Word::Wide(sensor));
        for awaited in self.awaited.iter_mut().take(known) {
            awaited.z.iter_mut().for_each(|coordinate| each(part, Word::Real(coordinate)));
            each(part, Word::Real(&mut awaited.ln_reference));
        }
        let particles = if known > 0 { particles } else { 0 };
        let notes = self.noted.weights.iter_mut().zip(self.noted.births.chunks_mut(self.noted.words.max(1)));
        for ((weights, births), birthplace) in notes.zip(self.birthplaces.iter_mut()).take(particles) {
            births.iter_mut().for_each(|word| each(part, Word::Wide(word)));
            weights.iter_mut().for_each(|weight| each(part, Word::Real(weight)));
            let crate::PlanarPose { x_m, y_m, heading_rad } = &mut birthplace.pose;
            [x_m, y_m, heading_rad].into_iter().for_each(|number| each(part, Word::Real(number)));
            of_symmetric(part, &mut birthplace.covariance, each);
        }
    }
}
