//! Distributions of one point of a process, f(y).

use super::{Point, ProcessError};
use scphd_log::noise::Noise;
use std::f64::consts::PI;

/// A distribution of one point or one parent.
///
/// Any `Fn(&mut Noise) -> T` is one. [`Rectangle`](super::Rectangle) is the uniform one over itself.
pub trait Spatial {
    /// What is drawn.
    type Place;

    /// Draws y ∼ f(y).
    fn draw(&self, noise: &mut Noise) -> Self::Place;
}

impl<T, F: Fn(&mut Noise) -> T> Spatial for F {
    type Place = T;

    fn draw(&self, noise: &mut Noise) -> T {
        self(noise)
    }
}

/// A normal distribution in the plane. It has no border: a draw may leave any region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    mean: Point,
    /// Cholesky factor of the covariance: xx, yx, yy.
    factor: [f64; 3],
}

impl Normal {
    /// With a mean (m) and a covariance (m²).
    ///
    /// # Errors
    ///
    /// [`ProcessError::Position`] where the mean is not finite, [`ProcessError::Covariance`] where the covariance is
    /// not symmetric and positive definite.
    pub fn new(mean: Point, covariance: [[f64; 2]; 2]) -> Result<Self, ProcessError> {
        let [[xx, xy], [yx, yy]] = covariance;
        let left = xx.sqrt();
        let cross = yx / left;
        let rest = yy - cross * cross;
        if !(xx > 0.0 && rest > 0.0 && xy == yx && (xx + yy).is_finite()) {
            return Err(ProcessError::Covariance(covariance));
        }
        finite(mean)?;
        Ok(Self { mean, factor: [left, cross, rest.sqrt()] })
    }
}

impl Spatial for Normal {
    type Place = Point;

    fn draw(&self, noise: &mut Noise) -> Point {
        let [a, b] = [noise.normal(), noise.normal()];
        let [xx, yx, yy] = self.factor;
        [self.mean[0] + xx * a, self.mean[1] + yx * a + yy * b]
    }
}

/// Uniform in a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Its centre.
    pub centre: Point,
    /// Its radius, m.
    pub radius: f64,
}

impl Spatial for Disc {
    type Place = Point;

    fn draw(&self, noise: &mut Noise) -> Point {
        // The area within r grows with r².
        let distance = self.radius * noise.uniform().sqrt();
        along(self.centre, distance, 2.0 * PI * noise.uniform())
    }
}

/// A line segment; as a distribution, uniform along its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Its midpoint.
    pub centre: Point,
    /// Its orientation from the x axis, in [0, π) rad.
    pub orientation_rad: f64,
    /// Its length, m.
    pub length: f64,
}

impl Segment {
    /// Both ends.
    #[must_use]
    pub fn ends(&self) -> [Point; 2] {
        [-0.5, 0.5].map(|share| along(self.centre, share * self.length, self.orientation_rad))
    }
}

impl Spatial for Segment {
    type Place = Point;

    fn draw(&self, noise: &mut Noise) -> Point {
        along(self.centre, self.length * (noise.uniform() - 0.5), self.orientation_rad)
    }
}

/// The point at `distance` (m) from `from` in the direction `angle_rad`.
pub(super) fn along(from: Point, distance: f64, angle_rad: f64) -> Point {
    [from[0] + distance * libm::cos(angle_rad), from[1] + distance * libm::sin(angle_rad)]
}

/// `point`, if it is a position.
fn finite(point: Point) -> Result<Point, ProcessError> {
    if point.iter().all(|v| v.is_finite()) { Ok(point) } else { Err(ProcessError::Position(point)) }
}

#[cfg(test)]
mod tests {
    use super::super::statistics::{assert_chi_square, assert_moments};
    use super::*;

    const DRAWS: usize = 40_000;

    fn draws<S: Spatial>(spatial: &S, seed: u64) -> Vec<S::Place> {
        let mut noise = Noise::new(seed);
        (0..DRAWS).map(|_| spatial.draw(&mut noise)).collect()
    }

    /// Whether values in (0, 1) are uniform there.
    fn assert_uniform(values: impl Iterator<Item = f64>) {
        let mut counts = [0.0; 20];
        values.for_each(|value| counts[(20.0 * value) as usize] += 1.0);
        assert_chi_square(&counts, &[DRAWS as f64 / 20.0; 20], 19.0);
    }

    #[test]
    fn normal_has_its_mean_covariance_and_form() {
        let points = draws(&Normal::new([20.0, -5.0], [[160.0, 100.0], [100.0, 360.0]]).unwrap(), 1);
        let column = |f: fn(&Point) -> f64| points.iter().map(f).collect::<Vec<f64>>();
        assert_moments(&column(|p| p[0]), 20.0, 160.0);
        assert_moments(&column(|p| p[1]), -5.0, 360.0);
        assert_moments(&column(|p| p[0] + p[1]), 15.0, 160.0 + 360.0 + 200.0);
        // The squared Mahalanobis distance of a normal in the plane is exponential of mean 2.
        let determinant = 160.0 * 360.0 - 100.0 * 100.0;
        assert_uniform(points.iter().map(|p| {
            let [x, y] = [p[0] - 20.0, p[1] + 5.0];
            (-0.5 * (360.0 * x * x - 200.0 * x * y + 160.0 * y * y) / determinant).exp()
        }));
    }

    #[test]
    fn disc_is_uniform_in_radius_squared_and_angle() {
        let points = draws(&Disc { centre: [3.0, 4.0], radius: 2.0 }, 2);
        let offsets = || points.iter().map(|p| [p[0] - 3.0, p[1] - 4.0]);
        assert_uniform(offsets().map(|[x, y]| (x * x + y * y) / 4.0));
        assert_uniform(offsets().map(|[x, y]| y.atan2(x) / (2.0 * PI) + 0.5));
    }

    #[test]
    fn segment_is_uniform_between_its_ends() {
        let segment = Segment { centre: [3.0, 4.0], orientation_rad: 2.0, length: 10.0 };
        let [from, to] = segment.ends();
        assert!(((to[0] - from[0]).hypot(to[1] - from[1]) - 10.0).abs() < 1e-12);
        let points = draws(&segment, 3);
        for p in &points {
            let cross = (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]);
            assert!(cross.abs() < 1e-12);
        }
        assert_uniform(points.iter().map(|p| (p[0] - from[0]) / (to[0] - from[0])));
    }

    #[test]
    fn only_normals_with_a_covariance() {
        for covariance in [
            [[1.0, 1.0], [1.0, 1.0]],
            [[0.0, 0.0], [0.0, 1.0]],
            [[-1.0, 0.0], [0.0, 1.0]],
            [[1.0, 0.1], [0.2, 1.0]],
            [[f64::NAN, 0.0], [0.0, 1.0]],
            [[1.0, 0.0], [0.0, f64::INFINITY]],
        ] {
            assert!(matches!(Normal::new([0.0; 2], covariance), Err(ProcessError::Covariance(_))), "{covariance:?}");
        }
        let error = Normal::new([f64::NAN, 0.0], [[1.0, 0.0], [0.0, 1.0]]).unwrap_err();
        assert_eq!(error.to_string(), "(NaN, 0) is not a position");
    }
}
