//! The filter of a session: its memory, and the description of the vehicle in the simulated world.

use crate::sensor::{MEASUREMENTS, RANGE_M, SIGMAS, Surroundings};
use crate::world::World;
use nalgebra::{Vector2, Vector4};
use scphd::models::{ControlNoise, ModelError, PlanarMotion, RangeBearingWindow};
use scphd::numerics::Vector;
use scphd::settings::Extraction;
use scphd::{Births, Component, Config, ScPhd, memory};
use scphd_vehicle::{Description, Mixture, PolarRooms, Sensor};

/// Maximum number of particles.
pub const PARTICLES: usize = 64;

memory! {
    type State: PlanarMotion<f32> {
        particles: 64, samples: 1,
        features { pages: 1024, pages_per_map: 32, in_view: 256 },
        moving { pages: 512, pages_per_map: 16, in_view: 128 },
    }
}

/// Working memory for scans.
type Rooms = PolarRooms<f32, MEASUREMENTS>;
pub(crate) type Filter<'m> = Mixture<'m, f32, Rooms>;
pub(crate) type Features = Found<Vector2<f32>, 96>;
pub(crate) type Movers = Found<Vector4<f32>, 32>;

/// Odometry noise of the filter: the error of worn wheels is covered by noise with a correlation time of half a second and more.
const NOISE: ControlNoise<f32> = ControlNoise {
    speed_sigma_mps: 0.1,
    speed_sigma_ratio: 0.05,
    turn_sigma: 0.02,
    turn_sigma_ratio: 0.05,
    interval_s: 0.5,
};
/// Ratio of clutter to birth intensity of static features, and of the birth intensities of moving and static features.
const CLUTTER_OVER_BIRTH: f32 = 20.0;
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

/// The memory of the filter.
#[derive(Debug)]
pub(crate) struct Memory {
    state: State,
    rooms: Rooms,
}

impl Memory {
    pub(crate) const NEW: Self = Self { state: State::new(), rooms: Rooms::new() };

    pub(crate) fn clear(&mut self) {
        self.state.clear();
    }

    /// The filter of a description, which continues with the state in the memory.
    pub(crate) fn filter(&mut self, description: &Description<f32>) -> Result<Filter<'_>, Refused> {
        let Self { state, rooms } = self;
        Mixture::start(description, rooms, |motion, config| ScPhd::reborrow(motion, config, state)).map_err(|_| Refused)
    }
}

/// The vehicle of the simulated world, with this seed and number of particles.
pub(crate) fn robot(seed: u64, particles: usize) -> Description<f32> {
    let mut robot = Description::robot();
    robot.vehicle.noise = NOISE;
    robot.filter = scphd_vehicle::Filter::Mixture(Config {
        unconfirmed_weight: 0.5,
        extraction: Extraction::Peaks,
        extraction_weight: 0.3,
        ..Config::blind(particles, 1)
    });
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
