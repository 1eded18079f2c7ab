//! Detectors of range, bearing and elevation.

use crate::block::Handle;
use crate::memory::{Asked, Entry};
use crate::pointer::{Bytes, In, Out};
use crate::sets::{SONAR_64, memories};
use crate::{scphd_reason, scphd_status};
use nalgebra::Vector3;
use scphd::models::{ModelError, Mounting, RangeBearingElevation, Sensing, SonarLimits, SonarWindow, UniformClutter};
use scphd::storage::ScanRoom;
use scphd::{Births, Detector};

/// A detector of range, bearing and elevation, in its memory.
#[derive(Debug)]
pub struct scphd_sonar_detector {
    _opaque: [u8; 0],
}

/// A measurement of range, bearing and elevation.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_sonar {
    /// Range, m.
    pub range_m: f32,
    /// Bearing, rad, 0 ahead, positive to the left.
    pub bearing_rad: f32,
    /// Elevation, rad, 0 horizontal, positive upwards.
    pub elevation_rad: f32,
}

/// The pose of a sensor on its vehicle, relative to the vehicle's pose: x ahead, y to the left, z upwards. The rotation is roll,
/// then pitch, then yaw.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_mounting {
    /// Position ahead, m.
    pub forward_m: f32,
    /// Position to the left, m.
    pub left_m: f32,
    /// Position upwards, m.
    pub up_m: f32,
    /// Rotation about the axis ahead, rad.
    pub roll_rad: f32,
    /// Rotation about the axis to the left, rad.
    pub pitch_rad: f32,
    /// Rotation about the axis upwards, rad.
    pub yaw_rad: f32,
}

impl scphd_mounting {
    /// A sensor at the vehicle's pose.
    const NONE: Self = Self { forward_m: 0.0, left_m: 0.0, up_m: 0.0, roll_rad: 0.0, pitch_rad: 0.0, yaw_rad: 0.0 };

    /// `None` if the sensor is at the vehicle's pose.
    fn mounting(&self) -> Result<Option<Mounting<f32>>, ModelError> {
        let place = [self.forward_m, self.left_m, self.up_m];
        let angles = [self.roll_rad, self.pitch_rad, self.yaw_rad];
        if place.iter().chain(&angles).all(|&number| number == 0.0) {
            return Ok(None);
        }
        Mounting::in_space(place, angles).map(Some)
    }
}

/// The parameters of a sonar.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_sonar_config {
    /// `sizeof(scphd_sonar_config)`, set by the caller.
    pub struct_size: u32,
    /// Standard deviation of the range, m.
    pub range_sigma_m: f32,
    /// Standard deviation of the bearing, rad.
    pub bearing_sigma_rad: f32,
    /// Standard deviation of the elevation, rad.
    pub elevation_sigma_rad: f32,
    /// Greatest range, m.
    pub range_max_m: f32,
    /// Half width of the ramp at the greatest range, m.
    pub range_edge_m: f32,
    /// Half width of the view in bearing, rad; pi or more: all around.
    pub bearing_half_width_rad: f32,
    /// Half width of the view in elevation, rad; pi/2 or more: everything.
    pub elevation_half_width_rad: f32,
    /// Half width of the ramps at the edges in bearing and elevation, rad.
    pub angle_edge_rad: f32,
    /// Probability of detection, in [0, 1).
    pub probability: f32,
    /// Expected number of false measurements in a scan.
    pub clutter_per_scan: f32,
    /// Birth intensity of static features, 1/(m rad^2).
    pub births_still: f32,
    /// Pose of the sensor on the vehicle.
    pub mounting: scphd_mounting,
}

/// The models of a sonar.
pub(crate) type Spherical = Sensing<RangeBearingElevation<f32>, SonarWindow<f32>, UniformClutter<f32>>;

impl Handle for scphd_sonar_detector {
    type Inner = Detector<Spherical, ScanRoom<'static, Vector3<f32>>>;
    const KIND: u32 = 3;
}

/// Volume of a view, range × bearing × elevation, m rad².
fn measure(range_max_m: f32, bearing_half_width_rad: f32, elevation_half_width_rad: f32) -> f32 {
    let bearing = bearing_half_width_rad.min(core::f32::consts::PI);
    let elevation = elevation_half_width_rad.min(core::f32::consts::FRAC_PI_2);
    range_max_m * (bearing + bearing) * (elevation + elevation)
}

impl scphd_sonar_config {
    fn sensing(&self) -> Result<Spherical, ModelError> {
        let sensor = RangeBearingElevation::new(self.range_sigma_m, self.bearing_sigma_rad, self.elevation_sigma_rad)?;
        let field_of_view = SonarWindow::new(SonarLimits {
            range_max_m: self.range_max_m,
            range_edge_m: self.range_edge_m,
            bearing_half_width_rad: self.bearing_half_width_rad,
            elevation_half_width_rad: self.elevation_half_width_rad,
            angle_edge_rad: self.angle_edge_rad,
            probability: self.probability,
        })?;
        let measure = measure(self.range_max_m, self.bearing_half_width_rad, self.elevation_half_width_rad);
        let clutter = UniformClutter::of_scan(self.clutter_per_scan, measure)?;
        Ok(Sensing { sensor, field_of_view, clutter })
    }

    fn detector(&self) -> Result<Detector<Spherical>, ModelError> {
        let detector = Detector::new(self.sensing()?, Births::of_static(self.births_still))?;
        match self.mounting.mounting()? {
            Some(mounting) => detector.mounted(mounting),
            None => Ok(detector),
        }
    }
}

/// A detector without a view, for functions of the library that require one but do not use it.
pub(crate) fn blind() -> Result<Detector<Spherical>, ModelError> {
    let limits = SonarLimits {
        range_max_m: 1.0,
        range_edge_m: 0.0,
        bearing_half_width_rad: 1.0,
        elevation_half_width_rad: 1.0,
        angle_edge_rad: 0.0,
        probability: 0.0,
    };
    let (field_of_view, clutter) = (SonarWindow::new(limits)?, UniformClutter::of_scan(0.0, 1.0)?);
    let sensor = RangeBearingElevation::new(1.0, 1.0, 1.0)?;
    Detector::new(Sensing { sensor, field_of_view, clutter }, Births::NONE)
}

/// Writes the defaults of a sonar with this greatest range, m, and this probability of detection, in [0, 1): a view of all
/// directions, one false measurement in a scan, one new feature in ten scans, at the vehicle's pose. The standard deviations of
/// the noise are 0, which is out of range: set them.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_sonar_defaults(
    mut config: Out<scphd_sonar_config>,
    range_max_m: f32,
    probability: f32,
) -> scphd_status {
    use core::f32::consts::{FRAC_PI_2, PI};
    scphd_status::of(config.get().map(|config| {
        *config = scphd_sonar_config {
            struct_size: config.struct_size,
            range_sigma_m: 0.0,
            bearing_sigma_rad: 0.0,
            elevation_sigma_rad: 0.0,
            range_max_m,
            range_edge_m: 0.0,
            bearing_half_width_rad: PI,
            elevation_half_width_rad: FRAC_PI_2,
            angle_edge_rad: 0.0,
            probability,
            clutter_per_scan: 1.0,
            births_still: 0.1 / measure(range_max_m, PI, FRAC_PI_2),
            mounting: scphd_mounting::NONE,
        };
    }))
}

/// Starts a detector in this memory of `SCPHD_SIZE_SONAR_64` bytes. `abi_version` is `SCPHD_ABI_VERSION`. The reason may be null.
/// Writes the handle to `detector`, or null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_sonar_start(
    abi_version: u32,
    memory: Bytes,
    size_bytes: usize,
    config: In<scphd_sonar_config>,
    reason: Out<scphd_reason>,
    detector: Out<*mut scphd_sonar_detector>,
) -> scphd_status {
    let asked = Asked { abi_version, memory, size_bytes, reason, handle: detector };
    asked.make(&SONAR_64, Entry::Start, |room: &'static mut memories::Sonar64, reason| {
        let detector = config.get()?.detector().map_err(|error| reason.model(error))?;
        detector.over(room).map_err(|error| reason.setup(error))
    })
}
