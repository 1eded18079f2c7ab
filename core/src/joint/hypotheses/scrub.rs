//! Memory scrubbing of several hypotheses.

use super::super::movers::Movers;
use super::filter::MultiHypothesisSlam;
use super::slot::Weight;
use crate::snapshot::visit::{Sealing, Visit};
use crate::{Flaw, Motion, Pose, Real, Scrubbed, Scrubber, Vector};

/// Position at which [`MultiHypothesisSlam::scrub`] continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HypothesesScrubber {
    place: usize,
    within: Scrubber,
}

impl HypothesesScrubber {
    /// A scrubber that starts with the likeliest hypothesis.
    pub const fn new() -> Self {
        Self { place: 0, within: Scrubber::new() }
    }
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    MultiHypothesisSlam<'_, M, Z, V, OTHERS>
{
    /// Checks `parts` parts of one hypothesis after the other, as [`JointSlam::scrub`](crate::JointSlam::scrub) does. If a
    /// hypothesis other than the likeliest cannot be repaired, it is dropped and counted as isolated.
    ///
    /// # Errors
    /// Damage of the likeliest hypothesis that cannot be repaired.
    pub fn scrub(&mut self, scrubber: &mut HypothesesScrubber, parts: usize) -> Result<Scrubbed, Flaw> {
        let before = self.hypotheses();
        self.drop_unsound();
        let mut scrubbed = Scrubbed::default();
        let HypothesesScrubber { place, within } = scrubber;
        let result = self.with(*place, |slam| slam.scrub(within, parts));
        match result {
            Err(flaw) if *place == 0 => return Err(flaw),
            Err(_) => self.drop_at(*place),
            Ok(found) => scrubbed = found,
        }
        scrubbed.isolated += before.saturating_sub(self.hypotheses());
        if result.is_err() || scrubbed.round {
            let next = self.alive().find(|other| other > place);
            *scrubber = HypothesesScrubber { place: next.unwrap_or(0), within: Scrubber::new() };
            scrubbed.round = next.is_none();
        }
        Ok(scrubbed)
    }

    /// As [`JointSlam::seal`](crate::JointSlam::seal), of all hypotheses.
    pub fn seal(&self) -> u64 {
        let mut seal = Sealing::EMPTY;
        let own = self.slam.seal();
        [own as u32, (own >> 32) as u32].into_iter().for_each(|half| seal.word(half));
        for other in &self.others {
            seal.word(u32::from(other.weight.alive));
            if other.weight.alive {
                seal.scalar(other.weight.ln);
                other.header.walk(&mut seal);
                seal.count(other.header.len);
                other.estimate().used(0).iter().for_each(|&number| seal.scalar(number));
            }
        }
        seal.value()
    }

    pub(super) fn drop_at(&mut self, place: usize) {
        if let Some(other) = place.checked_sub(1).and_then(|index| self.others.get_mut(index)) {
            *other.weight = Weight::NONE;
        }
    }
}
