//! The filters of a planar vehicle with simulated memory faults, in single precision.

use super::Planar;
use super::joint::OnboardPlanar;
use super::onboard::{Direct, Drive};
use crate::black_box::KIND;
use crate::flips::Failing;
use crate::onboard::{Onboard, Refusal};
use scphd::diagnostics::{Scrubbed, Scrubber};
use scphd::errors::Flaw;
use scphd::models::{MeasurementModel, PlanarPose};
use scphd::numerics::Noise;
use scphd::snapshot::{from_slice, into_slice};

/// The methods of a filter in the field `filter`.
macro_rules! failing {
    () => {
        fn flip_bit(&mut self, draws: &mut Noise) {
            self.filter.flip_bit(draws);
        }

        fn scrub(&mut self, scrubber: &mut Scrubber, parts: usize) -> Result<Scrubbed, Flaw> {
            self.filter.scrub(scrubber, parts)
        }

        fn save_into(&mut self, bytes: &mut [u8]) -> Option<usize> {
            self.filter.save(KIND, into_slice(bytes)).ok()
        }

        fn restore_from(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
            let restored = self.filter.restore(KIND, from_slice(bytes));
            restored.map(drop).map_err(|_| Refusal::Unusable { why: "the snapshot cannot be used" })
        }
    };
}

impl<X: MeasurementModel<Pose = PlanarPose<f32>>> Failing<Planar> for Onboard<'_, Planar, Direct, Drive<f32>, X>
where
    Self: crate::Filter<Planar>,
{
    failing!();
}

impl Failing<Planar> for OnboardPlanar<'_, f32> {
    failing!();
}
