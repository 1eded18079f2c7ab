//! Axis-aligned boxes, by which pages out of view are passed over.

use crate::Real;
use nalgebra::SVector;

/// An axis-aligned box in map coordinates, m.
///
/// ```
/// use scphd::Bounds;
/// use nalgebra::Vector2;
///
/// let mut page = Bounds::<f32, 2>::EMPTY;
/// page.include(&Vector2::new(1.0, 2.0));
/// page.include(&Vector2::new(3.0, -1.0));
/// assert!(page.meets(&Bounds::around(&Vector2::new(4.0, 0.0), 1.5)));
/// assert!(!page.meets(&Bounds::around(&Vector2::new(5.0, 0.0), 1.5)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds<T, const D: usize> {
    /// Least coordinates, m.
    pub low: SVector<T, D>,
    /// Greatest coordinates, m.
    pub high: SVector<T, D>,
}

const fn filled<T: Real, const D: usize>(value: T) -> SVector<T, D> {
    SVector::from_array_storage(nalgebra::ArrayStorage([[value; D]; 1]))
}

impl<T: Real, const D: usize> Bounds<T, D> {
    /// The empty box, which meets nothing.
    pub const EMPTY: Self = Self { low: filled(T::INFINITY), high: filled(T::NEG_INFINITY) };

    /// The box that everything is in.
    pub const EVERYWHERE: Self = Self { low: filled(T::NEG_INFINITY), high: filled(T::INFINITY) };

    /// All zero; a placeholder for unused memory.
    pub(crate) const ZERO: Self = Self { low: filled(T::ZERO), high: filled(T::ZERO) };

    /// The cube of half width `reach` around `centre`, m.
    #[must_use]
    pub fn around(centre: &SVector<T, D>, reach: T) -> Self {
        Self { low: centre.map(|c| c - reach), high: centre.map(|c| c + reach) }
    }

    /// The box with so much of its extent more on every side.
    pub(crate) fn grown(&self, share: T) -> Self {
        let more = (self.high - self.low).map(|extent| extent * share);
        Self { low: self.low - more, high: self.high + more }
    }

    /// Grows to take in `point`.
    pub fn include(&mut self, point: &SVector<T, D>) {
        self.low.zip_apply(point, |low, p| *low = low.at_most(p));
        self.high.zip_apply(point, |high, p| *high = high.at_least(p));
    }

    /// Whether the point is in the box.
    #[inline]
    #[must_use]
    pub fn holds(&self, point: &SVector<T, D>) -> bool {
        let within = |((x, low), high): ((&T, &T), &T)| x >= low && x <= high;
        point.iter().zip(self.low.iter()).zip(self.high.iter()).all(within)
    }

    /// Whether all of the other box is in this one.
    #[inline]
    #[must_use]
    pub fn covers(&self, other: &Self) -> bool {
        self.holds(&other.low) && self.holds(&other.high)
    }

    /// Whether the boxes share a point.
    #[inline]
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        let below = |a: &SVector<T, D>, b: &SVector<T, D>| a.iter().zip(b.iter()).all(|(a, b)| a <= b);
        below(&self.low, &other.high) && below(&other.low, &self.high)
    }
}
