//! The mixture filter that processes all records of a black box.

use crate::error::StreamError;
use crate::header::Header;
use crate::kind::Kind;
use crate::onboard::{Filter, Helm, Onboard, Refusal, Scan, Seen, config};
use crate::record::{How, Measurements, Part, Place, Record, Which};
use crate::snapshot::Snapshot;
use crate::writer::Writer;
use core::fmt::Debug;
use scphd::diagnostics::Probe;
use scphd::errors::ScanError;
use scphd::models::{Fix, MeasurementModel, ModelError, Motion, Pose, TangentOf};
use scphd::numerics::{Symmetric, Vector};
use scphd::snapshot::{RestoreError, SaveError};
use scphd::storage::ScanRoom;
use scphd::{Component, Detector, DetectorMemory, Real, ScPhd};

/// Type id of the snapshots of this crate's filters; readers accept any.
pub(crate) const KIND: u32 = 0;

/// A filter of a black box on the host, which also writes snapshots.
pub trait Saves<K: Kind>: Filter<K> {
    /// Writes a snapshot of the present state.
    ///
    /// # Errors
    /// The error of the sink, or the state is damaged.
    fn save<E, F: FnMut(&[u8]) -> Result<(), E>>(&mut self, log: &mut Writer<K, F>) -> Result<(), SaveError<E>>;
}

/// A kind of stream whose heads and records contain all parameters of the models.
pub trait Modelled<T: Real>: Kind {
    /// The motion model of the mixture.
    type Motion: Motion<Pose: Pose<Scalar = T>>;
    /// The conversion of inputs to controls.
    type Helm: Helm<T, Self::Input, <Self::Motion as Motion>::Control> + Debug;
    /// The models of a detector.
    type Sensing: MeasurementModel<Pose = <Self::Motion as Motion>::Pose>;

    /// The motion model of a head.
    fn motion(header: &Header<Self>) -> Result<Self::Motion, ModelError>;

    /// Updates the conversion of inputs with a head.
    fn steer(helm: &mut Self::Helm, header: &Header<Self>) -> Result<(), ModelError>;

    /// The first detector, which is in the head.
    fn first(header: &Header<Self>) -> Result<Detector<Self::Sensing>, Refusal>;

    /// A further detector.
    fn other(sensor: &Self::Sensor) -> Result<Detector<Self::Sensing>, Refusal>;

    /// Passes a fix to a filter.
    fn observe(filter: &mut impl Observes<<Self::Motion as Motion>::Pose>, fix: &Self::Fix) -> Result<(), Refusal>;
}

/// A filter that processes fixes.
pub trait Observes<P: Pose> {
    /// Processes a fix.
    fn take<F: Fix<Pose = P>>(&mut self, fix: &F, measured: &F::Measurement) -> Result<(), Refusal>;
}

impl<M: Motion> Observes<M::Pose> for ScPhd<'_, M> {
    fn take<F: Fix<Pose = M::Pose>>(&mut self, fix: &F, measured: &F::Measurement) -> Result<(), Refusal> {
        self.observe(fix, measured).map(drop).map_err(Refusal::Observe)
    }
}

/// Pose, covariance and seed of a record.
pub(crate) fn placed<K: Kind, T: Real, P: Pose<Scalar = T>>(place: &Place<'_, K>) -> (P, Symmetric<TangentOf<P>>, u64) {
    let (full, lower, seed) = place.get();
    let mut numbers = full.as_ref().iter();
    let pose = P::of_numbers(|| numbers.next().map_or(T::ZERO, |&number| T::from_f64(number)));
    let covariance = Symmetric::from_fn(|row, column| {
        let (row, column) = (row.max(column), row.min(column));
        lower.as_ref().get(row * (row + 1) / 2 + column).map_or(T::ZERO, |&number| T::from_f64(number))
    });
    (pose, covariance, seed)
}

/// Copies the features of a map into `slots`. Returns their number.
pub(crate) fn loaded<T: Real, D: Vector<Scalar = T>, N: AsRef<[f64]>>(
    features: impl ExactSizeIterator<Item = N>,
    slots: &mut [Component<D>],
) -> Result<usize, Refusal> {
    let count = features.len();
    if count > slots.len() {
        let (components, capacity) = (count, slots.len());
        return Err(Refusal::Map(scphd::errors::LoadMapError::TooManyComponents { components, capacity }));
    }
    for (slot, feature) in slots.iter_mut().zip(features) {
        let mut numbers = feature.as_ref().iter();
        let mut next = || numbers.next().copied().unwrap_or(0.0);
        let label = next() as u32;
        let mut real = || T::from_f64(next());
        let (ln_weight, mean) = (real(), D::with(|_| real()));
        *slot = Component { label, ln_weight, mean, covariance: Symmetric::from_fn(|_, _| real()) };
    }
    Ok(count)
}

/// A further detector, if there is one, or the memory for it.
#[derive(Debug)]
pub(crate) struct Other<'m, X: MeasurementModel, const MEASUREMENTS: usize> {
    room: Option<&'m mut DetectorMemory<X::Measurement, MEASUREMENTS>>,
    detector: Option<Seated<'m, X>>,
}

impl<'m, T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>, const MEASUREMENTS: usize> Other<'m, X, MEASUREMENTS> {
    pub(crate) fn in_room(room: &'m mut DetectorMemory<X::Measurement, MEASUREMENTS>) -> Self {
        Self { room: Some(room), detector: None }
    }

    /// Adds the detector, or replaces its models.
    fn set(&mut self, detector: Detector<X>) -> Result<(), Refusal> {
        if let Some(known) = &mut self.detector {
            known.adopt(detector);
        } else if let Some(room) = self.room.take() {
            self.detector = Some(detector.over(room)?);
        }
        Ok(())
    }
}

/// The mixture filter with all records of a black box: all detectors, fixes, maps, changes of models, poses set from outside, and
/// snapshots.
#[derive(Debug)]
pub struct BlackBoxFilter<'m, G: Modelled<T>, T: Real, const MEASUREMENTS: usize, const OTHERS: usize> {
    pub(crate) first: Onboard<'m, G, G::Helm, G::Motion, G::Sensing>,
    pub(crate) others: [Other<'m, G::Sensing, MEASUREMENTS>; OTHERS],
}

/// A detector with its memory.
type Seated<'m, X> = Detector<X, ScanRoom<'m, <X as MeasurementModel>::Measurement>>;

impl<'m, G: Modelled<T>, T: Real, const MEASUREMENTS: usize, const OTHERS: usize>
    BlackBoxFilter<'m, G, T, MEASUREMENTS, OTHERS>
{
    fn set(&mut self, which: Which<G>, models: &G::Sensor) -> Result<(), Refusal> {
        let slot = which.beyond_first().and_then(|place| self.others.get_mut(place)).ok_or(Refusal::NotAboard)?;
        let detector = G::other(models)?;
        self.first.filter.check(&detector)?;
        slot.set(detector)
    }

    fn place(&mut self, place: &Place<'_, G>) -> Result<(), Refusal> {
        let (pose, covariance, seed) = placed(place);
        let filter = &mut self.first.filter;
        Ok(match place.how {
            How::Reset => filter.reset(pose, seed),
            How::ResetWithin => filter.reset_within(pose, &covariance, seed),
            How::Relocate => filter.relocate(pose, &covariance),
            How::Scatter => filter.scatter(&covariance),
        }?)
    }

    /// Continues with the models and the tuning of a head.
    fn retune(&mut self, header: &Header<G>) -> Result<(), Refusal> {
        let detector = G::first(header)?;
        let filter = &mut self.first.filter;
        filter.check(&detector)?;
        filter.configure(config(header))?;
        filter.retune(G::motion(header)?)?;
        G::steer(&mut self.first.helm, header)?;
        self.first.detector.adopt(detector);
        Ok(())
    }
}

impl<'m, G, T, const MEASUREMENTS: usize, const OTHERS: usize> Filter<G>
    for BlackBoxFilter<'m, G, T, MEASUREMENTS, OTHERS>
where
    G: Modelled<T>,
    T: Real,
    Onboard<'m, G, G::Helm, G::Motion, G::Sensing>: Filter<G>,
{
    const BLACK_BOX: bool = true;

    fn predict(&mut self, input: &G::Input) -> Result<(), Refusal> {
        self.first.predict(input)
    }

    fn receive(&mut self, measurements: Measurements<'_, G>) -> Scan {
        self.first.receive(measurements)
    }

    fn scan_with(&mut self, scan: Scan, probe: &mut impl Probe) -> Result<Seen, Refusal> {
        let Some(place) = scan.beyond_first.filter(|_| !scan.localising) else {
            return self.first.scan_with(scan, probe);
        };
        let detector = self.others.get_mut(place).and_then(|other| other.detector.as_mut());
        let detector = detector.ok_or(Refusal::NotAboard)?;
        let measurements = scan.of(self.first.measurements).map_err(Refusal::Scan)?;
        let report = self.first.filter.scan_with(detector, measurements, probe).map_err(Refusal::Scan)?;
        Ok(Seen::of(&report))
    }

    #[inline(never)]
    fn take(&mut self, record: &Record<'_, G>) -> Result<(), Refusal> {
        match record {
            Record::Fix(fix) => G::observe(&mut self.first.filter, &fix.get().ok_or(Refusal::NotAboard)?),
            Record::Detector(which, models) => self.set(*which, &models.get()),
            Record::Place(place) => self.place(place),
            Record::Map(features) => {
                let count = loaded(features.clone(), self.first.features)?;
                let features = self.first.features.get(..count).unwrap_or(&[]);
                self.first.filter.load_map(features).map_err(Refusal::Map)
            }
            Record::Head(head) => self.retune(&head.decode().map_err(unreadable)?),
            Record::Predict(_) | Record::Scan(_) => Err(Refusal::NotAboard),
        }
    }

    #[inline(never)]
    fn restore(&mut self, snapshot: &Snapshot<'_, G>) -> Result<(), Refusal> {
        for (which, models) in snapshot.detectors() {
            self.set(which, &models.get())?;
        }
        if let Some(source) = snapshot.part(Part::Navigator) {
            self.first.helm.restore(snapshot.user_kind(Part::Navigator), source).map_err(unrestored)?;
        }
        let source = snapshot.part(Part::Filter).ok_or(Refusal::NotAboard)?;
        self.first.filter.restore(snapshot.user_kind(Part::Filter), source).map(drop).map_err(unrestored)
    }

    fn estimate(&mut self) -> (G::Pose, usize) {
        self.first.estimate()
    }

    fn estimate_pose(&self) -> (G::Pose, G::Covariance) {
        self.first.estimate_pose()
    }

    fn digest(&self) -> u64 {
        self.first.digest()
    }
}

impl<G, T, const MEASUREMENTS: usize, const OTHERS: usize> Saves<G> for BlackBoxFilter<'_, G, T, MEASUREMENTS, OTHERS>
where
    G: Modelled<T>,
    T: Real,
    Self: Filter<G>,
{
    fn save<E, F: FnMut(&[u8]) -> Result<(), E>>(&mut self, log: &mut Writer<G, F>) -> Result<(), SaveError<E>> {
        let parts = if G::Helm::HAS_STATE { &[Part::Filter, Part::Navigator][..] } else { &[Part::Filter] };
        log.snapshot(parts, self.digest()).map_err(SaveError::Sink)?;
        for &part in parts {
            log.save(part, |sink| match part {
                Part::Filter => self.first.filter.save(KIND, sink),
                Part::Navigator => self.first.helm.save(KIND, sink),
            })?;
        }
        Ok(())
    }
}

/// The reason for which a filter cannot be restored from a snapshot.
pub(crate) fn unrestored(error: RestoreError<StreamError>) -> Refusal {
    let why = match error {
        RestoreError::Source(_) => "a slice of the snapshot is missing or damaged",
        RestoreError::Foreign => "this is not a snapshot",
        RestoreError::Version { .. } => "the snapshot has another format version",
        RestoreError::Damaged => "the snapshot is damaged",
        RestoreError::Content => "the snapshot is of another filter, scalar, pose or measurement",
        RestoreError::Kind { .. } => "the snapshot is of another type of vehicle",
        RestoreError::NoRoom { .. } => "the snapshot does not fit the memory",
        RestoreError::Setup(_) => "the snapshot does not fit the tuning",
        RestoreError::Flawed(_) => "the snapshot is not a valid state",
        _ => "the snapshot cannot be used",
    };
    Refusal::Unusable { why }
}

/// The error of a head among the records that cannot be read.
pub(crate) fn unreadable(_error: StreamError) -> Refusal {
    Refusal::Unusable { why: "a header among the records cannot be read" }
}

impl From<ScanError> for Refusal {
    fn from(error: ScanError) -> Self {
        Self::Scan(error)
    }
}
