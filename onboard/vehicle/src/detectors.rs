//! The detectors of a filter, one for each sensor of its description.

use crate::{Description, SENSORS, Sensor, Setting, StartError};

/// The detectors of a description.
pub(crate) fn detectors<T, D>(
    description: &Description<T>,
    detector: impl Fn(&Sensor<T>) -> Result<D, StartError>,
) -> Result<[Option<D>; SENSORS], StartError> {
    let mut places = [const { None }; SENSORS];
    for (place, sensor) in places.iter_mut().zip(&description.sensors) {
        *place = sensor.as_ref().map(&detector).transpose()?;
    }
    Ok(places)
}

/// Makes the detector of a sensor in its place. Not inlined, so that its code exists once.
#[inline(never)]
pub(crate) fn make_detector<T, D>(
    places: &mut [Option<D>; SENSORS],
    index: usize,
    sensor: &Sensor<T>,
    detector: impl Fn(&Sensor<T>) -> Result<D, StartError>,
) -> Result<(), StartError> {
    let place = places.get_mut(index).ok_or(StartError::NoRoom { part: Setting::SENSOR_MODEL })?;
    *place = Some(detector(sensor)?);
    Ok(())
}
