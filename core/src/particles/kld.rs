//! How many particles are needed where they are: the Kullback–Leibler bound (Fox 2003).

use crate::{Adaptive, Candidate, Noise, Pose, Real};

impl<T: Real> Adaptive<T> {
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
    use crate::{Adaptive, Candidate, PlanarPose};
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
