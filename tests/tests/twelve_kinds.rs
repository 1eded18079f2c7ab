//! The drive of the C and Python interfaces through streams: the recording of a filter that is built from a description replays to
//! the digests of the library. Those of the filters with the capacities of streams are of the library without a description; a joint
//! map of other capacities is built from the description once more.

use nalgebra::Vector2;
use scphd::models::{AckermannGeometry, OdometryCorrection, OdometryPrior};
use scphd::settings::{HypothesesConfig, MovingConfig};
use scphd::{Births, Config, JointConfig};
use scphd_drive::{Event, Filters, Memory, events};
use scphd_stream::planar::{
    self, BlackBox, BlackBoxArchive, BlackBoxCalibrated, BlackBoxHypotheses, BlackBoxJoint, BlackBoxMovers, Odometry,
    Planar,
};
use scphd_stream::{Aboard, Header, Scalar, Which, Writer};
use scphd_tests::with_roomy_stack;
use scphd_vehicle::{
    Backing, Control, Description, Filter, FixSpec, JointSettings, Measurements, Sensor, Services, Slam, VehicleKind,
    joint_backing,
};
use std::convert::Infallible;

use crate::black_box::replayed;

joint_backing! {
    struct Plain: PlanarPose<f32> { features: 64, measurements: 64 }
}
joint_backing! {
    struct Tracks: PlanarPose<f32> { features: 64, measurements: 64, movers: 64 }
}
joint_backing! {
    struct Archive: PlanarPose<f32> { features: 64, measurements: 64, movers: 64, archived: 256 }
}
joint_backing! {
    struct Learning: CalibratedPose<f32> { features: 64, measurements: 64 }
}

/// The description of a robot with lidar, radar, satellite receiver and compass.
fn robot() -> Description<f32> {
    let mut lidar = Sensor::range_bearing(12.0, 0.85, [0.05, 0.01]);
    (lidar.window.range_edge_m, lidar.window.bearing_edge_rad) = (3.0 * 0.05, 3.0 * 0.01);
    lidar.window.bearing_half_width_rad = 2.0;
    lidar.clutter_per_scan = 2.0;
    lidar.births = Births { of_static: 0.002, of_moving: 0.001 };
    (lidar.seat_m, lidar.yaw_rad) = ([0.22, 0.0], 0.5);
    let mut radar = Sensor::range_bearing(20.0, 0.85, [0.2, 0.03]);
    (radar.window.range_edge_m, radar.window.bearing_edge_rad) = (3.0 * 0.2, 3.0 * 0.03);
    radar.window.bearing_half_width_rad = 0.8;
    radar.range_sigma_ratio = 0.02;
    radar.births = Births::of_static(0.003);
    (radar.seat_m, radar.yaw_rad) = ([-0.3, 0.1], 3.0);
    let mut robot = Description::robot();
    robot.sensors = [Some(lidar), Some(radar), None, None];
    robot.position = Some(FixSpec { gate: 25.0, antenna_m: [-0.5, 0.1], ..FixSpec::of_sigma(0.3) });
    robot.heading = Some(FixSpec::of_sigma(0.05));
    (robot.start.pose.x_m, robot.start.pose.heading_rad) = (5.0, 1.5);
    robot
}

/// With these settings of the joint map.
fn joint(settings: JointSettings<f32>) -> Description<f32> {
    Description { filter: Filter::Joint(settings), ..robot() }
}

/// With this vehicle; a car has the lengths of the drive.
fn moving_as(kind: VehicleKind) -> Description<f32> {
    let mut other = robot();
    other.vehicle.kind = kind;
    if kind == VehicleKind::Ackermann {
        other.vehicle.geometry =
            AckermannGeometry { wheelbase_m: 2.5, encoder_offset_m: 0.5, sensor_forward_m: 3.0, sensor_left_m: 0.25 };
    }
    other
}

/// The control of this vehicle for a speed and a turn rate.
fn control(kind: VehicleKind, speed_mps: f32, rate: f32) -> Control<f32> {
    let (left_mps, turn) = match kind {
        VehicleKind::Holonomic => (0.25 * rate, rate),
        VehicleKind::Ackermann => (0.0, 0.5 * rate),
        VehicleKind::Unicycle | VehicleKind::UnicycleEuler => (0.0, rate),
    };
    Control { speed_mps, left_mps, turn }
}

/// The digest of the described filter in this memory after the drive.
fn driven(described: &Description<f32>, memory: &mut impl Backing<f32>, events: &[Event]) -> u64 {
    let mut slam = memory.start(described).unwrap();
    slam.reset(&described.start).unwrap();
    let scan = |slam: &mut dyn Services<f32>, sensor, scan: &[[f32; 2]]| {
        let scan: Vec<Vector2<f32>> = scan.iter().map(|&z| z.into()).collect();
        slam.scan(sensor, Measurements::RangeBearing(&scan)).map(drop).unwrap();
    };
    for event in events {
        match event {
            &Event::Predict([speed_mps, rate, dt_s]) => {
                slam.predict(control(described.vehicle.kind, speed_mps, rate), dt_s).map(drop).unwrap();
            }
            Event::Lidar(of) => scan(&mut slam, 0, of),
            Event::Radar(of) => scan(&mut slam, 1, of),
            &Event::Position([x_m, y_m]) => slam.observe_position(x_m, y_m).map(drop).unwrap(),
            &Event::Heading(heading_rad) => slam.observe_heading(heading_rad).map(drop).unwrap(),
            Event::Camera(_) | Event::Dive(_) | Event::Sonar(_) | Event::Height(_) | Event::Compare => {}
        }
    }
    slam.digest()
}

/// The recording of the drive for this vehicle.
fn recording(described: &Description<f32>, events: &[Event]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let sink = |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), Infallible>(())
    };
    let Ok(mut log) = Writer::<Planar, _>::start(&Header::of(described, Scalar::F32).unwrap(), sink);
    let wide = |scan: &[[f32; 2]]| scan.iter().map(|z| z.map(f64::from)).collect::<Vec<_>>();
    for event in events {
        let Ok(()) = match event {
            &Event::Predict([speed_mps, rate, dt_s]) => {
                log.predict(&Odometry::of(control(described.vehicle.kind, speed_mps, rate), dt_s))
            }
            Event::Lidar(scan) => log.scan(&wide(scan)),
            Event::Radar(scan) => log.scan_of(Which::number(1).unwrap(), &wide(scan)),
            Event::Position(place) => log.fix(&planar::Fix::Position {
                place_m: place.map(f64::from),
                sigma_m: f64::from(0.3_f32),
                gate: 25.0,
                antenna_m: [-0.5_f32, 0.1].map(f64::from),
            }),
            Event::Heading(heading) => log.fix(&planar::Fix::Heading {
                heading_rad: f64::from(*heading),
                sigma_rad: f64::from(0.05_f32),
                gate: f64::INFINITY,
            }),
            // The diver's, and bearings, which streams do not have.
            Event::Camera(_) | Event::Dive(_) | Event::Sonar(_) | Event::Height(_) | Event::Compare => Ok(()),
        };
    }
    let Ok(()) = log.end();
    bytes
}

/// Whether the replay of the recording has this digest at its end.
fn same<A: Aboard<f32, Kind = Planar>>(described: &Description<f32>, events: &[Event], digest: u64) -> bool {
    let (recovered, told) = replayed::<A, f32>(&recording(described, events)).unwrap();
    assert!(recovered.ended && recovered.gaps == 0);
    told.digests.last().unwrap().1 == digest
}

#[test]
fn ten_filters_of_the_drive_replay_from_streams() {
    with_roomy_stack(|| {
        let (mut events, mut memory) = (events(), Box::new(Memory::NEW));
        // A replay tells the digest after each scan.
        let last = events.iter().rposition(|event| matches!(event, Event::Lidar(_) | Event::Radar(_))).unwrap();
        events.truncate(last + 1);
        let mut filters = Filters::new(&mut memory).unwrap();
        for event in &events {
            filters.take(event).unwrap();
        }
        // The others of twelve have other capacities, or sensors that streams do not have.
        let [_, informed, _, _, _, _, _, hypotheses, _, _, car_mixture, _] = filters.digests();
        let usual = JointSettings::default();
        let movers = JointSettings { movers: Some(MovingConfig::walkers()), ..usual };
        let prior = OdometryPrior {
            sigma: OdometryCorrection { speed_scale: 0.05, turn_scale: 0.05, turn_offset: 0.02 },
            lasts_s: 3600.0,
        };
        let mut particles = robot();
        particles.filter = Filter::Mixture(Config { prune_weight: 1e-3, ..Config::informed(4) });
        particles.start.seed = 8;
        let mut car_particles = moving_as(VehicleKind::Ackermann);
        car_particles.filter = Filter::Mixture(Config::informed(4));
        car_particles.start.seed = 10;
        let mut euler = moving_as(VehicleKind::UnicycleEuler);
        euler.filter = Filter::Joint(JointSettings { config: JointConfig::strict(), ..usual });
        let usual_joint = |described: Description<f32>| {
            same::<BlackBoxJoint>(&described, &events, driven(&described, &mut *Box::new(Plain::new()), &events))
        };
        let tracking = joint(movers);
        let archiving = joint(JointSettings { archive_reach_m: Some(12.0), ..movers });
        let learning = joint(JointSettings { odometry: Some(prior), ..usual });
        let several = joint(JointSettings { hypotheses: Some(HypothesesConfig::default()), ..movers });
        let alike = [
            same::<BlackBox>(&particles, &events, informed),
            usual_joint(robot()),
            same::<BlackBoxMovers>(&tracking, &events, driven(&tracking, &mut *Box::new(Tracks::new()), &events)),
            same::<BlackBoxArchive>(&archiving, &events, driven(&archiving, &mut *Box::new(Archive::new()), &events)),
            same::<BlackBoxCalibrated>(&learning, &events, driven(&learning, &mut *Box::new(Learning::new()), &events)),
            same::<BlackBoxHypotheses>(&several, &events, hypotheses),
            usual_joint(moving_as(VehicleKind::Holonomic)),
            usual_joint(moving_as(VehicleKind::Ackermann)),
            same::<BlackBox>(&car_particles, &events, car_mixture),
            usual_joint(euler),
        ];
        assert_eq!(alike, [true; 10]);
    });
}
