//! The filter that processes a stream, generic over the vehicle.

use crate::header::Parameters;
use crate::kind::Kind;
use crate::numbers::Numbers;
use crate::record::{Measurements, Record};
use crate::snapshot::Snapshot;
use scphd::diagnostics::Probe;
use scphd::errors::{LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use scphd::models::ModelError;
use scphd::numerics::Vector;
use scphd::{JointReport, PredictReport, Real, ScanReport};
use scphd_vehicle::{Invalid, Refused, Setting, StartError};

/// A filter on board for streams of a kind, with this number type.
pub trait Aboard<T: Real> {
    /// The kind of its streams.
    type Kind: Kind;
    /// All memory of the filter.
    type Memory;
    /// The filter in its memory.
    type Filter<'m>: Filter<Self::Kind>
    where
        T: 'm;

    /// Empty memory, all zero, so that a `static` is in .bss.
    const MEMORY: Self::Memory;
    /// Capacities that bound the work of a scan.
    const CAPACITIES: Capacities;
    /// Use of the RAM.
    const RAM_PARTS: [RamPart; 6];

    /// Constructs and starts the filter with the parameters of a head.
    ///
    /// # Errors
    /// A parameter of the head is out of range, or the filter does not fit the memory.
    fn start<'m>(head: &impl Parameters<Self::Kind>, memory: &'m mut Self::Memory) -> Result<Self::Filter<'m>, Refusal>
    where
        T: 'm;
}

/// A filter for streams of one kind.
pub trait Filter<K: Kind> {
    /// Whether it processes all records of a black box.
    const BLACK_BOX: bool = false;

    /// Predicts the pose.
    ///
    /// # Errors
    /// The input is invalid.
    fn predict(&mut self, input: &K::Input) -> Result<(), Refusal>;

    /// Stores a scan, for [`scan`](Self::scan).
    fn receive(&mut self, measurements: Measurements<'_, K>) -> Scan;

    /// Updates the filter with the last stored scan.
    ///
    /// # Errors
    /// A measurement is not finite, or there are too many.
    fn scan(&mut self, scan: Scan) -> Result<Seen, Refusal> {
        self.scan_with(scan, &mut ())
    }

    /// [`scan`](Self::scan) with a probe.
    ///
    /// # Errors
    /// As for `scan`.
    fn scan_with(&mut self, scan: Scan, probe: &mut impl Probe) -> Result<Seen, Refusal>;

    /// Processes a record that is neither a prediction nor a scan. Only the filters of a black box support these records; those
    /// for benchmarks do not.
    ///
    /// # Errors
    /// The filter does not support the record, or refuses it.
    fn take(&mut self, _record: &Record<'_, K>) -> Result<(), Refusal> {
        Err(Refusal::NotAboard)
    }

    /// Restores a snapshot. Only the filters of a black box support this; those for benchmarks do not.
    ///
    /// # Errors
    /// This filter does not support snapshots, or cannot use this one.
    fn restore(&mut self, _snapshot: &Snapshot<'_, K>) -> Result<(), Refusal> {
        Err(Refusal::NotAboard)
    }

    /// Estimates pose and map as a vehicle does after a scan. Returns the pose and the number of features.
    fn estimate(&mut self) -> (K::Pose, usize);

    /// The estimated pose, and the lower triangle of its covariance.
    fn estimate_pose(&self) -> (K::Pose, K::Covariance);

    /// A hash of the complete state.
    fn digest(&self) -> u64;
}

/// The lower triangle of a covariance.
pub(crate) fn lower<K: Kind, T: Real>(numbers: &[T]) -> K::Covariance {
    let mut lower = K::Covariance::ZERO;
    lower.as_mut().iter_mut().zip(numbers).for_each(|(slot, number)| *slot = number.to_f64());
    lower
}

/// Errors of the filter on board: why it refused the header or a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refusal {
    /// A parameter of a model is out of range.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The configuration is out of range or does not fit the memory.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The initial pose is out of range.
    #[error(transparent)]
    Reset(#[from] ResetError),
    /// A prediction was refused.
    #[error(transparent)]
    Predict(PredictError),
    /// A scan was refused.
    #[error(transparent)]
    Scan(#[from] ScanError),
    /// A measurement of the pose was refused.
    #[error(transparent)]
    Observe(ObserveError),
    /// A map was refused.
    #[error(transparent)]
    Map(LoadMapError),
    /// A snapshot, or a header among the records, cannot be used.
    #[error("{why}")]
    Unusable {
        /// The reason, as a text: with the details of the error, images without a black box would be two kilobytes larger.
        why: &'static str,
    },
    /// A setting of the description, by its number in the list, is out of range.
    #[error("{} must be {}", of(*number).0, of(*number).1)]
    Setting {
        /// The number of the setting.
        number: u32,
    },
    /// The memory is for another filter than this setting says, or the setting cannot change while the filter runs.
    #[error("the memory is not for what {} says", of(*number).0)]
    Part {
        /// The number of the setting.
        number: u32,
    },
    /// The filter does not support the record, or has no such detector.
    #[error("this filter does not support the record, or has no such detector")]
    NotAboard,
}

impl From<StartError> for Refusal {
    fn from(error: StartError) -> Self {
        match error {
            StartError::Setup(error) => Self::Setup(error),
            StartError::Invalid(invalid) => invalid.into(),
            StartError::NoRoom { part } | StartError::NotDescribed { part } | StartError::Fixed { part } => {
                Self::Part { number: part.number() }
            }
            _ => Self::NotAboard,
        }
    }
}

impl From<Invalid> for Refusal {
    fn from(invalid: Invalid) -> Self {
        Self::Setting { number: invalid.setting.number() }
    }
}

impl From<Refused<ScanError>> for Refusal {
    fn from(refused: Refused<ScanError>) -> Self {
        match refused {
            Refused::Filter(error) => Self::Scan(error),
            _ => Self::NotAboard,
        }
    }
}

/// Name and range of the setting with this number.
fn of(number: u32) -> (&'static str, &'static str) {
    Setting::of_number(number).map_or(("?", "?"), |setting| (setting.name(), setting.range()))
}

/// Results of a scan for a monitor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seen {
    /// Health flags as bits.
    pub health: u16,
    /// Greatest number of components in view of a candidate.
    pub in_view: u32,
    /// Number of maps written.
    pub maps_updated: u32,
    /// Number of pages in use.
    pub pages_used: u32,
    /// Total number of pages.
    pub pages: u32,
}

impl Seen {
    /// From the report of a scan of a joint map that has `held` features, and capacity for `room`.
    pub(crate) fn of_joint<T: Real>(report: &JointReport<T>, held: usize, room: usize) -> Self {
        let (health, in_view) = (report.health.bits(), report.in_view as u32);
        Self { health, in_view, maps_updated: 1, pages_used: held as u32, pages: room as u32 }
    }

    /// From the report of a scan.
    pub(crate) fn of<T: Real>(report: &ScanReport<T>) -> Self {
        Self {
            health: report.health.bits(),
            in_view: report.in_view as u32,
            maps_updated: report.maps_updated as u32,
            pages_used: (report.pages_used + report.moving_pages_used) as u32,
            pages: (report.pages + report.moving_pages) as u32,
        }
    }
}

/// A zero, for memory without measurements.
pub(crate) const fn zero<Z: Vector>() -> Z {
    Z::ZERO
}

/// A stored scan.
#[derive(Debug, Clone, Copy)]
pub struct Scan {
    len: usize,
    beyond: usize,
    /// Index of its detector.
    pub(crate) detector: usize,
    /// Whether it updates the pose only.
    pub(crate) localising: bool,
}

impl Scan {
    /// Stores a scan in that memory, as far as there is room.
    pub(crate) fn received<K: Kind<Measurement = [f64; D]>, Z: Vector, const D: usize>(
        measurements: Measurements<'_, K>,
        slots: &mut [Z],
    ) -> Self {
        let (detector, localising) = (usize::from(measurements.detector().get()), measurements.localising());
        let mut scan = Self { len: 0, beyond: 0, detector, localising };
        let mut slots = slots.iter_mut();
        for measurement in measurements {
            match slots.next() {
                Some(slot) => {
                    *slot = Vector::with(|k| Z::Scalar::from_f64(measurement.get(k).copied().unwrap_or(0.0)));
                    scan.len += 1;
                }
                None => scan.beyond += 1,
            }
        }
        scan
    }

    /// Whether it is of the first detector, and updates the map.
    pub(crate) fn is_plain(self) -> bool {
        self.detector == 0 && !self.localising
    }

    /// The measurements in that memory.
    pub(crate) fn of<Z>(self, held: &[Z]) -> Result<&[Z], ScanError> {
        if self.beyond > 0 {
            return Err(ScanError::TooManyMeasurements { measurements: self.measurements(), capacity: held.len() });
        }
        Ok(held.get(..self.len).unwrap_or(&[]))
    }

    /// Number of measurements.
    #[must_use]
    pub fn measurements(&self) -> usize {
        self.len + self.beyond
    }
}

/// Capacities that bound the work of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capacities {
    /// Candidates that are weighted, N·M.
    pub candidates: usize,
    /// Maps that are updated, N.
    pub particles: usize,
    /// Components of one map.
    pub components: usize,
    /// Components of all maps together.
    pub components_in_all: usize,
    /// Measurements of a scan.
    pub measurements: usize,
}

/// Memory for one purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RamPart {
    /// Its purpose.
    pub name: &'static str,
    /// Number of bytes.
    pub bytes: usize,
}

/// Number of bytes of the memory by purpose.
pub(crate) struct Ram {
    /// The whole memory.
    pub(crate) total: usize,
    /// The filter's state in it, with the working memory of its detector.
    pub(crate) state: usize,
    pub(crate) particles: usize,
    pub(crate) pages: usize,
    pub(crate) moving_pages: usize,
    pub(crate) scratch: usize,
}

impl Ram {
    /// Of a joint map, whose memory has this size in all, and that of its filter.
    pub(crate) const fn of_joint(total: usize, state: usize) -> Self {
        Self { total, state, particles: 0, pages: 0, moving_pages: 0, scratch: 0 }
    }

    pub(crate) const fn parts(&self) -> [RamPart; 6] {
        let named = self.particles + self.pages + self.moving_pages + self.scratch;
        [
            RamPart { name: "particles", bytes: self.particles },
            RamPart { name: "pages", bytes: self.pages },
            RamPart { name: "moving pages", bytes: self.moving_pages },
            RamPart { name: "scratch", bytes: self.scratch },
            RamPart { name: "other", bytes: self.state - named },
            RamPart { name: "in and out", bytes: self.total - self.state },
        ]
    }
}

/// The result of a prediction. Implausible predictions are left out, which the health of the next scan shows.
pub(crate) fn moved(outcome: Result<PredictReport, PredictError>) -> Result<(), Refusal> {
    match outcome {
        Ok(_) | Err(PredictError::Implausible(_)) => Ok(()),
        Err(refusal) => Err(Refusal::Predict(refusal)),
    }
}
