//! Distributions of the number of points, p(n).

use super::ProcessError;
use scphd_log::noise::Noise;

/// Greatest mean of a [`Poisson`] number; a draw takes time in proportion to it.
pub const MAX_MEAN: f64 = 1e7;
/// The largest mean drawn at once; e^−mean stays far from the smallest numbers.
const MEAN_AT_ONCE: f64 = 400.0;
/// Least probability of a [`Geometric`] number: the longest run in 53 bits stays countable on 32-bit machines.
const LEAST_PROBABILITY: f64 = 1e-7;

/// A distribution of the number of points, p(n).
///
/// Any `Fn(&mut Noise) -> usize` is one.
pub trait Cardinality {
    /// Draws n ∼ p(n).
    fn draw(&self, noise: &mut Noise) -> usize;
}

impl<F: Fn(&mut Noise) -> usize> Cardinality for F {
    fn draw(&self, noise: &mut Noise) -> usize {
        self(noise)
    }
}

/// Poisson (3.17): p(n) = e^−λ λⁿ/n!, mean and variance λ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Poisson(f64);

impl Poisson {
    /// With the mean λ.
    ///
    /// # Errors
    ///
    /// [`ProcessError::Mean`] where `mean` is not within 0 and [`MAX_MEAN`].
    pub fn new(mean: f64) -> Result<Self, ProcessError> {
        if (0.0..=MAX_MEAN).contains(&mean) { Ok(Self(mean)) } else { Err(ProcessError::Mean(mean)) }
    }

    /// The mean λ.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.0
    }
}

impl Cardinality for Poisson {
    /// A sum of Poisson numbers of small means, which is a Poisson number of the sum of the means.
    fn draw(&self, noise: &mut Noise) -> usize {
        let parts = (self.0 / MEAN_AT_ONCE).ceil().max(1.0);
        (0..parts as usize).map(|_| noise.poisson(self.0 / parts)).sum()
    }
}

/// Binomial: successes in a number of trials N, mean Np, variance Np(1−p).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Binomial {
    trials: usize,
    probability: f64,
}

impl Binomial {
    /// `trials` trials that succeed with `probability` each.
    ///
    /// # Errors
    ///
    /// [`ProcessError::Probability`] where `probability` is not within 0 and 1.
    pub fn new(trials: usize, probability: f64) -> Result<Self, ProcessError> {
        if (0.0..=1.0).contains(&probability) {
            Ok(Self { trials, probability })
        } else {
            Err(ProcessError::Probability(probability))
        }
    }
}

impl Cardinality for Binomial {
    fn draw(&self, noise: &mut Noise) -> usize {
        (0..self.trials).filter(|_| noise.happens(self.probability)).count()
    }
}

/// Geometric from zero: p(n) = q(1−q)ⁿ, mean (1−q)/q, variance (1−q)/q².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometric(f64);

impl Geometric {
    /// Failures before a success of probability q.
    ///
    /// # Errors
    ///
    /// [`ProcessError::Probability`] where `probability` is not within 1e-7 and 1.
    pub fn new(probability: f64) -> Result<Self, ProcessError> {
        if (LEAST_PROBABILITY..=1.0).contains(&probability) {
            Ok(Self(probability))
        } else {
            Err(ProcessError::Probability(probability))
        }
    }
}

impl Cardinality for Geometric {
    /// The inverse of the distribution function; for q = 1 the divisor is −∞ and the number 0.
    fn draw(&self, noise: &mut Noise) -> usize {
        (libm::log(noise.uniform()) / libm::log1p(-self.0)) as usize
    }
}

/// Always the same number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fixed(pub usize);

impl Cardinality for Fixed {
    fn draw(&self, _: &mut Noise) -> usize {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::statistics::{assert_chi_square, assert_moments};
    use super::*;

    const DRAWS: usize = 50_000;

    fn draws(cardinality: &impl Cardinality, seed: u64, count: usize) -> Vec<f64> {
        let mut noise = Noise::new(seed);
        (0..count).map(|_| cardinality.draw(&mut noise) as f64).collect()
    }

    #[test]
    fn moments_are_the_closed_forms() {
        assert_moments(&draws(&Poisson::new(3.5).unwrap(), 1, DRAWS), 3.5, 3.5);
        assert_moments(&draws(&Poisson::new(1250.0).unwrap(), 2, 5_000), 1250.0, 1250.0);
        assert_moments(&draws(&Binomial::new(30, 0.3).unwrap(), 3, DRAWS), 9.0, 6.3);
        assert_moments(&draws(&Geometric::new(0.2).unwrap(), 4, DRAWS), 4.0, 20.0);
        let dice = |noise: &mut Noise| 1 + (6.0 * noise.uniform()) as usize;
        assert_moments(&draws(&dice, 5, DRAWS), 3.5, 35.0 / 12.0);
    }

    #[test]
    fn every_number_is_as_frequent_as_its_probability() {
        let mut poisson = vec![(-4.0_f64).exp()];
        let mut geometric = vec![0.25];
        let mut binomial = vec![0.6_f64.powi(12)];
        for n in 1..12 {
            poisson.push(poisson[n - 1] * 4.0 / n as f64);
            geometric.push(geometric[n - 1] * 0.75);
            binomial.push(binomial[n - 1] * (13 - n) as f64 / n as f64 * 0.4 / 0.6);
        }
        for (drawn, probability) in [
            (draws(&Poisson::new(4.0).unwrap(), 6, DRAWS), poisson),
            (draws(&Geometric::new(0.25).unwrap(), 7, DRAWS), geometric),
            (draws(&Binomial::new(12, 0.4).unwrap(), 8, DRAWS), binomial),
        ] {
            // The last two cells hold the tail, so that none is nearly empty.
            let cells = 10;
            let mut counts = vec![0.0; cells + 1];
            drawn.iter().for_each(|&n| counts[(n as usize).min(cells)] += 1.0);
            let mut expected: Vec<f64> = probability[..cells].iter().map(|p| p * DRAWS as f64).collect();
            expected.push(DRAWS as f64 - expected.iter().sum::<f64>());
            assert_chi_square(&counts, &expected, cells as f64);
        }
    }

    #[test]
    fn limits() {
        let mut noise = Noise::new(9);
        assert_eq!(Poisson::new(0.0).unwrap().draw(&mut noise), 0);
        assert_eq!(Geometric::new(1.0).unwrap().draw(&mut noise), 0);
        assert_eq!(Binomial::new(7, 1.0).unwrap().draw(&mut noise), 7);
        assert_eq!(Binomial::new(7, 0.0).unwrap().draw(&mut noise), 0);
        assert_eq!(Fixed(7).draw(&mut noise), 7);
        for wrong in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(Poisson::new(wrong).is_err() && Binomial::new(1, wrong).is_err() && Geometric::new(wrong).is_err());
        }
        assert!(Geometric::new(0.0).is_err());
        let error = Poisson::new(-1.0).unwrap_err();
        assert_eq!(error.to_string(), "a mean number of -1 points is not within 0 and 10000000");
    }
}
