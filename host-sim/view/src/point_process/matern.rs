//! The Matérn cluster process.

use super::cardinality::Poisson;
use super::cluster::{Border, Cluster, checked_size, clusters};
use super::iid::IidProcess;
use super::region::Rectangle;
use super::spatial::Disc;
use super::{Point, ProcessError};
use scphd_log::noise::Noise;

/// The Matérn cluster process: a Poisson process of centres, uniform; around each a Poisson process of points, uniform
/// in a disc.
///
/// The total of [`Border::Kept`] has the mean λ₁λ₂ and the variance λ₁λ₂(1 + λ₂).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matern {
    region: Rectangle,
    centres: IidProcess<Poisson, Rectangle>,
    radius: f64,
    daughters: Poisson,
    border: Border,
}

impl Matern {
    /// The process with `centres` (λ₁) in `region` and `daughters` (λ₂) points within `radius` m of each.
    ///
    /// # Errors
    ///
    /// [`ProcessError::Size`] where the radius is not finite or negative; for [`Border::Stationary`],
    /// [`ProcessError::Region`] or [`ProcessError::Mean`] where the region that clusters reach from is too large.
    pub fn new(
        region: Rectangle,
        centres: Poisson,
        radius: f64,
        daughters: Poisson,
        border: Border,
    ) -> Result<Self, ProcessError> {
        let radius = checked_size(radius)?;
        let (cardinality, spatial) = border.parents(region, centres, radius)?;
        Ok(Self { region, centres: IidProcess { cardinality, spatial }, radius, daughters, border })
    }

    /// One realisation: the centres, each with its points.
    pub fn simulate(&self, noise: &mut Noise) -> Vec<Cluster<Point>> {
        let centres = self.centres.simulate(noise);
        clusters(centres, |&centre| {
            let disc = Disc { centre, radius: self.radius };
            self.border.cut(self.region, IidProcess { cardinality: self.daughters, spatial: disc }.simulate(noise))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::cluster::points;
    use super::super::spatial::along;
    use super::super::statistics::{
        assert_k, assert_mean_of, assert_means, assert_moments, beyond_k, expected_in_quadrats, pair_densities,
        quadrat_counts,
    };
    use super::*;
    use std::f64::consts::PI;

    const SIDES: [f64; 2] = [200.0, 120.0];
    const RADIUS: f64 = 20.0;
    const CENTRES: f64 = 5.0;
    const DAUGHTERS: f64 = 20.0;

    fn region() -> Rectangle {
        Rectangle::new([-100.0, 100.0], [-50.0, 70.0]).unwrap()
    }

    fn realisations(border: Border, seed: u64, runs: usize) -> Vec<Vec<Cluster<Point>>> {
        let mean = |mean| Poisson::new(mean).unwrap();
        let process = Matern::new(region(), mean(CENTRES), RADIUS, mean(DAUGHTERS), border).unwrap();
        let mut noise = Noise::new(seed);
        (0..runs).map(|_| process.simulate(&mut noise)).collect()
    }

    fn totals(realisations: &[Vec<Cluster<Point>>]) -> Vec<f64> {
        realisations.iter().map(|clusters| points(clusters).count() as f64).collect()
    }

    #[test]
    fn kept_counts_are_those_of_a_compound_poisson_number() {
        let kept = realisations(Border::Kept, 1, 20_000);
        assert_moments(&totals(&kept), CENTRES * DAUGHTERS, CENTRES * DAUGHTERS * (1.0 + DAUGHTERS));
        for Cluster { parent, daughters } in kept.iter().flatten() {
            assert!(daughters.iter().all(|d| (d[0] - parent[0]).hypot(d[1] - parent[1]) <= RADIUS * (1.0 + 1e-12)));
        }
    }

    #[test]
    fn clipping_loses_the_share_beyond_the_border() {
        // E[(1 − |x|/W)(1 − |y|/H)] for (x, y) uniform in the disc.
        let [w, h] = SIDES;
        let share = 1.0 - 4.0 * RADIUS / (3.0 * PI) * (1.0 / w + 1.0 / h) + RADIUS.powi(2) / (2.0 * PI * w * h);
        let clipped = realisations(Border::Clipped, 2, 20_000);
        assert!(clipped.iter().all(|clusters| points(clusters).all(|point| region().contains(point))));
        assert_mean_of(&totals(&clipped), CENTRES * DAUGHTERS * share);
    }

    #[test]
    fn stationary_counts_have_the_variance_of_the_endless_process() {
        // κλ₂A + κλ₂² ∫φ², where φ is the share of a disc in the region and ∫φ² = E[(W − |Δx|)(H − |Δy|)] for the
        // difference Δ of two points of the disc: E|Δ| = 128R/45π, E|Δ|² = R², every direction alike.
        let [w, h] = SIDES;
        let squared = w * h - (w + h) * 128.0 * RADIUS / (45.0 * PI) * 2.0 / PI + RADIUS.powi(2) / PI;
        let mean = CENTRES * DAUGHTERS;
        let variance = mean + CENTRES * DAUGHTERS.powi(2) * squared / (w * h);
        assert_moments(&totals(&realisations(Border::Stationary, 3, 20_000)), mean, variance);
    }

    #[test]
    fn intensity_up_to_and_beyond_the_border() {
        let view = region().grown(RADIUS).unwrap();
        let intensity = CENTRES * DAUGHTERS / region().area();
        let mut displacements = Vec::new();
        for angle in 0..40 {
            for step in 0..40 {
                let distance = RADIUS * ((f64::from(step) + 0.5) / 40.0).sqrt();
                displacements.push(along([0.0; 2], distance, 2.0 * PI * (f64::from(angle) + 0.5) / 40.0));
            }
        }
        for (border, parents, seen) in [
            (Border::Kept, region(), view),
            (Border::Clipped, region(), region()),
            (Border::Stationary, view, region()),
        ] {
            let counts: Vec<Vec<f64>> = realisations(border, 4, 6_000)
                .iter()
                .map(|clusters| quadrat_counts(points(clusters), seen, 6))
                .collect();
            assert_means(&counts, &expected_in_quadrats(seen, 6, parents, &displacements, intensity));
        }
    }

    #[test]
    fn sides_have_half_and_corners_a_quarter_of_the_intensity() {
        let runs = 40_000;
        let kept = realisations(Border::Kept, 5, runs);
        let inside = CENTRES * DAUGHTERS / region().area();
        // Squares of 4 m about a place; the intensity is odd about its value there, as far as it is a line.
        for (at, share) in [([0.0, 10.0], 1.0), ([-100.0, 10.0], 0.5), ([0.0, 70.0], 0.5), ([100.0, 70.0], 0.25)] {
            let square = Rectangle::new([at[0] - 2.0, at[0] + 2.0], [at[1] - 2.0, at[1] + 2.0]).unwrap();
            let counts: Vec<f64> = kept
                .iter()
                .map(|clusters| points(clusters).filter(|&point| square.contains(point)).count() as f64)
                .collect();
            assert_mean_of(&counts, share * inside * square.area());
        }
    }

    #[test]
    fn pairs_are_as_frequent_as_clusters_make_them() {
        let kappa = CENTRES / region().area();
        let realisations = realisations(Border::Stationary, 6, 3_000);
        let observed: Vec<Vec<Point>> = realisations.iter().map(|clusters| points(clusters).collect()).collect();
        for r in [5.0, 12.0, 20.0, 45.0] {
            let densities = pair_densities(&observed, region(), r, kappa * DAUGHTERS);
            assert_k(&densities, PI * r * r + within(r) / kappa);
            assert!(beyond_k(&densities, PI * r * r) > 8.0, "no clusters within {r} m");
        }
        // Known from geometry: two points of a disc are nearer than its radius with this probability.
        assert!((within(RADIUS) - (1.0 - 3.0 * 3.0_f64.sqrt() / (4.0 * PI))).abs() < 1e-12);
    }

    /// Probability that two points of a cluster are nearer than `r` m.
    fn within(r: f64) -> f64 {
        let z = (r / (2.0 * RADIUS)).min(1.0);
        let root = (1.0 - z * z).sqrt();
        2.0 + ((8.0 * z * z - 4.0) * z.acos() - 2.0 * z.asin() + 4.0 * z * root.powi(3) - 6.0 * z * root) / PI
    }

    #[test]
    fn only_radii() {
        let one = Poisson::new(1.0).unwrap();
        for radius in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Matern::new(region(), one, radius, one, Border::Kept), Err(ProcessError::Size(_))));
        }
        let error = Matern::new(region(), one, -1.0, one, Border::Kept).unwrap_err();
        assert_eq!(error.to_string(), "a cluster cannot have a size of -1 m");
    }
}
