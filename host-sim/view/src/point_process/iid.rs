//! I.i.d. processes (3.16).

use super::cardinality::Cardinality;
use super::spatial::Spatial;
use scphd_log::noise::Noise;

/// An i.i.d. process (3.16): f(Y) = n! p(n) f(y₁)…f(yₙ).
///
/// Its intensity is E\[n\] f(y). Nothing is cut at a border: points are wherever the spatial distribution puts them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IidProcess<C, S> {
    /// The cardinality distribution p(n).
    pub cardinality: C,
    /// The spatial distribution f(y).
    pub spatial: S,
}

impl<C: Cardinality, S: Spatial> IidProcess<C, S> {
    /// One realisation (procedure `simulateiidprocess`): n ∼ p(n), then n independent places.
    pub fn simulate(&self, noise: &mut Noise) -> Vec<S::Place> {
        let count = self.cardinality.draw(noise);
        (0..count).map(|_| self.spatial.draw(noise)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::cardinality::{Binomial, Fixed, Geometric};
    use super::super::region::Rectangle;
    use super::super::statistics::{assert_chi_square, assert_means, assert_moments, quadrat_counts};
    use super::*;

    /// Counts of `runs` realisations in 2 × 2 quadrats.
    fn counts(cardinality: impl Cardinality, seed: u64, runs: usize) -> Vec<Vec<f64>> {
        let spatial = Rectangle::new([-100.0, 100.0], [-50.0, 50.0]).unwrap();
        let process = IidProcess { cardinality, spatial };
        let mut noise = Noise::new(seed);
        (0..runs).map(|_| quadrat_counts(process.simulate(&mut noise), spatial, 2)).collect()
    }

    fn totals(counts: &[Vec<f64>]) -> Vec<f64> {
        counts.iter().map(|quadrats| quadrats.iter().sum()).collect()
    }

    #[test]
    fn the_number_is_that_of_the_cardinality() {
        assert_moments(&totals(&counts(Binomial::new(40, 0.25).unwrap(), 1, 20_000)), 10.0, 7.5);
        assert_moments(&totals(&counts(Geometric::new(0.1).unwrap(), 2, 20_000)), 9.0, 90.0);
        assert!(totals(&counts(Fixed(12), 3, 100)).iter().all(|&n| n == 12.0));
    }

    #[test]
    fn disjoint_quadrats_vary_together_as_the_cardinality_says() {
        // For shares a and b, cov(N_a, N_b) = ab(Var N − E N): Poisson is the one between.
        for (counts, expected) in [
            (counts(Fixed(40), 4, 20_000), -40.0 / 16.0),
            (counts(Geometric::new(0.1).unwrap(), 5, 20_000), (90.0 - 9.0) / 16.0),
            (counts(|noise: &mut Noise| noise.poisson(40.0), 6, 20_000), 0.0),
        ] {
            let mean = totals(&counts).iter().sum::<f64>() / (4.0 * counts.len() as f64);
            let products: Vec<Vec<f64>> = counts.iter().map(|q| vec![(q[0] - mean) * (q[3] - mean)]).collect();
            assert_means(&products, &[expected]);
        }
    }

    #[test]
    fn a_rectangle_is_filled_evenly() {
        let spatial = Rectangle::new([-100.0, 100.0], [-50.0, 50.0]).unwrap();
        let points = IidProcess { cardinality: Fixed(50_000), spatial }.simulate(&mut Noise::new(7));
        assert_chi_square(&quadrat_counts(points, spatial, 10), &[500.0; 100], 99.0);
    }
}
