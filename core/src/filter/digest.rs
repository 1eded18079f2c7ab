//! A hash of the complete filter state.

use crate::numerics::fnv::Fnv;
use crate::{Motion, Pose, Proposal, Real, ScPhd};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// A hash of the complete state: every pose, weight and component to the last bit, and the random stream.
    ///
    /// The same inputs give the same digest on every machine, at every optimisation level. The digest depends on all data that
    /// influences later results, and not on the order of the pages in the pool.
    pub fn digest(&self) -> u64 {
        let mut digest = Fnv::EMPTY;
        self.memory.walk(matches!(self.config.proposal, Proposal::Informed(_)), &mut digest);
        digest.value()
    }
}
