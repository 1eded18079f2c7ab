//! The same filters as descriptions.

use crate::Event;
use crate::filters::{SIDEWAYS, STEERED};
use nalgebra::{Vector1, Vector2};
use scphd::models::{AckermannGeometry, OdometryCorrection, OdometryPrior, PolarGrid};
use scphd::settings::{HypothesesConfig, MovingConfig};
use scphd::{Births, Config, JointConfig};
use scphd_vehicle::{
    Control, Description, Filter, FixSpec, JointSettings, Measurements, Sensor, SensorModel, Services, VehicleKind,
};
use std::error::Error;

/// A sensor with this range, half width of the view, standard deviations of range and bearing, and seat.
fn polar(range_m: f32, half_width_rad: f32, sigmas: [f32; 2], (seat_m, yaw_rad): ([f32; 2], f32)) -> Sensor<f32> {
    let mut sensor = Sensor { seat_m, yaw_rad, ..Sensor::range_bearing(range_m, 0.85, sigmas) };
    [sensor.window.range_edge_m, sensor.window.bearing_edge_rad] = sigmas.map(|sigma| 3.0 * sigma);
    sensor.window.bearing_half_width_rad = half_width_rad;
    sensor
}

/// A robot with lidar, radar, satellite receiver and compass, and a joint map.
fn robot() -> Description<f32> {
    let mut lidar = polar(12.0, 2.0, [0.05, 0.01], ([0.22, 0.0], 0.5));
    lidar.clutter_per_scan = 2.0;
    lidar.births = Births { of_static: 0.002, of_moving: 0.001 };
    let mut radar = polar(20.0, 0.8, [0.2, 0.03], ([-0.3, 0.1], 3.0));
    radar.range_sigma_ratio = 0.02;
    radar.births = Births::of_static(0.003);
    let mut robot = Description::robot();
    robot.sensors = [Some(lidar), Some(radar), None, None];
    robot.position = Some(FixSpec { gate: 25.0, antenna_m: [-0.5, 0.1], ..FixSpec::of_sigma(0.3) });
    robot.heading = Some(FixSpec::of_sigma(0.05));
    (robot.start.pose.x_m, robot.start.pose.heading_rad) = (5.0, 1.5);
    robot
}

/// With the camera.
fn with_camera(robot: Description<f32>) -> Description<f32> {
    let mut camera = Sensor::range_bearing(12.0, 0.85, [0.05, 0.02]);
    camera.model = SensorModel::Bearing;
    camera.window.bearing_half_width_rad = 2.0;
    camera.grid = PolarGrid { nearest_m: 2.0, farthest_m: 12.0, rings: 3, sectors: 16, weight: 0.0005 };
    (camera.seat_m, camera.yaw_rad) = ([0.22, 0.0], 0.5);
    let [lidar, radar, ..] = robot.sensors;
    Description { sensors: [lidar, radar, Some(camera), None], ..robot }
}

/// With a mixture whose random numbers have this seed.
fn mixture(mut described: Description<f32>, config: Config<f32>, seed: u64) -> Description<f32> {
    described.filter = Filter::Mixture(config);
    described.start.seed = seed;
    described
}

/// With this vehicle.
fn moving_as(kind: VehicleKind) -> Description<f32> {
    let mut other = robot();
    other.vehicle.kind = kind;
    if kind == VehicleKind::Ackermann {
        other.vehicle.geometry =
            AckermannGeometry { wheelbase_m: 2.5, encoder_offset_m: 0.5, sensor_forward_m: 3.0, sensor_left_m: 0.25 };
    }
    other
}

/// The filters in the order of [`digests`](crate::Filters::digests); none for the diver, whom descriptions do not have.
#[must_use]
pub fn descriptions() -> [Option<Description<f32>>; 12] {
    let usual = JointSettings::default();
    let joint = |settings| Description { filter: Filter::Joint(settings), ..robot() };
    let movers = JointSettings { movers: Some(MovingConfig::walkers()), ..usual };
    let sigma = OdometryCorrection { speed_scale: 0.05, turn_scale: 0.05, turn_offset: 0.02 };
    let strict = JointSettings { config: JointConfig::strict(), ..usual };
    let car = moving_as(VehicleKind::Ackermann);
    [
        Some(mixture(with_camera(robot()), Config::blind(32, 2), 7)),
        Some(mixture(robot(), Config { prune_weight: 1e-3, ..Config::informed(4) }, 8)),
        Some(robot()),
        None,
        Some(joint(movers)),
        Some(joint(JointSettings { archive_reach_m: Some(12.0), ..movers })),
        Some(joint(JointSettings { odometry: Some(OdometryPrior { sigma, lasts_s: 3600.0 }), ..usual })),
        Some(joint(JointSettings { hypotheses: Some(HypothesesConfig::default()), ..movers })),
        Some(moving_as(VehicleKind::Holonomic)),
        Some(car),
        Some(mixture(car, Config::informed(4), 10)),
        Some(Description { filter: Filter::Joint(strict), ..moving_as(VehicleKind::UnicycleEuler) }),
    ]
}

/// The control of this vehicle for the robot's speed and turn rate.
#[must_use]
pub fn control(kind: VehicleKind, speed_mps: f32, rate_radps: f32) -> Control<f32> {
    let (left_mps, turn) = match kind {
        VehicleKind::Holonomic => (SIDEWAYS * rate_radps, rate_radps),
        VehicleKind::Ackermann => (0.0, STEERED * rate_radps),
        VehicleKind::Unicycle | VehicleKind::UnicycleEuler => (0.0, rate_radps),
    };
    Control { speed_mps, left_mps, turn }
}

/// Updates a described filter with an input; inputs of sensors that the description does not have, and the diver's, are left out.
///
/// # Errors
/// The filter refuses the input.
pub fn take(
    slam: &mut (impl Services<f32> + ?Sized),
    described: &Description<f32>,
    event: &Event,
) -> Result<(), Box<dyn Error>> {
    let vectors = |scan: &[[f32; 2]]| scan.iter().map(|&z| z.into()).collect::<Vec<Vector2<f32>>>();
    match event {
        &Event::Predict([speed_mps, rate_radps, dt_s]) => {
            slam.predict(control(described.vehicle.kind, speed_mps, rate_radps), dt_s)?;
        }
        Event::Lidar(scan) => drop(slam.scan(0, Measurements::RangeBearing(&vectors(scan)))?),
        Event::Radar(scan) => drop(slam.scan(1, Measurements::RangeBearing(&vectors(scan)))?),
        Event::Camera(scan) if described.sensors[2].is_some() => {
            let scan: Vec<Vector1<f32>> = scan.iter().map(|&z| Vector1::new(z)).collect();
            slam.scan(2, Measurements::Bearing(&scan))?;
        }
        &Event::Position([x_m, y_m]) => drop(slam.observe_position(x_m, y_m)?),
        &Event::Heading(heading_rad) => drop(slam.observe_heading(heading_rad)?),
        Event::Camera(_) | Event::Dive(_) | Event::Sonar(_) | Event::Height(_) | Event::Compare => {}
    }
    Ok(())
}
