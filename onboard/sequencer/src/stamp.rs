//! Points in time and the time between them, in whole nanoseconds.

use scphd::Real;

/// When an input was measured, by which of the vehicle's instruments, and its number among the inputs of that one.
///
/// Inputs are taken in the order of their times. Where times are equal a control comes before all events, events come
/// in the order of `source`, and inputs of one source in the order of `number`: so the order of arrival decides
/// nothing. Two inputs that agree in all three are taken for one that was sent twice.
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
    /// ns, of a clock that all instruments share. Only differences count, so that the clock may begin anywhere and may
    /// pass from `u64::MAX` on to 0.
    pub time_ns: u64,
    /// Which instrument, as the vehicle numbers them.
    pub source: u8,
    /// Sequence number of the source, where it has one; it matters only among inputs of one source with one time.
    pub number: u32,
}

impl Stamp {
    /// The time of an input of this source, with the sequence number 0.
    #[must_use]
    pub const fn new(source: u8, time_ns: u64) -> Self {
        Self { time_ns, source, number: 0 }
    }

    /// The same with a sequence number.
    #[must_use]
    pub const fn numbered(self, number: u32) -> Self {
        Self { number, ..self }
    }
}

/// A time that passes.
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
    /// So many nanoseconds.
    #[must_use]
    pub const fn of_ns(ns: u64) -> Self {
        Self(ns)
    }

    /// In nanoseconds.
    #[must_use]
    pub const fn ns(self) -> u64 {
        self.0
    }

    /// In seconds: the one place where a time becomes a floating-point number. Exact up to the rounding of one
    /// division.
    #[must_use]
    pub fn seconds<T: Real>(self) -> T {
        T::from_f64(self.0 as f64 / 1e9)
    }
}

/// Where an input stands among the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Key {
    /// ns since the start.
    pub(crate) time: u64,
    pub(crate) source: u8,
    pub(crate) number: u32,
}
