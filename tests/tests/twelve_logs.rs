//! The drive of the C and Python interfaces as a log: read from its folder and with the settings of the described filters, the
//! simulator has the states of the library after each scan.

use scphd::settings::{MovingConfig, Proposal};
use scphd::{Config, JointConfig};
use scphd_drive::{Event, control, descriptions, events};
use scphd_filters::kind::Kind as _;
use scphd_filters::settings::{CalibrationSettings, FilterSettings, Settings};
use scphd_filters::slam::{Filter, Precision};
use scphd_log::dimensions::Planar;
use scphd_log::events::Event as Step;
use scphd_log::log::{Fix, FixNoise, Log, Mounting, NamedSensor, Nominal, Odometry, PoseFix, Scan, Sensor, Vehicle};
use scphd_log::log_folder;
use scphd_tests::with_roomy_stack;
use scphd_vehicle::{Backing, Control, Description, VehicleKind, joint_backing, mixture_backing};
use std::path::PathBuf;

use crate::twelve_kinds::driven;

/// Birth intensities of the lidar for static and moving features, and those of the radar divided by them.
const BIRTHS: [f64; 2] = [0.002, 0.001];
const RADAR_BIRTHS: f64 = 1.5;

fn stated(name: &str, of: &scphd_vehicle::Sensor<f32>) -> NamedSensor {
    let [forward_m, left_m, yaw_rad] = [of.seat_m[0], of.seat_m[1], of.yaw_rad].map(f64::from);
    let half_width_rad = f64::from(of.window.bearing_half_width_rad);
    NamedSensor {
        name: name.into(),
        sensor: Sensor {
            range_min_m: f64::from(of.window.range_min_m),
            range_max_m: f64::from(of.window.range_max_m),
            bearing_min_rad: -half_width_rad,
            bearing_max_rad: half_width_rad,
            mounting: Mounting { forward_m, left_m, yaw_rad },
        },
        nominal: Nominal {
            range_sigma_m: Some(f64::from(of.range_sigma_m)),
            range_sigma_ratio: f64::from(of.range_sigma_ratio),
            bearing_sigma_rad: Some(f64::from(of.bearing_sigma_rad)),
            detection_probability: Some(f64::from(of.window.probability_near)),
            clutter_per_scan: Some(f64::from(of.clutter_per_scan)),
            ..Nominal::default()
        },
    }
}

fn log(described: &Description<f32>, events: &[Event]) -> Log {
    let [Some(lidar), Some(radar), ..] = &described.sensors else { panic!("a lidar and a radar") };
    let lidar = stated("lidar", lidar);
    let (pose, kind, length) = (&described.start.pose, described.vehicle.kind, &described.vehicle.geometry);
    let (position, heading) = (described.position.unwrap(), described.heading.unwrap());
    let mut log = Log {
        name: "drive".into(),
        initial_pose: [pose.x_m, pose.y_m, pose.heading_rad].map(f64::from),
        vehicle: match kind {
            VehicleKind::Ackermann => Vehicle::Ackermann {
                wheelbase_m: f64::from(length.wheelbase_m),
                encoder_offset_m: f64::from(length.encoder_offset_m),
                sensor_forward_m: f64::from(length.sensor_forward_m),
                sensor_left_m: f64::from(length.sensor_left_m),
            },
            VehicleKind::Unicycle => Vehicle::UnicycleArc,
            VehicleKind::UnicycleEuler => Vehicle::Unicycle,
            VehicleKind::Holonomic => Vehicle::Holonomic,
        },
        sensor: lidar.sensor,
        sensor_name: lidar.name,
        nominal: lidar.nominal,
        others: vec![stated("radar", radar)],
        simulated: true,
        odometry: Vec::new(),
        scans: Vec::new(),
        fixes: Vec::new(),
        fix_noise: FixNoise {
            position_sigma_m: Some(f64::from(position.sigma)),
            heading_sigma_rad: Some(f64::from(heading.sigma)),
            gate: Some(f64::from(position.gate)),
            // Never moved by fixes.
            patience_s: Some(1e9),
            forward_m: f64::from(position.antenna_m[0]),
            left_m: f64::from(position.antenna_m[1]),
        },
        truth: Vec::new(),
        truth_sigma_m: 0.0,
        landmarks: Vec::new(),
        moving: Vec::new(),
    };
    let mut t_s = 0.0;
    let mut scan = |t_s, sensor, scan: &[[f32; 2]]| {
        let detections = scan.iter().map(|z| z.map(f64::from)).collect();
        log.scans.push(Scan { t_s, sensor, detections, labels: Vec::new() });
    };
    for event in events {
        match event {
            &Event::Predict([speed_mps, rate_radps, dt_s]) => {
                let Control { speed_mps, left_mps, turn } = control(kind, speed_mps, rate_radps);
                log.odometry.push(Odometry { t_s, control: [speed_mps, turn, left_mps].map(f64::from) });
                t_s += f64::from(dt_s);
            }
            Event::Lidar(of) => scan(t_s, 0, of),
            Event::Radar(of) => scan(t_s, 1, of),
            Event::Position(place) => {
                log.fixes.push(Fix { t_s, measured: PoseFix::Position(place.map(f64::from)) });
            }
            Event::Heading(heading) => {
                log.fixes.push(Fix { t_s, measured: PoseFix::Heading(f64::from(*heading)) });
            }
            // The diver's, and bearings, which logs do not have.
            Event::Camera(_) | Event::Dive(_) | Event::Sonar(_) | Event::Height(_) | Event::Compare => {}
        }
    }
    log
}

/// The settings of a mixture with an informed proposal.
fn recursion(config: &Config<f32>, filter: &mut FilterSettings) {
    let Proposal::Informed(informed) = config.proposal else { panic!("{:?}", config.proposal) };
    (filter.particles, filter.samples) = (config.particles, config.samples);
    filter.resample_threshold = f64::from(config.resample_threshold);
    filter.prune_weight = f64::from(config.prune_weight);
    filter.confirming_detections = f64::from(config.confirming_detections);
    filter.unconfirmed_weight = f64::from(config.unconfirmed_weight);
    filter.confirmed_weight = f64::from(config.confirmed_weight);
    filter.merge_distance = f64::from(config.merge_distance);
    filter.births_wait = config.births_wait;
    filter.max_components = config.max_components.min(65_536);
    filter.proposal_rounds = informed.rounds;
    filter.proposal_sampled_fraction = f64::from(informed.sampled_fraction);
    filter.proposal_min_responsibility = f64::from(informed.min_responsibility);
    filter.interval_margin = 1.0;
}

/// The settings of the description, where they are not the defaults of its log.
fn settings(log: &Log, described: &Description<f32>) -> (Settings, Filter) {
    let mut settings = Settings::for_log(log);
    let of_sensors = std::iter::once(&mut settings.sensor).chain(settings.others.iter_mut().map(|(_, sensor)| sensor));
    for (sensor, of) in of_sensors.zip(described.sensors.iter().flatten()) {
        sensor.range_edge_m = f64::from(of.window.range_edge_m);
        sensor.bearing_edge_rad = f64::from(of.window.bearing_edge_rad);
    }
    settings.others[0].1.birth_factor = RADAR_BIRTHS;
    settings.filter.birth_intensity = BIRTHS[0];
    let MovingConfig { spread_max_m, extraction_weight, .. } = MovingConfig::walkers();
    (settings.moving.spread_max_m, settings.moving.extraction_weight) = (spread_max_m, extraction_weight);
    let (has_movers, filter) = match described.filter {
        scphd_vehicle::Filter::Mixture(config) => {
            recursion(&config, &mut settings.filter);
            (true, Filter::Core(Precision::F32))
        }
        scphd_vehicle::Filter::Joint(joint) => {
            settings.joint.visible_s = f64::from(joint.config.persistence.visible_s);
            settings.joint.lifetime_s = f64::from(joint.config.persistence.lifetime_s);
            settings.joint.occlusion_factor = f64::from(joint.config.occlusion_factor);
            settings.joint.hypotheses = joint.hypotheses.map_or(1, |hypotheses| hypotheses.most);
            settings.calibration = joint.odometry.map(|prior| CalibrationSettings {
                speed_scale_sigma: f64::from(prior.sigma.speed_scale),
                turn_scale_sigma: f64::from(prior.sigma.turn_scale),
                turn_offset_sigma: f64::from(prior.sigma.turn_offset),
                lasts_s: f64::from(prior.lasts_s),
            });
            (joint.movers.is_some(), Filter::Joint(Precision::F32))
        }
    };
    settings.moving.birth_intensity = if has_movers { BIRTHS[1] } else { 0.0 };
    (settings, filter)
}

/// The log, written to a folder and read from it.
fn through_folder(log: &Log) -> Log {
    let path: PathBuf = std::env::temp_dir().join(format!("scphd-drive-{}", std::process::id()));
    log_folder::write(log, &path).unwrap();
    let read = log_folder::read(&path);
    std::fs::remove_dir_all(&path).unwrap();
    let read = read.unwrap();
    assert_eq!(&read, log);
    read
}

/// The digests of the simulator's filter after each scan of the drive.
fn simulated(described: &Description<f32>, events: &[Event]) -> Vec<u64> {
    let log = through_folder(&log(described, events));
    let (settings, filter) = settings(&log, described);
    settings.check().unwrap();
    let mut slam = Planar::slam(filter, &log, &settings, described.start.seed).unwrap();
    let mut watch = Planar::fix_watch(&settings).unwrap();
    let mut digests = Vec::new();
    for event in Planar::events(&log, &settings).unwrap() {
        match event {
            Step::Predict { control, dt_s, .. } => {
                watch.wait(dt_s);
                assert_eq!(slam.predict(control, dt_s).unwrap(), None);
            }
            Step::Fix { fix } => drop(watch.show(&mut *slam, &fix).unwrap()),
            Step::Scan { index } => {
                slam.scan(log.scans[index].sensor, &log.scans[index].detections).unwrap();
                digests.push(slam.digest().unwrap());
            }
        }
    }
    digests
}

// The capacities of the simulator, which has room for more than fits a board; a filter drops features that it has no room for.
joint_backing! {
    struct Plain: PlanarPose<f32> { features: 1024, measurements: 64 }
}
joint_backing! {
    struct Tracks: PlanarPose<f32> { features: 1024, measurements: 64, movers: 256 }
}
joint_backing! {
    struct Learning: CalibratedPose<f32> { features: 1024, measurements: 64 }
}
joint_backing! {
    struct Several: PlanarPose<f32> { features: 512, measurements: 64, movers: 256, hypotheses: 8 }
}
mixture_backing! {
    struct Particles: f32, measurements: 64 {
        particles: 4, samples: 1, features { pages: 2048, pages_per_map: 512, in_view: 4096 },
        moving { pages: 2048, pages_per_map: 512, in_view: 4096 },
    }
}

/// A described filter of the drive, as far as a log and its settings can have it: the births of moving features of all sensors are
/// in proportion to those of static ones, the fixes have one gate, and a joint map has the limits of existence that are usual.
fn described(place: usize) -> Description<f32> {
    let mut described = descriptions()[place].unwrap();
    if let ([_, Some(radar), ..], Some(heading)) = (&mut described.sensors, &mut described.heading) {
        radar.births.of_moving = 0.0015;
        heading.gate = 25.0;
    }
    if let scphd_vehicle::Filter::Joint(joint) = &mut described.filter {
        joint.config = JointConfig::default();
    }
    described
}

/// Whether the simulator has the digests of the described filter in this memory after each scan.
fn same(place: usize, memory: &mut impl Backing<f32>) -> bool {
    let (described, events) = (described(place), events());
    simulated(&described, &events) == driven(&described, memory, &events)
}

#[test]
fn nine_filters_of_the_drive_run_in_the_simulator() {
    with_roomy_stack(|| {
        let alike = [
            same(1, &mut *Box::new(Particles::new())),
            same(2, &mut *Box::new(Plain::new())),
            same(4, &mut *Box::new(Tracks::new())),
            same(6, &mut *Box::new(Learning::new())),
            same(7, &mut *Box::new(Several::new())),
            same(8, &mut *Box::new(Plain::new())),
            same(9, &mut *Box::new(Plain::new())),
            same(10, &mut *Box::new(Particles::new())),
            same(11, &mut *Box::new(Plain::new())),
        ];
        assert_eq!(alike, [true; 9]);
    });
}
