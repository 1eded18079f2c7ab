//! How many particles a resampling leaves: as many as the places they are at need (KLD sampling, Fox 2003).

use crate::candidate::Candidate;
use crate::{ConfigError, Noise, Pose, Real};

/// As many particles as keep the Kullback–Leibler divergence between them and the density that they sample, both taken over
/// cells of the ground plane and of the heading, below `error` with probability 1 − `risk`; at most
/// [`Config::particles`](crate::Config::particles).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Adaptive<T> {
    /// ε.
    pub error: T,
    /// δ.
    pub risk: T,
    /// Never fewer. Of few particles N_eff hardly falls below a high threshold, and only a resampling makes more of them.
    pub least: usize,
    /// Side of a cell in x and y, m.
    pub cell_m: T,
    /// Side of a cell in heading, rad.
    pub cell_rad: T,
}

impl<T: Real> Default for Adaptive<T> {
    /// Fox's figures: 5 %, 1 %; cells of half a metre and ten degrees.
    fn default() -> Self {
        Self {
            error: T::from_f64(0.05),
            risk: T::from_f64(0.01),
            least: 8,
            cell_m: T::from_f64(0.5),
            cell_rad: T::from_f64(0.175),
        }
    }
}

impl<T: Real> Adaptive<T> {
    /// The first field that is out of range, if any.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let require = |holds, field, range| if holds { Ok(()) } else { Err(ConfigError { field, range }) };
        let positive = |x: T| x > T::ZERO && x.is_finite();
        require(positive(self.error), "adaptive.error", "finite and positive")?;
        require(self.risk > T::ZERO && self.risk < T::ONE, "adaptive.risk", "above 0 and below 1")?;
        require(self.least >= 1, "adaptive.least", "at least 1")?;
        require(positive(self.cell_m), "adaptive.cell_m", "finite and positive")?;
        require(positive(self.cell_rad), "adaptive.cell_rad", "finite and positive")
    }

    /// How many of `most` particles are needed where the drawn ones are; `held` is scratch of as many places.
    pub(crate) fn needed<P: Pose<Scalar = T>>(
        &self,
        drawn: impl Iterator<Item = Candidate<P>>,
        most: usize,
        held: &mut [Candidate<P>],
    ) -> usize {
        let mut occupied = 0;
        for candidate in drawn {
            let cell = self.cell(&candidate.pose);
            let known = held.iter().take(occupied).rev().any(|other| self.cell(&other.pose) == cell);
            if !known && let Some(slot) = held.get_mut(occupied) {
                *slot = candidate;
                occupied += 1;
            }
        }
        // What overflows is more than there is anyway.
        let bound = usize::try_from(self.bound(occupied).to_i32()).unwrap_or(usize::MAX);
        bound.max(self.least).min(most)
    }

    fn cell<P: Pose<Scalar = T>>(&self, pose: &P) -> [i32; 3] {
        let [x_m, y_m, heading_rad] = pose.on_ground();
        [x_m / self.cell_m, y_m / self.cell_m, heading_rad / self.cell_rad].map(|place| place.floor().to_i32())
    }

    /// Samples that k occupied cells need: χ²_{k−1, 1−δ}/(2ε) by Wilson and Hilferty's approximation, rounded up.
    fn bound(&self, occupied: usize) -> T {
        if occupied < 2 {
            return T::ZERO;
        }
        let freedoms = T::from_usize(occupied - 1);
        let spread = T::from_f64(2.0 / 9.0) / freedoms;
        let root = T::ONE - spread + spread.sqrt() * Noise::quantile(T::ONE - self.risk);
        -(-(freedoms / (self.error + self.error) * root * root * root)).floor()
    }
}

#[cfg(test)]
mod tests {
    use super::Adaptive;
    use crate::{Candidate, PlanarPose};
    use std::vec::Vec;

    fn at(error: f64, risk: f64) -> Adaptive<f64> {
        Adaptive { error, risk, ..Adaptive::default() }
    }

    /// χ² quantiles from tables.
    #[test]
    fn the_bound_is_that_of_chi_squared() {
        for (k, risk, chi_squared) in [(2, 0.01, 6.635), (11, 0.01, 23.209), (31, 0.05, 43.773), (101, 0.5, 99.334)] {
            let bound = at(0.05, risk).bound(k);
            let expected = chi_squared / 0.1;
            assert!((bound / expected - 1.0).abs() < 0.025, "{k}: {bound} against {expected}");
        }
        // k = 3 has the closed form −2 ln δ.
        let expected = -(0.05_f64.ln()) / 0.02;
        assert!((at(0.02, 0.05).bound(3) / expected - 1.0).abs() < 0.01);
        assert_eq!(at(0.05, 0.01).bound(1), 0.0);
    }

    #[test]
    fn cells_are_counted_once_and_bounds_are_kept() {
        let pose = |x: f64, heading: f64| Candidate { pose: PlanarPose::new(x, 0.1, heading), ln_weight: 0.0 };
        let mut held = [pose(0.0, 0.0); 64];
        let adaptive = at(0.1, 0.1);
        let mut needed =
            |poses: &[Candidate<PlanarPose<f64>>], most| adaptive.needed(poses.iter().copied(), most, &mut held);
        // Everything in one cell, in two, and the same place with two headings.
        assert_eq!(needed(&[pose(0.1, 0.1), pose(0.2, 0.1), pose(0.4, 0.12)], 64), 8);
        let two = adaptive.bound(2) as usize;
        assert!(two > 8);
        assert_eq!(needed(&[pose(0.1, 0.1), pose(0.6, 0.1), pose(0.2, 0.1), pose(0.7, 0.1)], 64), two);
        assert_eq!(needed(&[pose(0.1, 0.1), pose(0.1, -0.1)], 64), two);
        let everywhere: Vec<_> = (0..60).map(|cell| pose(f64::from(cell), 0.0)).collect();
        assert_eq!(needed(&everywhere, 64), 64);
        assert_eq!(needed(&everywhere, 3), 3);
    }
}
