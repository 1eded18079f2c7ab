//! A page: a few neighbouring components and their bounding box.

use crate::{Bounds, Component, Feature, Real, Vector};

/// Number of components in one page. A page is shared, copied and skipped as a whole.
pub const PAGE_LEN: usize = 8;

/// Up to [`PAGE_LEN`] components and the bounding box of their positions.
#[derive(Debug, Clone, Copy)]
pub struct Page<F: Feature> {
    components: [Component<F::State>; PAGE_LEN],
    /// w of every component, stored so that the exponential is not computed for every candidate.
    weights: [<F::State as Vector>::Scalar; PAGE_LEN],
    bounds: Bounds<F::Position>,
    len: u16,
}

/// All data of a page, for fault injection.
#[cfg(any(test, feature = "flips"))]
pub(crate) struct Fields<'p, F: Feature> {
    pub(crate) components: &'p mut [Component<F::State>; PAGE_LEN],
    pub(crate) weights: &'p mut [<F::State as Vector>::Scalar; PAGE_LEN],
    pub(crate) bounds: &'p mut Bounds<F::Position>,
    pub(crate) len: &'p mut u16,
}

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Page<F> {
    /// All zero; a placeholder for unused memory.
    pub(crate) const ZERO: Self =
        Self { components: [Component::ZERO; PAGE_LEN], weights: [T::ZERO; PAGE_LEN], bounds: Bounds::ZERO, len: 0 };

    /// The components.
    #[inline]
    pub(crate) fn components(&self) -> &[Component<F::State>] {
        self.components.get(..usize::from(self.len)).unwrap_or(&self.components)
    }

    /// The components, each with its weight.
    #[inline]
    pub(crate) fn weighted(&self) -> impl Iterator<Item = (&Component<F::State>, T)> {
        self.components().iter().zip(self.weights.iter().copied())
    }

    /// The bounding box of their positions.
    #[inline]
    pub(crate) fn bounds(&self) -> &Bounds<F::Position> {
        &self.bounds
    }

    /// All data that a memory fault may change.
    #[cfg(any(test, feature = "flips"))]
    pub(crate) fn fields(&mut self) -> Fields<'_, F> {
        let Self { components, weights, bounds, len } = self;
        Fields { components, weights, bounds, len }
    }

    /// Replaces every component by the result of `change`, and removes those for which it is `None`.
    pub(crate) fn change(&mut self, change: impl Fn(&Component<F::State>) -> Option<Component<F::State>>) {
        let before = core::mem::replace(&mut self.len, 0);
        self.bounds = Bounds::EMPTY;
        for place in 0..usize::from(before).min(PAGE_LEN) {
            // Kept components are at indices before the next one to read.
            if let Some(changed) = self.components.get(place).and_then(&change) {
                self.push(&changed);
            }
        }
    }

    /// Replaces the content by at most [`PAGE_LEN`] components.
    pub(crate) fn fill<'a>(&mut self, components: impl Iterator<Item = &'a Component<F::State>>) {
        self.len = 0;
        self.bounds = Bounds::EMPTY;
        components.for_each(|component| self.push(component));
    }

    /// Makes this page a copy of another one.
    pub fn copy_from(&mut self, other: &Self) {
        let Self { components, weights, bounds, len } = self;
        (*components, *weights, *bounds, *len) = (other.components, other.weights, other.bounds, other.len);
    }

    /// The labels of its components.
    pub(crate) fn labels_mut(&mut self) -> impl Iterator<Item = &mut u32> {
        let len = usize::from(self.len);
        self.components.iter_mut().take(len).map(|component| &mut component.label)
    }

    /// Adds a component if there is room.
    pub(crate) fn push(&mut self, component: &Component<F::State>) {
        let place = usize::from(self.len);
        if let Some((slot, weight)) = self.components.get_mut(place).zip(self.weights.get_mut(place)) {
            *slot = *component;
            *weight = component.ln_weight.exp();
            self.bounds.include(&component.position());
            self.len += 1;
        }
    }
}
