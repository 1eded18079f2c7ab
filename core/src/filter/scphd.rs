//! The single-cluster PHD filter: models and tuning, working on a borrowed state.

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
/// Owns the motion model and the tuning, and borrows a [`State`] of any capacity. Its sensors are [detectors](Detector), which are
/// passed with every scan. [`ScPhd::scan`] has the stages of a scan: weight, normalise, resample, update, reduce.
///
/// `M` is the motion model.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{ControlNoise, PlanarPose, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl};
/// use scphd::storage::{MapMemory, Static};
/// use scphd::{Births, Config, Detector, DetectorMemory, ScPhd, State};
///
/// // On a vehicle these are statics; here the test owns them.
/// // 16 particles with one sample each; 64 pages of static features, 8 per map, 128 components in view.
/// type Memory = State<PlanarPose<f32>, 16, 16, MapMemory<Static<Vector2<f32>>, 16, 64, 8, 128>>;
/// let mut state = Box::new(Memory::new());
/// // Scans of up to 32 measurements.
/// let mut scratch = DetectorMemory::<Vector2<f32>, 32>::new();
///
/// let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// let sensing = Sensing::range_bearing([0.2, 0.02], window, 2.0)?;
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
    /// The greatest label of a loaded feature: half of all labels are left for births.
    pub const GREATEST_LOADED_LABEL: u32 = u32::MAX / 2;

    /// A filter that continues with the content of `state`. A new state must be [reset](Self::reset) first. If another filter used
    /// the state before, the configuration must have the same number of particles, and between a prediction and its scan the same
    /// number of samples; otherwise call [`State::clear`] first.
    ///
    /// # Errors
    /// The motion or the configuration is out of range, or does not fit the capacities of the state or its content.
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

    /// A filter for a state that was last used with the same motion and configuration: [`new`](Self::new) without the check of the
    /// maps, whose cost grows with the maps. For a program that stores the state and borrows a filter for every step.
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
    /// The motion or the configuration is out of range, or does not fit the capacities of the state or its content. A damaged state
    /// is not detected; `new` and [`audit`](Self::audit) detect it.
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

    /// Checks that this filter can process scans of this detector, so that an error is known before the first scan.
    ///
    /// # Errors
    /// It has a birth intensity of moving features and the state has no moving maps, or its birth intensity has more components
    /// than an update has memory for.
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

    /// Whether the state has maps for all kinds of births.
    fn has_room_for(&self, births: &Births<T>) -> bool {
        births.of_moving == T::ZERO || self.memory.moving_maps.pool.capacity() > 0
    }

    /// Starts or restarts the filter: every particle is at `pose` with the same weight and an empty map, and the random stream is
    /// that of `seed`.
    ///
    /// In single precision, coordinates have a resolution of about 0.01 mm at 100 m from the origin, 1 mm at 10 km, and 0.5 m at
    /// the northings of a survey grid: give poses and fixes relative to a nearby origin.
    ///
    /// # Errors
    /// The pose is not finite, or a coordinate is above 1e8; the state is unchanged.
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
        waiting.forget();
        Ok(())
    }

    /// Replaces the static map of every particle by this map, for example a surveyed map, or objects that a tracker continues. All
    /// particles share its pages. Labels are kept; if several components have the same label, the first keeps it and the others get
    /// new ones. Sort neighbouring components together, so that each page covers a small area.
    ///
    /// # Errors
    /// A component is not finite, beyond 1e8 m, or heavier than a million features; its covariance is not positive definite; its
    /// label is too great; or the map is too large. The state is unchanged.
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
        // At most half the square of the capacity, in comparisons.
        let held_before = |index: usize, label| components.iter().take(index).any(|component| component.label == label);
        // Delayed births belong to the previous map and have its labels.
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

    /// Predicts the pose after `dt` seconds under `control`: the first prediction after a scan draws M samples of every particle
    /// (5.12, 5.13), later ones propagate every sample. Static features do not move; moving features are predicted at the next
    /// scan, over the total time since the last one.
    ///
    /// # Errors
    /// The control is not admissible, `dt` is negative or not finite, one of them is [implausible](crate::Plausible), or the filter
    /// has not been reset. Poses, maps and random stream are unchanged. If only the control was refused, `dt` still counts as
    /// elapsed time for the moving features. The next report shows the refusal in its count and its health. A vehicle that loses an
    /// odometry sample can continue without it, or predict with a substitute control.
    pub fn predict(&mut self, control: &M::Control, dt: T) -> Result<PredictReport, PredictError> {
        self.predict_with(control, dt, &mut ())
    }

    /// [`predict`](Self::predict) with a probe.
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

    /// Checks a prediction; counts it if it is refused.
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

    /// Updates the filter with one scan of one of the vehicle's sensors: computes the weight of every candidate, resamples, and
    /// updates the maps of the selected particles (4.49–4.52, 5.17–5.24).
    ///
    /// # Errors
    /// A measurement is not finite, there are more measurements than the detector has memory for, the detector has moving births
    /// and the state has no moving maps, the covariance of the sensor's noise is not positive definite, or the filter has not been
    /// reset. The state is unchanged.
    pub fn scan<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        detector: &mut Detector<X, ScanRoom<'_, X::Measurement>>,
        measurements: &[X::Measurement],
    ) -> Result<ScanReport<T>, ScanError> {
        self.scan_with(detector, measurements, &mut ())
    }

    /// [`scan`](Self::scan) with a probe, which is called at the begin and the end of each stage.
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

    /// [`scan_with`](Self::scan_with) with an executor, which weights the candidates and updates the maps, on several cores if it
    /// has them.
    ///
    /// Both are divided into as many jobs as the [`DetectorMemory`](crate::DetectorMemory) has workers. The number of maps that are
    /// updated at the same time is the number of drafts of an [`UpdateMemory`](crate::UpdateMemory) for this type of state; with
    /// fewer than two (`&mut []` for none), only the weighting is divided. The result does not depend on any of these numbers.
    ///
    /// The probe is called on the calling core; the reduction of drafts is part of [`Stage::Update`].
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

    /// Checks a scan.
    pub(crate) fn check_scan<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        detector: &Detector<X, ScanRoom<'_, X::Measurement>>,
        measurements: &[X::Measurement],
    ) -> Result<(), ScanError> {
        self.memory.clamp();
        ScanError::check(measurements, detector.capacity())?;
        if self.has_room_for(&detector.births) { Ok(()) } else { Err(ScanError::NoRoomForMoving) }
    }

    /// Replaces the motion model, for example to tune its noise during operation. Allowed between any two steps.
    ///
    /// # Errors
    /// The model is out of range; the filter keeps the previous one.
    pub fn retune(&mut self, motion: M) -> Result<(), ModelError> {
        motion.check()?;
        self.motion = motion;
        Ok(())
    }

    /// Replaces the tuning. Allowed between any two steps. Checks the complete state, as [`new`](Self::new) does.
    ///
    /// # Errors
    /// The tuning is out of range, or does not fit the capacities of the state or its content, as for [`new`](Self::new); the
    /// filter keeps the previous one.
    pub fn configure(&mut self, config: Config<T>) -> Result<(), SetupError> {
        check_capacities(&config, self.memory.pose_covariances.len(), self.memory.candidates.len())?;
        self.memory.check(&config)?;
        self.config = config;
        Ok(())
    }

    /// The motion model.
    pub fn motion(&self) -> &M {
        &self.motion
    }

    /// The tuning.
    pub fn config(&self) -> &Config<T> {
        &self.config
    }

    /// The random stream in its present state; `None` before the first reset.
    pub fn noise(&self) -> Option<&Noise> {
        self.memory.cursor.noise.as_ref()
    }

    /// ln L of every candidate of the last scan, in the order that the candidates had before the scan (4.52).
    pub fn ln_likelihoods(&self) -> &[T] {
        self.memory.ln_likelihoods.get(..self.memory.cursor.weighed).unwrap_or(&[])
    }

    /// For every particle, the index of the candidate of the last scan that it continues.
    pub fn survivors(&self) -> &[u16] {
        let particles = if self.memory.cursor.weighed > 0 { self.memory.cursor.particles } else { 0 };
        self.memory.survivors.get(..particles).unwrap_or(&[])
    }

    /// Number of particles in use: the configured number, or fewer after resampling.
    pub fn particles(&self) -> usize {
        self.memory.cursor.particles
    }

    /// The candidates: N particles after a scan, N·M samples after a prediction. Weights sum to one.
    pub fn candidates(&self) -> &[Candidate<M::Pose>] {
        self.memory.candidates()
    }
}

/// Checks that the tuning is in range, and that its particles and candidates fit.
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
