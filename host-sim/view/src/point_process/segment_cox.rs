//! The segment Cox process.

use super::cardinality::Poisson;
use super::cluster::{Border, Cluster, checked_size, clusters};
use super::iid::IidProcess;
use super::region::Rectangle;
use super::spatial::{Segment, Spatial};
use super::{Point, ProcessError};
use scphd_log::noise::Noise;
use std::f64::consts::PI;

/// The segment Cox process: a Poisson process of line segments of one length, uniform in midpoint and orientation;
/// along each a Poisson process of points.
///
/// The total of [`Border::Kept`] has the mean λ₁λ₂ and the variance λ₁λ₂(1 + λ₂).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentCox {
    region: Rectangle,
    segments: IidProcess<Poisson, UniformSegments>,
    daughters: Poisson,
    border: Border,
}

/// Segments uniform in midpoint and orientation.
#[derive(Debug, Clone, Copy, PartialEq)]
struct UniformSegments {
    centres: Rectangle,
    length: f64,
}

impl Spatial for UniformSegments {
    type Place = Segment;

    fn draw(&self, noise: &mut Noise) -> Segment {
        let centre = self.centres.draw(noise);
        Segment { centre, orientation_rad: PI * noise.uniform(), length: self.length }
    }
}

impl SegmentCox {
    /// The process with `segments` (λ₁) midpoints in `region`, segments of `length` m and `daughters` (λ₂) points on
    /// each.
    ///
    /// # Errors
    ///
    /// [`ProcessError::Size`] where the length is not finite or negative; for [`Border::Stationary`],
    /// [`ProcessError::Region`] or [`ProcessError::Mean`] where the region that segments reach from is too large.
    pub fn new(
        region: Rectangle,
        segments: Poisson,
        length: f64,
        daughters: Poisson,
        border: Border,
    ) -> Result<Self, ProcessError> {
        let length = checked_size(length)?;
        let (cardinality, centres) = border.parents(region, segments, 0.5 * length)?;
        let segments = IidProcess { cardinality, spatial: UniformSegments { centres, length } };
        Ok(Self { region, segments, daughters, border })
    }

    /// One realisation: the segments, each with its points.
    pub fn simulate(&self, noise: &mut Noise) -> Vec<Cluster<Segment>> {
        let segments = self.segments.simulate(noise);
        clusters(segments, |&segment| {
            let points: Vec<Point> = IidProcess { cardinality: self.daughters, spatial: segment }.simulate(noise);
            self.border.cut(self.region, points)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::cluster::points;
    use super::super::spatial::along;
    use super::super::statistics::{
        assert_chi_square, assert_k, assert_mean_of, assert_means, assert_moments, beyond_k, expected_in_quadrats,
        pair_densities, quadrat_counts,
    };
    use super::*;

    const SIDES: [f64; 2] = [200.0, 120.0];
    const LENGTH: f64 = 40.0;
    const SEGMENTS: f64 = 6.0;
    const DAUGHTERS: f64 = 10.0;

    fn region() -> Rectangle {
        Rectangle::new([-100.0, 100.0], [-50.0, 70.0]).unwrap()
    }

    fn realisations(border: Border, seed: u64, runs: usize) -> Vec<Vec<Cluster<Segment>>> {
        let mean = |mean| Poisson::new(mean).unwrap();
        let process = SegmentCox::new(region(), mean(SEGMENTS), LENGTH, mean(DAUGHTERS), border).unwrap();
        let mut noise = Noise::new(seed);
        (0..runs).map(|_| process.simulate(&mut noise)).collect()
    }

    fn totals(realisations: &[Vec<Cluster<Segment>>]) -> Vec<f64> {
        realisations.iter().map(|clusters| points(clusters).count() as f64).collect()
    }

    #[test]
    fn kept_counts_are_those_of_a_compound_poisson_number() {
        let totals = totals(&realisations(Border::Kept, 1, 20_000));
        assert_moments(&totals, SEGMENTS * DAUGHTERS, SEGMENTS * DAUGHTERS * (1.0 + DAUGHTERS));
    }

    #[test]
    fn clipping_loses_the_share_beyond_the_border() {
        // E[(1 − |s cos θ|/W)(1 − |s sin θ|/H)] for s uniform in ±L/2 and θ uniform in [0, π).
        let [w, h] = SIDES;
        let share = 1.0 - LENGTH / (2.0 * PI) * (1.0 / w + 1.0 / h) + LENGTH.powi(2) / (12.0 * PI * w * h);
        let clipped = realisations(Border::Clipped, 2, 20_000);
        assert!(clipped.iter().all(|clusters| points(clusters).all(|point| region().contains(point))));
        assert_mean_of(&totals(&clipped), SEGMENTS * DAUGHTERS * share);
    }

    #[test]
    fn stationary_counts_have_the_variance_of_the_endless_process() {
        // κλ₂A + κλ₂² ∫φ², where φ is the share of a segment in the region and
        // ∫φ² = E[(W − |Δ cos θ|)(H − |Δ sin θ|)], Δ the difference of two points of the segment.
        let [w, h] = SIDES;
        let squared = w * h - (w + h) * LENGTH / 3.0 * 2.0 / PI + LENGTH.powi(2) / (6.0 * PI);
        let mean = SEGMENTS * DAUGHTERS;
        let variance = mean + SEGMENTS * DAUGHTERS.powi(2) * squared / (w * h);
        assert_moments(&totals(&realisations(Border::Stationary, 3, 20_000)), mean, variance);
    }

    #[test]
    fn intensity_up_to_and_beyond_the_border() {
        let view = region().grown(0.5 * LENGTH).unwrap();
        let intensity = SEGMENTS * DAUGHTERS / region().area();
        let mut displacements = Vec::new();
        for angle in 0..40 {
            for step in 0..40 {
                let distance = LENGTH * ((f64::from(step) + 0.5) / 40.0 - 0.5);
                displacements.push(along([0.0; 2], distance, PI * (f64::from(angle) + 0.5) / 40.0));
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
            let expected = expected_in_quadrats(seen, 6, parents, &displacements, intensity);
            if border == Border::Stationary {
                let even = SEGMENTS * DAUGHTERS / 36.0;
                assert!(expected.iter().all(|e| (e - even).abs() < 1e-9 * even));
            }
            assert_means(&counts, &expected);
        }
    }

    #[test]
    fn pairs_are_as_frequent_as_segments_make_them() {
        let kappa = SEGMENTS / region().area();
        let realisations = realisations(Border::Stationary, 5, 3_000);
        let observed: Vec<Vec<Point>> = realisations.iter().map(|clusters| points(clusters).collect()).collect();
        for r in [5.0, 15.0, 30.0, 50.0] {
            let share = if r < LENGTH { r / LENGTH * (2.0 - r / LENGTH) } else { 1.0 };
            let densities = pair_densities(&observed, region(), r, kappa * DAUGHTERS);
            assert_k(&densities, PI * r * r + share / kappa);
            assert!(beyond_k(&densities, PI * r * r) > 8.0, "no clusters within {r} m");
        }
    }

    #[test]
    fn orientation_is_uniform_and_independent_of_place_and_number() {
        let clusters: Vec<Cluster<Segment>> = realisations(Border::Kept, 6, 8_000).concat();
        let [w, h] = SIDES;
        let mut cells = vec![0.0; 4 * 4 * 6 * 2];
        for Cluster { parent, daughters } in &clusters {
            let column = (4.0 * (parent.centre[0] + 100.0) / w) as usize;
            let row = (4.0 * (parent.centre[1] + 50.0) / h) as usize;
            let direction = (6.0 * parent.orientation_rad / PI) as usize;
            let many = usize::from(daughters.len() > 10);
            cells[((column * 4 + row) * 6 + direction) * 2 + many] += 1.0;
        }
        let mut at_most_ten = 0.0;
        let mut term = (-DAUGHTERS).exp();
        for n in 0..=10 {
            at_most_ten += term;
            term *= DAUGHTERS / f64::from(n + 1);
        }
        let expected: Vec<f64> = (0..cells.len())
            .map(|cell| 8_000.0 * SEGMENTS / 96.0 * if cell % 2 == 0 { at_most_ten } else { 1.0 - at_most_ten })
            .collect();
        // The number of segments is Poisson, so every cell is, independently of the others.
        assert_chi_square(&cells, &expected, cells.len() as f64);
    }

    #[test]
    fn only_lengths() {
        let one = Poisson::new(1.0).unwrap();
        for length in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(SegmentCox::new(region(), one, length, one, Border::Kept), Err(ProcessError::Size(_))));
        }
        assert!(SegmentCox::new(region(), one, 1e300, one, Border::Stationary).is_err());
        assert!(SegmentCox::new(region(), one, 1e6, one, Border::Stationary).is_err());
    }
}
