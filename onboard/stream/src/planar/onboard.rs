//! The filter of a planar vehicle on board: its capacities, and its models from the head of the stream.

use super::{Odometry, Planar, Sensor, SensorModels, Vehicle};
use crate::Header;
use crate::onboard::{self, Aboard, Capacities, Helm, Onboard, Ram, RamPart, Refusal, config};
use core::marker::PhantomData;
use nalgebra::{Vector2, Vector3};
use scphd::errors::PredictError;
use scphd::models::{
    Ackermann, AckermannControl, AckermannGeometry, ControlNoise, Linearised, ModelError, Motion, Mounting, PlanarPose,
    RangeBearing, RangeBearingLimits, RangeBearingWindow, Rates, Sensing, Step, Unicycle, UnicycleControl,
    UniformClutter,
};
use scphd::numerics::Noise;
use scphd::storage::{Dynamic, MapMemory, Static};
use scphd::{Births, Detector, DetectorMemory, Real, ScPhd, State};

/// Capacities for the particles of section 5.3.1.
#[cfg(not(any(feature = "few-particles", feature = "small-pools")))]
mod room {
    pub(super) const PARTICLES: usize = 32;
    pub(super) const CANDIDATES: usize = 64;
    pub(super) const PAGES: usize = 192;
    pub(super) const MAP_PAGES: usize = 32;
    pub(super) const VIEW: usize = 96;
    pub(super) const MOVING_PAGES: usize = 112;
    pub(super) const MOVING_MAP_PAGES: usize = 10;
    pub(super) const MOVING_VIEW: usize = 72;
}

/// Capacities for informed particles, which need no samples.
#[cfg(feature = "few-particles")]
mod room {
    pub(super) const PARTICLES: usize = 4;
    pub(super) const CANDIDATES: usize = 4;
    pub(super) const PAGES: usize = 176;
    pub(super) const MAP_PAGES: usize = 40;
    pub(super) const VIEW: usize = 256;
    pub(super) const MOVING_PAGES: usize = 48;
    pub(super) const MOVING_MAP_PAGES: usize = 16;
    pub(super) const MOVING_VIEW: usize = 160;
}

/// Capacities for the same number of particles: a quarter of the pages that they need; the other capacities are what the stream
/// `faults` uses.
#[cfg(all(feature = "small-pools", not(feature = "few-particles")))]
mod room {
    pub(super) const PARTICLES: usize = 32;
    pub(super) const CANDIDATES: usize = 64;
    pub(super) const PAGES: usize = 80;
    pub(super) const MAP_PAGES: usize = 8;
    pub(super) const VIEW: usize = 96;
    pub(super) const MOVING_PAGES: usize = 24;
    pub(super) const MOVING_MAP_PAGES: usize = 10;
    pub(super) const MOVING_VIEW: usize = 72;
}

use room::{CANDIDATES, MAP_PAGES, MOVING_MAP_PAGES, MOVING_PAGES, MOVING_VIEW, PAGES, PARTICLES, VIEW};
/// Maximum number of measurements of a scan.
pub const MEASUREMENTS: usize = 64;
/// Capacity of an estimated map, features.
const FEATURES: usize = 128;

/// State of a filter with these increases of all capacities of the one on board.
type StateWith<
    T,
    const PARTICLES_AND: usize,
    const CANDIDATES_AND: usize,
    const PAGES_AND: usize,
    const VIEW_AND: usize,
    const MOVING_PAGES_AND: usize,
    const MOVING_VIEW_AND: usize,
> = State<
    PlanarPose<T>,
    PARTICLES_AND,
    CANDIDATES_AND,
    MapMemory<Static<Vector2<T>>, PARTICLES_AND, PAGES_AND, MAP_PAGES, VIEW_AND>,
    MapMemory<Dynamic<Vector2<T>>, PARTICLES_AND, MOVING_PAGES_AND, MOVING_MAP_PAGES, MOVING_VIEW_AND>,
>;

/// The working memory of the detector.
type Scratch<T, const MEASUREMENTS_AND: usize> = DetectorMemory<Vector2<T>, MEASUREMENTS_AND>;

type OnboardState<T> = StateWith<T, PARTICLES, CANDIDATES, PAGES, VIEW, MOVING_PAGES, MOVING_VIEW>;

/// All memory of the filter on board.
pub type Memory<T> = onboard::Memory<OnboardState<T>, Vector2<T>, Vector2<T>, MEASUREMENTS, FEATURES>;

/// The size of the state with these increases of the capacities, minus that of the one on board.
macro_rules! price {
    ($particles:expr, $candidates:expr, $pages:expr, $view:expr, $moving_pages:expr, $moving_view:expr) => {
        size_of::<
            StateWith<
                T,
                { PARTICLES + $particles },
                { CANDIDATES + $candidates },
                { PAGES + $pages },
                { VIEW + $view },
                { MOVING_PAGES + $moving_pages },
                { MOVING_VIEW + $moving_view },
            >,
        >() - size_of::<OnboardState<T>>()
    };
}

/// Use of the RAM, from the cost of each capacity: the size of a state with eight more of it.
const fn ram<T: Real>() -> Ram {
    let candidates = price!(0, 8, 0, 0, 0, 0) / 8;
    let particles = price!(8, 8, 0, 0, 0, 0) / 8 - candidates;
    Ram {
        total: size_of::<Memory<T>>(),
        state: size_of::<OnboardState<T>>() + size_of::<Scratch<T, MEASUREMENTS>>(),
        particles: particles * PARTICLES + candidates * CANDIDATES,
        pages: price!(0, 0, 8, 0, 0, 0) / 8 * PAGES,
        moving_pages: price!(0, 0, 0, 0, 8, 0) / 8 * MOVING_PAGES,
        scratch: size_of::<Scratch<T, MEASUREMENTS>>()
            + price!(0, 0, 0, 8, 0, 0) / 8 * VIEW
            + price!(0, 0, 0, 0, 0, 8) / 8 * MOVING_VIEW,
    }
}

impl<T: Real> Aboard<T> for Planar {
    type Kind = Self;
    type Memory = Memory<T>;
    type Filter<'m>
        = Onboard<'m, Self, Direct, Drive<T>, Sensing<RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>>>
    where
        T: 'm;

    const MEMORY: Memory<T> = Memory::with(State::new());
    const CAPACITIES: Capacities = Capacities {
        candidates: CANDIDATES,
        particles: PARTICLES,
        components: (MAP_PAGES + MOVING_MAP_PAGES) * scphd::storage::PAGE_LEN,
        components_in_all: (PAGES + MOVING_PAGES) * scphd::storage::PAGE_LEN,
        measurements: MEASUREMENTS,
    };
    const RAM_PARTS: [RamPart; 6] = ram::<T>().parts();

    fn start<'m>(header: &Header<Self>, memory: &'m mut Memory<T>) -> Result<Self::Filter<'m>, Refusal>
    where
        T: 'm,
    {
        let onboard::Memory { state, scratch, measurements, features } = memory;
        let mut filter = ScPhd::new(motion(header, margin(header))?, config(header), state)?;
        let detector = detector(&Sensor::first(header))?.over(scratch)?;
        filter.check(&detector)?;
        filter.reset(start(header), header.seed)?;
        Ok(Onboard { filter, detector, helm: Direct, kind: PhantomData, measurements, features })
    }
}

/// Passes controls through unchanged.
#[derive(Debug, Clone, Copy)]
pub struct Direct;

impl<T: Real> Helm<T, Odometry, [T; 2]> for Direct {
    fn control(&mut self, odometry: &Odometry) -> Result<Option<([T; 2], T)>, PredictError> {
        Ok(Some((odometry.control.map(T::from_f64), T::from_f64(odometry.dt_s))))
    }
}

/// The motion model that the head selects.
#[derive(Debug, Clone, Copy)]
pub enum Drive<T> {
    /// Speed of the encoder's wheel and steering angle.
    Ackermann(Ackermann<T>),
    /// Speed and turn rate.
    Unicycle(Unicycle<T>),
}

fn ackermann<T: Copy>([speed_mps, steering_rad]: [T; 2]) -> AckermannControl<T> {
    AckermannControl { speed_mps, steering_rad }
}

fn unicycle<T: Copy>([speed_mps, rate_radps]: [T; 2]) -> UnicycleControl<T> {
    UnicycleControl { speed_mps, rate_radps }
}

impl<T: Real> Motion for Drive<T> {
    type Pose = PlanarPose<T>;
    type Control = [T; 2];

    const TRANSLATION_INVARIANT: bool = true;

    fn check(&self) -> Result<(), ModelError> {
        match self {
            Self::Ackermann(car) => car.check(),
            Self::Unicycle(robot) => robot.check(),
        }
    }

    fn admits(&self, control: &[T; 2]) -> bool {
        match self {
            Self::Ackermann(car) => car.admits(&ackermann(*control)),
            Self::Unicycle(robot) => robot.admits(&unicycle(*control)),
        }
    }

    fn rates(&self, control: &[T; 2]) -> Rates<T> {
        match self {
            Self::Ackermann(car) => car.rates(&ackermann(*control)),
            Self::Unicycle(robot) => robot.rates(&unicycle(*control)),
        }
    }

    fn propagate(&self, pose: &Self::Pose, control: &[T; 2], dt: T) -> Self::Pose {
        match self {
            Self::Ackermann(car) => car.propagate(pose, &ackermann(*control), dt),
            Self::Unicycle(robot) => robot.propagate(pose, &unicycle(*control), dt),
        }
    }

    fn sample(&self, pose: &Self::Pose, control: &[T; 2], dt: T, noise: &mut Noise) -> Self::Pose {
        match self {
            Self::Ackermann(car) => car.sample(pose, &ackermann(*control), dt, noise),
            Self::Unicycle(robot) => robot.sample(pose, &unicycle(*control), dt, noise),
        }
    }

    fn linearise(&self, pose: &Self::Pose, control: &[T; 2], dt: T) -> Linearised<Vector3<T>> {
        match self {
            Self::Ackermann(car) => car.linearise(pose, &ackermann(*control), dt),
            Self::Unicycle(robot) => robot.linearise(pose, &unicycle(*control), dt),
        }
    }
}

/// Factor on the correlation time of odometry errors in a mixture.
pub(super) fn margin(header: &Header<Planar>) -> f64 {
    let margin = header.recursion.interval_margin;
    if margin == 0.0 { 1.0 } else { margin }
}

/// The motion model, with this factor on the correlation time of its errors.
pub(super) fn motion<T: Real>(header: &Header<Planar>, margin: f64) -> Result<Drive<T>, ModelError> {
    let numbers = &header.models;
    let noise = ControlNoise {
        speed_sigma_mps: T::from_f64(numbers.speed_sigma_mps),
        speed_sigma_ratio: T::from_f64(numbers.speed_sigma_ratio),
        turn_sigma: T::from_f64(numbers.turn_sigma),
        turn_sigma_ratio: T::from_f64(numbers.turn_sigma_ratio),
        interval_s: T::from_f64(numbers.noise_interval_s * margin),
    };
    Ok(match header.vehicle {
        Vehicle::Ackermann => {
            let geometry = AckermannGeometry {
                wheelbase_m: T::from_f64(numbers.wheelbase_m),
                encoder_offset_m: T::from_f64(numbers.encoder_offset_m),
                sensor_forward_m: T::from_f64(numbers.sensor_forward_m),
                sensor_left_m: T::from_f64(numbers.sensor_left_m),
            };
            Drive::Ackermann(Ackermann::new(geometry, noise)?)
        }
        Vehicle::Unicycle => Drive::Unicycle(Unicycle::new(Step::Euler, noise)?),
        Vehicle::UnicycleArc => Drive::Unicycle(Unicycle::new(Step::Arc, noise)?),
    })
}

/// The initial pose.
pub(super) fn start<T: Real>(header: &Header<Planar>) -> PlanarPose<T> {
    let super::Models { start_x_m, start_y_m, start_heading_rad, .. } = header.models;
    let [x, y, heading] = [start_x_m, start_y_m, start_heading_rad].map(T::from_f64);
    PlanarPose::new(x, y, heading)
}

pub(super) type PlanarSensing<T> = Sensing<RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>>;

/// A detector with its mounting.
pub(super) fn detector<T: Real>(sensor: &Sensor) -> Result<Detector<PlanarSensing<T>>, ModelError> {
    let births = Births {
        of_static: T::from_f64(sensor.birth_intensity),
        of_moving: T::from_f64(sensor.moving_birth_intensity),
    };
    let detector = Detector::new(sensing(&sensor.models)?, births)?;
    match mounting(&sensor.models)? {
        Some(mounting) => detector.mounted(mounting),
        None => Ok(detector),
    }
}

/// The mounting of the sensor; `None` if its pose is that of the vehicle.
fn mounting<T: Real>(sensor: &SensorModels) -> Result<Option<Mounting<T>>, ModelError> {
    place([sensor.mounted_forward_m, sensor.mounted_left_m, sensor.mounted_yaw_rad])
}

/// A mounting: position ahead and to the left, m, and rotation to the left, rad; `None` if all are zero.
pub(super) fn place<T: Real>(place: [f64; 3]) -> Result<Option<Mounting<T>>, ModelError> {
    if place == [0.0; 3] {
        return Ok(None);
    }
    let [forward, left, yaw] = place.map(T::from_f64);
    Mounting::in_plane(forward, left, yaw).map(Some)
}

fn sensing<T: Real>(sensor: &SensorModels) -> Result<PlanarSensing<T>, ModelError> {
    let limits = RangeBearingLimits {
        range_min_m: T::from_f64(sensor.range_min_m),
        range_max_m: T::from_f64(sensor.range_max_m),
        range_edge_m: T::from_f64(sensor.range_edge_m),
        bearing_center_rad: T::from_f64(sensor.bearing_center_rad),
        bearing_half_width_rad: T::from_f64(sensor.bearing_half_width_rad),
        bearing_edge_rad: T::from_f64(sensor.bearing_edge_rad),
        probability_near: T::from_f64(sensor.detection_near),
        probability_far: T::from_f64(sensor.detection_far),
    };
    let field_of_view = RangeBearingWindow::new(limits)?;
    Ok(Sensing {
        sensor: RangeBearing::new(T::from_f64(sensor.range_sigma_m), T::from_f64(sensor.bearing_sigma_rad))?,
        field_of_view,
        clutter: UniformClutter::of_scan(T::from_f64(sensor.clutter_per_scan), field_of_view.measure())?,
    })
}
