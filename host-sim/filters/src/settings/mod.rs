//! Settings of a run: defaults derived from a log, overridden by a TOML file, then by the command line.

pub(crate) mod defaults;
pub mod file;
mod limits;
mod moving_objects;
mod odometry_noise;
mod origin;
mod used;
mod white;

pub use file::{FileError, FileProblem};
pub use limits::OutOfRange;
pub use origin::{Origin, Origins, changed};
pub use scphd_reference::Likelihood;
pub use used::{is_used_by, users_of};

use scphd_log::log::{FixNoise, Mounting};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Settings of a run; every field is required here, and optional in the TOML file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "InFile", into = "InFile")]
pub struct Settings {
    pub filter: FilterSettings,
    pub vehicle: VehicleSettings,
    /// The sensor's noise and view, or the first sensor's.
    pub sensor: SensorSettings,
    /// The name of the first of several sensors; empty for an only one.
    pub sensor_name: String,
    /// The other sensors, in order of their names.
    pub others: Vec<(String, SensorSettings)>,
    pub moving: MovingSettings,
    pub joint: JointSettings,
    /// Fixes of the pose, if the log has some.
    pub fixes: Option<FixNoise>,
    /// Calibration of the odometry by a joint map, if enabled.
    pub calibration: Option<CalibrationSettings>,
}

/// The structure of a settings file: `[sensor]` for an only sensor, `[sensors.NAME]` for each of several.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct InFile {
    filter: FilterSettings,
    vehicle: VehicleSettings,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensor: Option<SensorSettings>,
    moving: MovingSettings,
    joint: JointSettings,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fixes: Option<FixNoise>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    calibration: Option<CalibrationSettings>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    sensors: BTreeMap<String, SensorSettings>,
}

impl From<Settings> for InFile {
    fn from(settings: Settings) -> Self {
        let Settings { filter, vehicle, sensor, sensor_name, others, moving, joint, fixes, calibration } = settings;
        let (sensor, sensors) = if others.is_empty() {
            (Some(sensor), BTreeMap::new())
        } else {
            (None, std::iter::once((sensor_name, sensor)).chain(others).collect())
        };
        Self { filter, vehicle, sensor, moving, joint, fixes, calibration, sensors }
    }
}

impl TryFrom<InFile> for Settings {
    type Error = &'static str;

    fn try_from(file: InFile) -> Result<Self, &'static str> {
        let InFile { filter, vehicle, sensor, moving, joint, fixes, calibration, sensors } = file;
        let mut all = sensor.map(|sensor| (String::new(), sensor)).into_iter().chain(sensors);
        let (sensor_name, sensor) = all.next().ok_or("no sensor")?;
        let others: Vec<_> = all.collect();
        if sensor_name.is_empty() && !others.is_empty() {
            return Err("sensor: with several sensors each is [sensors.NAME]");
        }
        Ok(Self { filter, vehicle, sensor, sensor_name, others, moving, joint, fixes, calibration })
    }
}

impl Settings {
    /// The settings of every sensor, in the order of the log's.
    pub fn sensors(&self) -> impl Iterator<Item = &SensorSettings> {
        std::iter::once(&self.sensor).chain(self.others.iter().map(|(_, sensor)| sensor))
    }

    fn sensors_mut(&mut self) -> impl Iterator<Item = &mut SensorSettings> {
        std::iter::once(&mut self.sensor).chain(self.others.iter_mut().map(|(_, sensor)| sensor))
    }
}

/// `[filter]`: see [`scphd::Config`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterSettings {
    /// N.
    pub particles: usize,
    /// M.
    pub samples: usize,
    /// w_b, 1/(m·rad).
    pub birth_intensity: f64,
    /// Resample below this N_eff / N.
    pub resample_threshold: f64,
    /// Drop components below this weight.
    pub prune_weight: f64,
    /// Number of measurements: a component is confirmed if its covariance is smaller than after this many.
    pub confirming_detections: f64,
    /// Forget unconfirmed components that leave the view with less than this weight.
    pub unconfirmed_weight: f64,
    /// Least weight of a confirmed component after misses.
    pub confirmed_weight: f64,
    /// Merge components within this squared Mahalanobis distance.
    pub merge_distance: f64,
    /// Greatest number of components kept in view.
    pub max_components: usize,
    /// Which components are the estimated static features.
    pub extraction: Extraction,
    /// Least weight of an estimated static feature.
    pub extraction_weight: f64,
    /// The distribution from which poses are sampled.
    pub proposal: Proposal,
    /// Number of linearisations of the informed proposal.
    pub proposal_rounds: usize,
    /// Fraction of the proposal's covariance that is sampled.
    pub proposal_sampled_fraction: f64,
    /// Minimum responsibility for a measurement with which a component steers the proposal.
    pub proposal_min_responsibility: f64,
    /// Factor for `vehicle.noise_interval_s` in a mixture; a joint map uses it without a factor.
    pub interval_margin: f64,
    /// Whether unexplained measurements become births in the next scan only: fewer components.
    pub births_wait: bool,
    pub likelihood: Likelihood,
}

/// The distribution from which poses are sampled: see [`scphd::settings::Proposal`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Proposal {
    /// The motion model.
    Blind,
    /// The motion model and the scan.
    Informed,
}

/// Which components are the estimated features: see [`scphd::settings::Extraction`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Extraction {
    Heaviest,
    /// The highest peaks.
    Peaks,
    Confirmed,
}

/// `[moving]`: the moving part of the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MovingSettings {
    /// w_m, 1/(m·rad); 0: all features are static.
    pub birth_intensity: f64,
    /// Standard deviation of each coordinate of a new feature's velocity, m/s.
    pub velocity_sigma_mps: f64,
    /// q, spectral density of the acceleration, m²/s³.
    pub acceleration_psd: f64,
    /// τ, mean lifetime, s.
    pub lifetime_s: f64,
    /// Forget components whose position has a greater standard deviation, m.
    pub spread_max_m: f64,
    /// Least weight of an estimated moving feature.
    pub extraction_weight: f64,
}

/// `[joint]`: settings of the joint map only, see [`scphd::JointConfig`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointSettings {
    /// Mean time for which a landmark is visible before it is occluded, s; 1e9: never occluded.
    pub visible_s: f64,
    /// Mean time for which it is occluded, s.
    pub occluded_s: f64,
    /// Mean time until it is removed, s; 1e9: never.
    pub lifetime_s: f64,
    /// Share of p_D that remains behind a nearer detection.
    pub occlusion_factor: f64,
    /// Greatest squared Mahalanobis distance at which two features are merged.
    pub merge_distance: f64,
    /// Most hypotheses of data association.
    pub hypotheses: usize,
}

/// `[vehicle]`: see [`scphd::models::ControlNoise`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleSettings {
    /// Standard deviation of the speed, m/s.
    pub speed_sigma_mps: f64,
    /// Relative standard deviation of the speed; adds in quadrature.
    pub speed_sigma_ratio: f64,
    /// Standard deviation of the second control: steering angle, rad, or turn rate, rad/s.
    pub turn_sigma: f64,
    /// Relative standard deviation of the second control; adds in quadrature.
    pub turn_sigma_ratio: f64,
    /// Correlation time of the errors, s.
    pub noise_interval_s: f64,
}

/// `[calibration]`, only for a joint map: see [`scphd::models::SelfCalibrating`]. With it, `[vehicle]` is the remaining noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationSettings {
    /// Standard deviation of the speed's scale error.
    pub speed_scale_sigma: f64,
    /// Standard deviation of the second control's scale error.
    pub turn_scale_sigma: f64,
    /// Standard deviation of the second control's offset: steering angle, rad, or turn rate, rad/s.
    pub turn_offset_sigma: f64,
    /// Time after which these have changed by as much, s; 1e9: never.
    pub lasts_s: f64,
}

/// `[sensor]`: see [`scphd::models::RangeBearing`] and [`scphd::models::RangeBearingWindow`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorSettings {
    /// Standard deviation of the range, m.
    pub range_sigma_m: f64,
    /// Standard deviation of the range divided by the range; adds in quadrature.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub range_sigma_ratio: f64,
    /// Standard deviation of the bearing, rad.
    pub bearing_sigma_rad: f64,
    /// Least range, m.
    pub range_min_m: f64,
    /// Greatest range, m.
    pub range_max_m: f64,
    /// Half width of the soft edges in range, m.
    pub range_edge_m: f64,
    /// Right edge of the window, rad.
    pub bearing_min_rad: f64,
    /// Left edge of the window, rad.
    pub bearing_max_rad: f64,
    /// Half width of the soft edges in bearing, rad.
    pub bearing_edge_rad: f64,
    /// p_D at range zero.
    pub detection_near: f64,
    /// p_D at the greatest range.
    pub detection_far: f64,
    /// λ, false measurements a scan.
    pub clutter_per_scan: f64,
    /// Position of the sensor ahead of the vehicle's pose, m.
    pub forward_m: f64,
    /// Position to its left, m.
    pub left_m: f64,
    /// Yaw of the sensor, to the left, rad.
    pub yaw_rad: f64,
    /// With several sensors: birth intensities of this one divided by those of `filter` and `moving`.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub birth_factor: f64,
}

fn one() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_one(factor: &f64) -> bool {
    *factor == 1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(ratio: &f64) -> bool {
    *ratio == 0.0
}

impl SensorSettings {
    /// Standard deviation of a range, m.
    pub fn range_sigma_at(&self, range_m: f64) -> f64 {
        libm::hypot(self.range_sigma_m, self.range_sigma_ratio * range_m)
    }

    pub fn mounting(&self) -> Mounting {
        Mounting { forward_m: self.forward_m, left_m: self.left_m, yaw_rad: self.yaw_rad }
    }

    /// Middle of the bearing window, rad.
    pub fn bearing_center_rad(&self) -> f64 {
        0.5 * (self.bearing_min_rad + self.bearing_max_rad)
    }

    /// Half width of the bearing window, rad; π and above is a full circle.
    pub fn bearing_half_width_rad(&self) -> f64 {
        0.5 * (self.bearing_max_rad - self.bearing_min_rad)
    }

    /// Measure of the window in measurement space, m·rad: an intensity times it is a number a scan.
    pub fn measure(&self) -> f64 {
        (self.range_max_m - self.range_min_m) * 2.0 * self.bearing_half_width_rad().min(std::f64::consts::PI)
    }
}
