//! The filter that processes a stream, generic over the vehicle.

use crate::header::{self, Header, Moving};
use crate::kind::Kind;
use crate::numbers::Numbers;
use crate::record::{Measurements, Record};
use crate::snapshot::Snapshot;
use core::fmt;
use core::marker::PhantomData;
use scphd::diagnostics::Probe;
use scphd::errors::{ConfigError, LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use scphd::models::{ConstantVelocity, MeasurementModel, ModelError, Motion, Pose, PositionOf};
use scphd::numerics::Vector;
use scphd::settings::{Extraction, Informed, MovingConfig, Proposal};
use scphd::snapshot::{RestoreError, SaveError};
use scphd::storage::ScanRoom;
use scphd::{Births, Component, Config, Detector, DetectorMemory, PredictReport, Real, ScPhd, ScanReport};

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
    fn start<'m>(header: &Header<Self::Kind>, memory: &'m mut Self::Memory) -> Result<Self::Filter<'m>, Refusal>
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

/// Converts inputs of a stream to controls of a motion model, with their duration, s.
pub trait Helm<T, I, C> {
    /// Whether it has a state, which a snapshot must contain.
    const HAS_STATE: bool = false;

    /// Converts an input; `None` if no time has passed.
    ///
    /// # Errors
    /// The input is invalid; the state is unchanged.
    fn control(&mut self, input: &I) -> Result<Option<(C, T)>, PredictError>;

    /// Saves its state, if it has one.
    ///
    /// # Errors
    /// The error of the sink, or the state is damaged.
    fn save<E>(&self, _kind: u32, _sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        Ok(0)
    }

    /// Restores the saved state.
    ///
    /// # Errors
    /// The bytes are not its state, or it has none.
    fn restore<E>(
        &mut self,
        _kind: u32,
        _source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        Err(RestoreError::Content)
    }
}

/// All memory of a filter on board: its state, the working memory of its detector, a received scan, and an estimated map.
#[derive(Debug)]
pub struct Memory<S, D: Vector, Z: Vector, const MEASUREMENTS: usize, const FEATURES: usize> {
    pub(crate) state: S,
    pub(crate) scratch: DetectorMemory<Z, MEASUREMENTS>,
    pub(crate) measurements: [Z; MEASUREMENTS],
    pub(crate) features: [Component<D>; FEATURES],
}

impl<S, D: Vector, Z: Vector, const MEASUREMENTS: usize, const FEATURES: usize>
    Memory<S, D, Z, MEASUREMENTS, FEATURES>
{
    /// Memory with this state, and without data.
    pub(crate) const fn with(state: S) -> Self {
        Self {
            state,
            scratch: DetectorMemory::new(),
            measurements: [Z::ZERO; MEASUREMENTS],
            features: [Component::ZERO; FEATURES],
        }
    }
}

/// A filter for streams of kind `G`, with memory for its inputs and outputs, and the conversion of its inputs.
#[derive(Debug)]
pub struct Onboard<'m, G, N, M: Motion, X: MeasurementModel> {
    pub(crate) filter: ScPhd<'m, M>,
    pub(crate) detector: Detector<X, ScanRoom<'m, X::Measurement>>,
    pub(crate) helm: N,
    pub(crate) kind: PhantomData<G>,
    pub(crate) measurements: &'m mut [X::Measurement],
    pub(crate) features: &'m mut [Component<PositionOf<M::Pose>>],
}

impl<G, T, N, M, X, const Z: usize, const K: usize> Filter<G> for Onboard<'_, G, N, M, X>
where
    G: Kind<Measurement = [f64; Z], Pose = [f64; K]>,
    T: Real,
    N: Helm<T, G::Input, M::Control>,
    M: Motion<Pose: Pose<Scalar = T>>,
    X: MeasurementModel<Pose = M::Pose>,
{
    fn predict(&mut self, input: &G::Input) -> Result<(), Refusal> {
        if let Some((control, dt)) = self.helm.control(input).map_err(Refusal::Predict)? {
            moved(self.filter.predict(&control, dt))?;
        }
        Ok(())
    }

    fn receive(&mut self, measurements: Measurements<'_, G>) -> Scan {
        const { assert!(X::Measurement::DIMENSION == Z, "the sensor must measure what the stream holds") };
        Scan::received(measurements, self.measurements)
    }

    fn scan_with(&mut self, scan: Scan, probe: &mut impl Probe) -> Result<Seen, Refusal> {
        if !scan.is_plain() {
            return Err(Refusal::NotAboard);
        }
        let measurements = scan.of(self.measurements).map_err(Refusal::Scan)?;
        let report = self.filter.scan_with(&mut self.detector, measurements, probe).map_err(Refusal::Scan)?;
        Ok(Seen::of(&report))
    }

    fn estimate(&mut self) -> ([f64; K], usize) {
        let pose = self.filter.estimate_pose().map_or(M::Pose::ZERO, |pose| pose.mean).coordinates();
        let map = self.filter.estimate_map(&self.detector, self.features);
        (core::array::from_fn(|k| pose.at(k).to_f64()), map.features)
    }

    fn estimate_pose(&self) -> ([f64; K], G::Covariance) {
        let Some(pose) = self.filter.estimate_pose() else { return ([0.0; K], G::Covariance::ZERO) };
        let mean = pose.mean.coordinates();
        (core::array::from_fn(|k| mean.at(k).to_f64()), lower::<G, _>(pose.covariance.as_lower()))
    }

    fn digest(&self) -> u64 {
        self.filter.digest()
    }
}

/// The lower triangle of a covariance.
pub(crate) fn lower<K: Kind, T: Real>(numbers: &[T]) -> K::Covariance {
    let mut lower = K::Covariance::ZERO;
    lower.as_mut().iter_mut().zip(numbers).for_each(|(slot, number)| *slot = number.to_f64());
    lower
}

/// Errors of the filter on board: why it refused the header or a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refusal {
    /// A parameter of a model is out of range.
    Model(ModelError),
    /// The configuration is out of range or does not fit the memory.
    Setup(SetupError),
    /// The initial pose is out of range.
    Reset(ResetError),
    /// A prediction was refused.
    Predict(PredictError),
    /// A scan was refused.
    Scan(ScanError),
    /// A measurement of the pose was refused.
    Observe(ObserveError),
    /// A map was refused.
    Map(LoadMapError),
    /// A snapshot, or a header among the records, cannot be used.
    Unusable {
        /// The reason, as a text: with the details of the error, images without a black box would be two kilobytes larger.
        why: &'static str,
    },
    /// The filter does not support the record, or has no such detector.
    NotAboard,
}

impl From<ModelError> for Refusal {
    fn from(error: ModelError) -> Self {
        Self::Model(error)
    }
}

impl From<SetupError> for Refusal {
    fn from(error: SetupError) -> Self {
        Self::Setup(error)
    }
}

impl From<ConfigError> for Refusal {
    fn from(error: ConfigError) -> Self {
        Self::Setup(error.into())
    }
}

impl From<ResetError> for Refusal {
    fn from(error: ResetError) -> Self {
        Self::Reset(error)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model(error) => error.fmt(f),
            Self::Setup(error) => error.fmt(f),
            Self::Reset(error) => error.fmt(f),
            Self::Predict(error) => error.fmt(f),
            Self::Scan(error) => error.fmt(f),
            Self::Observe(error) => error.fmt(f),
            Self::Map(error) => error.fmt(f),
            Self::Unusable { why } => f.write_str(why),
            Self::NotAboard => f.write_str("this filter does not support the record, or has no such detector"),
        }
    }
}

impl core::error::Error for Refusal {}

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

/// A stored scan.
#[derive(Debug, Clone, Copy)]
pub struct Scan {
    len: usize,
    beyond: usize,
    /// Index of its detector among those beyond the first.
    pub(crate) beyond_first: Option<usize>,
    /// Whether it updates the pose only.
    pub(crate) localising: bool,
}

impl Scan {
    /// Stores a scan in that memory, as far as there is room.
    pub(crate) fn received<K: Kind<Measurement = [f64; D]>, Z: Vector, const D: usize>(
        measurements: Measurements<'_, K>,
        slots: &mut [Z],
    ) -> Self {
        let (beyond_first, localising) = (measurements.detector().beyond_first(), measurements.localising());
        let mut scan = Self { len: 0, beyond: 0, beyond_first, localising };
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
        self.beyond_first.is_none() && !self.localising
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

/// The tuning of a head.
pub(crate) fn config<K: Kind, T: Real>(header: &Header<K>) -> Config<T> {
    let Header { recursion, moving, .. } = header;
    Config {
        particles: header.particles as usize,
        samples: header.samples as usize,
        resample_threshold: T::from_f64(recursion.resample_threshold),
        prune_weight: T::from_f64(recursion.prune_weight),
        confirming_detections: T::from_f64(recursion.confirming_detections),
        unconfirmed_weight: T::from_f64(recursion.unconfirmed_weight),
        confirmed_weight: T::from_f64(recursion.confirmed_weight),
        proposal: match header.proposal {
            header::Proposal::Blind => Proposal::Blind,
            header::Proposal::Informed => Proposal::Informed(Informed {
                rounds: recursion.proposal_rounds as usize,
                sampled_fraction: T::from_f64(recursion.proposal_sampled_fraction),
                min_responsibility: T::from_f64(recursion.proposal_min_responsibility),
            }),
        },
        merge_distance: T::from_f64(recursion.merge_distance),
        extraction: match header.extraction {
            header::Extraction::Heaviest => Extraction::Heaviest,
            header::Extraction::Peaks => Extraction::Peaks,
            header::Extraction::Confirmed => Extraction::Confirmed,
        },
        extraction_weight: T::from_f64(recursion.extraction_weight),
        births_wait: header.births_wait,
        moving: moving_config(moving),
        max_components: header.max_components as usize,
        ..Config::default()
    }
}

/// The birth intensities of a head.
pub(crate) fn births<K: Kind, T: Real>(header: &Header<K>) -> Births<T> {
    Births {
        of_static: T::from_f64(header.recursion.birth_intensity),
        of_moving: T::from_f64(header.moving.birth_intensity),
    }
}

/// The tuning for moving features; without births of moving features the other numbers are not used and may be zero.
pub(crate) fn moving_config<T: Real>(moving: &Moving) -> MovingConfig<T> {
    if moving.birth_intensity == 0.0 {
        return MovingConfig::walkers();
    }
    MovingConfig {
        velocity_sigma_mps: T::from_f64(moving.velocity_sigma_mps),
        motion: ConstantVelocity {
            acceleration_psd: T::from_f64(moving.acceleration_psd),
            lifetime_s: T::from_f64(moving.lifetime_s),
        },
        spread_max_m: T::from_f64(moving.spread_max_m),
        extraction_weight: T::from_f64(moving.extraction_weight),
    }
}
