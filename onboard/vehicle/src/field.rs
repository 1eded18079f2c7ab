//! What there is to say of a setting, the numbers that it may be, and where a description keeps it.

use crate::Description;
use scphd::Real;

/// The numbers that a setting may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub(crate) least: f32,
    pub(crate) most: f32,
    /// Whether the ends are part of the range.
    pub(crate) closed: [bool; 2],
}

impl Range {
    /// The numbers between two others, without these.
    pub(crate) const fn open(least: f32, most: f32) -> Self {
        Self { least, most, closed: [false; 2] }
    }

    /// The numbers from one to another.
    pub(crate) const fn within(least: f32, most: f32) -> Self {
        Self { least, most, closed: [true; 2] }
    }

    /// Whether a number is part of the range; NaN is part of none.
    pub(crate) fn has<T: Real>(&self, number: T) -> bool {
        let [least, most] = [self.least, self.most].map(|end| T::from_f64(f64::from(end)));
        let [low, high] = self.closed;
        let above = number > least || low && number == least;
        let below = number < most || high && number == most;
        above && below
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

impl<T: Real> Place<'_, T> {
    /// Whether the number there is part of a range.
    pub(crate) fn is_in(&self, range: &Range) -> bool {
        match self {
            Self::Number(number) => range.has(**number),
            Self::Count(count) => range.has(**count as f32),
            Self::Small(count) => range.has(f32::from(**count)),
            // Any is a good one; the range is that of what can be set exactly.
            Self::Seed(_) => true,
        }
    }
}

/// Reads a setting that is one of several.
pub(crate) type Get<T> = fn(&Description<T>, usize) -> Option<usize>;
/// Sets a setting that is one of several; false where the description has no such part.
pub(crate) type Set<T> = fn(&mut Description<T>, usize, usize) -> bool;

/// What a setting means.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Meaning {
    pub(crate) unit: &'static str,
    pub(crate) about: &'static str,
    pub(crate) choices: &'static [&'static str],
}
