//! Alternative readings of a log.

use std::f64::consts::{FRAC_PI_2, PI};

/// An alternative reading of a log.
pub(super) struct Reading {
    pub(super) code: &'static str,
    pub(super) place: &'static str,
    pub(super) what: &'static str,
    pub(super) advice: &'static str,
    pub(super) speed: f64,
    pub(super) turn: f64,
    /// Unit of ranges, m.
    pub(super) range: f64,
    pub(super) mirrored: bool,
    pub(super) yaw_rad: f64,
    /// Whether bearings are measured from an axis of the map.
    pub(super) absolute: bool,
    pub(super) told_by: ToldBy,
}

/// Which pairs of scans distinguish a reading from the log as written.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum ToldBy {
    Motion,
    Turns,
    /// Motion that suffices for ranges in the unit of the reading: compared with ranges as written the vehicle hardly moves.
    MotionBesideRange,
    /// Distances, or turns, that suffice as read. With a bias of the turn rate, a smaller unit of turns matches better even if it
    /// is wrong; but only in the right unit are the turns those of the vehicle.
    WayAsRead,
    TurnsAsRead,
}

pub(super) const AS_WRITTEN: Reading = Reading {
    code: "",
    place: "",
    what: "",
    advice: "",
    speed: 1.0,
    turn: 1.0,
    range: 1.0,
    mirrored: false,
    yaw_rad: 0.0,
    absolute: false,
    told_by: ToldBy::Motion,
};

/// All landmarks stand still in the view.
pub(super) const STANDS: Reading = Reading {
    code: "detection-frame",
    place: "detections.csv",
    what: "the vehicle is taken to stand",
    advice: "range and bearing are seen from the sensor; these seem to be seen from a place that stands still, as the origin of the map or of the \
             odometry is: take them into the sensor's frame. If they are right, the odometry is not that of this vehicle, or its wheels \
             turned in the air",
    ..AS_WRITTEN
};

/// Speeds with the opposite sign.
pub(super) const BACKWARDS: Reading = Reading { speed: -1.0, ..AS_WRITTEN };

/// Ranges, and those of the view in `log.toml`, in another unit.
const fn ranges(range: f64, what: &'static str, advice: &'static str) -> Reading {
    let place = "detections.csv, column range_m, and log.toml, section sensor";
    Reading { code: "range-unit", place, what, advice, range, told_by: ToldBy::MotionBesideRange, ..AS_WRITTEN }
}

pub(super) const OTHERS: [Reading; 12] = [
    // Opposite signs of bearings or of turns give the same mirrored world: scans cannot distinguish the two.
    Reading {
        code: "mirrored",
        place: "detections.csv, column bearing_rad",
        what: "their bearings are taken to grow to the right, or the odometry's turns",
        advice: "bearings grow to the left, and steering angles and turn rates are positive to the left: change the sign of the one \
                 that is not",
        mirrored: true,
        told_by: ToldBy::Turns,
        ..AS_WRITTEN
    },
    Reading {
        code: "bearing-frame",
        place: "detections.csv, column bearing_rad",
        what: "bearings are taken to count from an axis of the map",
        advice: "a bearing counts from straight ahead of the sensor, to the left: take the vehicle's heading off",
        absolute: true,
        told_by: ToldBy::Turns,
        ..AS_WRITTEN
    },
    Reading {
        code: "bearing-frame",
        place: "detections.csv, column bearing_rad",
        what: "bearings are taken to be a compass's, from an axis of the map to the right",
        advice: "a bearing counts from straight ahead of the sensor, to the left: take it from the vehicle's heading as a compass has it",
        absolute: true,
        mirrored: true,
        told_by: ToldBy::Turns,
        ..AS_WRITTEN
    },
    ranges(0.001, "ranges, range_max_m and range_sigma_m are taken as mm", "all three are in metres: divide by 1000"),
    ranges(0.01, "ranges, range_max_m and range_sigma_m are taken as cm", "all three are in metres: divide by 100"),
    ranges(
        0.3048,
        "ranges, range_max_m and range_sigma_m are taken as feet",
        "all three are in metres: multiply by 0.3048",
    ),
    Reading {
        code: "turn-unit",
        place: "odometry.csv",
        what: "the odometry's turns are taken as degrees",
        advice: "turn rates are in radians a second, steering angles in radians: multiply by 0.0174533",
        turn: PI / 180.0,
        told_by: ToldBy::TurnsAsRead,
        ..AS_WRITTEN
    },
    Reading {
        code: "speed-unit",
        place: "odometry.csv",
        what: "speeds are taken as km/h",
        advice: "speeds are in metres a second: divide by 3.6",
        speed: 1.0 / 3.6,
        told_by: ToldBy::WayAsRead,
        ..AS_WRITTEN
    },
    Reading {
        code: "speed-unit",
        place: "odometry.csv",
        what: "speeds are taken as cm/s",
        advice: "speeds are in metres a second: divide by 100",
        speed: 0.01,
        told_by: ToldBy::WayAsRead,
        ..AS_WRITTEN
    },
    Reading {
        code: "sensor-yaw",
        place: "log.toml, section sensor",
        what: "the sensor is taken to look to the left",
        advice: "bearing 0 is straight ahead of the sensor: say sensor_yaw_rad = 1.5708, or change the bearings",
        yaw_rad: FRAC_PI_2,
        ..AS_WRITTEN
    },
    Reading {
        code: "sensor-yaw",
        place: "log.toml, section sensor",
        what: "the sensor is taken to look to the right",
        advice: "bearing 0 is straight ahead of the sensor: say sensor_yaw_rad = -1.5708, or change the bearings",
        yaw_rad: -FRAC_PI_2,
        ..AS_WRITTEN
    },
    Reading {
        code: "sensor-yaw",
        place: "log.toml, section sensor",
        what: "the sensor is taken to look back",
        advice: "bearing 0 is straight ahead of the sensor: say sensor_yaw_rad = 3.1416, or change the bearings; or change the sign of \
                 the speeds",
        yaw_rad: PI,
        ..AS_WRITTEN
    },
];
