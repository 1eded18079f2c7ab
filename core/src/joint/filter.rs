//! The filter with a joint map.

use super::archive::{Archive, Archived, JointArchive, NoArchive};
use super::config::JointConfig;
use super::covariance::{first, sandwiched, symmetric};
use super::existence::Existence;
use super::map_management::TENTATIVE_BELOW;
use super::movers::{JointMovers, MOVES, Movers, NoMovers, Tracked};
use super::state::{JointState, Memory};
use crate::models::require;
use crate::numerics::fnv::Fnv;
use crate::numerics::range::{is_within_range, is_within_square};
use crate::particles::cursor::passed;
use crate::particles::short::{is_short, propagated, short_beyond};
use crate::report::watch::Watch;
use crate::snapshot::visit::Walk;
use crate::{
    Component, ConfigError, Health, Linearised, Matrix, ModelError, Motion, MovingConfig, MovingOf, Pose, PoseEstimate,
    PositionOf, PredictError, PredictReport, Real, ResetError, ScalarOf, SetupError, Symmetric, TangentOf, Vector,
};

/// SLAM with a joint map: a motion model and a tuning, with the estimate in a [`JointState`]. The sensors are
/// [detectors](crate::Detector), which are passed with every scan.
///
/// `M` is the motion model, `Z` the measurement with the most dimensions, `A` the archive of distant features, if there
/// is one, `V` the tracks of moving objects, if there are any.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{ControlNoise, PlanarPose, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl};
/// use scphd::storage::joint_numbers;
/// use scphd::{Births, Detector, JointConfig, JointSlam, JointState};
///
/// // Up to 40 features, 16 measurements a scan: 20 KB.
/// type Memory = JointState<PlanarPose<f32>, Vector2<f32>, 40, { joint_numbers(3, 2, 40) }, 16>;
/// let mut state = Box::new(Memory::new());
///
/// let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// let sensing = Sensing::range_bearing([0.2, 0.02], window, 2.0)?;
/// let lidar = Detector::new(sensing, Births::of_static(1e-3))?;
/// let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02))?;
/// let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
/// slam.reset(PlanarPose::new(0.0, 0.0, 0.0))?;
/// for step in 0..20 {
///     slam.predict(&UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 }, 0.1)?;
///     // One landmark, 5 m to the left of the start.
///     let (along, left) = (0.1 * (step + 1) as f32, 5.0_f32);
///     slam.scan(&lidar, &[Vector2::new(along.hypot(left), left.atan2(-along))])?;
/// }
/// let pose = slam.estimate_pose().unwrap();
/// assert!((pose.mean.x_m - 2.0).abs() < 0.3);
/// let mut features = slam.features();
/// assert!((features.next().unwrap().mean.y - 5.0).abs() < 0.3 && features.next().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// If the map has more features than the state can store, a [`JointArchive`] stores the distant ones:
///
/// ```
/// # use nalgebra::Vector2;
/// # use scphd::models::{ControlNoise, PlanarPose, Step, Unicycle};
/// # use scphd::storage::joint_numbers;
/// # use scphd::{JointConfig, JointSlam, JointState};
/// use scphd::storage::JointArchive;
///
/// # type Memory = JointState<PlanarPose<f32>, Vector2<f32>, 40, { joint_numbers(3, 2, 40) }, 16>;
/// # let mut state = Box::new(Memory::new());
/// # let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02))?;
/// // A thousand features: 344 KB.
/// let mut archive = Box::new(JointArchive::<PlanarPose<f32>, 1000>::new());
/// let slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
/// // The detectors see 15 m far.
/// let mut slam = slam.with_archive(&mut archive, 15.0)?;
/// slam.reset(PlanarPose::new(0.0, 0.0, 0.0))?;
/// assert_eq!(slam.held(), 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Where people or vehicles move in the field of view, [`JointMovers`] track them and keep them out of the map:
///
/// ```
/// # use nalgebra::Vector2;
/// # use scphd::models::{ControlNoise, PlanarPose, Step, Unicycle};
/// # use scphd::storage::joint_numbers;
/// # use scphd::{JointConfig, JointSlam, JointState};
/// use scphd::settings::MovingConfig;
/// use scphd::storage::JointMovers;
///
/// # type Memory = JointState<PlanarPose<f32>, Vector2<f32>, 40, { joint_numbers(3, 2, 40) }, 16>;
/// # let mut state = Box::new(Memory::new());
/// # let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02))?;
/// // Up to 32 tracks: 2.6 KB.
/// let mut movers = JointMovers::<PlanarPose<f32>, 32>::new();
/// let slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
/// let mut slam = slam.with_movers(&mut movers, MovingConfig::walkers())?;
/// slam.reset(PlanarPose::new(0.0, 0.0, 0.0))?;
/// // Position and velocity of the objects that have moved in the scans so far.
/// assert_eq!(slam.moving().count(), 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct JointSlam<'s, M: Motion, Z: Vector, A = NoArchive, V = NoMovers> {
    motion: M,
    pub(super) config: JointConfig<ScalarOf<M::Pose>>,
    pub(super) memory: Memory<'s, M::Pose, Z>,
    pub(super) archive: A,
    pub(super) movers: V,
}

/// A filter with an archive.
type WithArchive<'s, M, Z, V> = JointSlam<'s, M, Z, Archived<'s, <M as Motion>::Pose>, V>;
/// A filter with tracks of moving objects.
type WithMovers<'s, M, Z, A> = JointSlam<'s, M, Z, A, Tracked<'s, <M as Motion>::Pose>>;
/// A filter that may have tracks of moving objects.
type WithMoversIf<'s, M, Z, A> = JointSlam<'s, M, Z, A, Option<Tracked<'s, <M as Motion>::Pose>>>;

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>> JointSlam<'s, M, Z> {
    /// A filter that continues with the content of `state`; a new state must be [reset](Self::reset) first.
    ///
    /// # Errors
    /// The motion or the configuration is out of range.
    pub fn new<const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize>(
        motion: M,
        config: JointConfig<T>,
        state: &'s mut JointState<M::Pose, Z, FEATURES, NUMBERS, MEASUREMENTS>,
    ) -> Result<Self, SetupError> {
        config.check()?;
        motion.check()?;
        Ok(Self { motion, config, memory: state.memory(), archive: NoArchive, movers: NoMovers })
    }
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V> JointSlam<'s, M, Z, NoArchive, V> {
    /// This filter with an archive, for a map with more features than the state can store: if the state has little free
    /// memory, features farther than `reach_m` from the vehicle are moved to the archive, and moved back when they may
    /// be in view again. `reach_m` is the greatest horizontal range of all detectors, m. The archive belongs to the
    /// state: pass both from the start, and again whenever the filter is constructed anew.
    ///
    /// # Errors
    /// The reach is not finite or not positive.
    pub fn with_archive<const CAPACITY: usize>(
        self,
        archive: &'s mut JointArchive<M::Pose, CAPACITY>,
        reach_m: T,
    ) -> Result<WithArchive<'s, M, Z, V>, SetupError> {
        require(reach_m > T::ZERO && reach_m.is_amount(), "reach_m", "positive")?;
        let Self { motion, config, memory, movers, .. } = self;
        Ok(JointSlam { motion, config, memory, archive: archive.archived(reach_m), movers })
    }
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A> JointSlam<'s, M, Z, A> {
    /// This filter with tracks of moving objects. A new feature may be static or moving, and both hypotheses are kept
    /// until the scans decide. Moving objects are not part of the map: measurements that they cause are not associated
    /// with static features, and do not correct the pose. Detectors need a birth intensity of moving objects
    /// ([`Births::of_moving`](crate::Births::of_moving)). The movers belong to the state: pass both from the start, and
    /// again whenever the filter is constructed anew.
    ///
    /// # Errors
    /// The configuration is out of range, or the state has room for more than 32768 features.
    pub fn with_movers<const CAPACITY: usize>(
        self,
        movers: &'s mut JointMovers<M::Pose, CAPACITY>,
        moving: MovingConfig<T>,
    ) -> Result<WithMovers<'s, M, Z, A>, SetupError> {
        moving.check()?;
        self.replace_movers(movers.tracked(moving))
    }

    /// [`with_movers`](Self::with_movers) if `movers` is `Some`, for a program that decides at run time whether to
    /// track moving objects.
    ///
    /// # Errors
    /// As for [`with_movers`](Self::with_movers).
    pub fn with_movers_if<const CAPACITY: usize>(
        self,
        movers: Option<(&'s mut JointMovers<M::Pose, CAPACITY>, MovingConfig<T>)>,
    ) -> Result<WithMoversIf<'s, M, Z, A>, SetupError> {
        movers.as_ref().map_or(Ok(()), |(_, moving)| moving.check())?;
        self.replace_movers(movers.map(|(movers, moving)| movers.tracked(moving)))
    }

    fn replace_movers<V>(self, movers: V) -> Result<JointSlam<'s, M, Z, A, V>, SetupError> {
        let Self { motion, config, memory, archive, .. } = self;
        require(memory.landmarks.len() <= usize::from(MOVES), "FEATURES", "at most 32768 with movers")?;
        Ok(JointSlam { motion, config, memory, archive, movers })
    }
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, A, V>
{
    /// The motion model.
    pub fn motion(&self) -> &M {
        &self.motion
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

    /// Replaces the tuning. Allowed between any two steps.
    ///
    /// # Errors
    /// The tuning is out of range; the filter keeps the previous one.
    pub fn configure(&mut self, config: JointConfig<T>) -> Result<(), ConfigError> {
        config.check()?;
        self.config = config;
        Ok(())
    }

    /// Starts or restarts the filter at `pose`, with zero covariance and an empty map.
    ///
    /// In single precision, coordinates have a resolution of about 0.01 mm at 100 m from the origin, 1 mm at 10 km, and
    /// 0.5 m at the northings of a survey grid: give poses and fixes relative to a nearby origin.
    ///
    /// # Errors
    /// The pose is not finite, or a coordinate is above 1e8; the state is unchanged.
    // Not inlined, so that its code exists once: `reset_within` calls it, too.
    #[inline(never)]
    pub fn reset(&mut self, pose: M::Pose) -> Result<(), ResetError> {
        ResetError::check_pose(&pose)?;
        let header = &mut *self.memory.header;
        (header.started, header.pose, header.moved, header.len) = (true, pose, [T::ZERO; 2], 0);
        header.remainder = [T::ZERO; 2];
        (header.waited_s, header.refused, header.next_label, header.watch) = (T::ZERO, 0, 0, Watch::ZERO);
        header.motion_noise = Symmetric::ZERO;
        self.memory.joint.clear();
        if let Some(mut view) = self.archive.view() {
            view.clear();
        }
        if let Some(mut tracks) = self.movers.tracks() {
            tracks.clear();
        }
        Ok(())
    }

    /// Predicts the pose of the vehicle after `dt` seconds under `control`.
    ///
    /// # Errors
    /// As for [`ScPhd::predict`](crate::ScPhd::predict).
    pub fn predict(&mut self, control: &M::Control, dt: T) -> Result<PredictReport, PredictError> {
        self.memory.clamp();
        let Memory { header, joint, .. } = &mut self.memory;
        if !header.started {
            return Err(PredictError::NotStarted);
        }
        let (motion, plausible) = (&self.motion, &self.config.plausible);
        if plausible.takes_time(dt) {
            header.waited_s = passed(header.waited_s, dt);
        }
        if let Some(refusal) = plausible.refusal(motion, Some(&header.pose), control, dt) {
            header.refused = header.refused.saturating_add(1);
            return Err(refusal);
        }
        let mut rejected = 0;
        if dt > T::ZERO {
            let mut left = header.remainder;
            let (moved, Linearised { transition, noise }) = if is_short(&header.pose, short_beyond(motion, control, dt))
            {
                propagated(motion, &header.pose, &mut left, control, dt)
            } else {
                (motion.propagate(&header.pose, control, dt), motion.linearise(&header.pose, control, dt))
            };
            let carried = sandwiched::<TangentOf<M::Pose>, TangentOf<M::Pose>, TangentOf<M::Pose>>(
                &transition,
                &joint.pose(),
                &transition,
            );
            let grown = carried + noise.to_matrix();
            let within = is_within_square(&Symmetric::<TangentOf<M::Pose>>::from_fn(|r, c| grown.at(r, c)));
            let finite = transition.as_slice().iter().all(|x| x.is_finite());
            if is_within_range(&moved.coordinates()) && within && finite {
                joint.propagate(&transition, &grown, header.len);
                header.pose = moved;
                header.remainder = left;
                let motion_noise = sandwiched::<TangentOf<M::Pose>, TangentOf<M::Pose>, TangentOf<M::Pose>>(
                    &transition,
                    &header.motion_noise.to_matrix(),
                    &transition,
                );
                let motion_noise = symmetric::<TangentOf<M::Pose>>(&motion_noise).plus(&noise);
                if is_within_square(&motion_noise) {
                    header.motion_noise = motion_noise;
                }
                if let Some(mut tracks) = self.movers.tracks() {
                    tracks.carried(&transition, &noise);
                }
            } else {
                rejected = 1;
            }
        }
        let health = Health::POSE_REJECTED.when(rejected > 0)
            | Health::PREDICTION_REFUSED.when(header.refused > 0)
            | header.watch.waiting(header.waited_s);
        Ok(PredictReport { candidates: 1, rejected, refused: header.refused, health })
    }

    /// The mean pose and its covariance; `None` before the first reset.
    pub fn estimate_pose(&self) -> Option<PoseEstimate<M::Pose>> {
        let Memory { header, joint, .. } = &self.memory;
        header.started.then(|| PoseEstimate {
            mean: header.pose,
            covariance: Symmetric::from_fn(|row, column| joint.get(row, column)),
        })
    }

    /// The estimated map: the features whose existence probability, visible or occluded, is at least
    /// `extraction_existence`, and which were detected at least twice. The weight of a component is this probability. A
    /// missed feature is first assumed to be occluded and remains in the map; its existence probability then decreases
    /// with time, until the feature leaves the estimate and finally, if it is not detected again, the state. Features
    /// in the archive are included, as they were when they were archived.
    pub fn features(&self) -> impl Iterator<Item = Component<PositionOf<M::Pose>>> + '_ {
        let Memory { header, landmarks, joint, .. } = &self.memory;
        let twice = T::from_f64(TENTATIVE_BELOW);
        let least = self.config.extraction_existence;
        let is_part = move |existence: Existence<T>, detections| existence.total() >= least && detections >= twice;
        let near = landmarks.iter().enumerate().take(header.len).filter_map(move |(index, landmark)| {
            let first = first::<M::Pose>(index);
            is_part(landmark.existence, landmark.detections).then(|| Component {
                label: landmark.label,
                ln_weight: landmark.existence.total().ln(),
                mean: landmark.mean,
                covariance: Symmetric::from_fn(|row, column| joint.get(first + row, first + column)),
            })
        });
        let far = self.archive.kept().iter().filter(move |entry| is_part(entry.existence, entry.detections));
        let far = far.map(|entry| Component {
            label: entry.label,
            ln_weight: entry.existence.total().ln(),
            mean: entry.mean,
            covariance: entry.covariance(),
        });
        near.chain(far)
    }

    /// The estimated moving objects, with position and velocity predicted to the present: those that exist and move with a
    /// probability of at least [`extraction_weight`](MovingConfig::extraction_weight). The weight of a component is this
    /// probability. Its label is that of the static feature that is the alternative hypothesis for the same object.
    pub fn moving(&self) -> impl Iterator<Item = Component<MovingOf<M::Pose>>> + '_ {
        let waited_s = self.memory.header.waited_s;
        let config = self.movers.common().map(|(_, config)| config);
        let movers = self.movers.kept().iter().zip(core::iter::repeat(config));
        movers.filter_map(move |(mover, config)| {
            let config = config.filter(|config| mover.weight() >= config.extraction_weight)?;
            if waited_s > T::ZERO {
                config.motion.advance::<PositionOf<M::Pose>>(&mover.component, waited_s)
            } else {
                Some(mover.component)
            }
        })
    }

    /// N̂: the expected number of features, the sum of their existence probabilities; for features in the archive, as
    /// they were when they were archived.
    pub fn expected_features(&self) -> T {
        let near = self.memory.landmarks.iter().take(self.memory.header.len).map(|landmark| landmark.existence);
        let far = self.archive.kept().iter().map(|entry| entry.existence);
        near.chain(far).fold(T::ZERO, |sum, existence| sum + existence.total())
    }

    /// A hash of the complete filter state: equal on every machine that processed the same inputs.
    pub fn digest(&self) -> u64 {
        let mut hash = Fnv::EMPTY;
        self.walk(&mut hash);
        hash.value()
    }

    /// Number of features in the state and in the archive, whatever their existence probability.
    pub fn held(&self) -> usize {
        self.memory.header.len + self.archive.kept().len()
    }

    /// The existence probability of the feature with this label; `None` if there is no such feature.
    #[must_use]
    pub fn existence(&self, label: u32) -> Option<T> {
        let near = self
            .memory
            .landmarks
            .iter()
            .take(self.memory.header.len)
            .map(|landmark| (landmark.label, landmark.existence));
        let far = self.archive.kept().iter().map(|entry| (entry.label, entry.existence));
        near.chain(far).find(|&(of, _)| of == label).map(|(_, existence)| existence.total())
    }
}
