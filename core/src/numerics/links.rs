//! Linked lists of indices in an array.

/// What a component in view is linked to, by their places.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linked {
    /// The next in the list that it is in.
    pub(crate) next: u16,
    /// The component that it is merged into.
    pub(crate) head: u16,
    /// The first of those that are merged into it.
    pub(crate) first_member: u16,
}

/// Past the last of a list.
pub(crate) const NONE: u16 = u16::MAX;
