//! The detectors of a filter, one for each sensor of its description.

use crate::{Description, SENSORS, Sensor, Setting, StartError};

/// Makes a detector of each sensor in the description; `None` where it has no sensor.
pub(crate) fn detectors<T, D>(
    description: &Description<T>,
    detector: impl Fn(&Sensor<T>) -> Result<D, StartError>,
) -> Result<[Option<D>; SENSORS], StartError> {
    let mut slots = [const { None }; SENSORS];
    for (slot, sensor) in slots.iter_mut().zip(&description.sensors) {
        *slot = sensor.as_ref().map(&detector).transpose()?;
    }
    Ok(slots)
}

/// Makes the detector of a sensor and stores it at this index. Not inlined, so that its code exists once.
#[inline(never)]
pub(crate) fn make_detector<T, D>(
    slots: &mut [Option<D>; SENSORS],
    index: usize,
    sensor: &Sensor<T>,
    detector: impl Fn(&Sensor<T>) -> Result<D, StartError>,
) -> Result<(), StartError> {
    let slot = slots.get_mut(index).ok_or(StartError::NoRoom { part: Setting::SENSOR_MODEL })?;
    *slot = Some(detector(sensor)?);
    Ok(())
}
