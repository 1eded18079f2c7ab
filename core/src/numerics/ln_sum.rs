//! Sums of weights in the log domain.

use crate::Real;

/// ln Σ exp(tᵢ), summed term by term without overflow or underflow (appendix A asks for the log domain).
///
/// The sum is stored relative to its greatest term, which needs one exponential per term and one logarithm at the end.
///
/// ```
/// use scphd::numerics::LnSum;
///
/// let mut sum = LnSum::EMPTY;
/// sum.add(-1000.0_f32);
/// sum.add(-1000.0);
/// assert!((sum.ln() - (-1000.0 + 2.0_f32.ln())).abs() < 1e-4);
/// assert_eq!(LnSum::<f32>::EMPTY.ln(), f32::NEG_INFINITY);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LnSum<T> {
    greatest: T,
    scaled: T,
}

impl<T: Real> LnSum<T> {
    /// The empty sum: ln 0.
    pub const EMPTY: Self = Self { greatest: T::NEG_INFINITY, scaled: T::ZERO };

    /// All zero; a placeholder for unused memory.
    pub(crate) const ZERO: Self = Self { greatest: T::ZERO, scaled: T::ZERO };

    /// The sum of one term, given by its logarithm.
    pub fn of(ln_term: T) -> Self {
        if ln_term > T::NEG_INFINITY { Self { greatest: ln_term, scaled: T::ONE } } else { Self::EMPTY }
    }

    /// Adds a term, given by its logarithm. A term of −∞ (weight zero) or NaN adds nothing, and neither does one that is too
    /// small to change the sum: relative to its greatest term, the sum is never below one.
    #[inline(always)]
    pub fn add(&mut self, ln_term: T) {
        let rises = ln_term > self.greatest;
        if !(rises || ln_term > self.greatest + T::LN_VANISHING) {
            return;
        }
        let ratio = (-(ln_term - self.greatest).abs()).exp();
        if rises {
            self.scaled = self.scaled * ratio + T::ONE;
            self.greatest = ln_term;
        } else {
            self.scaled += ratio;
        }
    }

    /// The logarithm of the sum.
    #[inline]
    pub fn ln(&self) -> T {
        // A sum of one term is that term.
        if self.scaled == T::ONE { self.greatest } else { self.greatest + self.scaled.ln() }
    }
}

/// Sum of the logarithms of `LnSum` values. Multiplies them while the product is in range, so that few logarithms are necessary.
pub(crate) fn ln_product<'s, T: Real>(sums: impl Iterator<Item = &'s LnSum<T>>) -> T {
    // Relative to its greatest term, a sum is between one and the number of its terms.
    let many = T::from_f64(1e30);
    let (mut ln_product, mut product) = (T::ZERO, T::ONE);
    for sum in sums {
        ln_product += sum.greatest;
        product *= sum.scaled;
        if product > many {
            ln_product += product.ln();
            product = T::ONE;
        }
    }
    ln_product + product.ln()
}

/// ln Σ exp(tᵢ) over all terms.
pub(crate) fn ln_sum<T: Real>(ln_terms: impl Iterator<Item = T>) -> T {
    let mut sum = LnSum::EMPTY;
    ln_terms.for_each(|term| sum.add(term));
    sum.ln()
}

#[cfg(test)]
mod tests {
    use super::{LnSum, ln_product, ln_sum};
    use std::vec::Vec;

    #[test]
    fn order_and_scale_do_not_matter() {
        let terms = [-3.0_f64, 2.0, -700.0, 1.5];
        let direct = terms.iter().map(|t| t.exp()).sum::<f64>().ln();
        assert!((ln_sum(terms.into_iter()) - direct).abs() < 1e-14);
        assert!((ln_sum(terms.into_iter().rev()) - direct).abs() < 1e-14);
        let shifted = ln_sum(terms.into_iter().map(|t| t - 5000.0));
        assert!((shifted - (direct - 5000.0)).abs() < 1e-11);
    }

    #[test]
    fn products_of_many_sums() {
        let sums: Vec<LnSum<f32>> = (0..200)
            .map(|k| {
                let mut sum = LnSum::of(0.1 * k as f32);
                (0..k).for_each(|_| sum.add(0.1 * k as f32));
                sum
            })
            .collect();
        let direct: f64 = sums.iter().map(|sum| f64::from(sum.ln())).sum();
        assert!((f64::from(ln_product(sums.iter())) / direct - 1.0).abs() < 1e-6);
        assert_eq!(ln_product([LnSum::<f32>::EMPTY].iter()), f32::NEG_INFINITY);
        assert_eq!(ln_product::<f32>([].iter()), 0.0);
    }

    #[test]
    fn zero_weights_are_valid() {
        assert_eq!(ln_sum([f32::NEG_INFINITY; 3].into_iter()), f32::NEG_INFINITY);
        assert_eq!(ln_sum([f32::NEG_INFINITY, 0.0].into_iter()), 0.0);
        let mut sum = LnSum::of(1.0_f32);
        sum.add(f32::NAN);
        assert_eq!(sum.ln(), 1.0);
    }
}
