//! Rigid alignment of the filter's path with the rejected fixes.

use super::rule::LOOSE;
use crate::{PlanarPose, PoseEstimate, Real, Symmetric, wrap};

/// Greatest standard deviation with which the rotation is taken from the fixes, rad; above it the filter's heading is better.
const TOLD_RAD: f64 = 0.1;
/// A vehicle moves if the standard deviation of its positions is above this multiple of that of a fix.
const MOVES: f64 = 0.3;
/// Greatest ratio of the two paths' lengths. Wheel slip and scale errors change it by tenths only.
const SCALE: f64 = 2.0;

/// Sums over pairs of the antenna's predicted position, p, and the fix, q, both relative to the first pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RefusedWay<T> {
    first: [[T; 2]; 2],
    count: T,
    /// Σ p and Σ q.
    sums: [[T; 2]; 2],
    /// Σ p·p and Σ q·q.
    squares: [T; 2],
    /// Σ p·q and Σ p×q.
    products: [T; 2],
}

impl<T: Real> RefusedWay<T> {
    pub(super) const NONE: Self = {
        let zero = [[T::ZERO; 2]; 2];
        Self { first: zero, count: T::ZERO, sums: zero, squares: [T::ZERO; 2], products: [T::ZERO; 2] }
    };

    pub(super) fn add(&mut self, expected: [T; 2], measured: [T; 2]) {
        if self.count == T::ZERO {
            self.first = [expected, measured];
        }
        let [[px, py], [qx, qy]] = self.first;
        let (p, q) = ([expected[0] - px, expected[1] - py], [measured[0] - qx, measured[1] - qy]);
        self.count += T::ONE;
        let [sum_p, sum_q] = &mut self.sums;
        (sum_p[0], sum_p[1], sum_q[0], sum_q[1]) = (sum_p[0] + p[0], sum_p[1] + p[1], sum_q[0] + q[0], sum_q[1] + q[1]);
        let [of_p, of_q] = &mut self.squares;
        (*of_p, *of_q) = (*of_p + dot(p, p), *of_q + dot(q, q));
        let [along, across] = &mut self.products;
        (*along, *across) = (*along + dot(p, q), *across + cross(p, q));
    }

    /// Whether the filter predicts a motion, but one that is too short to determine the rotation with fixes of this noise, m.
    pub(super) fn tells_soon(&self, sigma_m: T) -> bool {
        let variance = sigma_m * sigma_m;
        let [p, _] = self.sums.map(|sum| sum.map(|sum| sum / self.count));
        let of_p = self.squares.first().map_or(T::ZERO, |&squares| squares - self.count * dot(p, p));
        let is_told = of_p * T::from_f64(TOLD_RAD * TOLD_RAD) > variance;
        !is_told && of_p > self.count * variance * T::from_f64(MOVES * MOVES)
    }

    /// The pose after the rotation and translation that align three or more pairs; `None` if the paths do not fit.
    ///
    /// The rotation by least squares is θ = atan2(Σ p×q, Σ p·q) over differences from the means (Horn 1987, in the plane), its
    /// variance σ²/Σ p·p. The residuals are those after a change of scale, because odometry has a scale error.
    pub(super) fn laid_over(
        &self,
        sigma_m: T,
        estimate: &PoseEstimate<PlanarPose<T>>,
    ) -> Option<PoseEstimate<PlanarPose<T>>> {
        let (n, two) = (self.count, T::from_f64(2.0));
        let [p, q] = self.sums.map(|sum| sum.map(|sum| sum / n));
        let [of_p, of_q] = self.squares;
        let (of_p, of_q) = ((of_p - n * dot(p, p)).at_least(T::ZERO), (of_q - n * dot(q, q)).at_least(T::ZERO));
        let [along, across] = self.products;
        let (along, across) = (along - n * dot(p, q), across - n * cross(p, q));
        let variance = sigma_m * sigma_m;
        let is_told = of_p * T::from_f64(TOLD_RAD * TOLD_RAD) > variance;
        let (turn, unexplained) = if is_told {
            let common = (along * along + across * across).sqrt();
            let scale = common / of_p;
            if !(scale * T::from_f64(SCALE) > T::ONE && scale < T::from_f64(SCALE)) {
                return None;
            }
            (across.atan2(along), (of_q - common * scale).at_least(T::ZERO) / (two * n - two - two))
        } else {
            (T::ZERO, (of_p + of_q - two * along).at_least(T::ZERO) / (two * n - two))
        };
        // The comparison is written so that NaN does not fit.
        if !(unexplained <= variance * T::from_f64(LOOSE * LOOSE)) {
            return None;
        }
        let variance = variance.at_least(unexplained);
        let turn_variance = if is_told { variance / of_p } else { estimate.covariance.get(2, 2) };
        let [[first_px, first_py], [first_qx, first_qy]] = self.first;
        let PlanarPose { x_m, y_m, heading_rad } = estimate.mean;
        let arm = [x_m - first_px - p[0], y_m - first_py - p[1]];
        let (s, c) = turn.sin_cos();
        let arm = [c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]];
        let mean = PlanarPose::new(first_qx + q[0] + arm[0], first_qy + q[1] + arm[1], wrap(heading_rad + turn));
        // A rotation moves the pose around the centre of the fixes.
        let by_turn = [-arm[1], arm[0], T::ONE];
        let own = [variance, variance, T::ZERO];
        let covariance = Symmetric::from_fn(|row, column| {
            let at = |of: &[T; 3], k: usize| of.get(k).copied().unwrap_or(T::ZERO);
            let shared = turn_variance * at(&by_turn, row) * at(&by_turn, column);
            if row == column { shared + at(&own, row) } else { shared }
        });
        Some(PoseEstimate { mean, covariance })
    }
}

fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

fn cross<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::RefusedWay;
    use crate::{PlanarPose, PoseEstimate, Symmetric};

    /// Three pairs on a line, the middle one displaced by `e` across it: least squares leaves 2 e²/3, with two degrees of freedom
    /// after rotation, translation and scale.
    #[test]
    fn the_covariance_is_that_of_the_residuals() {
        let (sigma_m, e) = (0.1, 0.3);
        let mut way = RefusedWay::<f64>::NONE;
        for (x, y) in [(0.0, 0.0), (10.0, e), (20.0, 0.0)] {
            way.add([x, 0.0], [x, y]);
        }
        let estimate =
            PoseEstimate { mean: PlanarPose::new(10.0, 0.0, 0.2), covariance: Symmetric::from_diagonal([1.0; 3]) };
        let PoseEstimate { mean, covariance } = way.laid_over(sigma_m, &estimate).unwrap();
        assert!(
            (mean.x_m - 10.0).abs() + (mean.y_m - e / 3.0).abs() + (mean.heading_rad - 0.2).abs() < 1e-12,
            "{mean:?}"
        );
        let variance = e * e / 3.0;
        for (k, expected) in [variance, variance, variance / 200.0].into_iter().enumerate() {
            assert!((covariance.get(k, k) / expected - 1.0).abs() < 1e-9, "{covariance:?}");
        }
    }
}
