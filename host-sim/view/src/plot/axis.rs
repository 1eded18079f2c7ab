//! Axes: limits, ticks and their labels.

/// A closed range of an axis, in the unit of the axis; finite, and `low < high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    /// From 0 to 1, for axes without data.
    pub const UNIT: Self = Self { low: 0.0, high: 1.0 };

    /// The interval between two numbers, widened if they are equal; `None` if one is not finite or beyond 1e300, where the length
    /// could overflow.
    pub fn new(a: f64, b: f64) -> Option<Self> {
        if !(drawable(a) && drawable(b)) {
            return None;
        }
        let (low, high) = (a.min(b), a.max(b));
        // Ticks of a narrower interval could not be distinguished in f64.
        let least = (1e-9 * low.abs().max(high.abs())).max(1e-9);
        if high - low >= least {
            Some(Self { low, high })
        } else {
            let centre = 0.5 * (low + high);
            let half = (0.05 * centre.abs()).max(0.5);
            Some(Self { low: centre - half, high: centre + half })
        }
    }

    /// The smallest interval around all valid values; `None` if there are none.
    pub fn around(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut ends: Option<(f64, f64)> = None;
        for value in values.into_iter().filter(|v| drawable(*v)) {
            let (low, high) = ends.unwrap_or((value, value));
            ends = Some((low.min(value), high.max(value)));
        }
        ends.and_then(|(low, high)| Self::new(low, high))
    }

    pub fn low(self) -> f64 {
        self.low
    }

    pub fn high(self) -> f64 {
        self.high
    }

    /// Length, always greater than zero.
    pub fn span(self) -> f64 {
        self.high - self.low
    }

    /// Whether a value is inside, ends included.
    pub fn contains(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// The smallest interval around both.
    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The common part of both; `self` if there is none.
    pub fn intersection(self, other: Self) -> Self {
        Self::new(self.low.max(other.low), self.high.min(other.high))
            .filter(|_| self.low < other.high && other.low < self.high)
            .unwrap_or(self)
    }

    /// The interval extended by `fraction` of its length at both ends.
    pub fn padded(self, fraction: f64) -> Self {
        self.with_span(self.span() * (1.0 + 2.0 * fraction))
    }

    /// The interval with the same centre and this length.
    pub fn with_span(self, span: f64) -> Self {
        let centre = 0.5 * (self.low + self.high);
        Self { low: centre - 0.5 * span, high: centre + 0.5 * span }
    }

    /// About `wanted` round numbers inside the interval, with their labels.
    pub fn ticks(self, wanted: f64) -> Vec<(f64, String)> {
        let rough = self.span() / wanted.max(1.0);
        let power = rough.log10().floor();
        let unit = 10f64.powf(power);
        let factor =
            [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().find(|factor| factor * unit >= rough * (1.0 - 1e-9)).unwrap_or(10.0);
        let step = factor * unit;
        // 2.5 needs a digit more than its power of ten.
        let digits = (-power + if factor == 2.5 { 1.0 } else { 0.0 } - if factor == 10.0 { 1.0 } else { 0.0 })
            .clamp(0.0, 12.0) as usize;

        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        (first..=last)
            .map(|index| {
                let value = index as f64 * step;
                (value, label(value, digits))
            })
            .collect()
    }
}

/// Whether a number can be an end of an interval.
fn drawable(value: f64) -> bool {
    value.abs() <= 1e300
}

/// The label of a number at a tick, with a true minus sign.
fn label(value: f64, digits: usize) -> String {
    let text = if value.abs() >= 1e7 { format!("{value:e}") } else { format!("{:.digits$}", value.abs()) };
    if value < 0.0 && value.abs() < 1e7 { format!("\u{2212}{text}") } else { text.replace('-', "\u{2212}") }
}

/// Extends both intervals as little as necessary for equal scales in x and y on `width` × `height` pixels.
pub fn equalised(x: Interval, y: Interval, width: f64, height: f64) -> (Interval, Interval) {
    let units_per_px = (x.span() / width).max(y.span() / height);
    (x.with_span(units_per_px * width), y.with_span(units_per_px * height))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, wanted: f64) -> Vec<String> {
        let ticks = Interval::new(low, high).unwrap().ticks(wanted);
        ticks.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(0.0, 10.0, 5.0), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(-1.1, 1.1, 4.0), ["\u{2212}1", "0", "1"]);
        assert_eq!(labels(0.0, 0.1, 4.0), ["0.000", "0.025", "0.050", "0.075", "0.100"]);
        assert_eq!(labels(-30.0, 4000.0, 4.0), ["0", "2000", "4000"]);
        assert_eq!(labels(0.0, 95.0, 10.0), ["0", "10", "20", "30", "40", "50", "60", "70", "80", "90"]);
        assert_eq!(labels(0.0, 4.8, 5.0), ["0", "1", "2", "3", "4"]);
    }

    #[test]
    fn intervals_are_never_empty() {
        assert!(Interval::new(f64::NAN, 1.0).is_none());
        assert!(Interval::around([f64::INFINITY, -f64::MAX]).is_none());
        for value in [0.0, 5.0, 1e12, -3e-20] {
            let interval = Interval::around([value]).unwrap();
            assert!(interval.low() < value && value < interval.high());
            assert!(!interval.ticks(5.0).is_empty());
        }
        let interval = Interval::around([3.0, f64::NAN, -1.0]).unwrap();
        assert_eq!((interval.low(), interval.high()), (-1.0, 3.0));
    }

    #[test]
    fn intersection_and_union() {
        let a = Interval::new(0.0, 2.0).unwrap();
        let b = Interval::new(1.0, 9.0).unwrap();
        let far = Interval::new(5.0, 9.0).unwrap();
        assert_eq!(a.union(b), Interval::new(0.0, 9.0).unwrap());
        assert_eq!(a.intersection(b), Interval::new(1.0, 2.0).unwrap());
        assert_eq!(a.intersection(far), a);
        assert_eq!(a.padded(0.5), Interval::new(-1.0, 3.0).unwrap());
    }

    #[test]
    fn equal_scale() {
        let x = Interval::new(0.0, 10.0).unwrap();
        let y = Interval::new(0.0, 10.0).unwrap();
        let (wide, tall) = equalised(x, y, 200.0, 100.0);
        assert_eq!(wide, Interval::new(-5.0, 15.0).unwrap());
        assert_eq!(tall, y);
    }
}
