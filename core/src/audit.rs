//! The whole state looked over: what a vehicle may do while it stands still, and every test.

use crate::candidate::total_weight;
use crate::{
    Clutter, Dim, FieldOfView, Locating, Motion, Packed, Pose, Real, ScPhd, Sensor, Twice, plausible::is_within_range,
};
use core::fmt;

/// What is wrong with a state. The filter makes none of it; memory that was damaged may show it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Flaw {
    /// A pose is beyond every range.
    Pose,
    /// The weights do not sum to one.
    Weights,
    /// The lists of pages and the counts of who holds them do not agree.
    Pages,
    /// A component is not finite, not positive definite, or not where its page says.
    Component,
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pose => "a pose is beyond every range",
            Self::Weights => "the weights do not sum to one",
            Self::Pages => "pages and the counts of their holders do not agree",
            Self::Component => "a component is not finite, not positive definite or out of place",
        })
    }
}

impl core::error::Error for Flaw {}

/// How far Σ ζ may be from one, in units of the last place: what rounding leaves of a few thousand candidates.
const TOLERATED_ROUNDINGS: f64 = 1000.0;

impl<T, P, M, S, V, C, const K: usize, const D: usize, const E: usize, const Z: usize>
    ScPhd<'_, T, P, M, S, V, C, K, D, E, Z>
where
    T: Real,
    P: Pose<T, K>,
    M: Motion<T, K, Pose = P>,
    S: Locating<T, K, D, Z> + Sensor<T, D, Z, Pose = P>,
    V: FieldOfView<T, S::Frame, D, Z>,
    C: Clutter<T, Z>,
    Dim<K>: Packed,
    Dim<D>: Packed + Twice<E>,
    Dim<E>: Packed,
    Dim<Z>: Packed,
{
    /// Looks over everything that the filter knows: poses and weights, every component of every map, and who holds which page.
    /// The state is the same afterwards. Linear in the state, and no part of a step: for tests, and for vehicles that want to
    /// know whether their memory is sound.
    ///
    /// # Errors
    /// The first flaw that was found.
    pub fn audit(&mut self) -> Result<(), Flaw> {
        let candidates = self.memory.candidates();
        // Before the first reset all is zero, and nothing is known.
        if candidates.is_empty() {
            return Ok(());
        }
        if !candidates.iter().all(|candidate| is_within_range(&candidate.pose.coordinates())) {
            return Err(Flaw::Pose);
        }
        let off = (total_weight(candidates) - T::ONE).abs();
        if !(off <= T::EPSILON * T::from_f64(TOLERATED_ROUNDINGS)) {
            return Err(Flaw::Weights);
        }
        let particles = self.memory.cursor.particles;
        self.memory.still.audit(particles)?;
        self.memory.moving.audit(particles)
    }
}
