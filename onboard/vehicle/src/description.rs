//! The description of a vehicle.

use crate::field::{Access, Place};
use crate::{Field, Invalid, Sensor, StartError, Vehicle, VehicleKind};
use crate::{FixSpec, PlanarState};
use nalgebra::Vector3;
use scphd::models::{AckermannGeometry, CalibratedPose, ControlNoise, OdometryPrior, PlanarPose};
use scphd::numerics::Symmetric;
use scphd::settings::MovingConfig;
use scphd::{Config, JointConfig, Real};

/// So many sensors at most are described.
pub const SENSORS: usize = 4;

/// A joint map, and what it has beside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointFilter<T> {
    /// Its tuning.
    pub config: JointConfig<T>,
    /// Features that move beside it, if any.
    pub movers: Option<MovingConfig<T>>,
    /// What is known of the odometry before it is learnt, if it is learnt.
    pub odometry: Option<OdometryPrior<T>>,
    /// How far the farthest-looking sensor sees, m, where features farther away go to an archive.
    pub archive_reach_m: Option<T>,
}

impl<T: Real> Default for JointFilter<T> {
    fn default() -> Self {
        Self { config: JointConfig::default(), movers: None, odometry: None, archive_reach_m: None }
    }
}

/// Which filter, with its tuning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Filter<T> {
    /// The single-cluster PHD filter.
    Mixture(Config<T>),
    /// The joint map.
    Joint(JointFilter<T>),
}

/// Where a vehicle starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<T> {
    /// The pose.
    pub pose: PlanarPose<T>,
    /// Standard deviation of its position, m. 0 with the other: certain.
    pub position_sigma_m: T,
    /// Standard deviation of its heading, rad.
    pub heading_sigma_rad: T,
    /// Seed of the random numbers of a mixture.
    pub seed: u64,
}

impl<T: Real> Start<T> {
    /// The covariance of the pose, if it is not certain.
    pub(crate) fn covariance(&self) -> Option<Symmetric<Vector3<T>>> {
        let [place, heading] = [self.position_sigma_m, self.heading_sigma_rad].map(|sigma| sigma * sigma);
        (place + heading > T::ZERO).then(|| Symmetric::from_diagonal([place, place, heading]))
    }
}

/// A vehicle in the plane with its filter, its sensors, its fixes and its start: plain numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Description<T> {
    /// How it moves.
    pub vehicle: Vehicle<T>,
    /// Its filter.
    pub filter: Filter<T>,
    /// Its sensors, each in a place of its own.
    pub sensors: [Option<Sensor<T>>; SENSORS],
    /// Measured positions, if there are such.
    pub position: Option<FixSpec<T>>,
    /// Measured headings, if there are such.
    pub heading: Option<FixSpec<T>>,
    /// Where it starts.
    pub start: Start<T>,
}

impl<T: Real> Description<T> {
    /// A robot that turns in place, with the noise of a wheeled vehicle and a joint map, without a sensor, at the origin.
    #[must_use]
    pub fn robot() -> Self {
        let (zero, one) = (T::ZERO, T::ONE);
        Self {
            vehicle: Vehicle {
                kind: VehicleKind::Unicycle,
                geometry: AckermannGeometry {
                    wheelbase_m: one,
                    encoder_offset_m: zero,
                    sensor_forward_m: zero,
                    sensor_left_m: zero,
                },
                noise: ControlNoise::wheeled(),
            },
            filter: Filter::Joint(JointFilter::default()),
            sensors: [None; SENSORS],
            position: None,
            heading: None,
            start: Start {
                pose: PlanarPose::new(zero, zero, zero),
                position_sigma_m: zero,
                heading_sigma_rad: zero,
                seed: 1,
            },
        }
    }

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
        crate::Fixes::of(self)?;
        Ok(())
    }
}
