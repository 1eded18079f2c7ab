//! The filter of a session: its memory, and the description of the vehicle in the simulated world.

use crate::sensor::{MEASUREMENTS, RANGE_M, SIGMAS, Surroundings};
use crate::world::World;
use nalgebra::{Vector2, Vector4};
use scphd::models::{ControlNoise, ModelError, PlanarMotion, PlanarPose, RangeBearingWindow};
use scphd::numerics::Vector;
use scphd::settings::{Extraction, MovingConfig};
use scphd::storage::Candidate;
use scphd::{Births, Component, Config, ScPhd, memory};
use scphd_vehicle::{
    Backing, Description, Fixes, JointSettings, Mixture, PolarRooms, Recordable as _, Sensor, Services, StartError,
    joint_backing,
};

/// Maximum number of particles.
pub const PARTICLES: usize = 64;

memory! {
    type State: PlanarMotion<f32> {
        particles: 64, samples: 1,
        features { pages: 1024, pages_per_map: 32, in_view: 256 },
        moving { pages: 512, pages_per_map: 16, in_view: 128 },
    }
}

/// Working memory for scans of a mixture.
type Rooms = PolarRooms<f32, MEASUREMENTS>;

/// Capacity of the joint map for features.
pub(crate) const FEATURES: usize = 96;

joint_backing! {
    struct JointMemory: PlanarPose<f32> { features: FEATURES, measurements: MEASUREMENTS, movers: 16 }
}

/// The filter of a session.
#[expect(clippy::large_enum_variant, reason = "there is one at a time, on the stack")]
#[derive(Debug)]
pub enum Filter<'m> {
    /// A joint map with moving-object tracks.
    Joint(<JointMemory as Backing<f32>>::Slam<'m>),
    /// A mixture for each particle.
    Mixture(Mixture<'m, f32, Rooms>),
}

impl Filter<'_> {
    /// All calls of the filter, of whichever kind.
    pub fn services(&mut self) -> &mut dyn Services<f32> {
        match self {
            Self::Joint(filter) => filter,
            Self::Mixture(filter) => filter,
        }
    }

    /// The particles; none of a joint map.
    pub(crate) fn particles(&mut self) -> &[Candidate<PlanarPose<f32>>] {
        match self {
            Self::Joint(_) => &[],
            Self::Mixture(filter) => filter.filter().candidates(),
        }
    }
}

pub(crate) type Features = Found<Vector2<f32>, FEATURES>;
pub(crate) type Movers = Found<Vector4<f32>, 32>;

/// Odometry noise of the filter: the error of worn wheels is covered by noise with a correlation time of half a second and more.
const NOISE: ControlNoise<f32> = ControlNoise {
    speed_sigma_mps: 0.1,
    speed_sigma_ratio: 0.05,
    turn_sigma: 0.02,
    turn_sigma_ratio: 0.05,
    interval_s: 0.5,
};
/// Ratio of the clutter intensity to the birth intensity of static features.
const CLUTTER_OVER_BIRTH: f32 = 20.0;
/// Ratio of the birth intensity of moving features to that of static ones.
const MOVING_SHARE: f32 = 0.3;
/// Least number of false measurements in a scan that the filter assumes; the birth intensity is proportional to it.
const LEAST_CLUTTER: f32 = 1.0;

/// An argument that is refused; the session is unchanged, or has to be started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refused;

/// Estimated features.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Found<N: Vector, const ROOM: usize> {
    pub(crate) features: [Component<N>; ROOM],
    pub(crate) found: usize,
}

impl<N: Vector, const ROOM: usize> Found<N, ROOM> {
    pub(crate) const NONE: Self = Self { features: [Component::ZERO; ROOM], found: 0 };

    pub(crate) fn found(&self) -> usize {
        self.found
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Component<N>> {
        self.features.iter().take(self.found)
    }
}

/// The memory of both kinds of filter.
#[derive(Debug)]
pub(crate) struct Memory {
    joint: JointMemory,
    state: State,
    rooms: Rooms,
}

impl Memory {
    pub(crate) const NEW: Self = Self { joint: JointMemory::new(), state: State::new(), rooms: Rooms::new() };

    /// Empties the state of the mixture, so that any configuration can start on it; the joint map is emptied by its reset.
    pub(crate) fn clear(&mut self) {
        self.state.clear();
    }

    /// The filter of a description, which continues with the state in the memory.
    pub(crate) fn filter(&mut self, description: &Description<f32>) -> Result<Filter<'_>, Refused> {
        self.start(description).map_err(|_| Refused)
    }

    fn start(&mut self, description: &Description<f32>) -> Result<Filter<'_>, StartError> {
        let Self { joint, state, rooms } = self;
        let fixes = Fixes::of(description)?;
        Ok(match description.filter {
            scphd_vehicle::Filter::Joint(_) => {
                let mut filter = joint.without_sensors(description, fixes)?;
                filter.add_sensors(description)?;
                Filter::Joint(filter)
            }
            scphd_vehicle::Filter::Mixture(_) => {
                // `reborrow` and not `new`, which would audit the whole state in every step.
                let mut filter = Mixture::without_sensors(description, fixes, rooms, |motion, config| {
                    ScPhd::reborrow(motion, config, state)
                })?;
                filter.add_sensors(description)?;
                Filter::Mixture(filter)
            }
        })
    }
}

/// The vehicle of the simulated world, with a joint map or, if there are particles, with a mixture of this seed.
pub(crate) fn robot(seed: u64, particles: usize) -> Description<f32> {
    let mut robot = Description::robot();
    robot.vehicle.noise = NOISE;
    robot.filter = if particles == 0 {
        let movers = Some(MovingConfig::walkers());
        scphd_vehicle::Filter::Joint(JointSettings { movers, ..JointSettings::default() })
    } else {
        scphd_vehicle::Filter::Mixture(Config {
            unconfirmed_weight: 0.5,
            extraction: Extraction::Peaks,
            extraction_weight: 0.3,
            ..Config::blind(particles, 1)
        })
    };
    (robot.start.pose, robot.start.seed) = (World::START, seed);
    robot
}

/// What the filter assumes about the sensor.
pub(crate) fn sensor(around: Surroundings) -> Result<Sensor<f32>, ModelError> {
    let mut sensor = Sensor::range_bearing(RANGE_M, around.detection, SIGMAS);
    sensor.window.range_edge_m = 3.0 * SIGMAS[0];
    sensor.clutter_per_scan = around.clutter.max(LEAST_CLUTTER);
    let of_static = sensor.clutter_per_scan / RangeBearingWindow::new(sensor.window)?.measure() / CLUTTER_OVER_BIRTH;
    sensor.births = Births { of_static, of_moving: MOVING_SHARE * of_static };
    Ok(sensor)
}
