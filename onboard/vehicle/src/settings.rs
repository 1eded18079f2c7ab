//! Settings of a description by their names, and whether they are in range.

use crate::field::{Access, Place};
use crate::{Description, Field, Filter, Fixes, Invalid, PlanarState, SENSORS, StartError};
use scphd::Real;
use scphd::models::{CalibratedPose, PlanarPose};

impl<T: Real> Description<T> {
    /// The setting of this name.
    #[must_use]
    pub fn field(name: &str) -> Option<&'static Field<T>> {
        Self::FIELDS.iter().find(|field| field.name == name)
    }

    /// The number of a setting, of this sensor where it is one of a sensor; of one of several, its place in the list. `None` where the
    /// description has no such part.
    #[must_use]
    pub fn get(&self, field: &Field<T>, sensor: usize) -> Option<f64> {
        match field.access {
            Access::Choice { get, .. } => get(self, sensor).map(|choice| choice as f64),
            Access::Number(find) => {
                let mut copy = *self;
                Some(match find(&mut copy, sensor)? {
                    Place::Number(number) => number.to_f64(),
                    Place::Count(count) => *count as f64,
                    Place::Small(count) => f64::from(*count),
                    Place::Seed(seed) => *seed as f64,
                })
            }
        }
    }

    /// Sets a setting.
    ///
    /// # Errors
    /// The number is out of its range, or the description has no such part; it is as it was.
    pub fn set(&mut self, field: &'static Field<T>, sensor: usize, number: f64) -> Result<(), Invalid> {
        let invalid = Self::invalid(field, sensor);
        if !field.range.has(number) {
            return Err(invalid);
        }
        let whole = || (number as u64 as f64 == number).then_some(number as u64).ok_or(invalid);
        match field.access {
            Access::Choice { names, set, .. } => {
                let choice = usize::try_from(whole()?).ok().filter(|choice| *choice < names.len()).ok_or(invalid)?;
                if set(self, sensor, choice) { Ok(()) } else { Err(invalid) }
            }
            Access::Number(find) => {
                match find(self, sensor).ok_or(invalid)? {
                    Place::Number(place) => *place = T::from_f64(number),
                    Place::Count(place) => *place = usize::try_from(whole()?).map_err(|_| invalid)?,
                    Place::Small(place) => *place = u16::try_from(whole()?).map_err(|_| invalid)?,
                    Place::Seed(place) => *place = whole()?,
                }
                Ok(())
            }
        }
    }

    fn invalid(field: &'static Field<T>, sensor: usize) -> Invalid {
        Invalid { field: field.name, range: field.range, sensor: field.is_of_a_sensor().then_some(sensor) }
    }

    /// Whether every setting is in its range, and whether they fit each other.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self) -> Result<(), StartError> {
        for field in Self::FIELDS {
            let places = if field.is_of_a_sensor() { SENSORS } else { 1 };
            for sensor in 0..places {
                if self.get(field, sensor).is_some_and(|number| !field.range.has(number)) {
                    return Err(Self::invalid(field, sensor).into());
                }
            }
        }
        if self.vehicle.noise.is_none() {
            return Err(scphd::models::ModelError::new("vehicle.noise", "above 0 in one of its numbers").into());
        }
        let drive = self.vehicle.drive()?;
        match self.filter {
            Filter::Mixture(config) => config.check().map_err(scphd::errors::SetupError::from)?,
            Filter::Joint(joint) => {
                joint.config.check().map_err(scphd::errors::SetupError::from)?;
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
