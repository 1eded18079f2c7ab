//! The rectangle a process is observed in.

use super::spatial::Spatial;
use super::{Point, ProcessError};
use scphd_log::noise::Noise;

/// A rectangle with sides along the axes, limits included, m; its area is finite and greater than zero.
///
/// As a [`Spatial`] distribution it is the uniform one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    low: Point,
    high: Point,
}

impl Rectangle {
    /// The rectangle between two values of x and two of y, the lower one first.
    ///
    /// # Errors
    ///
    /// [`ProcessError::Region`] where a side is not longer than zero or a limit or the area is not finite.
    pub fn new(x: [f64; 2], y: [f64; 2]) -> Result<Self, ProcessError> {
        let region = Self { low: [x[0], y[0]], high: [x[1], y[1]] };
        let [width, height] = region.sides();
        let sound = width > 0.0 && height > 0.0 && region.area() > 0.0 && region.area().is_finite();
        if sound { Ok(region) } else { Err(ProcessError::Region { low: region.low, high: region.high }) }
    }

    /// Lower limits of x and y.
    #[must_use]
    pub fn low(&self) -> Point {
        self.low
    }

    /// Upper limits of x and y.
    #[must_use]
    pub fn high(&self) -> Point {
        self.high
    }

    /// Lengths along x and y, m.
    #[must_use]
    pub fn sides(&self) -> [f64; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    /// Area, m².
    #[must_use]
    pub fn area(&self) -> f64 {
        let [width, height] = self.sides();
        width * height
    }

    /// Whether a point lies inside or on the border.
    #[must_use]
    pub fn contains(&self, point: Point) -> bool {
        (0..2).all(|axis| self.low[axis] <= point[axis] && point[axis] <= self.high[axis])
    }

    /// The rectangle with every side moved outwards by `margin` m; inwards where it is negative.
    ///
    /// # Errors
    ///
    /// [`ProcessError::Region`] where nothing is left or it grows beyond all numbers.
    pub fn grown(&self, margin: f64) -> Result<Self, ProcessError> {
        let axis = |axis: usize| [self.low[axis] - margin, self.high[axis] + margin];
        Self::new(axis(0), axis(1))
    }
}

impl Spatial for Rectangle {
    type Place = Point;

    fn draw(&self, noise: &mut Noise) -> Point {
        let x = noise.between(self.low[0], self.high[0]);
        [x, noise.between(self.low[1], self.high[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rectangles_with_an_area() {
        let region = Rectangle::new([-1.0, 3.0], [0.0, 2.0]).unwrap();
        assert_eq!(region.area(), 8.0);
        assert!(region.contains([-1.0, 2.0]) && !region.contains([0.0, 2.1]) && !region.contains([f64::NAN, 1.0]));
        assert_eq!(region.grown(1.0).unwrap(), Rectangle::new([-2.0, 4.0], [-1.0, 3.0]).unwrap());
        assert!(region.grown(-1.0).is_err() && region.grown(f64::NAN).is_err());
        for x in [[0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY], [-1e300, 1e300]] {
            assert!(Rectangle::new(x, [-1e200, 1e200]).is_err(), "{x:?}");
        }
        let error = Rectangle::new([1.0, 0.0], [0.0, 1.0]).unwrap_err();
        assert_eq!(error.to_string(), "a region from (1, 0) to (0, 1) m has no area that can be computed with");
    }
}
