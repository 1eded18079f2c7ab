//! What every stage needs first: whether its filter continues, and the state between the launches of a scan.

use crate::buffer::Status;
use crate::kind::Kind;
use crate::room::Size;
use crate::room::{Between, DraftOf, Group};
use crate::run::{Inputs, Outputs, asks_for_digest};
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// A `u32` as `usize`. The machine has at least 32 bits.
pub(crate) fn whole(number: u32) -> usize {
    number as usize
}

/// The state between the launches of a scan; `None` if the run has stopped.
pub(crate) unsafe fn between<'r, M: Size>(group: &Group<M>, scan: u32) -> Option<&'r Between> {
    // SAFETY: `open` has initialised it, or has stopped the run.
    unsafe { goes_on(group, scan).then(|| (*group.rooms).between.assume_init_ref()) }
}

/// The same state, mutable, for the only thread of a launch.
pub(crate) unsafe fn alone<'r, M: Size>(place: usize, group: &Group<M>, scan: u32) -> Option<&'r mut Between> {
    // SAFETY: as in `between`, and no other thread accesses it.
    unsafe { (place == 0 && goes_on(group, scan)).then(|| (*group.rooms).between.assume_init_mut()) }
}

/// Whether the run has not stopped and has this scan.
pub(crate) unsafe fn goes_on<M: Kind>(group: &Group<M>, scan: u32) -> bool {
    // SAFETY: there is a status, which only single-thread launches write, and a run, which is never written.
    unsafe { (*group.statuses).code == Status::DONE && scan < (*group.runs).scans }
}

/// The inputs of a run.
pub(crate) unsafe fn inputs<'r, M: Kind>(group: &Group<M>) -> Inputs<'r> {
    // SAFETY: the inputs are where the run says, and are never written.
    unsafe {
        let run = &*group.runs;
        Inputs {
            run,
            scans: from_raw_parts(group.scans, whole(run.scans)),
            predictions: from_raw_parts(group.predictions, whole(run.predictions)),
            measurements: from_raw_parts(group.measurements, whole(run.measurements)),
        }
    }
}

/// The outputs of a run, for the only thread that writes them.
pub(crate) unsafe fn outputs<'r, M: Kind>(group: &Group<M>) -> Outputs<'r> {
    // SAFETY: the outputs are where the run says.
    unsafe {
        let run = &*group.runs;
        Outputs {
            results: from_raw_parts_mut(group.results, whole(run.scans)),
            features: from_raw_parts_mut(group.features, whole(run.features)),
        }
    }
}

/// Whether the run needs a digest after this scan.
pub(crate) unsafe fn asks<M: Kind>(group: &Group<M>, scan: u32, digest_every: u32) -> bool {
    let taken = scan.saturating_add(1);
    // SAFETY: as in `goes_on`.
    unsafe { goes_on(group, scan) && asks_for_digest(whole(digest_every), whole(taken), taken == (*group.runs).scans) }
}

/// Gives the lent pages back.
pub(crate) unsafe fn give_pages_back(between: &mut Between) {
    let Between { scanning, pages, moving_pages, .. } = between;
    // SAFETY: these are the slices that were lent, and nothing else refers to them any more.
    unsafe { scanning.give_pages_back((pages.back(), moving_pages.back())) };
}

/// The first `count` drafts, for one thread.
pub(crate) unsafe fn all_drafts<'r, M: Size>(group: &Group<M>, count: usize) -> &'r mut [DraftOf] {
    // SAFETY: `desks` has initialised one for each particle.
    unsafe { from_raw_parts_mut(group.drafts.cast(), count) }
}

/// The draft at this place, for its thread.
pub(crate) unsafe fn draft<'r, M: Size>(group: &Group<M>, place: usize) -> &'r mut DraftOf {
    // SAFETY: `desks` has initialised it.
    unsafe { (*group.drafts.add(place)).assume_init_mut() }
}
