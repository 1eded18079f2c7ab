//! Reading, writing and checking the settings of a description.

use crate::field::Place;
use crate::list::numbers;
use crate::{Description, Filter, Fixes, Invalid, PlanarState, SENSORS, Setting, StartError};
use scphd::Real;
use scphd::models::{CalibratedPose, ModelError, PlanarPose};

/// Upper limit of counts.
const MOST: u32 = i32::MAX.unsigned_abs();

/// A non-negative number as a count; `None` if it is not an integer.
#[inline(never)]
fn whole<T: Real>(number: T) -> Option<u32> {
    (number.floor() == number).then(|| number.to_i32().unsigned_abs())
}

impl<T: Real> Description<T> {
    /// The number of a setting; for a setting with choices, the index of the choice. `sensor` is used only for settings of a
    /// sensor. `None` if the description has no such part.
    #[must_use]
    pub fn get(&self, setting: Setting, sensor: usize) -> Option<T> {
        let mut copy = *self;
        match copy.place(setting.place(), sensor) {
            Some(Place::Number(number)) => Some(*number),
            Some(Place::Count(count)) => Some(T::from_usize(*count)),
            Some(Place::Small(count)) => Some(T::from_usize(usize::from(*count))),
            Some(Place::Seed(seed)) => Some(T::from_f64(*seed as f64)),
            None => self.choice(setting.place(), sensor).map(T::from_usize),
        }
    }

    /// Sets a setting.
    ///
    /// # Errors
    /// The number is out of range, or the description has no such part; the description is unchanged.
    pub fn set(&mut self, setting: Setting, sensor: usize, number: T) -> Result<(), Invalid> {
        let invalid = Invalid::of(setting, sensor);
        if !numbers(setting.place()).is_some_and(|range| range.has(number)) {
            return Err(invalid);
        }
        let whole = || whole(number).ok_or(invalid);
        match self.place(setting.place(), sensor) {
            Some(Place::Number(place)) => *place = number,
            Some(Place::Count(place)) => {
                let count = whole()?;
                *place = if count < MOST { count as usize } else { usize::MAX };
            }
            Some(Place::Small(place)) => *place = u16::try_from(whole()?).map_err(|_| invalid)?,
            Some(Place::Seed(place)) => *place = u64::from(whole()?),
            None => return if self.choose(setting.place(), sensor, whole()? as usize) { Ok(()) } else { Err(invalid) },
        }
        Ok(())
    }

    /// Checks the range of every setting. Whether they fit each other is checked when models and filter are constructed. Not
    /// inlined, so that the copy is on the stack only here.
    ///
    /// # Errors
    /// The first error.
    #[inline(never)]
    pub fn check_ranges(&self) -> Result<(), StartError> {
        let mut copy = *self;
        for setting in Setting::all() {
            let Some(range) = numbers(setting.place()) else { continue };
            let places = if setting.is_of_a_sensor() { SENSORS } else { 1 };
            for sensor in 0..places {
                if copy.place(setting.place(), sensor).is_some_and(|place| !place.is_in(range)) {
                    return Err(Invalid::of(setting, sensor).into());
                }
            }
        }
        if self.vehicle.noise.is_none() {
            return Err(ModelError::new("vehicle.noise", "above 0 in one of its numbers").into());
        }
        Ok(())
    }

    /// Checks the range of every setting, and that they fit each other.
    ///
    /// # Errors
    /// The first error.
    pub fn check(&self) -> Result<(), StartError> {
        self.check_ranges()?;
        let drive = self.vehicle.drive()?;
        match self.filter {
            Filter::Mixture(config) => config.check().map_err(scphd::errors::SetupError::from)?,
            Filter::Joint(joint) => {
                joint.config.check().map_err(scphd::errors::SetupError::from)?;
                joint.hypotheses.map_or(Ok(()), |config| config.check()).map_err(scphd::errors::SetupError::from)?;
                if joint.odometry.is_some() {
                    CalibratedPose::moves(drive, joint.odometry)?;
                }
            }
        }
        for sensor in self.sensors.iter().flatten() {
            sensor.check::<PlanarPose<T>>()?;
        }
        Fixes::of(self)?;
        Ok(())
    }
}
