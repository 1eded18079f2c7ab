//! Poisson processes (3.18), homogeneous or not.

use super::cardinality::Poisson;
use super::iid::IidProcess;
use super::region::Rectangle;
use super::spatial::Spatial;
use super::{Point, ProcessError};
use scphd_log::noise::Noise;

/// The homogeneous Poisson process with `mean` points in `region`: intensity `mean`/area up to the border, nothing
/// beyond it.
///
/// # Errors
///
/// [`ProcessError::Mean`].
pub fn homogeneous(region: Rectangle, mean: f64) -> Result<IidProcess<Poisson, Rectangle>, ProcessError> {
    inhomogeneous(mean, region)
}

/// The Poisson process with `mean` points that lie as `spatial` says: intensity `mean` · f(y), wherever f(y) > 0.
///
/// # Errors
///
/// [`ProcessError::Mean`].
pub fn inhomogeneous<S: Spatial>(mean: f64, spatial: S) -> Result<IidProcess<Poisson, S>, ProcessError> {
    Ok(IidProcess { cardinality: Poisson::new(mean)?, spatial })
}

/// The Poisson process of a bounded intensity function over a rectangle, by thinning.
///
/// Points of the homogeneous process of the bound are kept with probability intensity/bound. The intensity is that of
/// the function up to the border; there is nothing beyond it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thinned<F> {
    proposals: IidProcess<Poisson, Rectangle>,
    intensity: F,
    bound: f64,
}

impl<F: Fn(Point) -> f64> Thinned<F> {
    /// The process of `intensity` (1/m²), which is nowhere in `region` greater than `bound`.
    ///
    /// # Errors
    ///
    /// [`ProcessError::Mean`] where the bound times the area is not a mean number of points.
    pub fn new(region: Rectangle, intensity: F, bound: f64) -> Result<Self, ProcessError> {
        Ok(Self { proposals: homogeneous(region, bound * region.area())?, intensity, bound })
    }

    /// One realisation.
    ///
    /// # Errors
    ///
    /// [`ProcessError::Intensity`] where the function is found negative, not a number or beyond its bound.
    pub fn simulate(&self, noise: &mut Noise) -> Result<Vec<Point>, ProcessError> {
        let mut kept = Vec::new();
        for at in self.proposals.simulate(noise) {
            let intensity = (self.intensity)(at);
            if !(0.0..=self.bound).contains(&intensity) {
                return Err(ProcessError::Intensity { at, intensity, bound: self.bound });
            }
            if noise.happens(intensity / self.bound) {
                kept.push(at);
            }
        }
        Ok(kept)
    }
}

#[cfg(test)]
mod tests {
    use super::super::spatial::Normal;
    use super::super::statistics::{assert_chi_square, assert_k, assert_moments, pair_densities, quadrat_counts};
    use super::*;
    use std::f64::consts::PI;

    fn region() -> Rectangle {
        Rectangle::new([-100.0, 100.0], [-100.0, 100.0]).unwrap()
    }

    fn totals(counts: &[Vec<f64>]) -> Vec<f64> {
        counts.iter().map(|quadrats| quadrats.iter().sum()).collect()
    }

    /// Counts in each quadrat over all runs.
    fn per_quadrat(counts: &[Vec<f64>]) -> Vec<f64> {
        (0..counts[0].len()).map(|quadrat| counts.iter().map(|run| run[quadrat]).sum()).collect()
    }

    #[test]
    fn homogeneous_counts_are_poisson_in_every_quadrat() {
        let process = homogeneous(region(), 100.0).unwrap();
        let mut noise = Noise::new(1);
        let counts: Vec<_> = (0..5_000).map(|_| quadrat_counts(process.simulate(&mut noise), region(), 4)).collect();
        assert_moments(&totals(&counts), 100.0, 100.0);
        // The means are known and the counts independent, so there are as many degrees of freedom as quadrats.
        assert_chi_square(&per_quadrat(&counts), &[5_000.0 * 100.0 / 16.0; 16], 16.0);
        for quadrat in 0..16 {
            let column: Vec<f64> = counts.iter().map(|run| run[quadrat]).collect();
            assert_moments(&column, 6.25, 6.25);
        }
    }

    #[test]
    fn homogeneous_has_no_clusters() {
        let process = homogeneous(region(), 200.0).unwrap();
        let mut noise = Noise::new(2);
        let realisations: Vec<_> = (0..1_000).map(|_| process.simulate(&mut noise)).collect();
        for r in [2.0, 8.0, 30.0] {
            assert_k(&pair_densities(&realisations, region(), r, 200.0 / region().area()), PI * r * r);
        }
    }

    #[test]
    fn thinning_leaves_the_intensity_function() {
        // Falls linearly in x from 0.02 to 0; constant in y.
        let intensity = |[x, _]: Point| 0.02 * (100.0 - x) / 200.0;
        let process = Thinned::new(region(), intensity, 0.025).unwrap();
        let mut noise = Noise::new(3);
        let runs = 1_000.0;
        let counts: Vec<_> =
            (0..runs as usize).map(|_| quadrat_counts(process.simulate(&mut noise).unwrap(), region(), 8)).collect();
        let expected: Vec<f64> = (0..64).map(|cell| runs * 0.02 * 625.0 * (7.5 - f64::from(cell % 8)) / 8.0).collect();
        assert_chi_square(&per_quadrat(&counts), &expected, 64.0);
        assert_moments(&totals(&counts), 400.0, 400.0);
    }

    #[test]
    fn thinning_and_placing_give_the_same_process() {
        // A normal intensity: by thinning over a region that holds all of it, and by placing.
        let (mean, variance) = (100.0, 400.0);
        let peak = mean / (2.0 * PI * variance);
        let density = move |[x, y]: Point| peak * (-0.5 * (x * x + y * y) / variance).exp();
        let thinned = Thinned::new(region(), density, peak).unwrap();
        let placed = inhomogeneous(mean, Normal::new([0.0; 2], [[variance, 0.0], [0.0, variance]]).unwrap()).unwrap();
        let mut noise = Noise::new(4);
        let mut totals = [Vec::new(), Vec::new()];
        let mut cells = [vec![0.0; 64], vec![0.0; 64]];
        let centre = Rectangle::new([-40.0, 40.0], [-40.0, 40.0]).unwrap();
        for _ in 0..1_000 {
            for (which, points) in
                [thinned.simulate(&mut noise).unwrap(), placed.simulate(&mut noise)].iter().enumerate()
            {
                totals[which].push(points.len() as f64);
                let counts = quadrat_counts(points.iter().copied().filter(|&p| centre.contains(p)), centre, 8);
                cells[which].iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            }
        }
        totals.iter().for_each(|totals| assert_moments(totals, mean, mean));
        // Difference of two Poisson numbers of one mean: the variance is the sum, best known from both.
        let both: Vec<f64> = cells[0].iter().zip(&cells[1]).map(|(a, b)| a + b).collect();
        let shifted: Vec<f64> = cells[0].iter().zip(&cells[1]).map(|(a, b)| a + b + (a - b)).collect();
        assert_chi_square(&shifted, &both, 64.0);
    }

    #[test]
    fn an_intensity_beyond_its_bound_is_told() {
        let steep = Thinned::new(region(), |[x, _]| 0.01 * x, 0.02).unwrap();
        let error = steep.simulate(&mut Noise::new(5)).unwrap_err();
        assert!(matches!(error, ProcessError::Intensity { bound: 0.02, .. }), "{error}");
        let unknown = Thinned::new(region(), |_| f64::NAN, 0.02).unwrap();
        assert!(unknown.simulate(&mut Noise::new(6)).is_err());
        for bound in [-1.0, f64::NAN, 1e9] {
            assert!(matches!(Thinned::new(region(), |_| 0.0, bound), Err(ProcessError::Mean(_))));
        }
    }
}
