//! A check of the complete state, for tests and for vehicles that check their memory.

use crate::filter::state::Memory;
use crate::numerics::range::is_within_range;
use crate::particles::candidate::{Candidate, total_weight};
use crate::{Flaw, Motion, Pose, Real, ScPhd, Symmetric};

/// Tolerance of Σ ζ = 1 in units of the last place: the rounding errors of some thousand candidates.
const TOLERATED_ROUNDINGS: f64 = 1000.0;

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// Checks the complete filter state: poses and weights, every component of every map, and the reference counts of all pages.
    /// The state is the same afterwards. The cost is linear in the size of the state; no step calls it. For tests, and for vehicles
    /// that check their memory.
    ///
    /// # Errors
    /// The first flaw that is found.
    pub fn audit(&mut self) -> Result<(), Flaw> {
        self.memory.audit()
    }
}

impl<T: Real, P: Pose<Scalar = T>> Memory<'_, P> {
    /// Returns the first flaw of the state, if any.
    pub(crate) fn audit(&mut self) -> Result<(), Flaw> {
        if self.cursor.particles == 0 {
            return Ok(());
        }
        self.check_cursor()?;
        let pose_covariances = self.pose_covariances.get(..self.cursor.particles).unwrap_or(&[]);
        let candidates = self.candidates();
        if !(candidates.iter().all(|candidate| is_within_range(&candidate.pose.coordinates()))
            && pose_covariances.iter().all(Symmetric::is_finite))
        {
            return Err(Flaw::Pose);
        }
        if !Self::is_one(candidates) {
            return Err(Flaw::Weights);
        }
        let particles = self.cursor.particles;
        if !self.waiting.is_sound(particles) {
            return Err(Flaw::Waiting);
        }
        self.static_maps.audit(particles)?;
        self.moving_maps.audit(particles)
    }

    /// Whether the weights sum to one within rounding errors.
    pub(crate) fn is_one(candidates: &[Candidate<P>]) -> bool {
        let off = (total_weight(candidates) - T::ONE).abs();
        off <= T::EPSILON * T::from_f64(TOLERATED_ROUNDINGS)
    }

    /// Whether the counts and times of a started filter are valid.
    pub(crate) fn check_cursor(&self) -> Result<(), Flaw> {
        let cursor = &*self.cursor;
        let sound = cursor.particles >= 1
            && cursor.noise.is_some()
            && cursor.particles <= self.pose_covariances.len()
            && cursor.children >= 1
            && cursor.candidates() <= self.candidates.len()
            && cursor.weighed <= self.ln_likelihoods.len()
            && cursor.heaviest < cursor.particles
            && cursor.waited_s >= T::ZERO
            && cursor.waited_s.is_finite();
        if sound { Ok(()) } else { Err(Flaw::Cursor) }
    }
}
