//! The description of a vehicle.

use crate::{FixSpec, Sensor, Vehicle, VehicleKind};
use nalgebra::Vector3;
use scphd::models::{AckermannGeometry, ControlNoise, OdometryPrior, PlanarPose};
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
    /// The covariance of the pose, if it is not certain: one that is no number is refused where it is used.
    pub(crate) fn covariance(&self) -> Option<Symmetric<Vector3<T>>> {
        let [place, heading] = [self.position_sigma_m, self.heading_sigma_rad].map(|sigma| sigma * sigma);
        (place + heading != T::ZERO).then(|| Symmetric::from_diagonal([place, place, heading]))
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
}
