//! What there is to say of a setting.

use crate::Description;
use core::fmt;

/// The numbers that a setting may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    least: f64,
    most: f64,
    /// Whether the ends are of the range.
    closed: [bool; 2],
    words: &'static str,
}

impl Range {
    /// Any finite number.
    pub const FINITE: Self = Self::open(f64::NEG_INFINITY, f64::INFINITY, "finite");
    /// Finite and not negative.
    pub const NOT_NEGATIVE: Self =
        Self { closed: [true, false], ..Self::open(0.0, f64::INFINITY, "finite and at least 0") };
    /// Finite and at least 1.
    pub const AT_LEAST_ONE: Self =
        Self { closed: [true, false], ..Self::open(1.0, f64::INFINITY, "finite and at least 1") };
    /// Finite and above 0.
    pub const POSITIVE: Self = Self::open(0.0, f64::INFINITY, "finite and above 0");
    /// Above 0, or infinite.
    pub const LIMIT: Self = Self { closed: [false, true], ..Self::open(0.0, f64::INFINITY, "above 0, or infinite") };
    /// 0 or more, or infinite.
    pub const GATE: Self = Self { closed: [true; 2], ..Self::open(0.0, f64::INFINITY, "at least 0, or infinite") };
    /// From 0 to 1.
    pub const SHARE: Self = Self::within(0.0, 1.0, "between 0 and 1");
    /// From 0 to below 1.
    pub const BELOW_ONE: Self = Self { closed: [true, false], ..Self::open(0.0, 1.0, "at least 0 and below 1") };
    /// Above 0 and below 1.
    pub const INSIDE_ONE: Self = Self::open(0.0, 1.0, "above 0 and below 1");
    /// A standard deviation whose square single precision can hold.
    pub const SIGMA: Self = Self::within(1e-6, 1e6, "between 0.000001 and 1000000");

    const fn open(least: f64, most: f64, words: &'static str) -> Self {
        Self { least, most, closed: [false; 2], words }
    }

    /// From one number to another, and what that is in words.
    #[must_use]
    pub const fn within(least: f64, most: f64, words: &'static str) -> Self {
        Self { least, most, closed: [true; 2], words }
    }

    /// Whether a number is of it; NaN is of none.
    #[must_use]
    pub fn has(&self, number: f64) -> bool {
        let [low, high] = self.closed;
        let above = number > self.least || low && number == self.least;
        let below = number < self.most || high && number == self.most;
        above && below
    }

    /// What a number of it is, as in "must be above 0".
    #[must_use]
    pub const fn words(&self) -> &'static str {
        self.words
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.words)
    }
}

/// Where a description keeps a number.
#[derive(Debug)]
pub(crate) enum Place<'a, T> {
    Number(&'a mut T),
    Count(&'a mut usize),
    Small(&'a mut u16),
    Seed(&'a mut u64),
}

/// Where a description keeps a number, of the sensor with this index where it is one of a sensor; `None` where it has no such part.
pub(crate) type Find<T> = for<'a> fn(&'a mut Description<T>, usize) -> Option<Place<'a, T>>;

/// How a setting is read and written.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Access<T: 'static> {
    Number(Find<T>),
    /// One of several, by its number in the list.
    Choice {
        names: &'static [&'static str],
        get: fn(&Description<T>, usize) -> Option<usize>,
        set: fn(&mut Description<T>, usize, usize) -> bool,
    },
}

/// A setting of a [`Description`].
#[derive(Debug, Clone, Copy)]
pub struct Field<T: 'static> {
    /// Its name, with a point between a part and what is of it.
    pub name: &'static str,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// What it may be.
    pub range: Range,
    /// What it is, in a sentence.
    pub about: &'static str,
    pub(crate) access: Access<T>,
}

impl<T> Field<T> {
    /// Of a setting that is one of several: their names, in the order of their numbers.
    #[must_use]
    pub fn choices(&self) -> Option<&'static [&'static str]> {
        match self.access {
            Access::Number(_) => None,
            Access::Choice { names, .. } => Some(names),
        }
    }

    /// Whether it is one of each sensor.
    #[must_use]
    pub fn is_of_a_sensor(&self) -> bool {
        self.name.starts_with("sensor.")
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::{String, ToString as _};

    fn spelled(range: &Range) -> String {
        let Range { least, most, closed: [low, high], .. } = *range;
        let (at_least, at_most) = (if low { "at least" } else { "above" }, if high { "at most" } else { "below" });
        match (least.is_finite(), most.is_finite()) {
            (false, _) => "finite".to_string(),
            (true, false) if high => std::format!("{at_least} {least}, or infinite"),
            (true, false) => std::format!("finite and {at_least} {least}"),
            (true, true) if low && high => std::format!("between {least} and {most}"),
            (true, true) => std::format!("{at_least} {least} and {at_most} {most}"),
        }
    }

    #[test]
    fn words_are_those_of_the_numbers() {
        for field in Description::<f32>::FIELDS {
            let words = match field.choices() {
                Some(names) => std::format!("one of {}", names.join(", ")),
                None => spelled(&field.range),
            };
            assert_eq!(field.range.to_string(), words, "{}", field.name);
        }
    }
}
