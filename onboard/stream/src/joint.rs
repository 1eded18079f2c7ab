//! The joint map on board, for all vehicles.

use crate::black_box::Observes;
use crate::header::Header;
use crate::kind::Kind;
use crate::numbers::Numbers;
use crate::onboard::{Capacities, Filter, Helm, Ram, RamPart, Refusal, Scan, Seen, lower, moved, moving_config};
use crate::record::Measurements;
use core::marker::PhantomData;
use scphd::diagnostics::{Probe, Stage};
use scphd::errors::SetupError;
use scphd::models::{Fix, MeasurementModel, Motion, Pose, ScalarOf};
use scphd::numerics::Vector;
use scphd::storage::{Archived, JointArchive, JointFilter, JointHypotheses, JointMovers, NoArchive, NoMovers, Tracked};
use scphd::{Detector, JointReport, JointSlam, MultiHypothesisSlam, Real};

/// Optional parts of a joint map on board: [`NoMovers`], [`Tracks`], [`Archive`] or [`Hypotheses`]. No code is linked for omitted
/// parts.
pub trait OptionalParts<M: Motion + 'static, Z: Vector<Scalar = ScalarOf<M::Pose>> + 'static> {
    /// Their memory.
    type Memory;
    /// The filter with these parts.
    type Filter<'m>: JointFilter<Motion = M>;

    /// New memory, all zero.
    const MEMORY: Self::Memory;

    /// Adds them to the map, with the settings in the header of a stream.
    ///
    /// # Errors
    /// A number of the header is out of range.
    fn add_to<'m, K: Kind>(
        map: JointSlam<'m, M, Z>,
        memory: &'m mut Self::Memory,
        header: &Header<K>,
    ) -> Result<Self::Filter<'m>, SetupError>;
}

impl<M: Motion + 'static, Z: Vector<Scalar = ScalarOf<M::Pose>> + 'static> OptionalParts<M, Z> for NoMovers {
    type Memory = ();
    type Filter<'m> = JointSlam<'m, M, Z>;

    const MEMORY: () = ();

    fn add_to<'m, K: Kind>(
        map: JointSlam<'m, M, Z>,
        (): &'m mut (),
        _: &Header<K>,
    ) -> Result<JointSlam<'m, M, Z>, SetupError> {
        Ok(map)
    }
}

/// Capacity for moving-object tracks of a joint map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tracks<const CAPACITY: usize>;

/// A joint map with moving-object tracks.
type WithTracks<'m, M, Z> = JointSlam<'m, M, Z, NoArchive, Tracked<'m, <M as Motion>::Pose>>;

impl<M: Motion + 'static, Z: Vector<Scalar = ScalarOf<M::Pose>> + 'static, const CAPACITY: usize> OptionalParts<M, Z>
    for Tracks<CAPACITY>
{
    type Memory = JointMovers<M::Pose, CAPACITY>;
    type Filter<'m> = WithTracks<'m, M, Z>;

    const MEMORY: JointMovers<M::Pose, CAPACITY> = JointMovers::new();

    fn add_to<'m, K: Kind>(
        map: JointSlam<'m, M, Z>,
        memory: &'m mut Self::Memory,
        header: &Header<K>,
    ) -> Result<WithTracks<'m, M, Z>, SetupError> {
        map.with_movers(memory, moving_config(&header.moving))
    }
}

/// Capacities of an archive of distant features, and for moving-object tracks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Archive<const ARCHIVED: usize, const TRACKS: usize>;

/// A joint map with an archive and moving-object tracks.
type WithArchive<'m, M, Z> = JointSlam<'m, M, Z, Archived<'m, <M as Motion>::Pose>, Tracked<'m, <M as Motion>::Pose>>;

impl<M: Motion + 'static, Z: Vector<Scalar = ScalarOf<M::Pose>> + 'static, const ARCHIVED: usize, const TRACKS: usize>
    OptionalParts<M, Z> for Archive<ARCHIVED, TRACKS>
{
    type Memory = (JointArchive<M::Pose, ARCHIVED>, JointMovers<M::Pose, TRACKS>);
    type Filter<'m> = WithArchive<'m, M, Z>;

    const MEMORY: Self::Memory = (JointArchive::new(), JointMovers::new());

    fn add_to<'m, K: Kind>(
        map: JointSlam<'m, M, Z>,
        (archive, movers): &'m mut Self::Memory,
        header: &Header<K>,
    ) -> Result<WithArchive<'m, M, Z>, SetupError> {
        let reach_m = ScalarOf::<M::Pose>::from_f64(header.joint.archive_reach_m);
        map.with_archive(archive, reach_m)?.with_movers(movers, moving_config(&header.moving))
    }
}

/// Capacities of several hypotheses of data association with moving-object tracks: `OTHERS` beside the likeliest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hypotheses<
    const OTHERS: usize,
    const FEATURES: usize,
    const NUMBERS: usize,
    const MEASUREMENTS: usize,
    const TRACKS: usize,
>;

impl<
    M: Motion + 'static,
    Z: Vector<Scalar = ScalarOf<M::Pose>> + 'static,
    const OTHERS: usize,
    const FEATURES: usize,
    const NUMBERS: usize,
    const MEASUREMENTS: usize,
    const TRACKS: usize,
> OptionalParts<M, Z> for Hypotheses<OTHERS, FEATURES, NUMBERS, MEASUREMENTS, TRACKS>
{
    type Memory =
        (JointMovers<M::Pose, TRACKS>, JointHypotheses<M::Pose, OTHERS, FEATURES, NUMBERS, MEASUREMENTS, TRACKS>);
    type Filter<'m> = MultiHypothesisSlam<'m, M, Z, Tracked<'m, M::Pose>, OTHERS>;

    const MEMORY: Self::Memory = (JointMovers::new(), JointHypotheses::new());

    fn add_to<'m, K: Kind>(
        map: JointSlam<'m, M, Z>,
        (movers, hypotheses): &'m mut Self::Memory,
        header: &Header<K>,
    ) -> Result<Self::Filter<'m>, SetupError> {
        let map = map.with_movers(movers, moving_config(&header.moving))?;
        map.with_hypotheses(hypotheses, header.joint.hypotheses())
    }
}

/// All memory of a joint map on board: state, optional parts, and the received scan.
#[derive(Debug)]
pub struct JointMemory<S, V, Z, const MEASUREMENTS: usize> {
    pub(crate) state: S,
    pub(crate) parts: V,
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

    /// Memory with this state and these parts, without a scan.
    pub(crate) const fn with(state: S, parts: V) -> Self {
        Self { state, parts, measurements: [Z::ZERO; MEASUREMENTS] }
    }
}

/// A joint map that processes fixes.
pub(crate) struct Fixed<'f, F>(pub(crate) &'f mut F);

impl<F: JointFilter> Observes<<F::Motion as Motion>::Pose> for Fixed<'_, F> {
    fn take<X: Fix<Pose = <F::Motion as Motion>::Pose>>(
        &mut self,
        fix: &X,
        measured: &X::Measurement,
    ) -> Result<(), Refusal> {
        self.0.observe(fix, measured).map(drop).map_err(Refusal::Observe)
    }
}

/// The capacities that bound the work of a scan.
pub(crate) const fn capacities(features: usize, measurements: usize) -> Capacities {
    Capacities { candidates: 1, particles: 1, components: features, components_in_all: features, measurements }
}

/// A joint map for streams of kind `G`, with the memory of received measurements and the conversion of controls.
#[derive(Debug)]
pub struct OnboardJoint<'m, G, N, F, X: MeasurementModel> {
    pub(crate) filter: F,
    pub(crate) detector: Detector<X>,
    pub(crate) helm: N,
    pub(crate) kind: PhantomData<G>,
    pub(crate) measurements: &'m mut [X::Measurement],
    /// Capacity for features.
    pub(crate) room: usize,
}

impl<'m, G, N, T, M, X, F> OnboardJoint<'m, G, N, F, X>
where
    T: Real,
    M: Motion<Pose: Pose<Scalar = T>> + 'static,
    X: MeasurementModel<Pose = M::Pose, Measurement: 'static>,
    F: JointFilter<Motion = M>,
{
    /// The map with its optional parts, at the initial pose of the header.
    pub(crate) fn start<K: Kind, B: OptionalParts<M, X::Measurement, Filter<'m> = F>>(
        map: JointSlam<'m, M, X::Measurement>,
        (parts, header): (&'m mut B::Memory, &Header<K>),
        (detector, helm): (Detector<X>, N),
        (measurements, room): (&'m mut [X::Measurement], usize),
        start: M::Pose,
    ) -> Result<Self, Refusal> {
        let mut filter = B::add_to(map, parts, header)?;
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

impl<G, T, N, M, X, F, const Z: usize, const K: usize> Filter<G> for OnboardJoint<'_, G, N, F, X>
where
    G: Kind<Measurement = [f64; Z], Pose = [f64; K]>,
    T: Real,
    N: Helm<T, G::Input, M::Control>,
    M: Motion<Pose: Pose<Scalar = T>> + 'static,
    X: MeasurementModel<Pose = M::Pose, Measurement: 'static>,
    F: JointFilter<Motion = M>,
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
