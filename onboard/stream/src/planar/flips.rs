//! The filters of a planar vehicle with simulated memory faults, in single precision.

use super::Planar;
use super::onboard::{MEASUREMENTS, Noise, OnBoard};
use crate::black_box::KIND;
use crate::flips::Failing;
use crate::onboard::Refusal;
use nalgebra::Vector2;
use scphd::JointSlam;
use scphd::diagnostics::{Scrubbed, Scrubber};
use scphd::errors::Flaw;
use scphd::models::{PlanarMotion, PlanarPose};
use scphd::numerics::Noise as Draws;
use scphd::snapshot::{from_slice, into_slice};
use scphd_vehicle::{Joint, Mixture, PolarRooms, Services as _};

/// The methods of a filter of `scphd-vehicle`.
macro_rules! failing {
    ($filter:ty) => {
        impl Failing<Planar> for OnBoard<'_, $filter, f32, false> {
            fn flip_bit(&mut self, draws: &mut Draws) {
                self.slam.filter().flip_bit(draws);
            }

            fn scrub(&mut self, scrubber: &mut Scrubber, parts: usize) -> Result<Scrubbed, Flaw> {
                self.slam.filter().scrub(scrubber, parts)
            }

            fn save_into(&mut self, bytes: &mut [u8]) -> Option<usize> {
                self.slam.save(KIND, &mut into_slice(bytes)).ok()
            }

            fn restore_from(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
                let restored = self.slam.restore(KIND, &mut from_slice(bytes));
                restored.map(drop).map_err(|_| Refusal::Unusable { why: "the snapshot cannot be used" })
            }
        }
    };
}

failing!(Mixture<'_, f32, PolarRooms<f32, MEASUREMENTS, Noise<f32>>>);
failing!(Joint<JointSlam<'_, PlanarMotion<f32>, Vector2<f32>>, PlanarPose<f32>, Noise<f32>>);
