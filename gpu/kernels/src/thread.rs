//! What one thread does: finds what is its own in the buffers of all, and takes its run on.

use crate::buffer::{Feature, Mover, Prediction, Run, Scan, ScanResult, Status};
use crate::run::{Inputs, Outputs, Span, follow};
use crate::slot::Slot;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use nalgebra::Vector2;

/// The buffers of a launch, in the memory of whoever runs it.
#[derive(Debug, Clone, Copy)]
pub struct Launch {
    /// The runs, one a thread.
    pub runs: *const Run,
    /// The scans of all runs.
    pub scans: *const Scan,
    /// The predictions of all runs.
    pub predictions: *const Prediction,
    /// The measurements of all runs.
    pub measurements: *const Vector2<f32>,
    /// A slot for every run, which begins as zeros.
    pub slots: *mut Slot,
    /// How every run stands.
    pub statuses: *mut Status,
    /// A result for every scan.
    pub results: *mut ScanResult,
    /// Room for the estimated features of all runs.
    pub features: *mut Feature,
    /// Room for the estimated moving features of all runs.
    pub movers: *mut Mover,
    /// Number of runs.
    pub threads: u32,
    /// The first scan to take in of every run; the filters are started where it is 0.
    pub first_scan: u32,
    /// The greatest number of scans to take in.
    pub take_scans: u32,
    /// A digest after every so many scans, and after the last; 0: after the last alone.
    pub digest_every: u32,
}

/// A number of things on a machine that has at least 32 bits.
pub(crate) fn whole(number: u32) -> usize {
    number as usize
}

/// What the thread of that place does. Places beyond the last run have nothing to do; a run that has stopped stays as it is.
///
/// # Safety
/// Every pointer is aligned and leads to as many values as the launch and its runs say, which live for as long as the call. No other
/// thread of the same place runs at the same time, and no places of one run are those of another.
pub unsafe fn thread(place: usize, launch: &Launch) {
    if place >= whole(launch.threads) {
        return;
    }
    // SAFETY: there are as many runs, slots and statuses as threads, and this thread's are its own; where a run says that its inputs and
    // outputs lie, they do, and no other run's do. A slot begins as zeros, which are a value of it, as `slot.rs` holds it to.
    unsafe {
        let run = &*launch.runs.add(place);
        let status = &mut *launch.statuses.add(place);
        if launch.first_scan != 0 && status.code != Status::DONE {
            return;
        }
        let inputs = Inputs {
            run,
            scans: from_raw_parts(launch.scans.add(whole(run.first_scan)), whole(run.scans)),
            predictions: from_raw_parts(launch.predictions.add(whole(run.first_prediction)), whole(run.predictions)),
            measurements: from_raw_parts(
                launch.measurements.add(whole(run.first_measurement)),
                whole(run.measurements),
            ),
        };
        let mut outputs = Outputs {
            results: from_raw_parts_mut(launch.results.add(whole(run.first_scan)), whole(run.scans)),
            features: from_raw_parts_mut(launch.features.add(whole(run.first_feature)), whole(run.features)),
            movers: from_raw_parts_mut(launch.movers.add(whole(run.first_mover)), whole(run.movers)),
        };
        let span = Span {
            first: whole(launch.first_scan),
            scans: whole(launch.take_scans),
            digest_every: whole(launch.digest_every),
        };
        *status = follow(inputs, &mut *launch.slots.add(place), &mut outputs, span);
    }
}
