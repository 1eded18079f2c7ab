//! Numbering of pages in the order of the traversal, so that a snapshot does not depend on their positions in the pool.

use crate::map::PageId;

/// A page that was not visited yet.
const UNMET: u16 = u16::MAX;

/// The numbers of the pages of one pool.
#[derive(Debug)]
pub(crate) struct Numbering<'n> {
    of_page: &'n mut [u16],
    next: u16,
}

/// Whether a page was visited before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Met {
    /// The first visit of this page.
    First,
    /// The page was visited before, and has this number.
    Before(u16),
}

impl<'n> Numbering<'n> {
    /// No pages visited yet; the memory has an element for every page.
    pub(crate) fn over(of_page: &'n mut [u16]) -> Self {
        of_page.fill(UNMET);
        Self { of_page, next: 0 }
    }

    /// Visits a page.
    pub(crate) fn meet(&mut self, id: PageId) -> Met {
        match self.of_page.get_mut(id.index()) {
            Some(number) if *number == UNMET => {
                *number = self.next;
                self.next = self.next.saturating_add(1);
                Met::First
            }
            Some(number) => Met::Before(*number),
            None => Met::First,
        }
    }
}
