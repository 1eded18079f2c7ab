//! Whether the filter is as sure of itself as it may be: evidence, innovations, position errors over their covariance; the same
//! in the plane and in space.

use crate::dimensions::{Coordinates, Covariance};
use crate::score::moving::median;

/// What the filter said of its own scans.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Consistency {
    scans: usize,
    ln_evidence: Option<f64>,
    innovation_sum: f64,
    innovations: usize,
}

impl Consistency {
    /// Takes one scan in: ln of its likelihood and its mean squared innovation, each where the filter says it.
    pub fn scan(&mut self, ln_evidence: Option<f64>, innovation: Option<f64>) {
        self.scans += 1;
        if let Some(ln_evidence) = ln_evidence {
            self.ln_evidence = Some(self.ln_evidence.unwrap_or(0.0) + ln_evidence);
        }
        if let Some(innovation) = innovation {
            self.innovation_sum += innovation;
            self.innovations += 1;
        }
    }

    /// ln of the likelihood of all scans. The filter leaves out the factor exp(−∫ κ + w_b dz) of every scan, which does not
    /// tell particles apart, but settings: `expected` is that integral, the mean number of false measurements and births.
    #[must_use]
    pub fn ln_evidence(&self, expected: f64) -> Option<f64> {
        self.ln_evidence.map(|sum| sum - self.scans as f64 * expected)
    }

    /// Mean squared innovation over what was expected of it.
    #[must_use]
    pub fn innovation(&self) -> Option<f64> {
        (self.innovations > 0).then(|| self.innovation_sum / self.innovations as f64)
    }
}

/// Median of eᵀ P⁻¹ e / D over errors e of a position in D dimensions, m, and their covariances P, m²; `None` where there are
/// none of them, or P is singular in all. Not the mean: after a scan that leaves all weight to one of the particles P is next to
/// nothing, and a few such scans would be all of it.
#[must_use]
pub fn of_positions<P: Coordinates>(errors: impl Iterator<Item = (P, Covariance<P>)>) -> Option<f64> {
    median(&errors.filter_map(|(error, covariance)| squared(error, covariance)).collect::<Vec<_>>())
}

/// eᵀ P⁻¹ e / D by P = L Lᵀ; `None` where P is not positive definite.
fn squared<P: Coordinates>(error: P, covariance: Covariance<P>) -> Option<f64> {
    let (error, covariance) = (error.as_ref(), covariance.as_ref());
    let mut lower = vec![vec![0.0; P::COUNT]; P::COUNT];
    let mut whitened = vec![0.0; P::COUNT];
    let mut sum = 0.0;
    for row in 0..P::COUNT {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| lower[row][k] * lower[column][k]).sum();
            let rest = covariance[row].as_ref()[column] - known;
            lower[row][column] = if column < row {
                rest / lower[column][column]
            } else if rest > 0.0 {
                rest.sqrt()
            } else {
                return None;
            };
        }
        let known: f64 = (0..row).map(|k| lower[row][k] * whitened[k]).sum();
        whitened[row] = (error[row] - known) / lower[row][row];
        sum += whitened[row] * whitened[row];
    }
    Some(sum / P::COUNT as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squared_errors_in_closed_form() {
        // P⁻¹ = [[2, −1], [−1, 2]] / 3.
        let planar = squared([1.0, 2.0], [[2.0, 1.0], [1.0, 2.0]]).unwrap();
        assert!((planar - (2.0 - 4.0 + 8.0) / 3.0 / 2.0).abs() < 1e-15);
        let c = [[4.0, 0.0, 2.0], [0.0, 9.0, 0.0], [2.0, 0.0, 2.0]];
        // x and z by P⁻¹ = [[2, −2], [−2, 4]] / 4, y alone.
        let spatial = squared([1.0, 3.0, 2.0], c).unwrap();
        assert!((spatial - ((2.0 - 8.0 + 16.0) / 4.0 + 1.0) / 3.0).abs() < 1e-15);
        for singular in [[[0.0, 0.0], [0.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]], [[f64::NAN, 0.0], [0.0, 1.0]]] {
            assert_eq!(squared([1.0, 1.0], singular), None);
        }
        assert_eq!(of_positions::<[f64; 3]>(std::iter::empty()), None);
    }

    #[test]
    fn sums_and_means_of_what_is_known() {
        let mut consistency = Consistency::default();
        assert_eq!((consistency.ln_evidence(1.0), consistency.innovation()), (None, None));
        consistency.scan(Some(-3.0), None);
        consistency.scan(Some(-5.0), Some(0.5));
        consistency.scan(None, Some(1.5));
        assert_eq!((consistency.ln_evidence(2.0), consistency.innovation()), (Some(-14.0), Some(1.0)));
    }
}
