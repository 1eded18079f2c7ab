//! The mixture (`ScPhd`) for a vehicle under water.

use crate::block::Handle;
use crate::memory::{Asked, Entry};
use crate::pointer::{Bytes, Handed, In, Out, tell};
use crate::sets::{WATER_INFORMED_16, memories};
use crate::{
    map, scphd_description, scphd_feature_3d, scphd_fix, scphd_fix_report, scphd_map, scphd_predict_report,
    scphd_reason, scphd_scan_report, scphd_sonar, scphd_sonar_detector, scphd_status, scphd_water_pose, sonar,
};
use nalgebra::{Vector1, Vector3};
use scphd::ScPhd;
use scphd::models::{Auv, AuvControl, AuvPose, Reading};
use scphd::numerics::Symmetric;
use scphd_vehicle::Filter;

/// A mixture under water, in its memory.
#[derive(Debug)]
pub struct scphd_water {
    _opaque: [u8; 0],
}

impl Handle for scphd_water {
    type Inner = ScPhd<'static, Auv<f32>>;
    const KIND: u32 = 2;
}

/// The parameters of a vehicle under water.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_water_config {
    /// `sizeof(scphd_water_config)`, set by the caller.
    pub struct_size: u32,
    /// Standard deviation of the angular acceleration about the vertical, rad/s^2.
    pub yaw_acceleration_sigma_radps2: f32,
    /// Correlation time of the velocity noise, s. 0: independent noise in every prediction.
    pub velocity_interval_s: f32,
}

/// The control of a step.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_water_control {
    /// `sizeof(scphd_water_control)`, set by the caller.
    pub struct_size: u32,
    /// Velocity along the vehicle's axes, x ahead, y to the left, z upwards, m/s.
    pub velocity_mps: [f32; 3],
    /// Covariance of the velocity: xx, xy, yy, xz, yz, zz, m^2/s^2.
    pub velocity_covariance: [f32; 6],
    /// Roll at the end of the step, rad.
    pub roll_rad: f32,
    /// Pitch at the end of the step, rad.
    pub pitch_rad: f32,
    /// Mean yaw rate during the step, rad/s.
    pub yaw_rate_radps: f32,
    /// Standard deviation of the yaw rate, rad/s. 0: no gyroscope.
    pub yaw_rate_sigma_radps: f32,
    /// z at the end of the step, m, positive upwards: minus the depth.
    pub z_m: f32,
    /// Standard deviation of z, m. 0: no pressure sensor.
    pub z_sigma_m: f32,
}

impl scphd_water_control {
    fn control(&self) -> AuvControl<f32> {
        let [xx, xy, yy, xz, yz, zz] = self.velocity_covariance;
        // If the standard deviation is not a number, the motion model refuses the control.
        let reading = |value: f32, sigma: f32| (sigma != 0.0).then_some(Reading { value, sigma });
        AuvControl {
            velocity_mps: Vector3::from(self.velocity_mps),
            velocity_covariance: Symmetric::from_fn(|row, column| match (row, column) {
                (0, _) => xx,
                (1, 0) => xy,
                (1, _) => yy,
                (_, 0) => xz,
                (_, 1) => yz,
                _ => zz,
            }),
            roll_rad: self.roll_rad,
            pitch_rad: self.pitch_rad,
            yaw_rate_radps: reading(self.yaw_rate_radps, self.yaw_rate_sigma_radps),
            z_m: reading(self.z_m, self.z_sigma_m),
        }
    }
}

fn make(
    entry: Entry,
    asked: Asked<scphd_water>,
    mut description: Handed<scphd_description>,
    config: In<scphd_water_config>,
) -> scphd_status {
    asked.make(&WATER_INFORMED_16, entry, |state: &'static mut memories::WaterInformed16, reason| {
        let asked = config.get()?;
        let Filter::Mixture(tuning) = description.enter()?.filter else { return Err(scphd_status::NotDescribed) };
        let motion = Auv::new(asked.yaw_acceleration_sigma_radps2, asked.velocity_interval_s);
        let motion = motion.map_err(|error| reason.model(error))?;
        ScPhd::new(motion, tuning, state).map_err(|error| reason.setup(error))
    })
}

/// Starts a filter in this memory of `SCPHD_SIZE_WATER_INFORMED_16` bytes, which is zero or was released. `abi_version` is
/// `SCPHD_ABI_VERSION`. Only the mixture's settings and the limits of the motion are used from the description. The reason may be
/// null. Writes the handle to `filter`, or null. Reset it to a pose next.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_start(
    abi_version: u32,
    memory: Bytes,
    size_bytes: usize,
    description: Handed<scphd_description>,
    config: In<scphd_water_config>,
    reason: Out<scphd_reason>,
    filter: Out<*mut scphd_water>,
) -> scphd_status {
    make(Entry::Start, Asked { abi_version, memory, size_bytes, reason, handle: filter }, description, config)
}

/// Resumes the filter that the same build of this library has left in this memory: after a reset of the processor that kept it,
/// or in a copy of it.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_resume(
    abi_version: u32,
    memory: Bytes,
    size_bytes: usize,
    description: Handed<scphd_description>,
    config: In<scphd_water_config>,
    reason: Out<scphd_reason>,
    filter: Out<*mut scphd_water>,
) -> scphd_status {
    make(Entry::Resume, Asked { abi_version, memory, size_bytes, reason, handle: filter }, description, config)
}

/// Sets position and yaw of a vehicle that is level and at rest, clears the map and seeds the random numbers.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_reset(
    mut filter: Handed<scphd_water>,
    x_m: f32,
    y_m: f32,
    z_m: f32,
    yaw_rad: f32,
    seed: u64,
) -> scphd_status {
    let mut reset = || Ok(filter.enter()?.reset(AuvPose::new(x_m, y_m, z_m, yaw_rad), seed)?);
    scphd_status::of(reset())
}

/// Predicts the pose after `dt_s` seconds. The report may be null. If the control is refused, see `scphd_slam_predict`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_predict(
    mut filter: Handed<scphd_water>,
    control: In<scphd_water_control>,
    dt_s: f32,
    mut report: Out<scphd_predict_report>,
) -> scphd_status {
    let mut predict = || {
        let report = report.wanted()?;
        let done = filter.enter()?.predict(&control.get()?.control(), dt_s)?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(predict())
}

/// Updates the filter with a scan of ranges, bearings and elevations. The report may be null, and so may the measurements if
/// `count` is 0.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_scan_sonar(
    mut filter: Handed<scphd_water>,
    mut detector: Handed<scphd_sonar_detector>,
    measurements: In<scphd_sonar>,
    count: usize,
    mut report: Out<scphd_scan_report>,
) -> scphd_status {
    let mut scan = || {
        let (measurements, report): (&[Vector3<f32>], _) = (measurements.vectors(count)?, report.wanted()?);
        let done = filter.enter()?.scan(&mut *detector.enter()?, measurements)?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(scan())
}

/// Updates the filter with a measured z, m, positive upwards: minus the depth. The report may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_observe_height(
    mut filter: Handed<scphd_water>,
    fix: In<scphd_fix>,
    z_m: f32,
    mut report: Out<scphd_fix_report>,
) -> scphd_status {
    let mut observe = || {
        let report = report.wanted()?;
        let fix = fix.get()?.height().map_err(|_| scphd_status::OutOfRange)?;
        let done = filter.enter()?.observe(&fix, &Vector1::new(z_m))?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(observe())
}

/// Updates the filter with a measured yaw, from the x axis towards the y axis. The report may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_observe_heading(
    mut filter: Handed<scphd_water>,
    fix: In<scphd_fix>,
    yaw_rad: f32,
    mut report: Out<scphd_fix_report>,
) -> scphd_status {
    let mut observe = || {
        let report = report.wanted()?;
        let fix = fix.get()?.heading().map_err(|_| scphd_status::OutOfRange)?;
        let done = filter.enter()?.observe(&fix, &Vector1::new(yaw_rad))?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(observe())
}

/// Writes the pose estimate.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_estimate_pose(
    mut filter: Handed<scphd_water>,
    mut pose: Out<scphd_water_pose>,
) -> scphd_status {
    let mut estimate = || {
        let pose = pose.get()?;
        *pose = filter.enter()?.estimate_pose().ok_or(scphd_status::NotReset)?.into();
        Ok(())
    };
    scphd_status::of(estimate())
}

/// Writes features to an array of `capacity` elements, and counts those that do not fit. If `capacity` is 0 the array may be
/// null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_estimate_map(
    mut filter: Handed<scphd_water>,
    mut features: Out<scphd_feature_3d>,
    capacity: usize,
    mut map: Out<scphd_map>,
) -> scphd_status {
    let mut estimate = || {
        // The extraction methods that are available here do not use the detector.
        let detector = sonar::blind().map_err(|_| scphd_status::OutOfRange)?;
        let filter = filter.enter()?;
        map::write(&mut features, capacity, &mut map, |room| filter.estimate_map(&detector, room))
    };
    scphd_status::of(estimate())
}

/// As `scphd_slam_digest`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_water_digest(mut filter: Handed<scphd_water>, mut digest: Out<u64>) -> scphd_status {
    let mut hash = || {
        let place = digest.place()?;
        place.write(filter.enter()?.digest());
        Ok(())
    };
    scphd_status::of(hash())
}
