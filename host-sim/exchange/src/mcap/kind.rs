//! The parts of an exported run that depend on the kind of vehicle.

use super::names::{BASE, JOINTS, MAP, ODOM, UNKNOWN, topic};
use super::shape::{covariance, pose, transform};
use scphd_filters::kind::Kind;
use scphd_log::dimensions::{Planar, PoseFix, Underwater};
use scphd_log::log::{Log, Vehicle};
use scphd_ros::messages::{
    Header, JointState, Odometry, PointCloud2, PoseWithCovarianceStamped, TransformStamped, Twist, TwistWithCovariance,
    Vector3,
};
use scphd_ros::{Time, WriteError, Writer, cloud};
use std::io::{Seek, Write};

/// A kind of vehicle whose runs can be exported.
pub trait Exported: Kind {
    /// The `log.toml` of the log, for importing the file again.
    fn head(log: &Self::Log) -> Option<String>;

    /// The mountings of the sensors, as transforms into the vehicle's frame.
    fn sensors(log: &Self::Log) -> Vec<TransformStamped>;

    /// The pose by dead reckoning, if it has a heading of its own: x m, y m, heading rad.
    fn smooth(reckoned: &Self::Reckoned) -> Option<[f64; 3]>;

    fn topic(log: &Self::Log, scan: usize) -> String;

    /// The detections of a scan; `pose` is the estimate.
    fn detections(log: &Self::Log, settings: &Self::Settings, scan: usize, pose: &Self::Pose, at: Time) -> PointCloud2;

    /// The times of the filter's inputs other than scans, s.
    fn told_at(log: &Self::Log) -> Vec<f64>;

    /// Declares the topics of these inputs.
    fn topics<W: Write + Seek>(log: &Self::Log, file: &mut Writer<W>) -> Result<(), WriteError>;

    /// Writes the input with this index in [`told_at`](Self::told_at).
    fn tell<W: Write + Seek>(log: &Self::Log, index: usize, at: Time, file: &mut Writer<W>) -> Result<(), WriteError>;
}

/// The frame of a sensor; `sensor` for an only one without a name.
fn frame(name: &str) -> &str {
    if name.is_empty() { "sensor" } else { name }
}

impl Exported for Planar {
    fn head(log: &Log) -> Option<String> {
        Some(scphd_log::log_folder::head(log))
    }

    fn sensors(log: &Log) -> Vec<TransformStamped> {
        let of = |(name, sensor, _): (&str, &scphd_log::log::Sensor, _)| {
            let seat = sensor.mounting;
            TransformStamped {
                header: Header::new(Time::default(), BASE),
                child_frame_id: frame(name).to_owned(),
                transform: transform(&[seat.forward_m, seat.left_m], seat.yaw_rad),
            }
        };
        log.sensors().map(of).collect()
    }

    fn smooth(reckoned: &[f64; 3]) -> Option<[f64; 3]> {
        Some(*reckoned)
    }

    fn topic(log: &Log, scan: usize) -> String {
        match log.sensors().nth(log.scans[scan].sensor) {
            Some((name, ..)) if !name.is_empty() => format!("{}/{name}", topic::DETECTIONS),
            _ => topic::DETECTIONS.to_owned(),
        }
    }

    fn detections(log: &Log, _settings: &Self::Settings, scan: usize, _pose: &[f64; 3], at: Time) -> PointCloud2 {
        let scan = &log.scans[scan];
        let name = log.sensors().nth(scan.sensor).map_or("", |(name, ..)| name);
        let header = Header::new(at, frame(name));
        let place = |[range, bearing]: [f64; 2]| [range * bearing.cos(), range * bearing.sin(), 0.0];
        let (axes, all) = (["x", "y", "z"], scan.detections.iter().copied());
        if scan.labels.is_empty() {
            return cloud(header, axes, ["range", "bearing"], all.map(|seen| (place(seen), seen)));
        }
        // Labels are whole numbers far below 2⁵³.
        let label = |index: usize| scan.labels.get(index).map_or(-1.0, |label| *label as f64);
        let points = all.enumerate().map(|(index, seen)| (place(seen), [seen[0], seen[1], label(index)]));
        cloud(header, axes, ["range", "bearing", "label"], points)
    }

    fn told_at(log: &Log) -> Vec<f64> {
        // Fixes are after rows of odometry of the same time, as in this order.
        log.odometry.iter().map(|row| row.t_s).chain(log.fixes.iter().map(|fix| fix.t_s)).collect()
    }

    fn topics<W: Write + Seek>(log: &Log, file: &mut Writer<W>) -> Result<(), WriteError> {
        match log.vehicle {
            Vehicle::Ackermann { .. } => file.topic::<JointState>(topic::INPUT_WHEELS, false)?,
            Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => {
                file.topic::<Odometry>(topic::INPUT_ODOMETRY, false)?
            }
        }
        if log.fixes.is_empty() {
            return Ok(());
        }
        file.topic::<PoseWithCovarianceStamped>(topic::INPUT_FIX, false)
    }

    fn tell<W: Write + Seek>(log: &Log, index: usize, at: Time, file: &mut Writer<W>) -> Result<(), WriteError> {
        let Some(row) = log.odometry.get(index) else {
            return fix(log, index - log.odometry.len(), at, file);
        };
        let [speed, turn, left] = row.control;
        if let Vehicle::Ackermann { .. } = log.vehicle {
            let state = JointState {
                header: Header::new(at, BASE),
                name: JOINTS.map(str::to_owned).into(),
                position: vec![0.0, turn],
                velocity: vec![speed, 0.0],
                effort: Vec::new(),
            };
            return file.write(topic::INPUT_WHEELS, at, &state);
        }
        let linear = Vector3 { x: speed, y: left, ..Vector3::default() };
        let twist = Twist { linear, angular: Vector3 { z: turn, ..Vector3::default() } };
        let mut odometry = Odometry {
            header: Header::new(at, ODOM),
            child_frame_id: BASE.to_owned(),
            twist: TwistWithCovariance { twist, ..TwistWithCovariance::default() },
            ..Odometry::default()
        };
        // The pose is on /tf: this message has only the input of the filter.
        odometry.pose.covariance = covariance(2, |row, column| if row == column { UNKNOWN } else { 0.0 });
        file.write(topic::INPUT_ODOMETRY, at, &odometry)
    }
}

/// Writes a fix; quantities that it does not measure have the variance [`UNKNOWN`].
fn fix<W: Write + Seek>(log: &Log, index: usize, at: Time, file: &mut Writer<W>) -> Result<(), WriteError> {
    let Some(fix) = log.fixes.get(index) else { return Ok(()) };
    let square = |sigma: Option<f64>| sigma.map_or(UNKNOWN, |sigma| sigma * sigma);
    let (place, heading_rad, variances) = match fix.measured {
        PoseFix::Position(place) => (place, 0.0, [square(log.fix_noise.position_sigma_m), UNKNOWN]),
        PoseFix::Heading(heading_rad) => ([0.0; 2], heading_rad, [UNKNOWN, square(log.fix_noise.heading_sigma_rad)]),
    };
    let mut message = PoseWithCovarianceStamped { header: Header::new(at, MAP), ..Default::default() };
    message.pose.pose = pose(&place, heading_rad);
    let entry = |row: usize, column: usize| if row == column { variances[usize::from(row == 2)] } else { 0.0 };
    message.pose.covariance = covariance(2, entry);
    file.write(topic::INPUT_FIX, at, &message)
}

impl Exported for Underwater {
    /// A folder cannot express such a log.
    fn head(_log: &Self::Log) -> Option<String> {
        None
    }

    fn sensors(_log: &Self::Log) -> Vec<TransformStamped> {
        Vec::new()
    }

    fn smooth(_reckoned: &[f64; 3]) -> Option<[f64; 3]> {
        None
    }

    fn topic(_log: &Self::Log, _scan: usize) -> String {
        topic::DETECTIONS.to_owned()
    }

    fn detections(log: &Self::Log, settings: &Self::Settings, scan: usize, pose: &[f64; 5], at: Time) -> PointCloud2 {
        let place = |pixels: &[f64; 4]| {
            // Without a position, only the pixels.
            let place = Self::place(log, settings, scan, pose, pixels).map_or([f64::NAN; 3], |(place, _)| place);
            (place, *pixels)
        };
        let points = log.scans[scan].detections.iter().map(place);
        let mut made = cloud(Header::new(at, MAP), ["x", "y", "z"], ["ul", "vl", "ur", "vr"], points);
        made.is_dense = false;
        made
    }

    fn told_at(_log: &Self::Log) -> Vec<f64> {
        Vec::new()
    }

    fn topics<W: Write + Seek>(_log: &Self::Log, _file: &mut Writer<W>) -> Result<(), WriteError> {
        Ok(())
    }

    fn tell<W: Write + Seek>(_: &Self::Log, _: usize, _: Time, _: &mut Writer<W>) -> Result<(), WriteError> {
        Ok(())
    }
}
