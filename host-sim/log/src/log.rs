//! A log in memory: odometry, scans and truth.
//!
//! Read from a folder (`log_folder`) or made by a simulation (`scenario`).

use crate::angle::wrap;
pub use crate::dimensions::PoseFix;
use crate::dimensions::{Dimensions, Planar};
use scphd::fixes::FixRule;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Motion model and geometry, from the `[vehicle]` section of `log.toml`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Vehicle {
    /// Equations 5.25–5.27 of the thesis; controls are encoder speed and steering angle.
    Ackermann {
        /// Wheelbase L, m.
        wheelbase_m: f64,
        /// Lateral offset H of the wheel encoder from the centreline, m.
        encoder_offset_m: f64,
        /// Forward offset a of the sensor from the rear axle, m.
        sensor_forward_m: f64,
        /// Leftward offset b of the sensor from the centreline, m.
        sensor_left_m: f64,
    },
    /// Euler step; controls are speed and turn rate.
    #[default]
    Unicycle,
    /// Exact arc; controls are speed and turn rate.
    UnicycleArc,
    /// Motion ahead, sideways and turning at once, exact arc; controls are speed ahead, turn rate and speed to the left.
    Holonomic,
}

/// Range-bearing sensor window, from the `[sensor]` section of `log.toml`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensor {
    /// Least range, m (0 if the log does not state it).
    pub range_min_m: f64,
    pub range_max_m: f64,
    /// Right edge of the window, rad.
    pub bearing_min_rad: f64,
    /// Left edge of the window, rad.
    pub bearing_max_rad: f64,
    pub mounting: Mounting,
}

impl Sensor {
    /// Whether a position with this range, m, and bearing, rad, is in the window.
    pub fn sees(&self, range_m: f64, bearing_rad: f64) -> bool {
        let half_rad = 0.5 * (self.bearing_max_rad - self.bearing_min_rad);
        let middle_rad = 0.5 * (self.bearing_max_rad + self.bearing_min_rad);
        (self.range_min_m..=self.range_max_m).contains(&range_m)
            && (half_rad >= PI || wrap(bearing_rad - middle_rad).abs() <= half_rad)
    }
}

/// Mounting of a sensor on its vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mounting {
    pub forward_m: f64,
    pub left_m: f64,
    pub yaw_rad: f64,
}

impl Mounting {
    /// The mounting at the vehicle's pose.
    pub const NONE: Self = Self { forward_m: 0.0, left_m: 0.0, yaw_rad: 0.0 };

    /// The pose (x m, y m, heading rad) of the sensor of a vehicle at `pose`.
    pub fn seat(&self, [x, y, heading]: [f64; 3]) -> [f64; 3] {
        if *self == Self::NONE {
            return [x, y, heading];
        }
        let (sine, cosine) = (libm::sin(heading), libm::cos(heading));
        [
            x + self.forward_m * cosine - self.left_m * sine,
            y + self.forward_m * sine + self.left_m * cosine,
            wrap(heading + self.yaw_rad),
        ]
    }
}

/// Noise as far as the log states it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Nominal {
    pub range_sigma_m: Option<f64>,
    /// Standard deviation of the range divided by the range; adds in quadrature. 0 if not stated.
    pub range_sigma_ratio: f64,
    pub bearing_sigma_rad: Option<f64>,
    /// Standard deviation of the speed, m/s, independent in each sample.
    pub speed_sigma_mps: Option<f64>,
    /// Standard deviation of the turn rate, rad/s, independent in each sample (all except Ackermann).
    pub rate_sigma_radps: Option<f64>,
    /// Standard deviation of the steering angle, rad, independent in each sample (Ackermann).
    pub steering_sigma_rad: Option<f64>,
    pub detection_probability: Option<f64>,
    pub clutter_per_scan: Option<f64>,
}

impl Nominal {
    /// Default standard deviation of the range, relative to the greatest range.
    const RANGE_SIGMA_SHARE: f64 = 0.01;
    const BEARING_SIGMA_RAD: f64 = 0.02;

    /// Standard deviations of range, m, without the part that grows with it, and bearing, rad: as stated, or defaults.
    pub fn sigmas(&self, sensor: &Sensor) -> [f64; 2] {
        [
            self.range_sigma_m.unwrap_or(Self::RANGE_SIGMA_SHARE * sensor.range_max_m),
            self.bearing_sigma_rad.unwrap_or(Self::BEARING_SIGMA_RAD),
        ]
    }

    pub fn sigmas_at(&self, sensor: &Sensor, range_m: f64) -> [f64; 2] {
        let [range_sigma_m, bearing_sigma_rad] = self.sigmas(sensor);
        [libm::hypot(range_sigma_m, self.range_sigma_ratio * range_m), bearing_sigma_rad]
    }
}

/// One odometry row; it holds until the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Odometry {
    pub t_s: f64,
    /// Speed (m/s), then steering angle (rad, Ackermann) or turn rate (rad/s, all others), then speed to the left (m/s, 0 except
    /// for holonomic vehicles).
    pub control: [f64; 3],
}

impl Odometry {
    /// Speed over ground, m/s, negative in reverse.
    pub fn speed_mps(&self) -> f64 {
        let [ahead, _, left] = self.control;
        if left == 0.0 { ahead } else { libm::hypot(ahead, left) }
    }
}

/// One scan of the sensor, possibly empty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scan<D: Dimensions = Planar> {
    pub t_s: f64,
    /// Index of its sensor in [`Log::sensors`], 0 for an only one.
    pub sensor: usize,
    /// The measurements: in the plane range (m) and bearing (rad, 0 ahead, positive to the left), in space pairs of pixels.
    pub detections: Vec<D::Measurement>,
    /// Label of the landmark of each detection, negative for none; empty if the log does not have labels. For baselines and
    /// scores, never an input of the filter.
    pub labels: Vec<i64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruePose<D: Dimensions = Planar> {
    pub t_s: f64,
    pub position: D::Position,
    /// Heading, rad, if known.
    pub heading_rad: Option<f64>,
}

/// One row of a true track of a moving landmark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingLandmark<D: Dimensions = Planar> {
    pub subject: i64,
    pub t_s: f64,
    pub position: D::Position,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    pub t_s: f64,
    pub measured: PoseFix,
}

/// Noise of fixes and their handling by a filter, from the section `[fixes]` of `log.toml`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixNoise {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_sigma_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heading_sigma_rad: Option<f64>,
    /// Gate, a squared Mahalanobis distance: fixes beyond it are left out; [`USUAL_GATE`](Self::USUAL_GATE) if not stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gate: Option<f64>,
    /// Time for which fixes are left out before consistent ones are accepted and the filter is relocated, s; the default of
    /// [`scphd::fixes::FixRule`] if not stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub patience_s: Option<f64>,
    /// Position of the antenna ahead of the vehicle's pose, m.
    pub forward_m: f64,
    /// Position to its left, m.
    pub left_m: f64,
}

impl FixNoise {
    /// Five standard deviations, the default of PX4's EKF2 and ArduPilot's EKF3.
    pub const USUAL_GATE: f64 = 25.0;

    /// The gate, or its default.
    pub fn gate(&self) -> f64 {
        self.gate.unwrap_or(Self::USUAL_GATE)
    }

    /// The rule for accepting fixes that were left out.
    pub fn rule(&self) -> FixRule<f64> {
        let usual = FixRule::default();
        FixRule { patience_s: self.patience_s.unwrap_or(usual.patience_s), ..usual }
    }
}

/// A sensor other than the first.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedSensor {
    pub name: String,
    pub sensor: Sensor,
    /// Its noise as far as the log states it; for the vehicle the same as for the first sensor.
    pub nominal: Nominal,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    pub name: String,
    /// Initial pose: x m, y m, heading rad.
    pub initial_pose: [f64; 3],
    pub vehicle: Vehicle,
    /// The sensor, or the first of several.
    pub sensor: Sensor,
    /// Its name; empty for an only one.
    pub sensor_name: String,
    /// The noise of the vehicle and of this sensor, as far as the log states it.
    pub nominal: Nominal,
    /// The other sensors; all are in order of their names.
    pub others: Vec<NamedSensor>,
    /// Whether the log is simulated, so that its nominal noise is exact.
    pub simulated: bool,
    /// Odometry in order of time.
    pub odometry: Vec<Odometry>,
    /// Scans in order of time.
    pub scans: Vec<Scan>,
    /// Fixes of the pose in order of time.
    pub fixes: Vec<Fix>,
    pub fix_noise: FixNoise,
    /// True trajectory in order of time; empty if unknown.
    pub truth: Vec<TruePose>,
    /// Standard deviation of a coordinate of the true positions, m; 0 if they are exact.
    pub truth_sigma_m: f64,
    /// True static landmarks, m; empty if unknown.
    pub landmarks: Vec<[f64; 2]>,
    /// True tracks of moving landmarks; empty if unknown.
    pub moving: Vec<MovingLandmark>,
}

impl Log {
    /// All sensors: name, view and noise.
    pub fn sensors(&self) -> impl Iterator<Item = (&str, &Sensor, &Nominal)> {
        let others = self.others.iter().map(|other| (other.name.as_str(), &other.sensor, &other.nominal));
        std::iter::once((self.sensor_name.as_str(), &self.sensor, &self.nominal)).chain(others)
    }
}
