//! The filter: models and tuning over a state.

use crate::filter::state::Memory;
use crate::particles::candidate::Candidate;
use crate::particles::predict::{predict, predict_gaussians};
use crate::report::watch::Watch;
use crate::{
    Births, Component, Config, Detector, Draft, Dynamic, Executor, LoadMapError, MapStorage, MeasurementModel,
    ModelError, Motion, Noise, PAGE_LEN, Pose, PositionOf, PredictError, PredictReport, Probe, Proposal, Real,
    ResetError, ScalarOf, ScanError, ScanReport, ScanRoom, Sensor, Serial, SetupError, Stage, State, Static, Symmetric,
};

/// The single-cluster PHD SLAM filter.
///
/// Holds the vehicle's motion and the tuning, and borrows a [`State`], which may be of any capacity. Its sensors are
/// [detectors](Detector), given with every scan. A scan is read from top to bottom in [`ScPhd::scan`]: weigh, normalise, select,
/// update, reduce.
///
/// `M` is the motion.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{
///     ControlNoise, PlanarPose, RangeBearing, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl,
///     UniformClutter,
/// };
/// use scphd::storage::{MapMemory, Static};
/// use scphd::{Births, Config, Detector, DetectorMemory, ScPhd, State};
///
/// // On a vehicle these are statics; here the test owns them.
/// // 16 particles of one sample each; 64 pages of static features, 8 to a map, 128 in view.
/// type Memory = State<PlanarPose<f32>, 16, 16, MapMemory<Static<Vector2<f32>>, 16, 64, 8, 128>>;
/// let mut state = Box::new(Memory::new());
/// // Scans of up to 32 measurements.
/// let mut scratch = DetectorMemory::<Vector2<f32>, 32>::new();
///
/// let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// let sensing = Sensing {
///     sensor: RangeBearing::new(0.2, 0.02)?,
///     field_of_view: window,
///     clutter: UniformClutter::of_scan(2.0, window.measure())?,
/// };
/// let mut lidar = Detector::new(sensing, Births::of_static(0.01))?.over(&mut scratch)?;
///
/// let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02))?;
/// let config = Config { particles: 16, ..Config::default() };
/// let mut filter = ScPhd::new(motion, config, &mut *state)?;
/// filter.reset(PlanarPose::new(0.0, 0.0, 0.0), 1)?;
///
/// for step in 0..20 {
///     filter.predict(&UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 }, 0.1)?;
///     // One landmark, 5 m to the left of the start.
///     let (along, left) = (0.1 * (step + 1) as f32, 5.0_f32);
///     let seen = Vector2::new(along.hypot(left), left.atan2(-along));
///     let report = filter.scan(&mut lidar, &[seen])?;
///     assert!(report.health.is_good(), "{:?}", report.health);
/// }
/// let pose = filter.estimate_pose().unwrap();
/// assert!((pose.mean.x_m - 2.0).abs() < 0.3);
/// let mut features = [scphd::Component::ZERO; 4];
/// let map = filter.estimate_map(&lidar, &mut features);
/// assert_eq!(map.features, 1);
/// assert!((features[0].mean.y - 5.0).abs() < 0.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ScPhd<'s, M: Motion> {
    pub(crate) motion: M,
    pub(crate) config: Config<ScalarOf<M::Pose>>,
    pub(crate) memory: Memory<'s, M::Pose>,
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'s, M> {
    /// The greatest label of a loaded feature: as many again are left for features that are born.
    pub const GREATEST_LOADED_LABEL: u32 = u32::MAX / 2;

    /// A filter over a state, which keeps what it holds: a fresh state must be [reset](Self::reset) first, one that a
    /// filter worked on before goes on from there, which takes the configuration to have as many particles, and between a
    /// prediction and its scan as many samples. Where it has others, [`State::clear`] comes first.
    ///
    /// # Errors
    /// The motion or the configuration is out of range, or does not fit the state or what that holds.
    pub fn new<const PARTICLES: usize, const CANDIDATES: usize, SM, VM, const WAITING: usize>(
        motion: M,
        config: Config<T>,
        state: &'s mut State<M::Pose, PARTICLES, CANDIDATES, SM, VM, WAITING>,
    ) -> Result<Self, SetupError>
    where
        SM: MapStorage<Static<PositionOf<M::Pose>>>,
        VM: MapStorage<Dynamic<PositionOf<M::Pose>>>,
    {
        let mut filter = Self::reborrow(motion, config, state)?;
        filter.audit().map_err(SetupError::HeldDamaged)?;
        Ok(filter)
    }

    /// Another filter over a state that one of this motion and configuration has just worked on: [`new`](Self::new) without looking the
    /// maps over, so that it takes no longer the more they hold. For a program that keeps the state, and borrows a filter for every step.
    ///
    /// ```
    /// # use nalgebra::Vector2;
    /// # use scphd::errors::SetupError;
    /// # use scphd::models::{ControlNoise, PlanarPose, Step, Unicycle, UnicycleControl};
    /// # use scphd::storage::{MapMemory, Static};
    /// # use scphd::{Config, ScPhd, State};
    /// type Memory = State<PlanarPose<f32>, 16, 16, MapMemory<Static<Vector2<f32>>, 16, 64, 8, 128>>;
    /// struct Vehicle { motion: Unicycle<f32>, config: Config<f32>, state: Box<Memory> }
    ///
    /// impl Vehicle {
    ///     fn filter(&mut self) -> Result<ScPhd<'_, Unicycle<f32>>, SetupError> {
    ///         ScPhd::reborrow(self.motion, self.config, &mut self.state)
    ///     }
    /// }
    ///
    /// # let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02))?;
    /// # let config = Config { particles: 16, ..Config::default() };
    /// # let mut vehicle = Vehicle { motion, config, state: Box::new(Memory::new()) };
    /// vehicle.filter()?.reset(PlanarPose::new(0.0, 0.0, 0.0), 1)?;
    /// vehicle.filter()?.predict(&UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 }, 0.1)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The motion or the configuration is out of range, or does not fit the state or what that holds. A damaged state is not told from a
    /// sound one: `new` and [`audit`](Self::audit) tell.
    pub fn reborrow<const PARTICLES: usize, const CANDIDATES: usize, SM, VM, const WAITING: usize>(
        motion: M,
        config: Config<T>,
        state: &'s mut State<M::Pose, PARTICLES, CANDIDATES, SM, VM, WAITING>,
    ) -> Result<Self, SetupError>
    where
        SM: MapStorage<Static<PositionOf<M::Pose>>>,
        VM: MapStorage<Dynamic<PositionOf<M::Pose>>>,
    {
        check_capacities(&config, PARTICLES, CANDIDATES)?;
        motion.check()?;
        let memory = state.memory();
        memory.check_held(&config)?;
        Ok(Self { motion, config, memory })
    }

    /// Whether this detector can serve this filter, so that a vehicle need not wait for its first scan to know.
    ///
    /// # Errors
    /// Its births move and the state has no moving maps, or its birth intensity has more components than an update has room for.
    pub fn check<X: MeasurementModel<Pose = M::Pose>, R>(&self, detector: &Detector<X, R>) -> Result<(), SetupError> {
        if !self.has_room_for(&detector.births) {
            return Err(SetupError::NoRoomForMoving);
        }
        let (sensor, capacity) = (detector.sensing.sensor(), self.memory.static_maps.workspace.capacity());
        let frame = sensor.frame(&M::Pose::ZERO);
        if (0..=capacity).all(|index| sensor.expected_birth(&frame, index).is_some()) {
            return Err(SetupError::TooManyBirths { capacity });
        }
        Ok(())
    }

    /// Whether there are maps for all that is born.
    fn has_room_for(&self, births: &Births<T>) -> bool {
        births.of_moving == T::ZERO || self.memory.moving_maps.pool.capacity() > 0
    }

    /// Starts, or starts again: every particle at `pose` with the same weight and an empty map, and the random stream
    /// of `seed`.
    ///
    /// In single precision two places a hundredth of a millimetre apart are told from each other 100 m from the origin, a millimetre 10 km from it and half
    /// a metre at the northings of a survey grid: give poses and fixes relative to a place nearby.
    ///
    /// # Errors
    /// The pose is not finite, or a coordinate above 1e8; the state is as it was.
    pub fn reset(&mut self, pose: M::Pose, seed: u64) -> Result<(), ResetError> {
        ResetError::check_pose(&pose)?;
        let Memory { cursor, pose_covariances, candidates, static_maps, moving_maps, waiting, .. } = &mut self.memory;
        cursor.particles = self.config.particles;
        cursor.children = 1;
        cursor.predicted = false;
        cursor.waited_s = T::ZERO;
        cursor.refused = 0;
        cursor.weighed = 0;
        cursor.heaviest = 0;
        cursor.next_label = 0;
        cursor.noise = Some(Noise::seeded(seed));
        cursor.watch = Watch::ZERO;
        let ln_weight = -T::from_usize(cursor.particles).ln();
        candidates.iter_mut().take(cursor.particles).for_each(|slot| *slot = Candidate::new(pose, ln_weight));
        pose_covariances.iter_mut().for_each(|pose_covariance| *pose_covariance = Symmetric::ZERO);
        static_maps.clear();
        moving_maps.clear();
        waiting.clear();
        Ok(())
    }

    /// Gives every particle this map instead of its own static one: a surveyed map to start from, or the objects a tracker is to
    /// take over. All particles share its pages. Labels are kept; of several components with one label the first keeps it, and
    /// the others get fresh ones. Neighbours should stand next to each other, so that a page spans little.
    ///
    /// # Errors
    /// A component is not finite, beyond 1e8 m or heavier than a million features, its covariance not positive definite, or its
    /// label too great; or the map does not fit. The state is as it was.
    pub fn load_map(&mut self, components: &[Component<PositionOf<M::Pose>>]) -> Result<(), LoadMapError> {
        let Memory { cursor, static_maps, waiting, .. } = &mut self.memory;
        let (maps, pool) = (&mut static_maps.table, &mut static_maps.pool);
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
        if let Some(index) = components.iter().position(|component| component.label > Self::GREATEST_LOADED_LABEL) {
            return Err(LoadMapError::Tag { index });
        }
        let greatest = components.iter().map(|component| component.label).max();
        let mut next_label = cursor.next_label.max(greatest.map_or(0, |label| label.saturating_add(1)));
        // Compares at most half as many pairs as the square of the capacity.
        let held_before = |index: usize, label| components.iter().take(index).any(|component| component.label == label);
        // What waits for the next scan is of the map before, and has its labels.
        waiting.forget();
        (0..cursor.particles).for_each(|particle| maps.release(particle, pool));
        for (place, chunk) in components.chunks(PAGE_LEN).enumerate() {
            let Some((id, page)) = pool.take() else { break };
            let mut named = [Component::ZERO; PAGE_LEN];
            for (offset, (slot, component)) in named.iter_mut().zip(chunk).enumerate() {
                *slot = *component;
                if held_before(place * PAGE_LEN + offset, component.label) {
                    slot.label = next_label;
                    next_label = next_label.wrapping_add(1);
                }
            }
            page.fill(named.iter().take(chunk.len()));
            maps.push(0, id);
        }
        (1..cursor.particles).for_each(|particle| maps.share(0, particle, pool));
        cursor.next_label = next_label;
        cursor.watch.know_below(next_label);
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
        self.check_prediction(control, dt)?;
        let Memory { cursor, pose_covariances, candidates, .. } = &mut self.memory;
        let motion = &self.motion;
        probe.enter(Stage::Predict);
        let predicted = match self.config.proposal {
            Proposal::Blind => predict(motion, self.config.samples, cursor, candidates, control, dt),
            Proposal::Informed(_) => predict_gaussians(motion, cursor, candidates, pose_covariances, control, dt),
        };
        probe.leave(Stage::Predict);
        predicted
    }

    /// Whether a prediction can be taken in; one that is refused is counted.
    pub(crate) fn check_prediction(&mut self, control: &M::Control, dt: T) -> Result<(), PredictError> {
        self.memory.clamp();
        let Memory { cursor, candidates, .. } = &mut self.memory;
        let (motion, plausible) = (&self.motion, &self.config.plausible);
        if cursor.noise.is_none() {
            return Err(PredictError::NotStarted);
        }
        let first = candidates.first().map(|candidate| &candidate.pose);
        if let Some(refusal) = plausible.refusal(motion, first, control, dt) {
            cursor.refused = cursor.refused.saturating_add(1);
            if plausible.takes_time(dt) {
                cursor.wait(dt);
            }
            return Err(refusal);
        }
        Ok(())
    }

    /// Takes in one scan of one of the vehicle's sensors: weighs every candidate, selects the particles that go on and updates
    /// their maps (4.49–4.52, 5.17–5.24).
    ///
    /// # Errors
    /// A measurement is not finite, there are more than the detector has room for, its births move and the state has no moving
    /// maps, the covariance of the sensor's noise is not positive definite, or the filter has not been reset; the state is as it was.
    pub fn scan<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        detector: &mut Detector<X, ScanRoom<'_, X::Measurement>>,
        measurements: &[X::Measurement],
    ) -> Result<ScanReport<T>, ScanError> {
        self.scan_with(detector, measurements, &mut ())
    }

    /// [`scan`](Self::scan), watched by a probe that is told where each stage begins and ends.
    ///
    /// # Errors
    /// As for `scan`.
    pub fn scan_with<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        detector: &mut Detector<X, ScanRoom<'_, X::Measurement>>,
        measurements: &[X::Measurement],
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, ScanError> {
        self.check_scan(detector, measurements)?;
        self.step::<X, false>(detector, measurements, &Serial, &mut [], probe)
    }

    /// [`scan_with`](Self::scan_with), with the candidates weighed and the maps updated by an executor: on several cores, if it has
    /// them.
    ///
    /// Both are divided into as many jobs as the [`DetectorMemory`](crate::DetectorMemory) has workers. As many maps are updated at a time as
    /// there are drafts of an [`UpdateMemory`](crate::UpdateMemory) for this kind of state; with fewer than two, `&mut []` for none, weighing
    /// alone is divided. The result does not depend on any of that.
    ///
    /// The probe is told on the calling core: what drafts are reduced is in [`Stage::Update`].
    ///
    /// # Errors
    /// As for `scan`.
    pub fn scan_on<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        detector: &mut Detector<X, ScanRoom<'_, X::Measurement>>,
        measurements: &[X::Measurement],
        executor: &impl Executor,
        drafts: &mut [Draft<'_, PositionOf<M::Pose>>],
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, ScanError> {
        self.check_scan(detector, measurements)?;
        self.step::<X, true>(detector, measurements, executor, drafts, probe)
    }

    /// Whether a scan can be taken in.
    pub(crate) fn check_scan<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        detector: &Detector<X, ScanRoom<'_, X::Measurement>>,
        measurements: &[X::Measurement],
    ) -> Result<(), ScanError> {
        self.memory.clamp();
        ScanError::check(measurements, detector.capacity())?;
        if self.has_room_for(&detector.births) { Ok(()) } else { Err(ScanError::NoRoomForMoving) }
    }

    /// Goes on with another motion, between any two steps: noise may be retuned in flight.
    ///
    /// # Errors
    /// It is out of range; the filter keeps the one it had.
    pub fn retune(&mut self, motion: M) -> Result<(), ModelError> {
        motion.check()?;
        self.motion = motion;
        Ok(())
    }

    /// Goes on with another tuning, between any two steps. Looks the whole state over, as [`new`](Self::new) does.
    ///
    /// # Errors
    /// It is out of range, or does not fit the state or what that holds, as for [`new`](Self::new); the filter keeps the one it had.
    pub fn configure(&mut self, config: Config<T>) -> Result<(), SetupError> {
        check_capacities(&config, self.memory.pose_covariances.len(), self.memory.candidates.len())?;
        self.memory.check(&config)?;
        self.config = config;
        Ok(())
    }

    /// The motion.
    #[must_use]
    pub fn motion(&self) -> &M {
        &self.motion
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
    pub fn candidates(&self) -> &[Candidate<M::Pose>] {
        self.memory.candidates()
    }
}

/// Whether a tuning is in range and its particles and candidates fit.
fn check_capacities<T: Real>(config: &Config<T>, particles: usize, candidates: usize) -> Result<(), SetupError> {
    config.check()?;
    if config.particles > particles {
        return Err(SetupError::TooManyParticles { particles: config.particles, capacity: particles });
    }
    let needed = config.particles.saturating_mul(config.samples);
    if needed > candidates {
        return Err(SetupError::TooManyCandidates { candidates: needed, capacity: candidates });
    }
    Ok(())
}
