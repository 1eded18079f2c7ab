//! The measurements of one scan, sorted so that a component is compared only with those near it.

use crate::numerics::work;
use crate::{Clutter, LnSum, Real, Sensor, Vector, wrap};
use core::ops::Range;

/// One measurement of the scan.
#[derive(Debug, Clone, Copy)]
pub struct Measurement<Z: Vector> {
    /// z.
    pub(crate) z: Z,
    /// ln( κ(z) + Σ w_b ), the intensity of the measurement without features; −∞ for zero.
    pub(crate) ln_unexplained: Z::Scalar,
}

/// ln of the least intensity to which weights are relative.
const LN_LEAST: f64 = -69.0;

/// A measurement is explained by features if they increase its intensity by more than a thousandth: ln 1.001.
const LN_EXPLAINED: f64 = 9.995_003_330_835_332e-4;

impl<T: Real, Z: Vector<Scalar = T>> Measurement<Z> {
    /// All zero; a placeholder for unused memory.
    pub(crate) const ZERO: Self = Self { z: Z::ZERO, ln_unexplained: T::ZERO };

    /// A finite reference for weights while η_z is not complete: ln( κ(z) + Σ w_b ), which bounds them from above, unless it is
    /// negligible.
    pub(crate) fn ln_reference(&self) -> T {
        self.ln_unexplained.at_least(T::from_f64(LN_LEAST))
    }

    /// Whether features explain the measurement at least in part, given ln η_z.
    pub(crate) fn is_explained(&self, ln_eta: T) -> bool {
        ln_eta > self.ln_unexplained + T::from_f64(LN_EXPLAINED)
    }
}

/// Number of buckets of the index over the sorting coordinate.
const BUCKETS: usize = 128;

/// A scan, sorted by the sensor's sorting coordinate.
#[derive(Debug, Clone)]
pub(crate) struct Scan<'s, Z: Vector> {
    measurements: &'s [Measurement<Z>],
    /// For every bucket, the index of its first measurement, where a search starts.
    starts: [u16; BUCKETS],
    /// Start of the first bucket, and number of buckets per unit of the coordinate.
    first: Z::Scalar,
    buckets_per_unit: Z::Scalar,
    /// Minimum of `ln_unexplained`.
    ln_least_unexplained: Z::Scalar,
}

/// A measurement and its index in the sorted scan.
pub(crate) type Indexed<'s, Z> = (usize, &'s Measurement<Z>);

impl<'s, T: Real, Z: Vector<Scalar = T>> Scan<'s, Z> {
    /// Sorts `measured` into `memory`, which must be at least as long; the rest of the memory is not used.
    pub(crate) fn sort<S: Sensor<Measurement = Z>>(
        memory: &'s mut [Measurement<Z>],
        measured: &[Z],
        clutter: &impl Clutter<Z>,
        birth_intensity: T,
    ) -> Self {
        let key = |measurement: &Measurement<Z>| measurement.z.at(S::SORTED_BY);
        let ln_birth = birth_intensity.ln();
        let mut ln_least_unexplained = T::INFINITY;
        let mut len = 0;
        for &z in measured {
            let mut z = z;
            if S::SORTED_BY_ANGLE
                && let Some(angle) = z.as_mut_slice().get_mut(S::SORTED_BY)
            {
                *angle = wrap(*angle);
            }
            let ln_clutter = clutter.ln_intensity(&z);
            // An invalid clutter intensity (infinite or NaN) counts as zero. The comparison is written so that NaN fails it.
            let ln_clutter = if ln_clutter < T::INFINITY { ln_clutter } else { T::NEG_INFINITY };
            let mut unexplained = LnSum::of(ln_clutter);
            unexplained.add(ln_birth);
            let ln_unexplained = unexplained.ln();
            ln_least_unexplained = ln_unexplained.at_most(ln_least_unexplained);
            // Insertion sort keeps measurements with equal keys in the caller's order. Scans are short and mostly sorted already.
            let mut place = Measurement { z, ln_unexplained };
            let position = memory.get(..len).unwrap_or(&[]).partition_point(|held| key(held) <= key(&place));
            for slot in memory.get_mut(position..=len).unwrap_or(&mut []) {
                place = core::mem::replace(slot, place);
            }
            len += 1;
        }
        let measurements = memory.get(..len).unwrap_or(&[]);
        let first = measurements.first().map_or(T::ZERO, key);
        let extent = measurements.last().map_or(T::ZERO, key) - first;
        let buckets_per_unit = if extent > T::ZERO { T::from_usize(BUCKETS) / extent } else { T::ZERO };
        let mut scan = Self { measurements, starts: [0; BUCKETS], first, buckets_per_unit, ln_least_unexplained };
        let mut begun = 0;
        for (place, measurement) in measurements.iter().enumerate() {
            let end = scan.bucket(key(measurement)) + 1;
            scan.starts.get_mut(begun..end).unwrap_or(&mut []).fill(place as u16);
            begun = begun.max(end);
        }
        scan.starts.get_mut(begun..).unwrap_or(&mut []).fill(len as u16);
        scan
    }

    /// The bucket of a coordinate, monotonic; coordinates outside the scan fall into the first or the last bucket.
    fn bucket(&self, coordinate: T) -> usize {
        ((coordinate - self.first) * self.buckets_per_unit).to_index(BUCKETS as u8 - 1)
    }

    /// Number of measurements.
    pub(crate) fn len(&self) -> usize {
        self.measurements.len()
    }

    /// All measurements in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &'s Measurement<Z>> + use<'s, T, Z> {
        self.measurements.iter()
    }

    /// Minimum of ln( κ(z) + Σ w_b ) over the measurements.
    pub(crate) fn ln_least_unexplained(&self) -> T {
        self.ln_least_unexplained
    }

    /// Minimum of the measurements' references for weights.
    pub(crate) fn ln_least_reference(&self) -> T {
        self.ln_least_unexplained.at_least(T::from_f64(LN_LEAST))
    }

    /// Calls `found` for all measurements whose sorting coordinate differs from that of `expected` by at most `reach`, and for
    /// some others.
    #[inline(always)]
    pub(crate) fn near<S: Sensor<Measurement = Z>>(
        &self,
        expected: &Z,
        reach: T,
        mut found: impl FnMut(Indexed<'s, Z>),
    ) {
        let centre = expected.at(S::SORTED_BY);
        let (low, high) = (centre - reach, centre + reach);
        let crosses = S::SORTED_BY_ANGLE && (low <= -T::PI || high > T::PI);
        let (mut places, mut rest) =
            if crosses { self.places_across(low, high) } else { (self.start(low)..self.end(high), 0..0) };
        loop {
            work::round();
            for index in places {
                let Some(measurement) = self.measurements.get(index) else { break };
                found((index, measurement));
            }
            if rest.is_empty() {
                return;
            }
            places = core::mem::replace(&mut rest, 0..0);
        }
    }

    /// The ranges of measurements within a window of angles that crosses ±π: from an index to the last one, then from the first
    /// one.
    #[inline(never)]
    fn places_across(&self, low: T, high: T) -> (Range<usize>, Range<usize>) {
        let (len, turn) = (self.len(), T::PI + T::PI);
        if high - low >= turn {
            return (0..len, 0..0);
        }
        let (start, end) = if low <= -T::PI {
            (self.start(low + turn), self.end(high))
        } else {
            (self.start(low), self.end(high - turn))
        };
        (start..len, 0..end.min(start))
    }

    /// An index before which no measurement reaches `bound`.
    fn start(&self, bound: T) -> usize {
        self.starts.get(self.bucket(bound)).copied().map_or(0, usize::from)
    }

    /// An index from which on all measurements are above `bound`.
    fn end(&self, bound: T) -> usize {
        self.starts.get(self.bucket(bound) + 1).copied().map_or(self.len(), usize::from)
    }
}
