//! Traversal of the delayed births, for digests and snapshots, and their validity check.

use crate::filter::waiting::memory::{Awaited, Awaiting, Waiting, are_below, words_for};
use crate::numerics::range::is_within_range;
use crate::snapshot::read::Reader;
use crate::snapshot::visit::Visit;
use crate::{Place, Pose, Real, Symmetric, Vector};

impl<T: Real, P: Pose<Scalar = T>> Waiting<'_, P> {
    /// Whether there is data to store.
    pub(crate) fn is_anything(&self) -> bool {
        self.awaiting.len > 0
    }

    /// Visits the delayed births of the first `particles` particles, if any.
    pub(crate) fn walk(&self, particles: usize, visit: &mut impl Visit) {
        if !self.is_anything() {
            return;
        }
        let Awaiting { len, first_label, ln_births, origin } = &*self.awaiting;
        let len = usize::from(*len);
        visit.word(len as u32);
        visit.word(*first_label);
        ln_births.iter().for_each(|&ln_intensity| visit.scalar(ln_intensity));
        visit.pose(origin);
        for awaited in self.awaited.iter().take(len) {
            awaited.position.as_slice().iter().for_each(|&coordinate| visit.scalar(coordinate));
            awaited.covariance.as_lower().iter().for_each(|&x| visit.scalar(x));
            visit.scalar(awaited.ln_reference);
        }
        let words = words_for(len);
        for (particle, birthplace) in self.birthplaces.iter().take(particles).enumerate() {
            for births in self.noted.births(particle).iter().take(words) {
                visit.word(*births as u32);
                visit.word((births >> 32) as u32);
            }
            self.weights(particle).iter().for_each(|&weight| visit.scalar(weight));
            visit.pose(birthplace);
        }
    }

    /// Restores what [`walk`](Self::walk) has written. Data beyond the capacity is left out, which an audit detects.
    pub(crate) fn fill<S, E>(&mut self, particles: usize, from: &mut Reader<'_, S, E>)
    where
        S: FnMut(usize, &mut [u8]) -> Result<(), E>,
    {
        let len = from.word() as usize;
        let first_label = from.word();
        let ln_births = core::array::from_fn(|_| from.scalar());
        *self.awaiting =
            Awaiting { len: len.min(usize::from(u16::MAX)) as u16, first_label, ln_births, origin: from.pose() };
        for slot in self.awaited.iter_mut().take(len) {
            let position = from.vector();
            let covariance = Symmetric::from_fn(|_, _| from.scalar());
            *slot = Awaited { position, covariance, ln_reference: from.scalar(), ..Awaited::ZERO };
        }
        let words = words_for(len);
        let notes = self.noted.weights.iter_mut().zip(self.noted.births.chunks_mut(self.noted.words.max(1)));
        for ((weights, births), birthplace) in notes.zip(self.birthplaces.iter_mut()).take(particles) {
            for births in births.iter_mut().take(words) {
                *births = u64::from(from.word()) | u64::from(from.word()) << 32;
            }
            *weights = core::array::from_fn(|_| from.scalar());
            *birthplace = from.pose();
        }
    }

    /// Whether the delayed births of the first `particles` particles are valid.
    pub(crate) fn is_sound(&self, particles: usize) -> bool {
        let len = usize::from(self.awaiting.len);
        let awaited = self.awaited.get(..len);
        let Awaiting { ln_births, origin, .. } = &*self.awaiting;
        len == 0
            || ln_births.iter().all(|&ln_intensity| ln_intensity < T::INFINITY)
                && origin.is_finite()
                && is_within_range(&origin.coordinates())
                && awaited.is_some_and(|awaited| awaited.iter().all(Awaited::is_sound))
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
                || birthplace.is_finite() && is_within_range(&birthplace.coordinates()))
    }
}

impl<T: Real, D: Place<Scalar = T>> Awaited<D> {
    fn is_sound(&self) -> bool {
        is_within_range(&self.position) && self.covariance.is_finite() && self.ln_reference.is_finite()
    }
}

#[cfg(test)]
impl<T: Real, P: Pose<Scalar = T>> Waiting<'_, P> {
    /// Number of words and scalars in a snapshot, for a pose with three numbers and tangent coordinates.
    pub(crate) fn documented(&self, particles: usize) -> [usize; 2] {
        let len = usize::from(self.awaiting.len);
        if len > 0 { [2 + 2 * words_for(len) * particles, 5 + 6 * len + 5 * particles] } else { [0; 2] }
    }
}

#[cfg(any(test, feature = "flips"))]
impl Waiting<'_, crate::PlanarPose<f32>> {
    /// All data of the first `particles` particles' delayed births that a memory fault may change.
    pub(crate) fn words(&mut self, particles: usize, each: &mut crate::numerics::flip::Each<'_>) {
        use crate::numerics::flip::{Word, of_symmetric};
        let of_pose = |pose: &mut crate::PlanarPose<f32>, each: &mut crate::numerics::flip::Each<'_>| {
            let crate::PlanarPose { x_m, y_m, heading_rad } = pose;
            [x_m, y_m, heading_rad].into_iter().for_each(|number| each("waiting births", Word::Real(number)));
        };
        let Awaiting { len, first_label, ln_births, origin } = &mut *self.awaiting;
        let (known, part) = (usize::from(*len), "waiting births");
        each(part, Word::Short(len));
        each(part, Word::Long(first_label));
        ln_births.iter_mut().for_each(|ln_intensity| each(part, Word::Real(ln_intensity)));
        of_pose(origin, each);
        for awaited in self.awaited.iter_mut().take(known) {
            awaited.position.iter_mut().for_each(|coordinate| each(part, Word::Real(coordinate)));
            of_symmetric(part, &mut awaited.covariance, each);
            each(part, Word::Real(&mut awaited.ln_reference));
        }
        let particles = if known > 0 { particles } else { 0 };
        let notes = self.noted.weights.iter_mut().zip(self.noted.births.chunks_mut(self.noted.words.max(1)));
        for ((weights, births), birthplace) in notes.zip(self.birthplaces.iter_mut()).take(particles) {
            births.iter_mut().for_each(|word| each(part, Word::Wide(word)));
            weights.iter_mut().for_each(|weight| each(part, Word::Real(weight)));
            of_pose(birthplace, each);
        }
    }
}
