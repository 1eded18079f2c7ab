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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_agree_with_finite_differences() {
        type Function = fn([Dual<2>; 2]) -> Dual<2>;
        let functions: [Function; 7] = [
            |[x, y]| x * y + x / y - y * 3.0,
            |[x, y]| (x * x + y).sqrt(),
            |[x, y]| x.sin() * y.cos(),
            |[x, y]| (x - y).tan(),
            |[x, y]| y.atan2(x),
            |[x, y]| (x * y).sinc(),
            |[x, y]| (x * y * 1e-3).sinc(),
        ];
        let (at, step) = ([0.7, 1.3], 1e-6);
        for (index, function) in functions.iter().enumerate() {
            let exact = function(Dual::variables(at));
            for k in 0..2 {
                let moved = |by: f64| {
                    let mut at = at;
                    at[k] += by;
                    function(Dual::variables(at)).value
                };
                let slope = (moved(step) - moved(-step)) / (2.0 * step);
                assert!((slope - exact.by[k]).abs() < 1e-8, "{index}: {slope} {exact:?}");
            }
        }
    }

    #[test]
    fn the_series_agrees_with_the_quotient() {
        let at = |a: f64| Dual::variables([a])[0].sinc();
        let (below, above) = (at(0.999_999e-2), at(1.000_001e-2));
        assert!((below.value - above.value).abs() < 1e-9 && (below.by[0] - above.by[0]).abs() < 1e-8);
        assert_eq!((at(0.0).value, at(0.0).by[0]), (1.0, 0.0));
    }
}
