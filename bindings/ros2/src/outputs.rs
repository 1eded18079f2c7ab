//! Converts estimates to messages.

use crate::engine::{Counts, Estimate};
use crate::inputs::Placed;
use scphd::models::{MovingOf, PlanarPose};
use scphd::numerics::nalgebra::Vector2;
use scphd::{Component, Health};
use scphd_exchange::mcap::UNKNOWN;
use scphd_exchange::mcap::shape::{between, covariance, pose, transform};
use scphd_filters::slam::{feature_of, moving_of};
use scphd_ros::Time;
use scphd_ros::messages::{
    DiagnosticArray, DiagnosticStatus, Header, KeyValue, MarkerArray, Odometry, PoseWithCovariance,
    PoseWithCovarianceStamped, TFMessage, TransformStamped, Twist, TwistWithCovariance, Vector3,
};
use scphd_sequencer::Flags;
use scphd_vehicle::{Services, VehicleKind};

/// Maximum number of features and of movers in a message.
const SHOWN: usize = 1024;

fn numbers(pose: &PlanarPose<f32>) -> [f64; 3] {
    [pose.x_m, pose.y_m, pose.heading_rad].map(f64::from)
}

fn placed(estimate: &Estimate) -> PoseWithCovariance {
    let [x, y, heading_rad] = numbers(&estimate.pose.mean);
    PoseWithCovariance {
        pose: pose(&[x, y], heading_rad),
        covariance: covariance(2, |row, column| f64::from(estimate.pose.covariance.get(row, column))),
    }
}

pub fn stamped(estimate: &Estimate, [map, ..]: &[String; 3]) -> PoseWithCovarianceStamped {
    let header = Header::new(Time::from_nanoseconds(estimate.stamp_ns), map);
    PoseWithCovarianceStamped { header, pose: placed(estimate) }
}

/// The pose in the map and the present motion.
pub fn odometry(estimate: &Estimate, [map, _, base]: &[String; 3], kind: VehicleKind) -> Odometry {
    let control = estimate.control;
    let linear = Vector3 { x: f64::from(control.speed_mps), y: f64::from(control.left_mps), z: 0.0 };
    // The second control of a car is a steering angle.
    let rate = if kind == VehicleKind::Ackermann { 0.0 } else { f64::from(control.turn) };
    let twist = Twist { linear, angular: Vector3 { z: rate, ..Vector3::default() } };
    let unknown = |row: usize, column: usize| if row == column { UNKNOWN } else { 0.0 };
    let covariance = std::array::from_fn(|row| std::array::from_fn(|column| unknown(row, column)));
    Odometry {
        header: Header::new(Time::from_nanoseconds(estimate.stamp_ns), map),
        child_frame_id: base.clone(),
        pose: placed(estimate),
        twist: TwistWithCovariance { twist, covariance },
    }
}

/// The transform from the odometry frame to the map. If odometry messages have poses, it is their frame; otherwise it is a frame
/// of the node, and the transform of the vehicle in it is added.
pub fn transforms(estimate: &Estimate, [map, odom, base]: &[String; 3], placed: Option<Placed>) -> TFMessage {
    let at = Time::from_nanoseconds(estimate.stamp_ns);
    let of = |parent: &str, child: &str, [x, y, heading_rad]: [f64; 3]| TransformStamped {
        header: Header::new(at, parent),
        child_frame_id: child.to_owned(),
        transform: transform(&[x, y], heading_rad),
    };
    let smooth = placed.map_or_else(|| numbers(&estimate.smooth), |(_, pose)| pose);
    let mut transforms = vec![of(map, odom, between(numbers(&estimate.pose.mean), smooth))];
    if placed.is_none() {
        transforms.push(of(odom, base, smooth));
    }
    TFMessage { transforms }
}

/// Features and movers as ellipses.
pub fn features(slam: &mut dyn Services<f32>, at_ns: u64, map: &str) -> MarkerArray {
    let mut room = vec![Component::<Vector2<f32>>::ZERO; SHOWN];
    let still = slam.features(&mut room).features;
    let mut moving_room = vec![Component::<MovingOf<PlanarPose<f32>>>::ZERO; SHOWN];
    let moving = slam.movers(&mut moving_room).features;
    let still: Vec<_> = room.iter().take(still).map(feature_of).collect();
    let moving: Vec<_> = moving_room.iter().take(moving).map(moving_of).collect();
    scphd_exchange::mcap::features::<scphd_log::dimensions::Planar>(&still, &moving, map, Time::from_nanoseconds(at_ns))
}

/// Diagnostics: warnings of the filter and of stamps, counts since the start, and the last reason why a message was rejected.
pub fn diagnostics(
    node: &str,
    at: Time,
    (flags, health): (Flags, Health),
    counts: &Counts,
    refused: Option<&str>,
) -> DiagnosticArray {
    let level = match () {
        () if health.contains(Health::LOST) => 2,
        () if health.is_good() && flags.is_empty() && refused.is_none() => u8::from(counts.scans == 0),
        () => 1,
    };
    let said = |names: String| names.trim_matches(['{', '}']).replace('"', "");
    let mut message: Vec<String> = [said(format!("{health:?}")), said(format!("{flags:?}"))].into();
    message.extend(refused.map(str::to_owned));
    message.retain(|part| !part.is_empty());
    if counts.scans == 0 {
        message.push("no scan yet".into());
    }
    let value = |key: &str, count: u64| KeyValue { key: key.into(), value: count.to_string() };
    let Counts { scans, fixes, outliers, refused: by_filter, dropped, gaps } = *counts;
    let status = DiagnosticStatus {
        level,
        name: format!("{node}: filter"),
        message: if message.is_empty() { "good".into() } else { message.join("; ") },
        hardware_id: String::new(),
        values: vec![
            value("scans", scans),
            value("fixes", fixes),
            value("fixes left out", outliers),
            value("inputs that the filter refused", by_filter),
            value("inputs late, twice or from beyond a jump of the clock", dropped),
            value("gaps of the odometry", gaps),
        ],
    };
    DiagnosticArray { header: Header::new(at, ""), status: vec![status] }
}
