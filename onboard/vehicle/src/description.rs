//! The description of a vehicle.

use crate::{FixSpec, Sensor, Vehicle, VehicleKind};
use nalgebra::Vector3;
use scphd::models::{AckermannGeometry, ControlNoise, OdometryPrior, PlanarPose};
use scphd::numerics::Symmetric;
use scphd::settings::{HypothesesConfig, MovingConfig};
use scphd::{Config, JointConfig, Real};

/// Maximum number of sensors.
pub const SENSORS: usize = 4;

/// A joint map with its optional parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSettings<T> {
    /// Tuning of the joint map.
    pub config: JointConfig<T>,
    /// Moving features, if any.
    pub movers: Option<MovingConfig<T>>,
    /// Prior of the odometry calibration, if the odometry is calibrated.
    pub odometry: Option<OdometryPrior<T>>,
    /// Greatest range of the sensors, m, if distant features are archived.
    pub archive_reach_m: Option<T>,
    /// Tuning of the hypotheses of data association, if there are several.
    pub hypotheses: Option<HypothesesConfig<T>>,
}

impl<T: Real> Default for JointSettings<T> {
    fn default() -> Self {
        let config = JointConfig::default();
        Self { config, movers: None, odometry: None, archive_reach_m: None, hypotheses: None }
    }
}

/// The type of the filter, with its tuning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Filter<T> {
    /// The single-cluster PHD filter.
    Mixture(Config<T>),
    /// The joint map.
    Joint(JointSettings<T>),
}

/// The initial pose of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<T> {
    /// The pose.
    pub pose: PlanarPose<T>,
    /// Standard deviation of its position, m. If both standard deviations are 0, the pose is exact.
    pub position_sigma_m: T,
    /// Standard deviation of its heading, rad.
    pub heading_sigma_rad: T,
    /// Seed of the random numbers of a mixture.
    pub seed: u64,
}

impl<T: Real> Start<T> {
    /// The covariance of the pose, unless it is exact. A NaN is refused where the covariance is used.
    pub(crate) fn covariance(&self) -> Option<Symmetric<Vector3<T>>> {
        let [place, heading] = [self.position_sigma_m, self.heading_sigma_rad].map(|sigma| sigma * sigma);
        (place + heading != T::ZERO).then(|| Symmetric::from_diagonal([place, place, heading]))
    }
}

/// A planar vehicle with its filter, sensors, fixes and initial pose, as numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Description<T> {
    /// The motion model.
    pub vehicle: Vehicle<T>,
    /// The filter.
    pub filter: Filter<T>,
    /// The sensors.
    pub sensors: [Option<Sensor<T>>; SENSORS],
    /// Position fixes, if any.
    pub position: Option<FixSpec<T>>,
    /// Heading fixes, if any.
    pub heading: Option<FixSpec<T>>,
    /// The initial pose.
    pub start: Start<T>,
}

impl<T: Real> Description<T> {
    /// A robot that turns in place, with the noise of a wheeled vehicle and a joint map, without sensors, at the origin.
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
            filter: Filter::Joint(JointSettings::default()),
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
}
