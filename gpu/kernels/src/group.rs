//! What every stage needs first: whether its filter continues, and the state between the launches of a scan.

use crate::buffer::Status;
use crate::room::{Between, DraftOf, DraftPlace, Group};
use crate::size::Size;
use core::slice::from_raw_parts_mut;

/// A `u32` as `usize`. The machine has at least 32 bits.
pub(crate) fn whole(number: u32) -> usize {
    number as usize
}

/// The state between the launches of a scan; `None` if the run has stopped.
pub(crate) unsafe fn between<'r, M: Size>(group: &Group<M>, scan: u32) -> Option<&'r Between> {
    // SAFETY: `open` has initialised it, or has stopped the run.
    unsafe { goes_on(group, scan).then(|| (*group.room).between.assume_init_ref()) }
}

/// The same state, mutable, for the only thread of a launch.
pub(crate) unsafe fn alone<'r, M: Size>(place: usize, group: &Group<M>, scan: u32) -> Option<&'r mut Between> {
    // SAFETY: as in `between`, and no other thread accesses it.
    unsafe { (place == 0 && goes_on(group, scan)).then(|| (*group.room).between.assume_init_mut()) }
}

/// Whether the run has not stopped and has this scan.
pub(crate) unsafe fn goes_on<M: Size>(group: &Group<M>, scan: u32) -> bool {
    // SAFETY: there is a status, which only single-thread launches write, and a run, which is never written.
    unsafe { (*group.status).code == Status::DONE && scan < (*group.run).scans }
}

/// Gives the lent pages back.
pub(crate) unsafe fn give_pages_back(between: &mut Between) {
    let Between { scanning, pages, moving_pages, .. } = between;
    // SAFETY: these are the slices that were lent, and nothing else refers to them any more.
    unsafe { scanning.give_pages_back((pages.back(), moving_pages.back())) };
}

/// The first `count` drafts, for one thread.
pub(crate) unsafe fn all_drafts<'r, M: Size>(group: &Group<M>, count: usize) -> &'r mut [DraftOf] {
    // SAFETY: `desks` has initialised one for each particle, and a `DraftPlace` contains nothing but a draft.
    unsafe { from_raw_parts_mut(group.drafts.cast(), count) }
}

/// The draft at this place, for its thread.
pub(crate) unsafe fn draft<'r, M: Size>(group: &Group<M>, place: usize) -> &'r mut DraftOf {
    // SAFETY: `desks` has initialised it.
    unsafe { (*group.drafts.add(place)).draft.assume_init_mut() }
}

// A `DraftPlace` has the size of a draft.
const _: () = assert!(size_of::<DraftPlace>() == size_of::<DraftOf>());
