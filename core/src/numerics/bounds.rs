//! Axis-aligned bounding boxes, with which pages out of view are skipped.

use crate::{Real, Vector};

/// An axis-aligned box in map coordinates, m.
///
/// ```
/// use scphd::numerics::Bounds;
/// use nalgebra::Vector2;
///
/// let mut page = Bounds::<Vector2<f32>>::EMPTY;
/// page.include(&Vector2::new(1.0, 2.0));
/// page.include(&Vector2::new(3.0, -1.0));
/// assert!(page.meets(&Bounds::around(&Vector2::new(4.0, 0.0), 1.5)));
/// assert!(!page.meets(&Bounds::around(&Vector2::new(5.0, 0.0), 1.5)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds<D> {
    /// Least coordinates, m.
    pub low: D,
    /// Greatest coordinates, m.
    pub high: D,
}

impl<T: Real, D: Vector<Scalar = T>> Bounds<D> {
    /// The empty box, which intersects no other box.
    pub const EMPTY: Self = Self { low: D::INFINITY, high: D::NEG_INFINITY };

    /// The box that contains all points.
    pub const EVERYWHERE: Self = Self { low: D::NEG_INFINITY, high: D::INFINITY };

    /// All zero; a placeholder for unused memory.
    pub(crate) const ZERO: Self = Self { low: D::ZERO, high: D::ZERO };

    /// The cube of half width `reach` around `centre`, m.
    pub fn around(centre: &D, reach: T) -> Self {
        Self { low: D::with(|k| centre.at(k) - reach), high: D::with(|k| centre.at(k) + reach) }
    }

    /// The box with a margin on every side of `share` times its extent.
    pub(crate) fn grown(&self, share: T) -> Self {
        let more = (self.high - self.low) * share;
        Self { low: self.low - more, high: self.high + more }
    }

    /// Extends the box to contain `point`.
    pub fn include(&mut self, point: &D) {
        self.low = D::with(|k| self.low.at(k).at_most(point.at(k)));
        self.high = D::with(|k| self.high.at(k).at_least(point.at(k)));
    }

    /// Whether the point is in the box.
    #[inline]
    #[must_use]
    pub fn holds(&self, point: &D) -> bool {
        let within = |((x, low), high): ((&T, &T), &T)| x >= low && x <= high;
        point.as_slice().iter().zip(self.low.as_slice()).zip(self.high.as_slice()).all(within)
    }

    /// Whether this box contains the whole other box.
    #[inline]
    #[must_use]
    pub fn covers(&self, other: &Self) -> bool {
        self.holds(&other.low) && self.holds(&other.high)
    }

    /// Whether the boxes intersect.
    #[inline]
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        let below = |a: &D, b: &D| a.as_slice().iter().zip(b.as_slice()).all(|(a, b)| a <= b);
        below(&self.low, &other.high) && below(&other.low, &self.high)
    }
}
