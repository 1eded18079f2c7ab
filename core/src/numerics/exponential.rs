//! Exponentials of numbers that come several times in a row.

use crate::Real;

/// The last exponential that was asked for: births of one scan weigh the same, most of them, and stand next to each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exponential<T> {
    of: T,
    is: T,
}

impl<T: Real> Exponential<T> {
    /// That of zero.
    pub(crate) const ZERO: Self = Self { of: T::ZERO, is: T::ONE };

    /// e to the power of `x`, to the bit.
    #[inline(always)]
    pub(crate) fn of(&mut self, x: T) -> T {
        // Written so that NaN is asked for anew.
        if !(x == self.of) {
            *self = Self { of: x, is: x.exp() };
        }
        self.is
    }
}

#[cfg(test)]
mod tests {
    use super::Exponential;

    #[test]
    fn every_number_gets_its_own() {
        let mut exponential = Exponential::ZERO;
        for x in [0.0_f32, -0.0, 0.0, 1.0, 1.0, -3.5, -3.5, f32::NEG_INFINITY, f32::NEG_INFINITY, 0.5, f32::INFINITY] {
            assert_eq!(exponential.of(x).to_bits(), crate::Real::exp(x).to_bits(), "{x}");
        }
        assert!(exponential.of(f32::NAN).is_nan() && exponential.of(f32::NAN).is_nan());
        assert_eq!(exponential.of(0.0), 1.0);
    }
}
