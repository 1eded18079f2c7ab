//! One run: a filter over the scans of a scenario.

use crate::buffer::{Prediction, Run, Scan, Status, joined};
use crate::memory::{Particles, Slot};
use crate::setup::{Sighting, control_of, describe};
use nalgebra::Vector2;
use scphd::models::{PlanarMotion, RangeBearing, RangeBearingWindow, RangeNoise, UniformClutter, WithNoise};
use scphd::storage::ScanRoom;
use scphd::{Detector, ScPhd};
use scphd_vehicle::{Description, Filter as Tuning};

/// The inputs of a run.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// The filter.
    pub run: &'a Run,
    /// All scans of the run.
    pub scans: &'a [Scan],
    /// All predictions of the run.
    pub predictions: &'a [Prediction],
    /// All measurements of the run.
    pub measurements: &'a [Vector2<f32>],
}

/// Processes all scans of a run by the library's own scan, on one core, and calls `each` after each of them.
///
/// # Errors
/// The code of a [`Status`].
pub fn follow<M: Particles>(
    inputs: Inputs<'_>,
    slot: &mut Slot<M>,
    mut each: impl FnMut(&ScPhd<'_, PlanarMotion<f32>>),
) -> Result<(), u32> {
    let (mut filter, mut detector) = over(inputs.run, slot)?;
    for scan in 0..inputs.scans.len() {
        let (predictions, measurements) = before(inputs, scan)?;
        for Prediction { control, dt_s } in predictions {
            let control = control_of(filter.motion(), *control);
            filter.predict(&control, *dt_s).map_err(|_| Status::PREDICTION)?;
        }
        filter.scan(&mut detector, measurements).map_err(|_| Status::SCAN)?;
        each(&filter);
    }
    Ok(())
}

/// A filter over a slot's state, of any capacities.
pub(crate) type Filter<'s> = ScPhd<'s, PlanarMotion<f32>>;
/// The models of a sensor.
pub(crate) type Sensing =
    scphd::models::Sensing<WithNoise<RangeBearing<f32>, RangeNoise<f32>>, RangeBearingWindow<f32>, UniformClutter<f32>>;
/// The sensor of a run.
pub(crate) type Sighted<'s> = Detector<Sensing, ScanRoom<'s, Vector2<f32>>>;

/// The started filter and the sensor over a slot, and the memory for estimates.
pub(crate) fn over<'s, M: Particles>(run: &Run, slot: &'s mut Slot<M>) -> Result<(Filter<'s>, Sighted<'s>), u32> {
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

/// The predictions before a scan, and its measurements.
pub(crate) fn before<'i>(inputs: Inputs<'i>, place: usize) -> Result<(&'i [Prediction], &'i [Vector2<f32>]), u32> {
    let scan = inputs.scans.get(place).ok_or(Status::BUFFERS)?;
    let predictions = part(inputs.predictions, scan.first_prediction, scan.predictions).ok_or(Status::BUFFERS)?;
    let measurements = part(inputs.measurements, scan.first_measurement, scan.measurements).ok_or(Status::BUFFERS)?;
    Ok((predictions, measurements))
}

/// `count` elements from `first` on; `None` if there are fewer.
fn part<T>(all: &[T], first: u32, count: u32) -> Option<&[T]> {
    let first = usize::try_from(first).ok()?;
    all.get(first..)?.get(..usize::try_from(count).ok()?)
}
