//! The filters of the library, updated with the same inputs.

use crate::Event;
use nalgebra::{Vector1, Vector2, Vector3};
use scphd::models::{
    Ackermann, AckermannControl, AckermannGeometry, Auv, AuvControl, AuvPose, BearingOnly, Calibrated, CalibratedPose,
    ControlNoise, HeadingFix, HeightFix, Holonomic, HolonomicControl, Mounting, OdometryCorrection, OdometryPrior,
    PlanarPose, PolarBirths, PolarGrid, PositionFix, RangeBearing, RangeBearingElevation, RangeBearingLimits,
    RangeBearingWindow, RangeNoise, Reading, SelfCalibrating, Sensing, SonarLimits, SonarWindow, Step, Unicycle,
    UnicycleControl, UniformClutter, WithNoise,
};
use scphd::numerics::Symmetric;
use scphd::settings::{HypothesesConfig, MovingConfig};
use scphd::storage::{Archived, JointArchive, JointHypotheses, JointMovers, ScanRoom, Tracked, joint_numbers};
use scphd::{
    Births, Config, Detector, DetectorMemory, JointConfig, JointSlam, MultiHypothesisSlam, Real, ScPhd, joint_memory,
    memory,
};
use std::error::Error;

memory! {
    type Blind: Unicycle<f32> {
        particles: 32, samples: 2, features { pages: 320, pages_per_map: 32, in_view: 256 },
        moving { pages: 128, pages_per_map: 16, in_view: 128 },
    }
}
memory! {
    type Informed: Unicycle<f32> {
        particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 },
        moving { pages: 64, pages_per_map: 16, in_view: 128 },
    }
}
memory! {
    type Water: Auv<f32> {
        particles: 16, samples: 1, features { pages: 160, pages_per_map: 24, in_view: 256 },
    }
}
joint_memory! { type Joint: Unicycle<f32> { measurement: Vector2<f32>, features: 40, measurements: 32 } }
joint_memory! { type Joint60: Unicycle<f32> { measurement: Vector2<f32>, features: 60, measurements: 32 } }
joint_memory! { type Joint24: Unicycle<f32> { measurement: Vector2<f32>, features: 24, measurements: 16 } }
joint_memory! { type Learning: Learner { measurement: Vector2<f32>, features: 60, measurements: 32 } }

/// Speed to the left of the holonomic vehicle divided by the turn rate, m/rad.
pub(crate) const SIDEWAYS: f32 = 0.25;
/// Steering angle of the car divided by the turn rate, s.
pub(crate) const STEERED: f32 = 0.5;

/// A robot that estimates its odometry error.
type Learner = SelfCalibrating<Unicycle<f32>, f32>;
/// Seven hypotheses beside the likeliest.
type Others = JointHypotheses<PlanarPose<f32>, 7, 24, { joint_numbers(3, 2, 24) }, 8>;
/// A joint map with movers and an archive.
type WithMovers<'m, A> = JointSlam<'m, Unicycle<f32>, Vector2<f32>, A, Tracked<'m, PlanarPose<f32>>>;
type Ranging = WithNoise<RangeBearing<f32>, RangeNoise<f32>>;
type Polar = Sensing<Ranging, RangeBearingWindow<f32>, UniformClutter<f32>>;
type OfLearner = Sensing<Calibrated<Ranging>, RangeBearingWindow<f32>, UniformClutter<f32>>;
type Direction = Sensing<BearingOnly<f32, PolarBirths<f32>>, RangeBearingWindow<f32>, UniformClutter<f32>>;
type Spherical = Sensing<RangeBearingElevation<f32>, SonarWindow<f32>, UniformClutter<f32>>;
type Over<'m, X, Z> = Detector<X, ScanRoom<'m, Z>>;

/// Memory of all filters.
#[derive(Debug)]
pub struct Memory {
    blind: Blind,
    informed: Informed,
    joint: Joint,
    movers: (Joint60, JointMovers<PlanarPose<f32>, 16>),
    archive: (Joint, JointMovers<PlanarPose<f32>, 16>, JointArchive<PlanarPose<f32>, 1000>),
    learning: Learning,
    hypotheses: (Joint24, JointMovers<PlanarPose<f32>, 8>, Others),
    sideways: Joint,
    car: Joint,
    car_mixture: Informed,
    strict: Joint,
    water: Water,
    lidar: DetectorMemory<Vector2<f32>, 32>,
    radar: DetectorMemory<Vector2<f32>, 128>,
    camera: DetectorMemory<Vector1<f32>, 64>,
    sonar: DetectorMemory<Vector3<f32>, 64>,
}

impl Memory {
    /// All memory zero.
    pub const NEW: Self = Self {
        blind: Blind::new(),
        informed: Informed::new(),
        joint: Joint::new(),
        movers: (Joint60::new(), JointMovers::new()),
        archive: (Joint::new(), JointMovers::new(), JointArchive::new()),
        learning: Learning::new(),
        hypotheses: (Joint24::new(), JointMovers::new(), Others::new()),
        sideways: Joint::new(),
        car: Joint::new(),
        car_mixture: Informed::new(),
        strict: Joint::new(),
        water: Water::new(),
        lidar: DetectorMemory::new(),
        radar: DetectorMemory::new(),
        camera: DetectorMemory::new(),
        sonar: DetectorMemory::new(),
    };
}

/// The filters and their detectors.
#[derive(Debug)]
pub struct Filters<'m> {
    blind: ScPhd<'m, Unicycle<f32>>,
    informed: ScPhd<'m, Unicycle<f32>>,
    joint: JointSlam<'m, Unicycle<f32>, Vector2<f32>>,
    movers: WithMovers<'m, scphd::storage::NoArchive>,
    archive: WithMovers<'m, Archived<'m, PlanarPose<f32>>>,
    learning: JointSlam<'m, Learner, Vector2<f32>>,
    hypotheses: MultiHypothesisSlam<'m, Unicycle<f32>, Vector2<f32>, Tracked<'m, PlanarPose<f32>>, 7>,
    learners: [Detector<OfLearner>; 2],
    sideways: JointSlam<'m, Holonomic<f32>, Vector2<f32>>,
    car: JointSlam<'m, Ackermann<f32>, Vector2<f32>>,
    car_mixture: ScPhd<'m, Ackermann<f32>>,
    strict: JointSlam<'m, Unicycle<f32>, Vector2<f32>>,
    water: ScPhd<'m, Auv<f32>>,
    lidar: Over<'m, Polar, Vector2<f32>>,
    radar: Over<'m, Polar, Vector2<f32>>,
    camera: Over<'m, Direction, Vector1<f32>>,
    sonar: Over<'m, Spherical, Vector3<f32>>,
}

fn polar(
    range_m: f32,
    half_width_rad: f32,
    sigmas: [f32; 2],
    ratio: f32,
    clutter: f32,
) -> Result<Polar, Box<dyn Error>> {
    let field_of_view = RangeBearingWindow::new(RangeBearingLimits {
        range_edge_m: 3.0 * sigmas[0],
        bearing_half_width_rad: half_width_rad,
        bearing_edge_rad: 3.0 * sigmas[1],
        ..RangeBearingLimits::full_circle(range_m, 0.85)
    })?;
    let clutter = UniformClutter::of_scan(clutter, field_of_view.measure())?;
    let sensor = WithNoise { sensor: RangeBearing::new(sigmas[0], sigmas[1])?, noise: RangeNoise::new(ratio)? };
    Ok(Sensing { sensor, field_of_view, clutter })
}

fn direction() -> Result<Direction, Box<dyn Error>> {
    let grid = PolarGrid { nearest_m: 2.0, farthest_m: 12.0, rings: 3, sectors: 16, weight: 0.0005 };
    let limits = RangeBearingLimits { bearing_half_width_rad: 2.0, ..RangeBearingLimits::full_circle(12.0, 0.85) };
    let field_of_view = RangeBearingWindow::new(limits)?;
    let clutter = UniformClutter::of_scan(1.0, 4.0)?;
    Ok(Sensing { sensor: BearingOnly::new(0.02, PolarBirths::new(grid)?)?, field_of_view, clutter })
}

fn spherical() -> Result<Spherical, Box<dyn Error>> {
    let limits = SonarLimits {
        range_max_m: 8.0,
        range_edge_m: 0.15,
        bearing_half_width_rad: f32::PI,
        elevation_half_width_rad: 0.5 * f32::PI,
        angle_edge_rad: 0.0,
        probability: 0.9,
    };
    let clutter = UniformClutter::of_scan(1.0, 8.0 * (2.0 * f32::PI) * f32::PI)?;
    Ok(Sensing {
        sensor: RangeBearingElevation::new(0.05, 0.02, 0.02)?,
        field_of_view: SonarWindow::new(limits)?,
        clutter,
    })
}

impl<'m> Filters<'m> {
    /// All filters at their start.
    ///
    /// # Errors
    /// None, because the configuration is in range.
    pub fn new(memory: &'m mut Memory) -> Result<Self, Box<dyn Error>> {
        let motion = Unicycle::new(Step::Arc, ControlNoise::wheeled())?;
        let geometry =
            AckermannGeometry { wheelbase_m: 2.5, encoder_offset_m: 0.5, sensor_forward_m: 3.0, sensor_left_m: 0.25 };
        let car = Ackermann::new(geometry, ControlNoise::wheeled())?;
        let births = [Births { of_static: 0.002, of_moving: 0.001 }, Births::of_static(0.003)];
        let views = [polar(12.0, 2.0, [0.05, 0.01], 0.0, 2.0)?, polar(20.0, 0.8, [0.2, 0.03], 0.02, 1.0)?];
        let seats = [Mounting::in_plane(0.22, 0.0, 0.5)?, Mounting::in_plane(-0.3, 0.1, 3.0)?];
        let seat = |place: usize| Detector::new(views[place], births[place])?.mounted(seats[place]);
        let learner = |place: usize| {
            let Sensing { sensor, field_of_view, clutter } = views[place];
            let view = Sensing { sensor: Calibrated(sensor), field_of_view, clutter };
            Detector::new(view, births[place])?.mounted(seats[place])
        };
        let sigma = OdometryCorrection { speed_scale: 0.05, turn_scale: 0.05, turn_offset: 0.02 };
        let learns = SelfCalibrating::new(motion, OdometryPrior { sigma, lasts_s: 3600.0 })?;
        let (of_map, tracks, pages) = (&mut memory.archive.0, &mut memory.archive.1, &mut memory.archive.2);
        let informed = Config { prune_weight: 1e-3, ..Config::informed(4) };
        let mut filters = Self {
            blind: ScPhd::new(motion, Config::blind(32, 2), &mut memory.blind)?,
            informed: ScPhd::new(motion, informed, &mut memory.informed)?,
            joint: JointSlam::new(motion, JointConfig::default(), &mut memory.joint)?,
            movers: JointSlam::new(motion, JointConfig::default(), &mut memory.movers.0)?
                .with_movers(&mut memory.movers.1, MovingConfig::walkers())?,
            archive: JointSlam::new(motion, JointConfig::default(), of_map)?
                .with_archive(pages, 12.0)?
                .with_movers(tracks, MovingConfig::walkers())?,
            learning: JointSlam::new(learns, JointConfig::default(), &mut memory.learning)?,
            learners: [learner(0)?, learner(1)?],
            hypotheses: JointSlam::new(motion, JointConfig::default(), &mut memory.hypotheses.0)?
                .with_movers(&mut memory.hypotheses.1, MovingConfig::walkers())?
                .with_hypotheses(&mut memory.hypotheses.2, HypothesesConfig::default())?,
            sideways: JointSlam::new(
                Holonomic::new(ControlNoise::wheeled())?,
                JointConfig::default(),
                &mut memory.sideways,
            )?,
            car: JointSlam::new(car, JointConfig::default(), &mut memory.car)?,
            car_mixture: ScPhd::new(car, Config::informed(4), &mut memory.car_mixture)?,
            strict: JointSlam::new(
                Unicycle::new(Step::Euler, ControlNoise::wheeled())?,
                JointConfig::strict(),
                &mut memory.strict,
            )?,
            water: ScPhd::new(Auv::new(0.1, 1.0)?, Config::informed(16), &mut memory.water)?,
            lidar: seat(0)?.over(&mut memory.lidar)?,
            radar: seat(1)?.over(&mut memory.radar)?,
            camera: Detector::new(direction()?, Births::NONE)?.mounted(seats[0])?.over(&mut memory.camera)?,
            sonar: Detector::new(spherical()?, Births::of_static(0.001))?.over(&mut memory.sonar)?,
        };
        let start = PlanarPose::new(5.0, 0.0, 1.5);
        filters.blind.reset(start, 7)?;
        filters.informed.reset(start, 8)?;
        filters.joint.reset(start)?;
        filters.movers.reset(start)?;
        filters.archive.reset(start)?;
        filters.hypotheses.reset(start)?;
        filters.sideways.reset(start)?;
        filters.car.reset(start)?;
        filters.car_mixture.reset(start, 10)?;
        filters.strict.reset(start)?;
        let of_odometry = learns.prior();
        let certain = Symmetric::from_fn(|row, column| if column < 3 { 0.0 } else { of_odometry.get(row, column) });
        filters.learning.reset_within(CalibratedPose::at(start), &certain)?;
        filters.water.reset(AuvPose::new(2.0, 0.0, -1.0, 1.5), 9)?;
        Ok(filters)
    }

    /// Updates the filters with an input.
    ///
    /// # Errors
    /// A filter refuses the input.
    pub fn take(&mut self, event: &Event) -> Result<(), Box<dyn Error>> {
        match event {
            Event::Predict([speed_mps, rate_radps, dt]) => {
                let control = UnicycleControl { speed_mps: *speed_mps, rate_radps: *rate_radps };
                self.blind.predict(&control, *dt)?;
                self.informed.predict(&control, *dt)?;
                self.joint.predict(&control, *dt)?;
                self.movers.predict(&control, *dt)?;
                self.archive.predict(&control, *dt)?;
                self.hypotheses.predict(&control, *dt)?;
                self.learning.predict(&control, *dt)?;
                self.strict.predict(&control, *dt)?;
                let (forward_mps, left_mps) = (*speed_mps, SIDEWAYS * *rate_radps);
                self.sideways.predict(&HolonomicControl { forward_mps, left_mps, rate_radps: *rate_radps }, *dt)?;
                let steered = AckermannControl { speed_mps: *speed_mps, steering_rad: STEERED * *rate_radps };
                self.car.predict(&steered, *dt)?;
                self.car_mixture.predict(&steered, *dt)?;
            }
            Event::Lidar(scan) => {
                let scan: Vec<Vector2<f32>> = scan.iter().map(|&z| z.into()).collect();
                self.blind.scan(&mut self.lidar, &scan)?;
                self.informed.scan(&mut self.lidar, &scan)?;
                self.joint.scan(&self.lidar, &scan)?;
                self.movers.scan(&self.lidar, &scan)?;
                self.archive.scan(&self.lidar, &scan)?;
                self.hypotheses.scan(&self.lidar, &scan)?;
                self.learning.scan(&self.learners[0], &scan)?;
                self.sideways.scan(&self.lidar, &scan)?;
                self.car.scan(&self.lidar, &scan)?;
                self.car_mixture.scan(&mut self.lidar, &scan)?;
                self.strict.scan(&self.lidar, &scan)?;
            }
            Event::Radar(scan) => {
                let scan: Vec<Vector2<f32>> = scan.iter().map(|&z| z.into()).collect();
                self.blind.scan(&mut self.radar, &scan)?;
                self.informed.scan(&mut self.radar, &scan)?;
                self.joint.scan(&self.radar, &scan)?;
                self.movers.scan(&self.radar, &scan)?;
                self.archive.scan(&self.radar, &scan)?;
                self.hypotheses.scan(&self.radar, &scan)?;
                self.learning.scan(&self.learners[1], &scan)?;
                self.sideways.scan(&self.radar, &scan)?;
                self.car.scan(&self.radar, &scan)?;
                self.car_mixture.scan(&mut self.radar, &scan)?;
                self.strict.scan(&self.radar, &scan)?;
            }
            Event::Camera(scan) => {
                let scan: Vec<Vector1<f32>> = scan.iter().map(|&z| Vector1::new(z)).collect();
                self.blind.scan(&mut self.camera, &scan)?;
            }
            Event::Position(position) => {
                let fix = PositionFix::new(0.3)?.gated(25.0)?.mounted(-0.5, 0.1)?;
                self.blind.observe(&fix, &(*position).into())?;
                self.informed.observe(&fix, &(*position).into())?;
                self.joint.observe(&fix, &(*position).into())?;
                self.movers.observe(&fix, &(*position).into())?;
                self.archive.observe(&fix, &(*position).into())?;
                self.hypotheses.observe(&fix, &(*position).into())?;
                self.learning.observe(&Calibrated(fix), &(*position).into())?;
                self.sideways.observe(&fix, &(*position).into())?;
                self.car.observe(&fix, &(*position).into())?;
                self.car_mixture.observe(&fix, &(*position).into())?;
                self.strict.observe(&fix, &(*position).into())?;
            }
            Event::Heading(heading) => {
                let (fix, heading) = (HeadingFix::new(0.05)?, Vector1::new(*heading));
                self.blind.observe(&fix, &heading)?;
                self.informed.observe(&fix, &heading)?;
                self.joint.observe(&fix, &heading)?;
                self.movers.observe(&fix, &heading)?;
                self.archive.observe(&fix, &heading)?;
                self.hypotheses.observe(&fix, &heading)?;
                self.learning.observe(&Calibrated(fix), &heading)?;
                self.sideways.observe(&fix, &heading)?;
                self.car.observe(&fix, &heading)?;
                self.car_mixture.observe(&fix, &heading)?;
                self.strict.observe(&fix, &heading)?;
            }
            Event::Dive([x, y, z, rate, height, dt]) => {
                let control = AuvControl {
                    velocity_mps: Vector3::new(*x, *y, *z),
                    velocity_covariance: Symmetric::from_diagonal([0.01; 3]),
                    roll_rad: 0.0,
                    pitch_rad: 0.0,
                    yaw_rate_radps: Some(Reading { value: *rate, sigma: 0.02 }),
                    z_m: Some(Reading { value: *height, sigma: 0.05 }),
                };
                self.water.predict(&control, *dt)?;
            }
            Event::Sonar(scan) => {
                let scan: Vec<Vector3<f32>> = scan.iter().map(|&z| z.into()).collect();
                self.water.scan(&mut self.sonar, &scan)?;
            }
            Event::Height(height) => {
                self.water.observe(&HeightFix::new(0.1)?, &Vector1::new(*height))?;
            }
            Event::Compare => {}
        }
        Ok(())
    }

    /// Digests of the states: blind mixture, informed mixture, joint map, diver; joint maps with movers, with an archive, with
    /// estimation of the odometry error, and with several hypotheses; joint map of a holonomic vehicle; joint map and informed
    /// mixture of a car; joint map with strict settings and Euler steps.
    #[must_use]
    pub fn digests(&self) -> [u64; 12] {
        [
            self.blind.digest(),
            self.informed.digest(),
            self.joint.digest(),
            self.water.digest(),
            self.movers.digest(),
            self.archive.digest(),
            self.learning.digest(),
            self.hypotheses.digest(),
            self.sideways.digest(),
            self.car.digest(),
            self.car_mixture.digest(),
            self.strict.digest(),
        ]
    }
}
