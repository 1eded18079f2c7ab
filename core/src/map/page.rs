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
    /// w of every component: an exponential, which every candidate would have to take again.
    weights: [T; PAGE_LEN],
    bounds: Bounds<T, D>,
    len: u16,
}

impl<T: Real, const N: usize, const D: usize> Page<T, N, D>
where
    Dim<N>: Packed,
{
    /// All zero; a placeholder for unused memory.
    pub(crate) const ZERO: Self =
        Self { components: [Component::ZERO; PAGE_LEN], weights: [T::ZERO; PAGE_LEN], bounds: Bounds::ZERO, len: 0 };

    /// The components.
    #[inline]
    pub(crate) fn components(&self) -> &[Component<T, N>] {
        self.components.get(..usize::from(self.len)).unwrap_or(&self.components)
    }

    /// The components, each with its weight.
    #[inline]
    pub(crate) fn weighted(&self) -> impl Iterator<Item = (&Component<T, N>, T)> {
        self.components().iter().zip(self.weights)
    }

    /// The box of their positions.
    #[inline]
    pub(crate) fn bounds(&self) -> &Bounds<T, D> {
        &self.bounds
    }

    /// Replaces every component by what `change` makes of it, and drops those of which it makes nothing.
    pub(crate) fn change(&mut self, change: impl Fn(&Component<T, N>) -> Option<Component<T, N>>) {
        let before = *self;
        self.refill(before.components().iter().filter_map(change));
    }

    /// Replaces the contents; takes at most [`PAGE_LEN`] components.
    pub(crate) fn fill<'a>(&mut self, components: impl Iterator<Item = &'a Component<T, N>>) {
        self.refill(components.copied());
    }

    fn refill(&mut self, components: impl Iterator<Item = Component<T, N>>) {
        self.len = 0;
        self.bounds = Bounds::EMPTY;
        for ((slot, weight), component) in self.components.iter_mut().zip(&mut self.weights).zip(components) {
            *slot = component;
            *weight = component.ln_weight.exp();
            self.bounds.include(&component.position());
            self.len += 1;
        }
    }
}
