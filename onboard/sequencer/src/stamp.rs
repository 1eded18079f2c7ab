//! Times and intervals, in integer nanoseconds.

use scphd::Real;

/// Time of measurement of an input, its source, and its number among the inputs of that source.
///
/// Inputs are ordered by time. At equal times a control precedes all events, events are ordered by `source`, and inputs of one
/// source by `number`: the order of arrival has no effect. Two inputs that agree in all three count as duplicates.
///
/// ```
/// use scphd_sequencer::Stamp;
///
/// const LIDAR: u8 = 1;
/// let stamp = Stamp::new(LIDAR, 12_000_000).numbered(7);
/// assert_eq!((stamp.source, stamp.time_ns, stamp.number), (1, 12_000_000, 7));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stamp {
    /// Time, ns, of a clock that all instruments share. Only differences count: the clock may start anywhere, and may wrap from
    /// `u64::MAX` to 0.
    pub time_ns: u64,
    /// Number of the instrument, chosen by the user.
    pub source: u8,
    /// Sequence number of the source, if it has one; used only for inputs of one source with the same time.
    pub number: u32,
}

impl Stamp {
    /// The time of an input of this source, with the sequence number 0.
    pub const fn new(source: u8, time_ns: u64) -> Self {
        Self { time_ns, source, number: 0 }
    }

    /// This time stamp with a sequence number.
    #[must_use]
    pub const fn numbered(self, number: u32) -> Self {
        Self { number, ..self }
    }
}

/// A time interval.
///
/// ```
/// use scphd_sequencer::Interval;
///
/// assert_eq!(Interval::of_ns(100_000_000).seconds::<f32>(), 0.1);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Interval(u64);

impl Interval {
    /// An interval in nanoseconds.
    pub const fn of_ns(ns: u64) -> Self {
        Self(ns)
    }

    /// The interval in nanoseconds.
    pub const fn ns(self) -> u64 {
        self.0
    }

    /// The interval in seconds: the only conversion of a time to a floating-point number, exact except for the rounding of one
    /// division.
    #[must_use]
    pub fn seconds<T: Real>(self) -> T {
        T::from_f64(self.0 as f64 / 1e9)
    }
}

/// The position of an input in the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Key {
    /// ns since the start.
    pub(crate) time: u64,
    pub(crate) source: u8,
    pub(crate) number: u32,
}
