//! What every stage looks at first: whether its filter goes on, and what there is between the launches of a scan.

use crate::buffer::Status;
use crate::room::{Between, DraftOf, DraftPlace, Group};
use crate::size::Size;
use core::slice::from_raw_parts_mut;

/// A number of things on a machine that has at least 32 bits.
pub(crate) fn whole(number: u32) -> usize {
    number as usize
}

/// What is between the launches of a scan; nothing where the run has stopped.
pub(crate) unsafe fn between<'r, M: Size>(group: &Group<M>, scan: u32) -> Option<&'r Between> {
    // SAFETY: `open` has put it there where it did not stop the run.
    unsafe { goes_on(group, scan).then(|| (*group.room).between.assume_init_ref()) }
}

/// The same for the one thread of its launch.
pub(crate) unsafe fn alone<'r, M: Size>(place: usize, group: &Group<M>, scan: u32) -> Option<&'r mut Between> {
    // SAFETY: as of `between`, and no other thread looks at it.
    unsafe { (place == 0 && goes_on(group, scan)).then(|| (*group.room).between.assume_init_mut()) }
}

/// Whether the run has not stopped and has such a scan.
pub(crate) unsafe fn goes_on<M: Size>(group: &Group<M>, scan: u32) -> bool {
    // SAFETY: there is a status, which only the one thread of a launch writes, and a run, which nobody does.
    unsafe { (*group.status).code == Status::DONE && scan < (*group.run).scans }
}

/// The pages come back that were lent.
pub(crate) unsafe fn give_pages_back(between: &mut Between) {
    let Between { scanning, pages, moving_pages, .. } = between;
    // SAFETY: these are the slices that were lent, and nobody else has them any more.
    unsafe { scanning.give_pages_back((pages.back(), moving_pages.back())) };
}

/// So many drafts, for one thread.
pub(crate) unsafe fn all_drafts<'r, M: Size>(group: &Group<M>, count: usize) -> &'r mut [DraftOf] {
    // SAFETY: `desks` has made as many as there are particles, and a place is a draft and nothing else.
    unsafe { from_raw_parts_mut(group.drafts.cast(), count) }
}

/// One draft, for the thread that has it.
pub(crate) unsafe fn draft<'r, M: Size>(group: &Group<M>, place: usize) -> &'r mut DraftOf {
    // SAFETY: `desks` has made it.
    unsafe { (*group.drafts.add(place)).draft.assume_init_mut() }
}

// A place for a draft is no larger than a draft.
const _: () = assert!(size_of::<DraftPlace>() == size_of::<DraftOf>());
