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
}

impl Range {
    /// Any finite number.
    pub const FINITE: Self = Self { least: f64::NEG_INFINITY, most: f64::INFINITY, closed: [false; 2] };
    /// Finite and not negative.
    pub const NOT_NEGATIVE: Self = Self { least: 0.0, most: f64::INFINITY, closed: [true, false] };
    /// Finite and above 0.
    pub const POSITIVE: Self = Self { least: 0.0, most: f64::INFINITY, closed: [false; 2] };
    /// Above 0, or infinite.
    pub const LIMIT: Self = Self { least: 0.0, most: f64::INFINITY, closed: [false, true] };
    /// 0 or more, or infinite.
    pub const GATE: Self = Self { least: 0.0, most: f64::INFINITY, closed: [true, true] };
    /// From 0 to 1.
    pub const SHARE: Self = Self::within(0.0, 1.0);
    /// From 0 to below 1.
    pub const BELOW_ONE: Self = Self { least: 0.0, most: 1.0, closed: [true, false] };
    /// Above 0 and below 1.
    pub const INSIDE_ONE: Self = Self { least: 0.0, most: 1.0, closed: [false; 2] };
    /// A standard deviation whose square single precision can hold.
    pub const SIGMA: Self = Self::within(1e-6, 1e6);

    /// From one number to another.
    #[must_use]
    pub const fn within(least: f64, most: f64) -> Self {
        Self { least, most, closed: [true; 2] }
    }

    /// Whether a number is of it; NaN is of none.
    #[must_use]
    pub fn has(&self, number: f64) -> bool {
        let [low, high] = self.closed;
        let above = number > self.least || low && number == self.least;
        let below = number < self.most || high && number == self.most;
        above && below
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { least, most, closed: [low, high] } = *self;
        let at_least = if low { "at least" } else { "above" };
        let at_most = if high { "at most" } else { "below" };
        match (least.is_finite(), most.is_finite()) {
            (false, false) => f.write_str("finite"),
            (false, true) => write!(f, "{at_most} {most}"),
            (true, false) if high => write!(f, "{at_least} {least}, or infinite"),
            (true, false) => write!(f, "finite and {at_least} {least}"),
            (true, true) if low && high => write!(f, "between {least} and {most}"),
            (true, true) => write!(f, "{at_least} {least} and {at_most} {most}"),
        }
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
