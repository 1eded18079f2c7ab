//! The updates of a scan, one for each distinct survivor.

use crate::numerics::work;

/// A map update: which map, for which particle, and with what share of the pool.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Task {
    /// The selected candidate.
    pub(crate) survivor: u16,
    /// The particle whose predicted map is updated.
    pub(crate) parent: usize,
    /// The particle that gets the updated map.
    pub(crate) particle: usize,
    /// Number of particles that share the updated map, from `particle` on.
    pub(crate) copies: usize,
    /// Whether no later survivor needs the parent's map.
    pub(crate) last_child: bool,
    /// Number of maps still to be updated, this one included.
    pub(crate) remaining: usize,
    /// Number of pages of the pool that must remain free.
    pub(crate) reserved: usize,
}

impl Task {
    /// A placeholder.
    pub(crate) const NONE: Self =
        Self { survivor: 0, parent: 0, particle: 0, copies: 0, last_child: false, remaining: 0, reserved: 0 };
}

/// One task for each of the `distinct` different survivors; together they leave `reserved` pages free.
pub(crate) fn tasks<'s>(
    survivors: &'s [u16],
    distinct: usize,
    reserved: usize,
    parent_of: impl Fn(u16) -> usize + 's,
) -> impl Iterator<Item = Task> + 's {
    let mut particle = 0;
    let mut remaining = distinct;
    let mut copies = runs(survivors).peekable();
    core::iter::from_fn(move || {
        work::round();
        let copy = copies.next()?;
        let survivor = *copy.first()?;
        let parent = parent_of(survivor);
        let last_child = copies.peek().and_then(|next| next.first()).is_none_or(|&next| parent_of(next) != parent);
        let task = Task { survivor, parent, particle, copies: copy.len(), last_child, remaining, reserved };
        particle += copy.len();
        remaining -= 1;
        Some(task)
    })
}

/// The survivors in runs of equal ones. The standard library's `chunk_by` has a panic that the compiler does not remove.
pub(crate) fn runs(mut survivors: &[u16]) -> impl Iterator<Item = &[u16]> {
    core::iter::from_fn(move || {
        let first = survivors.first()?;
        let len = survivors.iter().take_while(|&survivor| survivor == first).count();
        let (run, rest) = survivors.split_at_checked(len)?;
        survivors = rest;
        Some(run)
    })
}
