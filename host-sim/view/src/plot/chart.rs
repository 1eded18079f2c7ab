//! The content of a chart: axes and marks, without their drawing.

use super::axis::Interval;
use std::fmt;

/// An opaque colour: red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    pub const TRUTH: Self = Self(0, 0, 0);
    pub const DEAD_RECKONING: Self = Self(214, 39, 40);
    /// Secondary data.
    pub const GREY: Self = Self(130, 130, 130);
    /// Less important data.
    pub const PALE: Self = Self(208, 208, 208);
    /// Colours of runs and other equivalent curves, in this order; neighbours differ in brightness too, and the first two do not
    /// mix to grey.
    const CURVES: [Self; 6] = [
        Self(0, 92, 200),
        Self(60, 180, 60),
        Self(230, 126, 0),
        Self(160, 60, 170),
        Self(90, 170, 230),
        Self(120, 90, 40),
    ];

    /// The colour of the curve with this index; colours repeat after six.
    pub fn of_curve(index: usize) -> Self {
        Self::CURVES[index % Self::CURVES.len()]
    }
}

impl fmt::Display for Colour {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}

/// A Gaussian in the plane of the chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    /// Mean, in units of the axes.
    pub mean: [f64; 2],
    /// Covariance, in squared units of the axes.
    pub covariance: [[f64; 2]; 2],
    /// Weight, shown as opacity; 1 and above is fully opaque.
    pub weight: f64,
}

/// The shape of a mark. A point that is not finite interrupts a curve or is left out.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A curve through points (x, y).
    Line { points: Vec<[f64; 2]>, width_px: f64, dashed: bool },
    /// The area between two curves: x, lower y, upper y.
    Band(Vec<[f64; 3]>),
    /// Crosses at points (x, y).
    Crosses(Vec<[f64; 2]>),
    /// Many small points (x, y), transparent enough to show their density.
    Dots(Vec<[f64; 2]>),
    /// Circles around points (x, y).
    Rings(Vec<[f64; 2]>),
    /// Means with ellipses of 95 % probability.
    Gaussians(Vec<Gaussian>),
}

/// One series of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// Its name in the legend; empty: not in the legend.
    pub label: String,
    pub colour: Colour,
    pub shape: Shape,
}

impl Mark {
    /// A solid curve of the usual width.
    pub fn line(label: impl Into<String>, colour: Colour, points: Vec<[f64; 2]>) -> Self {
        let shape = Shape::Line { points, width_px: 1.8, dashed: false };
        Self::new(label, colour, shape)
    }

    /// A dashed curve of the usual width.
    pub fn dashed(label: impl Into<String>, colour: Colour, points: Vec<[f64; 2]>) -> Self {
        let shape = Shape::Line { points, width_px: 1.6, dashed: true };
        Self::new(label, colour, shape)
    }

    /// The area between two curves, given as rows of x, lower y and upper y.
    pub fn band(label: impl Into<String>, colour: Colour, rows: Vec<[f64; 3]>) -> Self {
        Self::new(label, colour, Shape::Band(rows))
    }

    pub fn crosses(label: impl Into<String>, colour: Colour, points: Vec<[f64; 2]>) -> Self {
        Self::new(label, colour, Shape::Crosses(points))
    }

    pub fn dots(label: impl Into<String>, colour: Colour, points: Vec<[f64; 2]>) -> Self {
        Self::new(label, colour, Shape::Dots(points))
    }

    pub fn rings(label: impl Into<String>, colour: Colour, points: Vec<[f64; 2]>) -> Self {
        Self::new(label, colour, Shape::Rings(points))
    }

    /// Means with ellipses of 95 % probability.
    pub fn gaussians(label: impl Into<String>, colour: Colour, features: Vec<Gaussian>) -> Self {
        Self::new(label, colour, Shape::Gaussians(features))
    }

    fn new(label: impl Into<String>, colour: Colour, shape: Shape) -> Self {
        Self { label: label.into(), colour, shape }
    }

    /// The same curve with another width, px; no effect on other shapes.
    pub fn wide(mut self, width: f64) -> Self {
        if let Shape::Line { width_px, .. } = &mut self.shape {
            *width_px = width;
        }
        self
    }

    /// Points that the limits must contain; for a [`Gaussian`] its mean.
    fn extent(&self) -> Vec<[f64; 2]> {
        let points = match &self.shape {
            Shape::Line { points, .. } | Shape::Crosses(points) | Shape::Dots(points) | Shape::Rings(points) => {
                points.clone()
            }
            Shape::Band(rows) => rows.iter().flat_map(|&[x, low, high]| [[x, low], [x, high]]).collect(),
            Shape::Gaussians(features) => features.iter().map(|f| f.mean).collect(),
        };
        points.into_iter().filter(|p| p[0].is_finite() && p[1].is_finite()).collect()
    }
}

/// A pair of axes with its marks; later marks are drawn over earlier ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chart {
    /// Name and unit of the x axis; may be empty.
    pub x_label: String,
    /// Name and unit of the y axis; may be empty.
    pub y_label: String,
    /// Limits of x; `None`: those of the marks.
    pub x: Option<Interval>,
    /// Limits of y; `None`: those of the marks with a margin.
    pub y: Option<Interval>,
    /// Whether the scales of x and y are equal; the limits are then extended as needed.
    pub equal_scale: bool,
    pub marks: Vec<Mark>,
}

impl Chart {
    pub fn has_data(&self) -> bool {
        self.marks.iter().any(|mark| !mark.extent().is_empty())
    }

    /// The limits of x and y, given or computed.
    pub fn limits(&self) -> (Interval, Interval) {
        let points: Vec<[f64; 2]> = self.marks.iter().flat_map(Mark::extent).collect();
        let around = |axis: usize| Interval::around(points.iter().map(|p| p[axis]));
        let x = self.x.or_else(|| around(0));
        let y = self.y.or_else(|| around(1).map(with_air));
        (x.unwrap_or(Interval::UNIT), y.unwrap_or(Interval::UNIT))
    }
}

/// A margin above and below; extended to zero if the values nearly reach it.
fn with_air(y: Interval) -> Interval {
    let padded = y.padded(0.06);
    if y.low() >= 0.0 && y.low() < 0.5 * y.high() {
        return Interval::new(0.0, padded.high()).unwrap_or(padded);
    }
    padded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_marks_unless_given() {
        let mut chart = Chart {
            marks: vec![
                Mark::line("a", Colour::of_curve(0), vec![[1.0, 5.0], [f64::NAN, 9.0], [3.0, 1.0]]),
                Mark::band("", Colour::of_curve(1), vec![[2.0, 0.5, 10.0]]),
            ],
            ..Chart::default()
        };
        let (x, y) = chart.limits();
        assert_eq!((x.low(), x.high()), (1.0, 3.0));
        assert_eq!(y.low(), 0.0);
        assert!(y.contains(10.0) && y.high() < 11.0);
        chart.y = Interval::new(-1.0, 2.0);
        assert_eq!(chart.limits().1, Interval::new(-1.0, 2.0).unwrap());
        assert!(chart.has_data());
    }

    #[test]
    fn an_empty_chart_has_limits() {
        let chart = Chart::default();
        assert!(!chart.has_data());
        assert_eq!(chart.limits(), (Interval::UNIT, Interval::UNIT));
    }

    #[test]
    fn colours_in_hexadecimal() {
        assert_eq!(Colour(0, 10, 255).to_string(), "#000aff");
        assert_eq!(Colour::of_curve(6), Colour::of_curve(0));
    }
}
