//! The filter of a run.

use crate::buffer::{Run, Status, joined};
use crate::memory::{Particles, Slot};
use crate::setup::{Sighting, describe};
use nalgebra::Vector2;
use scphd::models::{PlanarMotion, RangeBearing, RangeBearingWindow, RangeNoise, UniformClutter, WithNoise};
use scphd::storage::ScanRoom;
use scphd::{Detector, ScPhd};
use scphd_vehicle::{Description, Filter as Tuning};

/// A filter over a slot's state, of any capacities.
pub type Filter<'s> = ScPhd<'s, PlanarMotion<f32>>;
/// The models of a sensor.
pub type Sensing =
    scphd::models::Sensing<WithNoise<RangeBearing<f32>, RangeNoise<f32>>, RangeBearingWindow<f32>, UniformClutter<f32>>;
/// The sensor of a run.
pub type Sighted<'s> = Detector<Sensing, ScanRoom<'s, Vector2<f32>>>;

/// The started filter and the sensor over a slot.
///
/// # Errors
/// The code of a [`Status`].
pub fn over<'s, M: Particles>(run: &Run, slot: &'s mut Slot<M>) -> Result<(Filter<'s>, Sighted<'s>), u32> {
    let Slot { memory, scratch, .. } = slot;
    let refused = Status::SETUP;
    let mut description = Description::robot();
    let (motion, sensor) = describe(&mut description, &run.setup).ok_or(refused)?;
    let Tuning::Mixture(config) = description.filter else { return Err(refused) };
    let mut filter = memory.filter(motion, config).map_err(|_| refused)?;
    let detector = Sighting::over(sensor, scratch).map_err(|_| refused)?;
    filter.check(&detector).map_err(|_| refused)?;
    filter.reset(description.start.pose, joined(run.seed)).map_err(|_| refused)?;
    Ok((filter, detector))
}
