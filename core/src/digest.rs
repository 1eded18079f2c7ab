//! A digest of everything the filter knows.

use crate::{Component, Motion, Pose, Proposal, Real, ScPhd, Vector};

/// 64-bit FNV-1a over 32-bit words.
pub(crate) struct Fnv(u64);

impl Fnv {
    /// Of nothing.
    pub(crate) const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    /// Goes on from another one's value.
    pub(crate) fn after(value: u64) -> Self {
        Self(value)
    }

    /// Of all that was taken in.
    pub(crate) fn value(&self) -> u64 {
        self.0
    }

    pub(crate) fn take(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    pub(crate) fn take_scalar<T: Real>(&mut self, x: T) {
        let bits = x.bits();
        self.take(bits as u32);
        self.take((bits >> 32) as u32);
    }

    fn take_map<'c, T: Real, N: Vector<Scalar = T>>(&mut self, map: impl Iterator<Item = &'c Component<N>>) {
        for component in map {
            self.take(component.tag);
            self.take_scalar(component.ln_weight);
            component.mean.as_slice().iter().for_each(|&x| self.take_scalar(x));
            component.covariance.as_lower().iter().for_each(|&x| self.take_scalar(x));
        }
        self.take(u32::MAX);
    }
}

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
            digest.take_map(self.map(particle));
            digest.take_map(self.moving_map(particle));
        }
        digest.0
    }
}
