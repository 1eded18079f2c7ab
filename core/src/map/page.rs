//! A page: a few components that lie near each other, and the box they lie in.

use crate::{Bounds, Component, Dim, Packed, Real};

/// Components in one page. A page is what is shared, copied and passed over as one.
pub const PAGE_LEN: usize = 8;

/// Up to [`PAGE_LEN`] components and the box of their positions.
#[derive(Debug, Clone, Copy)]
pub struct Page<T: Real, const N: usize, const D: usize>
where
    Dim<N>: Packed,
{
    components: [Component<T, N>; PAGE_LEN],
    bounds: Bounds<T, D>,
    len: u16,
}

impl<T: Real, const N: usize, const D: usize> Page<T, N, D>
where
    Dim<N>: Packed,
{
    /// All zero; a placeholder for unused memory.
    pub(crate) const ZERO: Self = Self { components: [Component::ZERO; PAGE_LEN], bounds: Bounds::ZERO, len: 0 };

    /// The components.
    #[inline]
    pub(crate) fn components(&self) -> &[Component<T, N>] {
        self.components.get(..usize::from(self.len)).unwrap_or(&self.components)
    }

    /// The box of their positions.
    #[inline]
    pub(crate) fn bounds(&self) -> &Bounds<T, D> {
        &self.bounds
    }

    /// Replaces every component by what `change` makes of it, and drops those of which it makes nothing.
    pub(crate) fn change(&mut self, change: impl Fn(&Component<T, N>) -> Option<Component<T, N>>) {
        let before = *self;
        self.len = 0;
        self.bounds = Bounds::EMPTY;
        for (slot, changed) in self.components.iter_mut().zip(before.components().iter().filter_map(change)) {
            *slot = changed;
            self.bounds.include(&changed.position());
            self.len += 1;
        }
    }

    /// Replaces the contents; takes at most [`PAGE_LEN`] components.
    pub(crate) fn fill<'a>(&mut self, components: impl Iterator<Item = &'a Component<T, N>>) {
        self.len = 0;
        self.bounds = Bounds::EMPTY;
        for (slot, component) in self.components.iter_mut().zip(components) {
            *slot = *component;
            self.bounds.include(&component.position());
            self.len += 1;
        }
    }
}
