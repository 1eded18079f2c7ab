//! A digest of everything the filter knows.

use crate::numerics::fnv::Fnv;
use crate::{Component, Motion, Pose, Proposal, Real, ScPhd, Vector};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// A hash of the complete state: every pose, weight and component to the last bit, and the random stream.
    ///
    /// The same inputs give the same digest on every machine, at every optimisation level. It does not depend on where
    /// in the pool a page lies, but on everything that decides how the filter goes on. What is learnt of a sensor stands in the
    /// [digest of its detector](crate::Detector::digest).
    #[must_use]
    pub fn digest(&self) -> u64 {
        let mut digest = Fnv::EMPTY;
        let cursor = &*self.memory.cursor;
        for count in [cursor.particles, cursor.children, usize::from(cursor.predicted), cursor.heaviest] {
            digest.take(count as u32);
        }
        digest.take(cursor.next_tag);
        digest.take_scalar(cursor.waited_s);
        if let Some(noise) = &cursor.noise {
            noise
                .bytes()
                .chunks(4)
                .for_each(|word| digest.take(word.iter().fold(0, |sum, &b| sum << 8 | u32::from(b))));
        }
        for candidate in self.candidates() {
            digest.take_scalar(candidate.ln_weight);
            candidate.pose.coordinates().as_slice().iter().for_each(|&x| digest.take_scalar(x));
        }
        if matches!(self.config.proposal, Proposal::Informed(_)) {
            for spread in self.memory.spreads.iter().take(cursor.particles) {
                spread.as_lower().iter().for_each(|&x| digest.take_scalar(x));
            }
        }
        for particle in 0..cursor.particles {
            take_map(&mut digest, self.map(particle));
            take_map(&mut digest, self.moving_map(particle));
        }
        digest.value()
    }
}

/// Takes in a map, component by component.
fn take_map<'c, T: Real, N: Vector<Scalar = T>>(digest: &mut Fnv, map: impl Iterator<Item = &'c Component<N>>) {
    for component in map {
        digest.take(component.tag);
        digest.take_scalar(component.ln_weight);
        component.mean.as_slice().iter().for_each(|&x| digest.take_scalar(x));
        component.covariance.as_lower().iter().for_each(|&x| digest.take_scalar(x));
    }
    digest.take(u32::MAX);
}
