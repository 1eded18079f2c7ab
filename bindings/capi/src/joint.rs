//! The joint map (`JointSlam`) for a vehicle in the plane.

use crate::block::Handle;
use crate::map::write_each;
use crate::memory::{Entry, Memory, hand_out};
use crate::pointer::{Bytes, Handed, In, Out, tell};
use crate::reason::Reason;
use crate::sets::in_joint;
use crate::{
    scphd_feature, scphd_fix, scphd_fix_report, scphd_joint_report, scphd_map, scphd_plane_pose, scphd_plausible,
    scphd_predict_report, scphd_range_bearing, scphd_range_bearing_detector, scphd_reason, scphd_status, scphd_vehicle,
    version,
};
use nalgebra::{Vector1, Vector2};
use scphd::models::{AckermannControl, HolonomicControl, PlanarControl, PlanarMotion, PlanarPose, UnicycleControl};
use scphd::settings::Persistence;
use scphd::{JointConfig, JointSlam};

/// A joint map, in its memory.
#[derive(Debug)]
pub struct scphd_joint {
    _opaque: [u8; 0],
}

impl Handle for scphd_joint {
    type Inner = JointSlam<'static, PlanarMotion<f32>, Vector2<f32>>;
    const KIND: u32 = 2;
}

/// What there is to say of such a filter. Do not fill it in by hand, but by `scphd_joint_defaults`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_joint_config {
    /// `sizeof(scphd_joint_config)`, set by the caller.
    pub struct_size: u32,
    /// The vehicle.
    pub vehicle: scphd_vehicle,
    /// A measurement gives birth where nothing else explains at least this share of it.
    pub birth_probability_min: f32,
    /// Squared Mahalanobis distance beyond which a measurement says nothing of a feature.
    pub gate: f32,
    /// Mean time that a landmark stays in sight before something hides it, s; infinite: nothing does.
    pub visible_s: f32,
    /// Mean time that it stays hidden, s.
    pub occluded_s: f32,
    /// Mean time until it is taken away, s; infinite: never.
    pub lifetime_s: f32,
    /// Share of the probability of detection that is left behind a nearer detection.
    pub occlusion_factor: f32,
    /// A feature is dropped below this probability that it is there.
    pub least_existence: f32,
    /// The same while it was detected less than twice.
    pub least_tentative: f32,
    /// A feature is part of the estimate from this probability on.
    pub extraction_existence: f32,
    /// Squared Mahalanobis distance within which two features are one.
    pub merge_distance: f32,
    /// What no vehicle does.
    pub plausible: scphd_plausible,
}

impl scphd_joint_config {
    fn of(config: &JointConfig<f32>) -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            vehicle: scphd_vehicle::wheeled(),
            birth_probability_min: config.birth_probability_min,
            gate: config.gate,
            visible_s: config.persistence.visible_s,
            occluded_s: config.persistence.occluded_s,
            lifetime_s: config.persistence.lifetime_s,
            occlusion_factor: config.occlusion_factor,
            least_existence: config.least_existence,
            least_tentative: config.least_tentative,
            extraction_existence: config.extraction_existence,
            merge_distance: config.merge_distance,
            plausible: scphd_plausible::of(config.plausible),
        }
    }

    fn config(&self) -> JointConfig<f32> {
        JointConfig {
            birth_probability_min: self.birth_probability_min,
            gate: self.gate,
            persistence: Persistence {
                visible_s: self.visible_s,
                occluded_s: self.occluded_s,
                lifetime_s: self.lifetime_s,
            },
            occlusion_factor: self.occlusion_factor,
            least_existence: self.least_existence,
            least_tentative: self.least_tentative,
            extraction_existence: self.extraction_existence,
            merge_distance: self.merge_distance,
            plausible: self.plausible.limits(),
        }
    }
}

/// Fills in a configuration, but for its size. The vehicle is a robot without noise: set what it is.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_defaults(mut config: Out<scphd_joint_config>) -> scphd_status {
    scphd_status::of(config.get().map(|config| *config = scphd_joint_config::of(&JointConfig::default())))
}

/// A caller's memory and what a filter is to be in it.
struct Asked {
    abi_version: u32,
    set: u32,
    memory: Bytes,
    size_bytes: usize,
    config: In<scphd_joint_config>,
    reason: Out<scphd_reason>,
    filter: Out<*mut scphd_joint>,
}

impl Asked {
    fn enter(mut self, entry: Entry) -> scphd_status {
        scphd_status::of(hand_out(self.filter, || {
            version::check(self.abi_version)?;
            let mut reason = Reason::of(&mut self.reason)?;
            let memory = Memory::of::<scphd_joint>(self.memory, self.size_bytes, self.set, entry)?;
            let config = self.config.get()?;
            let (motion, config) = (config.vehicle.motion(&mut reason)?, config.config());
            in_joint!(memory, |state| JointSlam::new(motion, config, state).map_err(|error| reason.setup(error)))
        }))
    }
}

/// Starts a filter in this memory, which is zero or was released: `abi_version` is `SCPHD_ABI_VERSION`, `set` one of
/// `SCPHD_SET_JOINT_...`. The reason may be null. Writes the handle to `filter`, or null. Reset it to a pose next.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_start(
    abi_version: u32,
    set: u32,
    memory: Bytes,
    size_bytes: usize,
    config: In<scphd_joint_config>,
    reason: Out<scphd_reason>,
    filter: Out<*mut scphd_joint>,
) -> scphd_status {
    Asked { abi_version, set, memory, size_bytes, config, reason, filter }.enter(Entry::Start)
}

/// Goes on with what the same build of this library has left in this memory, as `scphd_plane_resume`; but what is found is taken as it is.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_resume(
    abi_version: u32,
    set: u32,
    memory: Bytes,
    size_bytes: usize,
    config: In<scphd_joint_config>,
    reason: Out<scphd_reason>,
    filter: Out<*mut scphd_joint>,
) -> scphd_status {
    Asked { abi_version, set, memory, size_bytes, config, reason, filter }.enter(Entry::Resume)
}

/// Puts the vehicle to a pose, certain of it, with an empty map.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_reset(
    mut filter: Handed<scphd_joint>,
    x_m: f32,
    y_m: f32,
    heading_rad: f32,
) -> scphd_status {
    let mut reset = || Ok(filter.enter()?.reset(PlanarPose::new(x_m, y_m, heading_rad))?);
    scphd_status::of(reset())
}

fn predict(
    mut filter: Handed<scphd_joint>,
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

/// As `scphd_plane_predict_car`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_predict_car(
    filter: Handed<scphd_joint>,
    speed_mps: f32,
    steering_rad: f32,
    dt_s: f32,
    report: Out<scphd_predict_report>,
) -> scphd_status {
    predict(filter, PlanarControl::Ackermann(AckermannControl { speed_mps, steering_rad }), dt_s, report)
}

/// As `scphd_plane_predict_robot`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_predict_robot(
    filter: Handed<scphd_joint>,
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
pub extern "C" fn scphd_joint_predict_holonomic(
    filter: Handed<scphd_joint>,
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
pub extern "C" fn scphd_joint_scan_range_bearing(
    mut filter: Handed<scphd_joint>,
    mut detector: Handed<scphd_range_bearing_detector>,
    measurements: In<scphd_range_bearing>,
    count: usize,
    mut report: Out<scphd_joint_report>,
) -> scphd_status {
    let mut scan = || {
        let (measurements, report): (&[Vector2<f32>], _) = (measurements.vectors(count)?, report.wanted()?);
        let done = filter.enter()?.scan(&*detector.enter()?, measurements)?;
        tell(report, done);
        Ok(())
    };
    scphd_status::of(scan())
}

/// As `scphd_plane_observe_position`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_observe_position(
    mut filter: Handed<scphd_joint>,
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

/// As `scphd_plane_observe_heading`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_observe_heading(
    mut filter: Handed<scphd_joint>,
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
pub extern "C" fn scphd_joint_estimate_pose(
    mut filter: Handed<scphd_joint>,
    mut pose: Out<scphd_plane_pose>,
) -> scphd_status {
    let mut estimate = || {
        let pose = pose.get()?;
        *pose = filter.enter()?.estimate_pose().ok_or(scphd_status::NotReset)?.into();
        Ok(())
    };
    scphd_status::of(estimate())
}

/// Writes the features to an array of so many; what does not fit is counted. An array of none may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_estimate_map(
    mut filter: Handed<scphd_joint>,
    mut features: Out<scphd_feature>,
    capacity: usize,
    mut map: Out<scphd_map>,
) -> scphd_status {
    let mut estimate = || {
        let (map, room, filter) = (map.get()?, features.room(capacity)?, filter.enter()?);
        let features = filter.features().map(scphd_feature::from);
        *map = scphd_map::of(write_each(room, features, filter.expected_features()));
        Ok(())
    };
    scphd_status::of(estimate())
}

/// As `scphd_plane_digest`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_joint_digest(mut filter: Handed<scphd_joint>, mut digest: Out<u64>) -> scphd_status {
    let mut hash = || {
        let place = digest.place()?;
        place.write(filter.enter()?.digest());
        Ok(())
    };
    scphd_status::of(hash())
}
