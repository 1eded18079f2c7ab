//! Regularised resampling: copies of a particle are set apart by a kernel.
//!
//! Resampling draws from a sum of points. Drawing from the density that those points stand for, smoothed by a kernel as wide
//! as their number allows (Musso, Oudjane & Le Gland 2001), makes different particles of the copies of one.

use crate::numerics::range::is_within_range;
use crate::numerics::vector::applied;
use crate::particles::candidate::{Candidate, moments};
use crate::{Linear, Noise, Pose, Real, TangentOf, Vector};

/// The kernel: Gaussian, shaped like the candidates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kernel<P: Pose> {
    /// A factor of its covariance.
    root: Linear<TangentOf<P>, TangentOf<P>>,
}

impl<T: Real, P: Pose<Scalar = T>> Kernel<P> {
    /// `share` times as wide as is best for `particles` samples of a Gaussian with the covariance of these candidates.
    pub(crate) fn of(candidates: &[Candidate<P>], particles: usize, share: T) -> Self {
        let (_, covariance) = moments(candidates, T::ONE);
        Self { root: covariance.root() * (share * bandwidth(TangentOf::<P>::DIMENSION, particles)) }
    }

    /// Moves every particle by a sample of its own, of K normal numbers. A pose that would leave the range of the scalar stays.
    pub(crate) fn spread(&self, particles: &mut [Candidate<P>], noise: &mut Noise) {
        for particle in particles {
            let drawn = TangentOf::<P>::with(|_| noise.normal());
            let moved = particle.pose.displaced(&applied::<TangentOf<P>, TangentOf<P>>(&self.root, &drawn));
            if is_within_range(&moved.coordinates()) {
                particle.pose = moved;
            }
        }
    }
}

/// Standard deviation of the kernel in those of the samples: (4/((K + 2) N))^(1/(K + 4)) (Silverman 1986, 4.14).
fn bandwidth<T: Real>(dimension: usize, samples: usize) -> T {
    let [dimension, samples] = [dimension, samples].map(T::from_usize);
    let base = T::from_f64(4.0) / ((dimension + T::from_f64(2.0)) * samples);
    (base.ln() / (dimension + T::from_f64(4.0))).exp()
}

#[cfg(test)]
mod tests {
    use super::{Kernel, bandwidth};
    use crate::particles::candidate::{Candidate, moments};
    use crate::{Noise, PlanarPose, Pose, Symmetric};
    use std::vec::Vec;

    /// Weighted poses about a heading next to the cut of the circle, x and heading correlated.
    fn candidates(count: usize) -> Vec<Candidate<PlanarPose<f64>>> {
        let mut noise = Noise::seeded(3);
        let pose = |noise: &mut Noise| {
            let [a, b, c]: [f64; 3] = core::array::from_fn(|_| noise.normal());
            PlanarPose::new(10.0, -4.0, 3.1).displaced(&[0.3 * a, 0.1 * b, 0.1 * a + 0.02 * c].into())
        };
        let ln_weight = -(count as f64).ln();
        (0..count).map(|_| Candidate { pose: pose(&mut noise), ln_weight }).collect()
    }

    #[test]
    fn silvermans_factor() {
        // In one dimension the well-known 1.06 n^(-1/5).
        assert!((bandwidth::<f64>(1, 100) - 1.0592 * 100_f64.powf(-0.2)).abs() < 1e-4);
        // In two it is n^(-1/6).
        assert!((bandwidth::<f64>(2, 64) - 0.5).abs() < 1e-12);
        let f32 = bandwidth::<f32>(3, 32);
        assert!((f64::from(f32) - (4.0_f64 / 160.0).powf(1.0 / 7.0)).abs() < 1e-6);
    }

    /// Mean of x, covariance of x and a kernel H independent of it: that of the sum.
    #[test]
    fn moments_are_those_of_samples_and_kernel() {
        let before = candidates(40_000);
        let (mean, covariance) = moments(&before, 1.0);
        for share in [0.5, 1.0] {
            // A kernel as for ten particles, so that it is wide enough to tell.
            let mut after = before.clone();
            Kernel::of(&before, 10, share).spread(&mut after, &mut Noise::seeded(8));
            let (moved_mean, moved) = moments(&after, 1.0);
            let h = share * bandwidth::<f64>(3, 10);
            let expected = covariance.scaled(1.0 + h * h);
            let shift = moved_mean.difference(&mean);
            for row in 0..3 {
                // Five standard errors, of a mean and of a variance.
                assert!(shift[row].abs() < 5.0 * h * (covariance.get(row, row) / 4e4).sqrt(), "{share} {row}");
                for column in 0..=row {
                    let scale = (expected.get(row, row) * expected.get(column, column)).sqrt();
                    let error = moved.get(row, column) - expected.get(row, column);
                    assert!(error.abs() < 5.0 * scale * (2.0_f64 / 4e4).sqrt(), "{share} {row} {column}");
                }
            }
        }
    }

    #[test]
    fn particles_all_in_one_place_stay_there() {
        let one = [Candidate { pose: PlanarPose::new(1.0_f32, 2.0, 3.0), ln_weight: -(4.0_f32.ln()) }; 4];
        let mut after = one;
        Kernel::of(&one, 4, 1.0).spread(&mut after, &mut Noise::seeded(1));
        let (_, covariance) = moments(&after, 1.0);
        assert!(covariance.get(0, 0) < 1e-10 && covariance != Symmetric::from_diagonal([1.0; 3]));
        assert!((after[0].pose.x_m - 1.0).abs() < 1e-5 && (after[3].pose.heading_rad - 3.0).abs() < 1e-5);
    }
}
