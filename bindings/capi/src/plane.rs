//! The mixture (`ScPhd`) for a vehicle in the plane.

use crate::block::Handle;
use crate::memory::{Entry, Memory, hand_out};
use crate::pointer::{Bytes, Handed, In, Out, tell};
use crate::reason::Reason;
use crate::sets::in_plane;
use crate::{
    map, range_bearing, scphd_bearing_detector, scphd_feature, scphd_fix, scphd_fix_report, scphd_map, scphd_mover,
    scphd_plane_pose, scphd_predict_report, scphd_range_bearing, scphd_range_bearing_detector, scphd_reason,
    scphd_scan_report, scphd_status, scphd_tuning, scphd_vehicle, version,
};
use nalgebra::{Vector1, Vector2};
use scphd::models::{AckermannControl, HolonomicControl, PlanarControl, PlanarMotion, PlanarPose, UnicycleControl};
use scphd::{Config, ScPhd};

/// A mixture in the plane, in its memory.
#[derive(Debug)]
pub struct scphd_plane {
    _opaque: [u8; 0],
}

impl Handle for scphd_plane {
    type Inner = ScPhd<'static, PlanarMotion<f32>>;
    const KIND: u32 = 1;
}

/// What there is to say of such a filter.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_plane_config {
    /// `sizeof(scphd_plane_config)`, set by the caller.
    pub struct_size: u32,
    /// The vehicle.
    pub vehicle: scphd_vehicle,
    /// The tuning.
    pub tuning: scphd_tuning,
}

fn fill(mut config: Out<scphd_plane_config>, of: Config<f32>) -> scphd_status {
    scphd_status::of(config.get().map(|config| {
        let struct_size = config.struct_size;
        *config = scphd_plane_config { struct_size, vehicle: scphd_vehicle::wheeled(), tuning: scphd_tuning::of(&of) };
    }))
}

/// Fills in a configuration, but for its size: many particles, each with so many samples of the motion that the scan chooses among. For
/// sensors whose scan leaves several places open. The vehicle is a robot without noise: set what it is.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_blind(config: Out<scphd_plane_config>, particles: u32, samples: u32) -> scphd_status {
    fill(config, Config::blind(particles as usize, samples as usize))
}

/// Fills in a configuration, but for its size: few particles that take the scan in before they are drawn. For sensors whose scan tells
/// where the vehicle is among its features. The vehicle is a robot without noise: set what it is.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_informed(config: Out<scphd_plane_config>, particles: u32) -> scphd_status {
    fill(config, Config::informed(particles as usize))
}

/// A caller's memory and what a filter is to be in it.
struct Asked {
    abi_version: u32,
    set: u32,
    memory: Bytes,
    size_bytes: usize,
    config: In<scphd_plane_config>,
    reason: Out<scphd_reason>,
    filter: Out<*mut scphd_plane>,
}

impl Asked {
    fn enter(mut self, entry: Entry) -> scphd_status {
        scphd_status::of(hand_out(self.filter, || {
            version::check(self.abi_version)?;
            let mut reason = Reason::of(&mut self.reason)?;
            let memory = Memory::of::<scphd_plane>(self.memory, self.size_bytes, self.set, entry)?;
            let config = self.config.get()?;
            let (motion, config) = (config.vehicle.motion(&mut reason)?, config.tuning.config(&mut reason)?);
            in_plane!(memory, |state| ScPhd::new(motion, config, state).map_err(|error| reason.setup(error)))
        }))
    }
}

/// Starts a filter in this memory, which is zero or was released: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of
/// `SCPHD_SET_PLANE_...`. The reason may be null. Writes the handle to `filter`, or null. Reset it to a pose next.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_start(
    abi_version: u32,
    set: u32,
    memory: Bytes,
    size_bytes: usize,
    config: In<scphd_plane_config>,
    reason: Out<scphd_reason>,
    filter: Out<*mut scphd_plane>,
) -> scphd_status {
    Asked { abi_version, set, memory, size_bytes, config, reason, filter }.enter(Entry::Start)
}

/// Goes on with what the same build of this library has left in this memory: after a reset of the processor that kept it, or in a copy of
/// it. The configuration may be another, but for particles, samples and proposal. What is found is checked; it is no checksum, and
/// memory that may have been damaged needs one.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_resume(
    abi_version: u32,
    set: u32,
    memory: Bytes,
    size_bytes: usize,
    config: In<scphd_plane_config>,
    reason: Out<scphd_reason>,
    filter: Out<*mut scphd_plane>,
) -> scphd_status {
    Asked { abi_version, set, memory, size_bytes, config, reason, filter }.enter(Entry::Resume)
}

/// Puts the vehicle to a pose, with an empty map, and begins the random stream of a seed.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_reset(
    mut filter: Handed<scphd_plane>,
    x_m: f32,
    y_m: f32,
    heading_rad: f32,
    seed: u64,
) -> scphd_status {
    let mut reset = || Ok(filter.enter()?.reset(PlanarPose::new(x_m, y_m, heading_rad), seed)?);
    scphd_status::of(reset())
}

fn predict(
    mut filter: Handed<scphd_plane>,
    control: PlanarControl<f32>,
    dt_s: f32,
    mut report: Out<scphd_predict_report>,
) -> scphd_status {
    let mut predict = || {
        let report = report.wanted()?;
        let done = filter.enter()?.predict(&control, dt_s)?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(predict())
}

/// Moves a car for `dt_s` seconds: speed of its encoder's wheel, steering angle to the left. The report may be null. Where the control is
/// refused, its time has passed all the same, and the next report says so.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_predict_car(
    filter: Handed<scphd_plane>,
    speed_mps: f32,
    steering_rad: f32,
    dt_s: f32,
    report: Out<scphd_predict_report>,
) -> scphd_status {
    predict(filter, PlanarControl::Ackermann(AckermannControl { speed_mps, steering_rad }), dt_s, report)
}

/// Moves a robot for `dt_s` seconds: speed, turn rate to the left. As `scphd_plane_predict_car`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_predict_robot(
    filter: Handed<scphd_plane>,
    speed_mps: f32,
    rate_radps: f32,
    dt_s: f32,
    report: Out<scphd_predict_report>,
) -> scphd_status {
    predict(filter, PlanarControl::Unicycle(UnicycleControl { speed_mps, rate_radps }), dt_s, report)
}

/// Moves a vehicle that moves sideways too for `dt_s` seconds: speeds ahead and to the left, turn rate to the left. As
/// `scphd_plane_predict_car`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_predict_holonomic(
    filter: Handed<scphd_plane>,
    forward_mps: f32,
    left_mps: f32,
    rate_radps: f32,
    dt_s: f32,
    report: Out<scphd_predict_report>,
) -> scphd_status {
    predict(filter, PlanarControl::Holonomic(HolonomicControl { forward_mps, left_mps, rate_radps }), dt_s, report)
}

/// Takes in a scan of range and bearing. The report may be null; so may the measurements, where there are none.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_scan_range_bearing(
    mut filter: Handed<scphd_plane>,
    mut detector: Handed<scphd_range_bearing_detector>,
    measurements: In<scphd_range_bearing>,
    count: usize,
    mut report: Out<scphd_scan_report>,
) -> scphd_status {
    let mut scan = || {
        let (measurements, report): (&[Vector2<f32>], _) = (measurements.vectors(count)?, report.wanted()?);
        let done = filter.enter()?.scan(&mut *detector.enter()?, measurements)?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(scan())
}

/// Takes in a scan of bearings, rad, 0 ahead, growing to the left. As `scphd_plane_scan_range_bearing`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_scan_bearing(
    mut filter: Handed<scphd_plane>,
    mut detector: Handed<scphd_bearing_detector>,
    bearings_rad: In<f32>,
    count: usize,
    mut report: Out<scphd_scan_report>,
) -> scphd_status {
    let mut scan = || {
        let (measurements, report): (&[Vector1<f32>], _) = (bearings_rad.vectors(count)?, report.wanted()?);
        let done = filter.enter()?.scan(&mut *detector.enter()?, measurements)?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(scan())
}

/// Takes in a measured position, between any two steps. The report may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_observe_position(
    mut filter: Handed<scphd_plane>,
    fix: In<scphd_fix>,
    x_m: f32,
    y_m: f32,
    mut report: Out<scphd_fix_report>,
) -> scphd_status {
    let mut observe = || {
        let report = report.wanted()?;
        let fix = fix.get()?.position().map_err(|_| scphd_status::OutOfRange)?;
        let done = filter.enter()?.observe(&fix, &Vector2::new(x_m, y_m))?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(observe())
}

/// Takes in a measured heading, from the x axis towards the y axis, between any two steps. The report may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_observe_heading(
    mut filter: Handed<scphd_plane>,
    fix: In<scphd_fix>,
    heading_rad: f32,
    mut report: Out<scphd_fix_report>,
) -> scphd_status {
    let mut observe = || {
        let report = report.wanted()?;
        let fix = fix.get()?.heading().map_err(|_| scphd_status::OutOfRange)?;
        let done = filter.enter()?.observe(&fix, &Vector1::new(heading_rad))?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(observe())
}

/// Where the vehicle is.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_estimate_pose(
    mut filter: Handed<scphd_plane>,
    mut pose: Out<scphd_plane_pose>,
) -> scphd_status {
    let mut estimate = || {
        let pose = pose.get()?;
        *pose = filter.enter()?.estimate_pose().ok_or(scphd_status::NotReset)?.into();
        Ok(())
    };
    scphd_status::of(estimate())
}

/// Writes the features that stand still to an array of so many; what does not fit is counted. An array of none may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_estimate_map(
    mut filter: Handed<scphd_plane>,
    mut features: Out<scphd_feature>,
    capacity: usize,
    mut map: Out<scphd_map>,
) -> scphd_status {
    let mut estimate = || {
        // The extractions that there are here do not look at it.
        let detector = range_bearing::blind().map_err(|_| scphd_status::OutOfRange)?;
        let filter = filter.enter()?;
        map::write(&mut features, capacity, &mut map, |room| filter.estimate_map(&detector, room))
    };
    scphd_status::of(estimate())
}

/// Writes the features that move to an array of so many, where they are by now. As `scphd_plane_estimate_map`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_estimate_movers(
    mut filter: Handed<scphd_plane>,
    mut movers: Out<scphd_mover>,
    capacity: usize,
    mut map: Out<scphd_map>,
) -> scphd_status {
    let mut estimate = || {
        let filter = filter.enter()?;
        map::write(&mut movers, capacity, &mut map, |room| filter.estimate_moving(room))
    };
    scphd_status::of(estimate())
}

/// A hash of all that the filter knows, to the last bit: the same inputs give the same on every machine.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_plane_digest(mut filter: Handed<scphd_plane>, mut digest: Out<u64>) -> scphd_status {
    let mut hash = || {
        let place = digest.place()?;
        place.write(filter.enter()?.digest());
        Ok(())
    };
    scphd_status::of(hash())
}
