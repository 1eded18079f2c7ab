//! The library's [`ScPhd`] with the types of a log.

use super::MEASUREMENTS;
use super::contract::{PoseAndCovariance, Refusal, ScanOutcome, Slam, left_out, no_sensor, refusal};
use super::fixes::{Fixed, Map};
use super::models::{Models, Referred, feature_of, full, measured, moving_of, pose_of};
use super::stage_times::StageTimes;
use crate::threads::Threads;
use scphd::errors::{Implausible, SetupError};
use scphd::models::{MeasurementModel, Motion, MovingOf, Pose, PositionOf, ScalarOf};
use scphd::numerics::{Noise, Place, Vector};
use scphd::storage::{Capacities, Draft, Dynamic, MapStorage, ScanRoom, Static, UpdateMemory};
use scphd::{Component, Config, DetectorMemory, Real, ScPhd, State};
use scphd_log::dimensions::{Coordinates, Covariance, Dimensions};
use scphd_reference as reference;
use scphd_reference::{Candidate, Draws};
use scphd_score::record::{MapFeature, MovingFeature, Usage};
use std::fmt::Debug;
use std::marker::PhantomData;

/// Number of jobs for weighing and updates: several for each thread, so that no thread waits long for another.
const WORKERS: usize = 16;
/// Number of survivors whose maps are updated in parallel before they are stored in order: several for each thread.
const DRAFTS: usize = 32;

/// A [`State`] of any capacities.
pub(crate) trait Room<M: Motion>: Debug {
    /// A filter that continues with this state. It is constructed anew for every step.
    fn filter(&mut self, motion: M, config: Config<ScalarOf<M::Pose>>) -> Result<ScPhd<'_, M>, SetupError>;

    /// Working memory for updates of its maps on several threads.
    fn update_memory(&self) -> Box<dyn UpdateRoom<PositionOf<M::Pose>>>;
}

/// Working memory for the update of several maps, of any capacities.
pub(crate) trait UpdateRoom<D: Place>: Debug {
    /// The drafts (updated maps that are not stored yet) in this memory.
    fn drafts(&mut self) -> Vec<Draft<'_, D>>;
}

impl<M: Capacities + Debug, const DRAFTS: usize> UpdateRoom<M::Position> for UpdateMemory<M, DRAFTS> {
    fn drafts(&mut self) -> Vec<Draft<'_, M::Position>> {
        UpdateMemory::drafts(self).into()
    }
}

impl<M: Motion<Pose: 'static>, const PARTICLES: usize, const CANDIDATES: usize, S, V> Room<M>
    for State<M::Pose, PARTICLES, CANDIDATES, S, V>
where
    S: MapStorage<Static<PositionOf<M::Pose>>> + 'static,
    V: MapStorage<Dynamic<PositionOf<M::Pose>>> + 'static,
{
    fn filter(&mut self, motion: M, config: Config<ScalarOf<M::Pose>>) -> Result<ScPhd<'_, M>, SetupError> {
        ScPhd::reborrow(motion, config, self)
    }

    fn update_memory(&self) -> Box<dyn UpdateRoom<PositionOf<M::Pose>>> {
        Box::new(UpdateMemory::<Self, DRAFTS>::new())
    }
}

/// A filter whose whole state can be read, for the comparison with the reference after every step.
pub trait Transparent<D: Dimensions, P, const N: usize, const V: usize>: Slam<D> {
    /// The present state.
    fn snapshot(&mut self) -> Result<Snapshot<P, N, V>, Refusal>;
}

/// The state of a filter in the types of the reference: poses `P`, features of `N` and moving ones of `V` numbers.
pub struct Snapshot<P, const N: usize, const V: usize> {
    /// Candidates, in order; weights sum to one.
    pub candidates: Vec<Candidate<P>>,
    /// The static map of every particle.
    pub maps: Vec<Vec<reference::Component<N>>>,
    /// The moving features of every particle, at the time of the last scan, `waited_s` ago.
    pub moving: Vec<Vec<reference::Component<V>>>,
    /// Sum of dt of the predictions since the last scan, s.
    pub waited_s: f64,
    /// The particle whose map is the estimate.
    pub heaviest: usize,
    /// ln L of the candidates that the last scan weighed.
    pub ln_likelihoods: Vec<f64>,
    /// For every particle the candidate of the last scan that it continues.
    pub survivors: Vec<usize>,
    /// A copy of the random number generator: returns the numbers that the filter will draw next.
    pub draws: Box<dyn Draws>,
}

impl<P: Debug, const N: usize, const V: usize> Debug for Snapshot<P, N, V> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Snapshot")
            .field("candidates", &self.candidates)
            .field("maps", &self.maps)
            .field("moving", &self.moving)
            .field("waited_s", &self.waited_s)
            .field("heaviest", &self.heaviest)
            .finish_non_exhaustive()
    }
}

/// The filter of a log, with its state on the heap.
struct CoreFilter<D: Dimensions, M: Motion<Pose: Fixed<D>>, X: MeasurementModel<Pose = M::Pose>> {
    models: Models<D, M, X>,
    config: Config<ScalarOf<M::Pose>>,
    state: Box<dyn Room<M>>,
    /// Working memory for every sensor.
    scratch: Vec<DetectorMemory<X::Measurement, MEASUREMENTS, WORKERS>>,
    threads: Threads,
    /// Working memory for the updates on several threads; `None` with one thread.
    updates: Option<Box<dyn UpdateRoom<PositionOf<M::Pose>>>>,
}

/// A boxed filter whose state is read in the types of the reference.
pub(crate) type Core<D, M, const N: usize, const V: usize> =
    Box<dyn Transparent<D, <<M as Motion>::Pose as Referred>::Reference, N, V>>;

/// Starts the filter of a log.
pub(crate) fn start<D, M, X, const N: usize, const V: usize>(
    models: Models<D, M, X>,
    config: Config<ScalarOf<M::Pose>>,
    state: Box<dyn Room<M>>,
    seed: u64,
) -> Result<Core<D, M, N, V>, Refusal>
where
    D: Dimensions,
    M: Motion<Pose: Referred + Fixed<D>> + Copy + Debug + 'static,
    X: MeasurementModel<Pose = M::Pose> + Copy + Debug + 'static,
{
    let start = models.start;
    let scratch = models.detectors.iter().map(|_| DetectorMemory::new()).collect();
    let mut started = CoreFilter { models, config, state, scratch, threads: Threads::default(), updates: None };
    for sensor in 0..started.scratch.len() {
        started.with(sensor, |filter, detector| filter.check(detector))?.map_err(refusal)?;
    }
    started.with(0, |filter, _| filter.reset(start, seed))?.map_err(refusal)?;
    Ok(Box::new(started))
}

impl<D: Dimensions, M: Motion<Pose: Fixed<D>> + Copy, X: MeasurementModel<Pose = M::Pose> + Copy> CoreFilter<D, M, X> {
    /// Calls `work` with one of the detectors and a filter that continues with the state.
    fn with<R>(
        &mut self,
        sensor: usize,
        work: impl FnOnce(&mut ScPhd<'_, M>, &mut scphd::Detector<X, ScanRoom<'_, X::Measurement>>) -> R,
    ) -> Result<R, Refusal> {
        let (Some(&detector), Some(scratch)) = (self.models.detectors.get(sensor), self.scratch.get_mut(sensor)) else {
            return Err(no_sensor(sensor));
        };
        let mut detector = detector.over(scratch).map_err(refusal)?;
        let mut filter = self.state.filter(self.models.motion, self.config).map_err(refusal)?;
        Ok(work(&mut filter, &mut detector))
    }
}

impl<D: Dimensions, M: Motion<Pose: Fixed<D>> + Copy, X: MeasurementModel<Pose = M::Pose> + Copy> Slam<D>
    for CoreFilter<D, M, X>
{
    fn predict(&mut self, control: D::Control, dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        let control = (self.models.control)(control);
        left_out(self.with(0, |filter, _| filter.predict(&control, ScalarOf::<M::Pose>::from_f64(dt_s)))?)
    }

    fn observe(&mut self, fix: &D::Fix) -> Result<bool, Refusal> {
        let models = self.models.fixes;
        self.with(0, |filter, _| M::Pose::observe(filter, &models, fix))?
    }

    fn relocate(&mut self, pose: &D::Pose, covariance: &Covariance<D::Pose>) -> Result<(), Refusal> {
        self.with(0, |filter, _| M::Pose::relocate(filter, Map::Kept, pose, covariance))?
    }

    fn restart(&mut self, pose: &D::Pose, covariance: &Covariance<D::Pose>) -> Result<(), Refusal> {
        self.with(0, |filter, _| M::Pose::relocate(filter, Map::Dropped, pose, covariance))?
    }

    fn scan(&mut self, sensor: usize, detections: &[D::Measurement]) -> Result<ScanOutcome, Refusal> {
        let measurements = measured::<D, X::Measurement>(detections);
        let threads = self.threads.clone();
        let mut times = StageTimes::default();
        let mut updates = self.updates.take();
        let mut drafts = updates.as_mut().map_or_else(Vec::new, |updates| updates.drafts());
        let scanned = self.with(sensor, |filter, detector| {
            filter.scan_on(detector, &measurements, &threads, &mut drafts, &mut times)
        });
        drop(drafts);
        self.updates = updates;
        let report = scanned?.map_err(refusal)?;
        Ok(ScanOutcome {
            n_eff: report.n_eff.to_f64(),
            resampled: report.resampled,
            ln_evidence: Some(report.ln_evidence.to_f64()),
            innovation: Some(report.innovation.to_f64()).filter(|&innovation| innovation > 0.0),
            usage: Usage { in_view: report.in_view, no_birth: report.no_birth, pages_used: Some(report.pages_used) },
            health: report.health,
            stages_us: Some(times.us()),
        })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance<D>, Refusal> {
        let estimate = self.with(0, |filter, _| filter.estimate_pose())?.ok_or_else(|| refusal("not started"))?;
        Ok(pose_of::<D, M::Pose>(&estimate))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature<D>>), Refusal> {
        let held = self.with(0, |filter, _| filter.map(filter.heaviest()).count())?;
        let mut features = vec![Component::<PositionOf<M::Pose>>::ZERO; held];
        let sensors = self.scratch.len();
        let mut estimate = |sensor| self.with(sensor, |filter, detector| filter.estimate_map(detector, &mut features));
        // Whether a component is confirmed depends on the detector: the one with most confirmed components is used.
        let mut most = (0, 0);
        for sensor in (0..sensors).filter(|_| sensors > 1) {
            most = most.max((estimate(sensor)?.features, sensor));
        }
        let estimate = estimate(most.1)?;
        let features = features.iter().take(estimate.features).map(feature_of);
        Ok((estimate.expected_features.to_f64(), features.collect()))
    }

    fn moving(&mut self) -> Result<Vec<MovingFeature<D>>, Refusal> {
        let held = self.with(0, |filter, _| filter.moving_map(filter.heaviest()).count())?;
        let mut features = vec![Component::<MovingOf<M::Pose>>::ZERO; held];
        let estimate = self.with(0, |filter, _| filter.estimate_moving(&mut features))?;
        let features = features.iter().take(estimate.features).map(moving_of);
        Ok(features.collect())
    }

    fn particles(&mut self) -> Result<Vec<(D::Pose, f64)>, Refusal> {
        self.with(0, |filter, _| {
            let candidates = filter.candidates().iter().map(|candidate| {
                let pose = candidate.pose.coordinates();
                (D::Pose::with(|k| pose.at(k).to_f64()), candidate.ln_weight.exp().to_f64())
            });
            candidates.collect()
        })
    }

    fn digest(&mut self) -> Option<u64> {
        self.with(0, |filter, _| filter.digest()).ok()
    }

    fn work_on(&mut self, threads: &Threads) {
        self.threads = threads.clone();
        self.updates = threads.are_several().then(|| self.state.update_memory());
    }

    fn state_bytes(&self) -> Option<u64> {
        Some((size_of_val(&*self.state) + size_of_val(&*self.scratch)) as u64)
    }
}

impl<D, M, X, const N: usize, const V: usize> Transparent<D, <M::Pose as Referred>::Reference, N, V>
    for CoreFilter<D, M, X>
where
    D: Dimensions,
    M: Motion<Pose: Referred + Fixed<D>> + Copy,
    X: MeasurementModel<Pose = M::Pose> + Copy,
{
    fn snapshot(&mut self) -> Result<Snapshot<<M::Pose as Referred>::Reference, N, V>, Refusal> {
        self.with(0, |filter, _| {
            let particles = filter.particles();
            let candidates = filter.candidates().iter().map(|candidate| Candidate {
                pose: candidate.pose.referred(),
                ln_weight: candidate.ln_weight.to_f64(),
            });
            let noise = filter.noise().cloned().ok_or_else(|| refusal("not started"))?;
            Ok(Snapshot {
                candidates: candidates.collect(),
                maps: (0..particles).map(|particle| filter.map(particle).map(of_core).collect()).collect(),
                moving: (0..particles).map(|particle| filter.moving_map(particle).map(of_core).collect()).collect(),
                waited_s: filter.waited_s().to_f64(),
                heaviest: filter.heaviest(),
                ln_likelihoods: filter.ln_likelihoods().iter().map(|ln_l| ln_l.to_f64()).collect(),
                survivors: filter.survivors().iter().map(|&survivor| usize::from(survivor)).collect(),
                draws: Box::new(Ahead::<ScalarOf<M::Pose>> { noise, scalar: PhantomData }),
            })
        })?
    }
}

fn of_core<V: Vector, const N: usize>(component: &Component<V>) -> reference::Component<N> {
    reference::Component {
        ln_weight: component.ln_weight.to_f64(),
        mean: std::array::from_fn(|k| component.mean.at(k).to_f64()),
        covariance: full(&component.covariance),
    }
}

/// A copy of a filter's random number generator, which draws the numbers that the filter will draw next.
struct Ahead<T> {
    noise: Noise,
    scalar: PhantomData<T>,
}

impl<T: Real> Draws for Ahead<T> {
    fn normal(&mut self) -> f64 {
        self.noise.normal::<T>().to_f64()
    }

    fn uniform(&mut self) -> f64 {
        self.noise.uniform::<T>().to_f64()
    }
}
