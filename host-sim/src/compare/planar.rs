//! Lockstep in the plane.

use super::{Comparable, Comparison, Lockstep, drive};
use crate::dimensions::Planar;
use crate::log::Log;
use crate::reference::Reference;
use crate::settings::Settings;
use crate::slam::{Precision, Refusal, core_filter, reference_of};

impl Comparable<Planar, 2, 4> for Reference {
    fn control(control: &[f64; 2]) -> [f64; 2] {
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
        let reference = reference_of(settings, &log.vehicle);
        let mut filter = core_filter(settings, &log.vehicle, log.initial_pose, precision, seed)?;
        drive(log, settings, &reference, &mut *filter, progress)
    }
}
