//! The filter that a stream is fed to: its capacities, its models, its tuning, from the head of the stream.

use crate::{Header, Vehicle, header};
use core::fmt;
use nalgebra::{SVector, Vector2};
use scphd::{
    Ackermann, AckermannControl, AckermannGeometry, Component, Config, ConstantVelocity, ControlNoise, Extraction,
    Informed, Likelihood, Linearised, MapMemory, ModelError, Models, Motion, MovingConfig, Noise, PlanarPose,
    PredictError, Probe, Proposal, RangeBearing, RangeBearingWindow, Real, Reduction, ResetError, ScPhd, ScanError,
    SetupError, State, Step, Unicycle, UnicycleControl, UniformClutter,
};

const PARTICLES: usize = 32;
const CANDIDATES: usize = 64;
const PAGES: usize = 320;
const MAP_PAGES: usize = 32;
const MOVING_PAGES: usize = 96;
const MOVING_MAP_PAGES: usize = 16;
/// Measurements that a scan can have.
pub const MEASUREMENTS: usize = 64;
const VIEW: usize = 256;
const MOVING_VIEW: usize = 128;
/// Features of an estimated map.
const FEATURES: usize = 128;

/// State of a filter with room for this many more of everything than the one on board.
type StateWith<
    T,
    const PARTICLES_AND: usize,
    const CANDIDATES_AND: usize,
    const PAGES_AND: usize,
    const MEASUREMENTS_AND: usize,
    const VIEW_AND: usize,
    const MOVING_PAGES_AND: usize,
    const MOVING_VIEW_AND: usize,
> = State<
    T,
    PlanarPose<T>,
    3,
    2,
    PARTICLES_AND,
    CANDIDATES_AND,
    MEASUREMENTS_AND,
    MapMemory<T, 2, 2, PARTICLES_AND, PAGES_AND, MAP_PAGES, VIEW_AND>,
    MapMemory<T, 4, 2, PARTICLES_AND, MOVING_PAGES_AND, MOVING_MAP_PAGES, MOVING_VIEW_AND>,
>;

type OnboardState<T> = StateWith<T, PARTICLES, CANDIDATES, PAGES, MEASUREMENTS, VIEW, MOVING_PAGES, MOVING_VIEW>;

type Filter<'m, T> =
    ScPhd<'m, T, PlanarPose<T>, Drive<T>, RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>, 3, 2, 4, 2>;

/// All memory of the filter on board: its state, a scan on its way in, an estimated map on its way out. All zero when
/// new, so that a `static` of it lies in .bss.
#[derive(Debug)]
pub struct Memory<T: Real> {
    state: OnboardState<T>,
    measurements: [SVector<T, 2>; MEASUREMENTS],
    features: [Component<T, 2>; FEATURES],
}

/// Fresh memory.
#[must_use]
pub const fn memory<T: Real>() -> Memory<T> {
    Memory {
        state: State::new(),
        measurements: [SVector::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; 2]; 1])); MEASUREMENTS],
        features: [Component::ZERO; FEATURES],
    }
}

/// What part of the memory serves a purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RamPart {
    /// What it is for.
    pub name: &'static str,
    /// How much it is.
    pub bytes: usize,
}

/// The state with so many more of each capacity, less the one on board, for each of them.
macro_rules! price {
    ($particles:expr, $candidates:expr, $pages:expr, $measurements:expr, $view:expr, $moving_pages:expr, $moving_view:expr) => {
        size_of::<
            StateWith<
                T,
                { PARTICLES + $particles },
                { CANDIDATES + $candidates },
                { PAGES + $pages },
                { MEASUREMENTS + $measurements },
                { VIEW + $view },
                { MOVING_PAGES + $moving_pages },
                { MOVING_VIEW + $moving_view },
            >,
        >() - size_of::<OnboardState<T>>()
    };
}

/// Where the RAM goes, from the price of each capacity: how much larger a state is with eight more of it.
#[must_use]
pub const fn ram_parts<T: Real>() -> [RamPart; 6] {
    let (total, state) = (size_of::<Memory<T>>(), size_of::<OnboardState<T>>());
    let candidates = price!(0, 8, 0, 0, 0, 0, 0) / 8;
    let particles = price!(8, 8, 0, 0, 0, 0, 0) / 8 - candidates;
    let particles = particles * PARTICLES + candidates * CANDIDATES;
    let pages = price!(0, 0, 8, 0, 0, 0, 0) / 8 * PAGES;
    let moving_pages = price!(0, 0, 0, 0, 0, 8, 0) / 8 * MOVING_PAGES;
    let scratch = price!(0, 0, 0, 8, 0, 0, 0) / 8 * MEASUREMENTS
        + price!(0, 0, 0, 0, 8, 0, 0) / 8 * VIEW
        + price!(0, 0, 0, 0, 0, 0, 8) / 8 * MOVING_VIEW;
    let named = particles + pages + moving_pages + scratch;
    [
        RamPart { name: "particles", bytes: particles },
        RamPart { name: "pages", bytes: pages },
        RamPart { name: "moving pages", bytes: moving_pages },
        RamPart { name: "scratch", bytes: scratch },
        RamPart { name: "other", bytes: state - named },
        RamPart { name: "in and out", bytes: total - state },
    ]
}

/// What bounds the work of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capacities {
    /// Candidates that are weighed, N·M.
    pub candidates: usize,
    /// Maps that are updated, N.
    pub particles: usize,
    /// Components of one map.
    pub components: usize,
    /// Components of all maps.
    pub components_in_all: usize,
    /// Measurements of a scan.
    pub measurements: usize,
}

/// What bounds the work of a scan with the memory on board.
pub const CAPACITIES: Capacities = Capacities {
    candidates: CANDIDATES,
    particles: PARTICLES,
    components: (MAP_PAGES + MOVING_MAP_PAGES) * scphd::PAGE_LEN,
    components_in_all: (PAGES + MOVING_PAGES) * scphd::PAGE_LEN,
    measurements: MEASUREMENTS,
};

/// The motion model that the head of the stream chooses.
#[derive(Debug, Clone, Copy)]
enum Drive<T> {
    Ackermann(Ackermann<T>),
    Unicycle(Unicycle<T>),
}

fn ackermann<T: Copy>([speed_mps, steering_rad]: [T; 2]) -> AckermannControl<T> {
    AckermannControl { speed_mps, steering_rad }
}

fn unicycle<T: Copy>([speed_mps, rate_radps]: [T; 2]) -> UnicycleControl<T> {
    UnicycleControl { speed_mps, rate_radps }
}

impl<T: Real> Motion<T, 3> for Drive<T> {
    type Pose = PlanarPose<T>;
    type Control = [T; 2];

    fn admits(&self, control: &[T; 2]) -> bool {
        match self {
            Self::Ackermann(car) => car.admits(&ackermann(*control)),
            Self::Unicycle(robot) => robot.admits(&unicycle(*control)),
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

    fn linearise(&self, pose: &Self::Pose, control: &[T; 2], dt: T) -> Linearised<T, 3> {
        match self {
            Self::Ackermann(car) => car.linearise(pose, &ackermann(*control), dt),
            Self::Unicycle(robot) => robot.linearise(pose, &unicycle(*control), dt),
        }
    }
}

/// Why the filter refused the head or a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refusal {
    /// A model cannot work with its parameters.
    Model(ModelError),
    /// The configuration is out of range or does not fit the memory.
    Setup(SetupError),
    /// The filter cannot start there.
    Reset(ResetError),
    /// A prediction was refused.
    Predict(PredictError),
    /// A scan was refused.
    Scan(ScanError),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model(error) => error.fmt(f),
            Self::Setup(error) => error.fmt(f),
            Self::Reset(error) => error.fmt(f),
            Self::Predict(error) => error.fmt(f),
            Self::Scan(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for Refusal {}

/// What a scan left behind, for the one who watches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seen {
    /// Bits of the health flags.
    pub health: u16,
    /// The most components in view of a candidate.
    pub in_view: u32,
    /// Maps written.
    pub maps_updated: u32,
    /// Pages in use.
    pub pages_used: u32,
    /// Pages in all.
    pub pages: u32,
}

/// A scan in the memory.
#[derive(Debug, Clone, Copy)]
pub struct Scan {
    len: usize,
    beyond: usize,
}

impl Scan {
    /// Number of measurements.
    #[must_use]
    pub fn measurements(&self) -> usize {
        self.len + self.beyond
    }
}

/// A filter in fixed memory.
#[derive(Debug)]
pub struct Onboard<'m, T: Real> {
    filter: Filter<'m, T>,
    measurements: &'m mut [SVector<T, 2>; MEASUREMENTS],
    features: &'m mut [Component<T, 2>; FEATURES],
}

impl<'m, T: Real> Onboard<'m, T> {
    /// Sets the filter up as the head of a stream says, and starts it.
    ///
    /// # Errors
    /// A number of the head is out of range, or the filter does not fit the memory.
    pub fn start(header: &Header, memory: &'m mut Memory<T>) -> Result<Self, Refusal> {
        let Memory { state, measurements, features } = memory;
        let models = models(header).map_err(Refusal::Model)?;
        let mut filter = ScPhd::new(models, config(header), state).map_err(Refusal::Setup)?;
        let [x, y, heading] = [header.start_x_m, header.start_y_m, header.start_heading_rad].map(T::from_f64);
        filter.reset(PlanarPose::new(x, y, heading), header.seed).map_err(Refusal::Reset)?;
        Ok(Self { filter, measurements, features })
    }

    /// Moves the vehicle.
    ///
    /// # Errors
    /// The control is not one the vehicle can be given.
    pub fn predict(&mut self, control: [f64; 2], dt_s: f64) -> Result<(), Refusal> {
        self.filter.predict(&control.map(T::from_f64), T::from_f64(dt_s)).map(drop).map_err(Refusal::Predict)
    }

    /// Takes a scan into the memory, for [`scan`](Self::scan).
    pub fn receive(&mut self, measurements: impl Iterator<Item = [f64; 2]>) -> Scan {
        let mut scan = Scan { len: 0, beyond: 0 };
        let mut slots = self.measurements.iter_mut();
        for [range, bearing] in measurements {
            match slots.next() {
                Some(slot) => {
                    *slot = Vector2::new(T::from_f64(range), T::from_f64(bearing));
                    scan.len += 1;
                }
                None => scan.beyond += 1,
            }
        }
        scan
    }

    /// Updates the filter with the scan that was received last.
    ///
    /// # Errors
    /// A measurement is not finite, or there are too many.
    pub fn scan(&mut self, scan: Scan) -> Result<Seen, Refusal> {
        self.scan_with(scan, &mut ())
    }

    /// [`scan`](Self::scan), watched by a probe.
    ///
    /// # Errors
    /// As for `scan`.
    pub fn scan_with(&mut self, scan: Scan, probe: &mut impl Probe) -> Result<Seen, Refusal> {
        if scan.beyond > 0 {
            let (measurements, capacity) = (scan.len + scan.beyond, MEASUREMENTS);
            return Err(Refusal::Scan(ScanError::TooManyMeasurements { measurements, capacity }));
        }
        let measurements = self.measurements.get(..scan.len).unwrap_or(&[]);
        let report = self.filter.scan_with(measurements, probe).map_err(Refusal::Scan)?;
        Ok(Seen {
            health: report.health.bits(),
            in_view: report.in_view as u32,
            maps_updated: report.maps_updated as u32,
            pages_used: (report.pages_used + report.moving_pages_used) as u32,
            pages: (report.pages + report.moving_pages) as u32,
        })
    }

    /// Estimates pose and map as a vehicle would after a scan: x (m), y (m) and heading (rad) of the pose, and the number
    /// of features.
    pub fn estimate(&mut self) -> ([f64; 3], usize) {
        let pose = self.filter.estimate_pose().map_or(PlanarPose::new(T::ZERO, T::ZERO, T::ZERO), |pose| pose.mean);
        let map = self.filter.estimate_map(self.features);
        ([pose.x_m, pose.y_m, pose.heading_rad].map(T::to_f64), map.features)
    }

    /// Hash of the complete state.
    #[must_use]
    pub fn digest(&self) -> u64 {
        self.filter.digest()
    }
}

type OnboardModels<T> = Models<Drive<T>, RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>>;

fn models<T: Real>(header: &Header) -> Result<OnboardModels<T>, ModelError> {
    let noise = ControlNoise {
        speed_sigma_mps: T::from_f64(header.speed_sigma_mps),
        speed_sigma_ratio: T::from_f64(header.speed_sigma_ratio),
        turn_sigma: T::from_f64(header.turn_sigma),
        turn_sigma_ratio: T::from_f64(header.turn_sigma_ratio),
        interval_s: T::from_f64(header.noise_interval_s),
    };
    let motion = match header.vehicle {
        Vehicle::Ackermann => {
            let geometry = AckermannGeometry {
                wheelbase_m: T::from_f64(header.wheelbase_m),
                encoder_offset_m: T::from_f64(header.encoder_offset_m),
                sensor_forward_m: T::from_f64(header.sensor_forward_m),
                sensor_left_m: T::from_f64(header.sensor_left_m),
            };
            Drive::Ackermann(Ackermann::new(geometry, noise)?)
        }
        Vehicle::Unicycle => Drive::Unicycle(Unicycle::new(Step::Euler, noise)?),
        Vehicle::UnicycleArc => Drive::Unicycle(Unicycle::new(Step::Arc, noise)?),
    };
    let field_of_view = RangeBearingWindow {
        range_min_m: T::from_f64(header.range_min_m),
        range_max_m: T::from_f64(header.range_max_m),
        range_edge_m: T::from_f64(header.range_edge_m),
        bearing_center_rad: T::from_f64(header.bearing_center_rad),
        bearing_half_width_rad: T::from_f64(header.bearing_half_width_rad),
        bearing_edge_rad: T::from_f64(header.bearing_edge_rad),
        probability_near: T::from_f64(header.detection_near),
        probability_far: T::from_f64(header.detection_far),
    };
    field_of_view.check()?;
    Ok(Models {
        motion,
        sensor: RangeBearing::new(T::from_f64(header.range_sigma_m), T::from_f64(header.bearing_sigma_rad))?,
        field_of_view,
        clutter: UniformClutter::of_scan(T::from_f64(header.clutter_per_scan), field_of_view.measure())?,
    })
}

fn config<T: Real>(header: &Header) -> Config<T> {
    Config {
        particles: header.particles as usize,
        samples: header.samples as usize,
        birth_intensity: T::from_f64(header.birth_intensity),
        resample_threshold: T::from_f64(header.resample_threshold),
        prune_weight: T::from_f64(header.prune_weight),
        confirming_detections: T::from_f64(header.confirming_detections),
        unconfirmed_weight: T::from_f64(header.unconfirmed_weight),
        confirmed_weight: T::from_f64(header.confirmed_weight),
        proposal: match header.proposal {
            header::Proposal::Blind => Proposal::Blind,
            header::Proposal::Informed => Proposal::Informed(Informed {
                rounds: header.proposal_rounds as usize,
                drawn: T::from_f64(header.proposal_drawn),
                least_share: T::from_f64(header.proposal_least_share),
            }),
        },
        likelihood: match header.likelihood {
            header::Likelihood::SingleCluster => Likelihood::SingleCluster,
            header::Likelihood::RbEmpty => Likelihood::EmptyMap,
            header::Likelihood::RbSingle => Likelihood::SingleFeature,
        },
        reduction: match header.reduction {
            header::Reduction::Greedy => Reduction::Greedy { merge_distance: T::from_f64(header.merge_distance) },
            header::Reduction::Runnalls => Reduction::Runnalls { merge_cost: T::from_f64(header.merge_cost) },
        },
        extraction: match header.extraction {
            header::Extraction::Heaviest => Extraction::Heaviest,
            header::Extraction::Peaks => Extraction::Peaks,
            header::Extraction::Confirmed => Extraction::Confirmed,
        },
        extraction_weight: T::from_f64(header.extraction_weight),
        moving: MovingConfig {
            birth_intensity: T::from_f64(header.moving_birth_intensity),
            velocity_sigma_mps: T::from_f64(header.velocity_sigma_mps),
            motion: ConstantVelocity {
                acceleration_psd: T::from_f64(header.acceleration_psd),
                lifetime_s: T::from_f64(header.lifetime_s),
            },
            spread_max_m: T::from_f64(header.spread_max_m),
            extraction_weight: T::from_f64(header.moving_extraction_weight),
        },
        max_components: header.max_components as usize,
        ..Config::default()
    }
}
