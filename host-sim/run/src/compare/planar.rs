//! Lockstep in the plane.

use super::{Comparable, Comparison, JointComparison, Lockstep, NO_FIXES, drive, joint};
use scphd_filters::settings::Settings;
use scphd_filters::slam::{Precision, Refusal, core_filter, joint_filter, joint_references_of, references_of};
use scphd_log::dimensions::Planar;
use scphd_log::log::Log;
use scphd_reference::Reference;

impl Comparable<Planar, 2, 4> for Reference {
    fn control(control: &[f64; 3]) -> [f64; 3] {
        *control
    }

    fn coordinates(pose: &[f64; 3]) -> [f64; 3] {
        *pose
    }
}

impl Lockstep for Planar {
    fn lockstep(
        log: &Log,
        settings: &Settings,
        precision: Precision,
        seed: u64,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Comparison, Refusal> {
        if !log.fixes.is_empty() {
            return Err(Refusal(NO_FIXES.into()));
        }
        let references = references_of(settings, &log.vehicle);
        let mut filter = core_filter(settings, &log.vehicle, log.initial_pose, precision, seed)?;
        drive(log, settings, &references, &mut *filter, progress)
    }
    fn joint_lockstep(
        log: &Log,
        settings: &Settings,
        precision: Precision,
        progress: &mut dyn FnMut(usize),
    ) -> Result<JointComparison, Refusal> {
        if !log.fixes.is_empty() {
            return Err(Refusal(NO_FIXES.into()));
        }
        if settings.calibration.is_some() {
            return Err(Refusal("calibration: the reference takes odometry as it is".into()));
        }
        let references = joint_references_of(settings, &log.vehicle);
        let mut filter = joint_filter(settings, &log.vehicle, log.initial_pose, precision)?;
        joint::drive::<Self, _>(log, settings, &references, |&control| control, &mut *filter, progress)
    }
}
