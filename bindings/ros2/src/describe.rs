//! The wiring of a node that processes a log as `scphd-sim replay` does.

use crate::setup::{DETECTIONS, FIXES, ODOMETRY, Order, Source, Topic, Wiring};
use scphd_exchange::mcap::topic;
use scphd_lidar::PostSettings;
use scphd_log::log::{Log, Vehicle};

/// The topics on which a log is published, and sufficient waiting times.
pub fn wiring(log: &Log) -> Wiring {
    let (odometry, kind) = match log.vehicle {
        Vehicle::Ackermann { .. } => (topic::INPUT_WHEELS, ODOMETRY[1]),
        _ => (topic::INPUT_ODOMETRY, ODOMETRY[0]),
    };
    let sensor = |name: &str| {
        let topic =
            if name.is_empty() { topic::DETECTIONS.to_owned() } else { format!("{}/{name}", topic::DETECTIONS) };
        Source {
            name: name.to_owned(),
            topic: Topic::new(&topic, DETECTIONS[0]),
            seated: true,
            posts: PostSettings::of_radius(0.05),
        }
    };
    let times = || log.odometry.iter().map(|row| row.t_s).chain(log.scans.last().map(|scan| scan.t_s));
    let gap_s = times().zip(times().skip(1)).map(|(from, to)| to - from).fold(0.0, f64::max);
    let usual = Wiring::default();
    let order = Order {
        gap_s: usual.order.gap_s.max((10.0 * gap_s).ceil()),
        jump_s: usual.order.jump_s.max((10.0 * gap_s).ceil()),
        ..usual.order
    };
    Wiring {
        odometry: Topic::new(odometry, kind),
        sensors: log.sensors().map(|(name, ..)| sensor(name)).collect(),
        fixes: (!log.fixes.is_empty()).then(|| Topic::new(topic::INPUT_FIX, FIXES[0])),
        order,
        ..usual
    }
}
