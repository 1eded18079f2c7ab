//! Numbers with their derivatives (automatic differentiation), so that no derivative of a model is written by hand.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number and its derivatives with respect to `N` variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dual<const N: usize> {
    pub(super) value: f64,
    pub(super) by: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// A number that does not depend on the variables.
    pub(super) fn constant(value: f64) -> Self {
        Self { value, by: [0.0; N] }
    }

    /// The variables with these values.
    pub(super) fn variables(values: [f64; N]) -> [Self; N] {
        from_fn(|k| Self { value: values[k], by: from_fn(|other| if other == k { 1.0 } else { 0.0 }) })
    }

    /// A function of the number, with the given value and derivative.
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, by: self.by.map(|by| slope * by) }
    }

    fn times(self, other: Self) -> Self {
        let by = from_fn(|k| self.by[k] * other.value + self.value * other.by[k]);
        Self { value: self.value * other.value, by }
    }

    pub(super) fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }

    pub(super) fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }

    pub(super) fn tan(self) -> Self {
        let tangent = self.value.tan();
        self.chain(tangent, 1.0 + tangent * tangent)
    }

    pub(super) fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }

    /// The angle of (x, y), where y is this number.
    pub(super) fn atan2(self, x: Self) -> Self {
        let squared = self.value * self.value + x.value * x.value;
        let by = from_fn(|k| (x.value * self.by[k] - self.value * x.by[k]) / squared);
        Self { value: self.value.atan2(x.value), by }
    }

    /// sin a / a, near 0 by its series.
    pub(super) fn sinc(self) -> Self {
        let a = self.value;
        if a.abs() > 1e-2 {
            return self.sin() / self;
        }
        let a2 = a * a;
        self.chain(
            1.0 - a2 / 6.0 * (1.0 - a2 / 20.0 * (1.0 - a2 / 42.0)),
            -a / 3.0 * (1.0 - a2 / 10.0 * (1.0 - a2 / 28.0 * (1.0 - a2 / 54.0))),
        )
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, by: from_fn(|k| self.by[k] + other.by[k]) }
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;

    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        self.times(other)
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self.chain(self.value * factor, factor)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        self * other.chain(1.0 / other.value, -1.0 / (other.value * other.value))
    }
}
