//! The joint map on board, for all vehicles.

use crate::header::{Header, Moving};
use crate::kind::Kind;
use crate::numbers::Numbers;
use crate::onboard::{Capacities, Filter, Helm, Ram, RamPart, Refusal, Scan, Seen, lower, moved, moving_config};
use crate::record::Measurements;
use core::marker::PhantomData;
use scphd::diagnostics::{Probe, Stage};
use scphd::errors::SetupError;
use scphd::models::{MeasurementModel, Motion, Pose, ScalarOf};
use scphd::numerics::Vector;
use scphd::storage::{JointMovers, Movers, NoMovers, Tracked};
use scphd::{Detector, JointReport, JointSlam, Real};

/// Capacity for moving-object tracks of a joint map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tracks<const CAPACITY: usize>;

/// Moving-object tracks of a joint map on board: [`Tracks`], or [`NoMovers`] without any, which links no code for them.
pub trait OptionalTracks<P: Pose> {
    /// Their memory.
    type Memory;
    /// The tracks in that memory.
    type Movers<'m>: Movers<P>
    where
        P: 'm;

    /// New memory, all zero.
    const MEMORY: Self::Memory;

    /// Adds them to the map, with the settings in the header of a stream.
    ///
    /// # Errors
    /// A number of the header is out of range.
    fn add_tracks<'m, M: Motion<Pose = P>, Z: Vector<Scalar = ScalarOf<P>>>(
        map: JointSlam<'m, M, Z>,
        memory: &'m mut Self::Memory,
        moving: &Moving,
    ) -> Result<JointMap<'m, M, Z, Self::Movers<'m>>, SetupError>;
}

/// A joint map with movers `V`.
pub(crate) type JointMap<'m, M, Z, V> = JointSlam<'m, M, Z, scphd::storage::NoArchive, V>;

impl<P: Pose> OptionalTracks<P> for NoMovers {
    type Memory = ();
    type Movers<'m>
        = NoMovers
    where
        P: 'm;

    const MEMORY: () = ();

    fn add_tracks<'m, M: Motion<Pose = P>, Z: Vector<Scalar = ScalarOf<P>>>(
        map: JointSlam<'m, M, Z>,
        (): &'m mut (),
        _moving: &Moving,
    ) -> Result<JointMap<'m, M, Z, NoMovers>, SetupError> {
        Ok(map)
    }
}

impl<P: Pose, const CAPACITY: usize> OptionalTracks<P> for Tracks<CAPACITY> {
    type Memory = JointMovers<P, CAPACITY>;
    type Movers<'m>
        = Tracked<'m, P>
    where
        P: 'm;

    const MEMORY: JointMovers<P, CAPACITY> = JointMovers::new();

    fn add_tracks<'m, M: Motion<Pose = P>, Z: Vector<Scalar = ScalarOf<P>>>(
        map: JointSlam<'m, M, Z>,
        memory: &'m mut JointMovers<P, CAPACITY>,
        moving: &Moving,
    ) -> Result<JointMap<'m, M, Z, Tracked<'m, P>>, SetupError> {
        map.with_movers(memory, moving_config(moving))
    }
}

/// All memory of a joint map on board: state, tracks, and the received scan.
#[derive(Debug)]
pub struct JointMemory<S, V, Z, const MEASUREMENTS: usize> {
    pub(crate) state: S,
    pub(crate) movers: V,
    pub(crate) measurements: [Z; MEASUREMENTS],
}

impl<S, V, Z: Vector, const MEASUREMENTS: usize> JointMemory<S, V, Z, MEASUREMENTS> {
    /// RAM by part.
    pub(crate) const RAM_PARTS: [RamPart; 6] = Ram {
        total: size_of::<Self>(),
        state: size_of::<S>() + size_of::<V>(),
        particles: 0,
        pages: 0,
        moving_pages: size_of::<V>(),
        scratch: 0,
    }
    .parts();

    /// Memory with this state and these tracks, without a scan.
    pub(crate) const fn with(state: S, movers: V) -> Self {
        Self { state, movers, measurements: [Z::ZERO; MEASUREMENTS] }
    }
}

/// The capacities that bound the work of a scan.
pub(crate) const fn capacities(features: usize, measurements: usize) -> Capacities {
    Capacities { candidates: 1, particles: 1, components: features, components_in_all: features, measurements }
}

/// A joint map for streams of kind `G`, with the memory of received measurements and the conversion of controls.
#[derive(Debug)]
pub struct OnboardJoint<'m, G, N, M: Motion, X: MeasurementModel, V = NoMovers> {
    pub(crate) filter: JointMap<'m, M, X::Measurement, V>,
    pub(crate) detector: Detector<X>,
    pub(crate) helm: N,
    pub(crate) kind: PhantomData<G>,
    pub(crate) measurements: &'m mut [X::Measurement],
    /// Capacity for features.
    pub(crate) room: usize,
}

impl<'m, G, N, T, M, X, V> OnboardJoint<'m, G, N, M, X, V>
where
    T: Real,
    M: Motion<Pose: Pose<Scalar = T>>,
    X: MeasurementModel<Pose = M::Pose>,
    V: Movers<M::Pose>,
{
    /// The map with the tracks that the header asks for, at its initial pose.
    pub(crate) fn start<K: Kind, B: OptionalTracks<M::Pose, Movers<'m> = V>>(
        map: JointSlam<'m, M, X::Measurement>,
        (movers, header): (&'m mut B::Memory, &Header<K>),
        (detector, helm): (Detector<X>, N),
        (measurements, room): (&'m mut [X::Measurement], usize),
        start: M::Pose,
    ) -> Result<Self, Refusal> {
        let mut filter = B::add_tracks(map, movers, &header.moving)?;
        filter.reset(start)?;
        Ok(Self { filter, detector, helm, kind: PhantomData, measurements, room })
    }

    /// The results of a scan.
    pub(crate) fn seen(&self, report: &JointReport<T>) -> Seen {
        Seen {
            health: report.health.bits(),
            in_view: report.in_view as u32,
            maps_updated: 1,
            pages_used: self.filter.held() as u32,
            pages: self.room as u32,
        }
    }
}

impl<G, T, N, M, X, V, const Z: usize, const K: usize> Filter<G> for OnboardJoint<'_, G, N, M, X, V>
where
    G: Kind<Measurement = [f64; Z], Pose = [f64; K]>,
    T: Real,
    N: Helm<T, G::Input, M::Control>,
    M: Motion<Pose: Pose<Scalar = T>>,
    X: MeasurementModel<Pose = M::Pose>,
    V: Movers<M::Pose>,
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
        // A joint map has only one stage.
        probe.enter(Stage::Update);
        let report = self.filter.scan(&self.detector, measurements);
        probe.leave(Stage::Update);
        Ok(self.seen(&report.map_err(Refusal::Scan)?))
    }

    fn estimate(&mut self) -> ([f64; K], usize) {
        let pose = self.filter.estimate_pose().map_or(M::Pose::ZERO, |pose| pose.mean).coordinates();
        (core::array::from_fn(|k| pose.at(k).to_f64()), self.filter.features().count())
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
