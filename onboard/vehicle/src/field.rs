//! Meaning and range of a setting, and its place in a description.

use crate::Description;
use scphd::Real;

/// The range of a setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub(crate) least: f32,
    pub(crate) most: f32,
    /// Whether the ends are part of the range.
    pub(crate) closed: [bool; 2],
}

impl Range {
    /// The numbers between two limits, without the limits.
    pub(crate) const fn open(least: f32, most: f32) -> Self {
        Self { least, most, closed: [false; 2] }
    }

    /// The numbers between two limits, with the limits.
    pub(crate) const fn within(least: f32, most: f32) -> Self {
        Self { least, most, closed: [true; 2] }
    }

    /// Whether it is the same range.
    pub(crate) const fn is(&self, other: &Self) -> bool {
        let ([a, b], [c, d]) = (self.closed, other.closed);
        self.least.to_bits() == other.least.to_bits() && self.most.to_bits() == other.most.to_bits() && a == c && b == d
    }

    /// Whether a number is in the range; NaN is in no range.
    pub(crate) fn has<T: Real>(&self, number: T) -> bool {
        let [least, most] = [self.least, self.most].map(|end| T::from_f64(f64::from(end)));
        let [low, high] = self.closed;
        let above = number > least || low && number == least;
        let below = number < most || high && number == most;
        above && below
    }
}

/// Reference to a number in a description.
#[derive(Debug)]
pub(crate) enum Place<'a, T> {
    Number(&'a mut T),
    Count(&'a mut usize),
    Small(&'a mut u16),
    Seed(&'a mut u64),
}

impl<T: Real> Place<'_, T> {
    /// Whether the number is in a range.
    pub(crate) fn is_in(&self, range: &Range) -> bool {
        match self {
            Self::Number(number) => range.has(**number),
            Self::Count(count) => range.has(**count as f32),
            Self::Small(count) => range.has(f32::from(**count)),
            // Any seed is valid; the range is that of the numbers that can be set exactly.
            Self::Seed(_) => true,
        }
    }
}

/// Reads a setting with several choices.
pub(crate) type Get<T> = fn(&Description<T>, usize) -> Option<usize>;
/// Sets a setting with several choices; `false` if the description has no such part.
pub(crate) type Set<T> = fn(&mut Description<T>, usize, usize) -> bool;

/// The meaning of a setting.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Meaning {
    pub(crate) unit: &'static str,
    pub(crate) about: &'static str,
    pub(crate) choices: &'static [&'static str],
}
