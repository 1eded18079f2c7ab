//! Time stamps.

use crate::definition::messages;

const NANOSECONDS: u64 = 1_000_000_000;

messages! {
    "builtin_interfaces"
    /// Whole seconds, and nanoseconds beyond them, less than 10⁹.
    #[derive(Copy, Eq, Default)]
    Time { sec: i32, nanosec: u32, }

    /// Whole seconds, and nanoseconds beyond them.
    #[derive(Copy, Default)]
    Duration { sec: i32, nanosec: u32, }
}

/// A time that a stamp cannot express: below 0, beyond 2³¹ s, or NaN.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{0} s is no time for a stamp, which are from 0 to 2^31 s")]
pub struct TimeError(pub f64);

impl Time {
    /// The stamp nearest to a time in seconds.
    pub fn from_seconds(t_s: f64) -> Result<Self, TimeError> {
        // Whole seconds and the remainder separately: the product with 10⁹ would lose digits.
        let whole = t_s.floor();
        let rest = ((t_s - whole) * 1e9).round();
        if !(whole >= 0.0 && whole < f64::from(i32::MAX)) {
            return Err(TimeError(t_s));
        }
        // Both are whole numbers in the range of their types.
        Ok(Self::from_nanoseconds(whole as u64 * NANOSECONDS + rest as u64))
    }

    /// The stamp of a number of nanoseconds; times beyond 2³¹ s are limited.
    pub fn from_nanoseconds(ns: u64) -> Self {
        let sec = i32::try_from(ns / NANOSECONDS).unwrap_or(i32::MAX);
        // Less than 10⁹.
        Self { sec, nanosec: (ns % NANOSECONDS) as u32 }
    }

    /// Nanoseconds; 0 for a negative stamp.
    pub fn nanoseconds(&self) -> u64 {
        u64::try_from(self.sec).map_or(0, |sec| sec * NANOSECONDS + u64::from(self.nanosec))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_times_are_restored_to_the_bit() {
        for k in 0..200_000_u32 {
            let t_s = format!("{}.{:03}", k / 7, k % 1000).parse::<f64>().unwrap();
            let ns = Time::from_seconds(t_s).unwrap().nanoseconds();
            assert_eq!(ns as f64 / 1e9, t_s);
        }
    }

    #[test]
    fn a_remainder_that_rounds_up_gives_the_next_second() {
        assert_eq!(Time::from_seconds(1.999_999_999_9).unwrap(), Time { sec: 2, nanosec: 0 });
        assert_eq!(Time::from_seconds(0.25).unwrap(), Time { sec: 0, nanosec: 250_000_000 });
    }

    #[test]
    fn times_out_of_range_are_refused() {
        for t_s in [-1e-9, 2.2e9, f64::NAN, f64::INFINITY] {
            assert!(Time::from_seconds(t_s).is_err(), "{t_s}");
        }
        assert_eq!(Time { sec: -1, nanosec: 5 }.nanoseconds(), 0);
    }
}
