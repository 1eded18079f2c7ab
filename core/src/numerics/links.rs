//! Linked lists of indices in an array.

/// The links of a component in view to others, by their indices.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linked {
    /// The next component in the same list.
    pub(crate) next: u16,
    /// The component into which this one is merged.
    pub(crate) head: u16,
    /// The first component that is merged into this one.
    pub(crate) first_member: u16,
}

/// The end of a list.
pub(crate) const NONE: u16 = u16::MAX;
