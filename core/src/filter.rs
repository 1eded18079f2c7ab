//! The filter: models and tuning over a state.

use crate::online::Learnt;
use crate::plausible::is_within_range;
use crate::predict::{predict, spread};
use crate::state::{Memory, State};
use crate::{
    Clutter, Component, Config, Dim, Executor, FieldOfView, LoadMapError, Locating, MapStorage, Models, Motion, Noise,
    PAGE_LEN, Packed, Pose, PredictError, PredictReport, Probe, Proposal, Real, ResetError, ScanError, ScanReport,
    Sensor, Serial, SetupError, Stage, Symmetric, Twice, candidate::Candidate,
};
use nalgebra::SVector;

/// The single-cluster PHD SLAM filter.
///
/// Holds the models and the tuning, and borrows a [`State`], which may be of any capacity. A scan is read from top to
/// bottom in [`ScPhd::scan`]: weigh, normalise, select, update, reduce.
///
/// `M` is the motion, `S` the sensor, `V` its field of view, `C` its clutter; K, D, E and Z are the dimensions of pose,
/// position, moving feature (E = 2D) and measurement.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::{
///     Config, ControlNoise, MapMemory, Models, PlanarPose, RangeBearing, RangeBearingWindow, ScPhd, State, Step,
///     Unicycle, UnicycleControl, UniformClutter,
/// };
///
/// // On a vehicle the state is a static; here the test owns it.
/// // 16 particles of one sample each, 32 measurements; 64 pages of static features, 8 to a map, 128 in view.
/// type Memory = State<f32, PlanarPose<f32>, 3, 2, 16, 16, 32, MapMemory<f32, 2, 2, 16, 64, 8, 128>>;
/// let mut state = Box::new(Memory::new());
///
/// let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// let models = Models {
///     motion: Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02))?,
///     sensor: RangeBearing::new(0.2, 0.02)?,
///     field_of_view: window,
///     clutter: UniformClutter::of_scan(2.0, window.measure())?,
/// };
/// let config = Config { particles: 16, ..Config::default() };
/// let mut filter = ScPhd::new(models, config, &mut *state)?;
/// filter.reset(PlanarPose::new(0.0, 0.0, 0.0), 1)?;
///
/// for step in 0..20 {
///     filter.predict(&UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 }, 0.1)?;
///     // One landmark, 5 m to the left of the start.
///     let (along, left) = (0.1 * (step + 1) as f32, 5.0_f32);
///     let seen = Vector2::new(along.hypot(left), left.atan2(-along));
///     let report = filter.scan(&[seen])?;
///     assert!(report.health.is_good(), "{:?}", report.health);
/// }
/// let pose = filter.estimate_pose().unwrap();
/// assert!((pose.mean.x_m - 2.0).abs() < 0.3);
/// let mut features = [scphd::Component::ZERO; 4];
/// let map = filter.estimate_map(&mut features);
/// assert_eq!(map.features, 1);
/// assert!((features[0].mean.y - 5.0).abs() < 0.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ScPhd<'s, T: Real, P, M, S, V, C, const K: usize, const D: usize, const E: usize, const Z: usize>
where
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<E>: Packed,
{
    pub(crate) models: Models<M, S, V, C>,
    pub(crate) config: Config<T>,
    pub(crate) memory: Memory<'s, T, P, K, D, E, Z>,
}

impl<'s, T, P, M, S, V, C, const K: usize, const D: usize, const E: usize, const Z: usize>
    ScPhd<'s, T, P, M, S, V, C, K, D, E, Z>
where
    T: Real,
    P: Pose<T, K>,
    M: Motion<T, K, Pose = P>,
    S: Locating<T, K, D, Z> + Sensor<T, D, Z, Pose = P>,
    V: FieldOfView<T, S::Frame, D, Z>,
    C: Clutter<T, Z>,
    Dim<K>: Packed,
    Dim<D>: Packed + Twice<E>,
    Dim<E>: Packed,
    Dim<Z>: Packed,
{
    /// The greatest tag of a loaded feature: as many again are left for features that are born.
    pub const GREATEST_LOADED_TAG: u32 = u32::MAX / 2;

    /// A filter over a state, which keeps what it holds: a fresh state must be [reset](Self::reset) first, one that a
    /// filter worked on before goes on from there, which takes the configuration to have as many particles, and between a
    /// prediction and its scan as many samples. Where it has others, [`State::clear`] comes first.
    ///
    /// # Errors
    /// A model or the configuration is out of range, or does not fit the state or what that holds.
    pub fn new<
        const PARTICLES: usize,
        const CANDIDATES: usize,
        const MEASUREMENTS: usize,
        SM,
        VM,
        const WORKERS: usize,
    >(
        models: Models<M, S, V, C>,
        config: Config<T>,
        state: &'s mut State<T, P, K, Z, PARTICLES, CANDIDATES, MEASUREMENTS, SM, VM, WORKERS>,
    ) -> Result<Self, SetupError>
    where
        SM: MapStorage<T, D, D>,
        VM: MapStorage<T, E, D>,
    {
        config.check()?;
        if config.particles > PARTICLES {
            return Err(SetupError::TooManyParticles { particles: config.particles, capacity: PARTICLES });
        }
        let candidates = config.particles.saturating_mul(config.samples);
        if candidates > CANDIDATES {
            return Err(SetupError::TooManyCandidates { candidates, capacity: CANDIDATES });
        }
        if config.moving.birth_intensity > T::ZERO && VM::PARTICLES == 0 {
            return Err(SetupError::NoRoomForMoving);
        }
        let mut memory = state.memory();
        models.check_for(memory.still.workspace.capacity())?;
        memory.check(&config)?;
        Ok(Self { models, config, memory })
    }

    /// Starts, or starts again: every particle at `pose` with the same weight and an empty map, and the random stream
    /// of `seed`.
    ///
    /// # Errors
    /// The pose is not finite, or a coordinate above 1e8; the state is as it was.
    pub fn reset(&mut self, pose: P, seed: u64) -> Result<(), ResetError> {
        if !(pose.is_finite() && is_within_range(&pose.coordinates())) {
            return Err(ResetError::NonFinitePose);
        }
        let Memory { cursor, spreads, candidates, still, moving, .. } = &mut self.memory;
        cursor.particles = self.config.particles;
        cursor.children = 1;
        cursor.predicted = false;
        cursor.waited_s = T::ZERO;
        cursor.refused = 0;
        cursor.weighed = 0;
        cursor.heaviest = 0;
        cursor.next_tag = 0;
        cursor.learnt = Learnt::ZERO;
        cursor.noise = Some(Noise::seeded(seed));
        let ln_weight = -T::from_usize(cursor.particles).ln();
        candidates.iter_mut().take(cursor.particles).for_each(|slot| *slot = Candidate { pose, ln_weight });
        spreads.iter_mut().for_each(|spread| *spread = Symmetric::ZERO);
        still.clear();
        moving.clear();
        Ok(())
    }

    /// Gives every particle this map instead of its own static one: a surveyed map to start from, or the objects a tracker is to
    /// take over. All particles share its pages. Tags are kept; of several components with one tag the first keeps it, and
    /// the others get fresh ones. Neighbours should stand next to each other, so that a page spans little.
    ///
    /// # Errors
    /// A component is not finite, beyond 1e8 m or heavier than a million features, its covariance not positive definite, or its
    /// tag too great; or the map does not fit. The state is as it was.
    pub fn load_map(&mut self, components: &[Component<T, D>]) -> Result<(), LoadMapError> {
        let Memory { cursor, still, .. } = &mut self.memory;
        let (maps, pool) = (&mut still.table, &mut still.pool);
        if cursor.particles == 0 {
            return Err(LoadMapError::NotStarted);
        }
        let capacity = maps.map_pages().min(pool.capacity()) * PAGE_LEN;
        if components.len() > capacity {
            return Err(LoadMapError::TooManyComponents { components: components.len(), capacity });
        }
        if let Some(index) = components.iter().position(|component| !component.is_usable()) {
            return Err(LoadMapError::Component { index });
        }
        if let Some(index) = components.iter().position(|component| component.tag > Self::GREATEST_LOADED_TAG) {
            return Err(LoadMapError::Tag { index });
        }
        let greatest = components.iter().map(|component| component.tag).max();
        let mut next_tag = cursor.next_tag.max(greatest.map_or(0, |tag| tag.saturating_add(1)));
        // Compares at most half as many pairs as the square of the capacity.
        let held_before = |index: usize, tag| components.iter().take(index).any(|component| component.tag == tag);
        (0..cursor.particles).for_each(|particle| maps.release(particle, pool));
        for (place, chunk) in components.chunks(PAGE_LEN).enumerate() {
            let Some((id, page)) = pool.take() else { break };
            let mut named = [Component::ZERO; PAGE_LEN];
            for (offset, (slot, component)) in named.iter_mut().zip(chunk).enumerate() {
                *slot = *component;
                if held_before(place * PAGE_LEN + offset, component.tag) {
                    slot.tag = next_tag;
                    next_tag = next_tag.wrapping_add(1);
                }
            }
            page.fill(named.iter().take(chunk.len()));
            maps.push(0, id);
        }
        (1..cursor.particles).for_each(|particle| maps.share(0, particle, pool));
        cursor.next_tag = next_tag;
        Ok(())
    }

    /// Moves the vehicle for `dt` seconds under `control`: draws M samples of every particle in the first prediction
    /// after a scan (5.12, 5.13), and moves every sample on in later ones. Static features stay where they are; moving ones
    /// are moved when the next scan comes, by all the steps at once.
    ///
    /// # Errors
    /// The control is not admissible, `dt` negative or not finite, either of them [implausible](crate::Plausible), or the
    /// filter not reset. Poses, maps and random stream are as they were. Moving features wait for the time that has passed, unless
    /// it is `dt` itself that was refused, and the next report has the refusal in its count and its health: a vehicle that
    /// misses a row of its odometry goes on without, or bridges it with a control of its own before it asks.
    pub fn predict(&mut self, control: &M::Control, dt: T) -> Result<PredictReport, PredictError> {
        self.predict_with(control, dt, &mut ())
    }

    /// [`predict`](Self::predict), watched by a probe.
    ///
    /// # Errors
    /// As for `predict`.
    pub fn predict_with(
        &mut self,
        control: &M::Control,
        dt: T,
        probe: &mut impl Probe,
    ) -> Result<PredictReport, PredictError> {
        let Memory { cursor, spreads, candidates, .. } = &mut self.memory;
        let (motion, plausible) = (&self.models.motion, &self.config.plausible);
        if cursor.noise.is_none() {
            return Err(PredictError::NotStarted);
        }
        let first = candidates.first().map(|candidate| &candidate.pose);
        if let Some(refusal) = plausible.refusal(motion, first, control, dt) {
            cursor.refused = cursor.refused.saturating_add(1);
            if plausible.takes_time(dt) {
                cursor.waited_s += dt;
            }
            return Err(refusal);
        }
        probe.enter(Stage::Predict);
        let predicted = match self.config.proposal {
            Proposal::Blind => predict(motion, self.config.samples, cursor, candidates, control, dt),
            Proposal::Informed(_) => spread(motion, cursor, candidates, spreads, control, dt),
        };
        probe.leave(Stage::Predict);
        predicted
    }

    /// Takes in one scan: weighs every candidate, selects the particles that go on and updates their maps
    /// (4.49–4.52, 5.17–5.24).
    ///
    /// # Errors
    /// A measurement is not finite, there are more than the state holds, or the filter has not been reset; the state is
    /// as it was.
    pub fn scan(&mut self, measurements: &[SVector<T, Z>]) -> Result<ScanReport<T>, ScanError> {
        self.scan_with(measurements, &mut ())
    }

    /// [`scan`](Self::scan), watched by a probe that is told where each stage begins and ends.
    ///
    /// # Errors
    /// As for `scan`.
    pub fn scan_with(
        &mut self,
        measurements: &[SVector<T, Z>],
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, ScanError> {
        self.scan_on(measurements, &Serial, probe)
    }

    /// [`scan_with`](Self::scan_with), with the candidates weighed by an executor: on several cores, if it has them.
    ///
    /// They are divided into as many jobs as the [`State`] has workers. The result does not depend on it, nor on the
    /// executor.
    ///
    /// # Errors
    /// As for `scan`.
    pub fn scan_on(
        &mut self,
        measurements: &[SVector<T, Z>],
        executor: &impl Executor,
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, ScanError> {
        ScanError::check(measurements, self.memory.measurements.len())?;
        self.step(measurements, executor, probe)
    }

    /// Goes on with other models, between any two steps: noise may be retuned in flight.
    ///
    /// # Errors
    /// A model is out of range, or its births do not fit the state; the filter keeps the models it had.
    pub fn retune(&mut self, models: Models<M, S, V, C>) -> Result<(), SetupError> {
        models.check_for(self.memory.still.workspace.capacity())?;
        self.models = models;
        Ok(())
    }

    /// The models.
    #[must_use]
    pub fn models(&self) -> &Models<M, S, V, C> {
        &self.models
    }

    /// The tuning.
    #[must_use]
    pub fn config(&self) -> &Config<T> {
        &self.config
    }

    /// The random stream as it stands; `None` before the first reset.
    #[must_use]
    pub fn noise(&self) -> Option<&Noise> {
        self.memory.cursor.noise.as_ref()
    }

    /// ln L of every candidate that the last scan weighed, in the order of the candidates before it (4.52).
    #[must_use]
    pub fn ln_likelihoods(&self) -> &[T] {
        self.memory.ln_likelihoods.get(..self.memory.cursor.weighed).unwrap_or(&[])
    }

    /// For every particle the index of the candidate of the last scan that it continues.
    #[must_use]
    pub fn survivors(&self) -> &[u16] {
        let particles = if self.memory.cursor.weighed > 0 { self.memory.cursor.particles } else { 0 };
        self.memory.survivors.get(..particles).unwrap_or(&[])
    }

    /// Particles in use: as many as configured, or as the last resampling has left.
    #[must_use]
    pub fn particles(&self) -> usize {
        self.memory.cursor.particles
    }

    /// The candidates: N particles after a scan, N·M samples after a prediction. Weights sum to one.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate<T, P>] {
        self.memory.candidates()
    }
}
