//! The filter over a joint map.

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

/// SLAM with a joint map: motion and tuning over a [`JointState`]; the sensors are [detectors](crate::Detector), given with every scan.
///
/// `M` is the motion, `Z` the widest measurement, `A` where features that are far away are kept, if anywhere, `V` what moves, if anything.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{
///     ControlNoise, PlanarPose, RangeBearing, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl,
///     UniformClutter,
/// };
/// use scphd::storage::joint_numbers;
/// use scphd::{Births, Detector, JointConfig, JointSlam, JointState};
///
/// // Up to 40 features, 16 measurements a scan: 20 KB.
/// type Memory = JointState<PlanarPose<f32>, Vector2<f32>, 40, { joint_numbers(3, 2, 40) }, 16>;
/// let mut state = Box::new(Memory::new());
///
/// let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// let sensing = Sensing {
///     sensor: RangeBearing::new(0.2, 0.02)?,
///     field_of_view: window,
///     clutter: UniformClutter::of_scan(2.0, window.measure())?,
/// };
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
/// For a map that is larger than the state, a [`JointArchive`] keeps the features that are far away:
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
/// Where others move about, [`JointMovers`] keep them out of the map:
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
/// // Up to 32 of them: 2.6 KB.
/// let mut movers = JointMovers::<PlanarPose<f32>, 32>::new();
/// let slam = JointSlam::new(motion, JointConfig::default(), &mut *state)?;
/// let mut slam = slam.with_movers(&mut movers, MovingConfig::walkers())?;
/// slam.reset(PlanarPose::new(0.0, 0.0, 0.0))?;
/// // Position and velocity, of what the scans so far have shown to move.
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

/// A filter with an archive behind it.
type WithArchive<'s, M, Z, V> = JointSlam<'s, M, Z, Archived<'s, <M as Motion>::Pose>, V>;
/// A filter with movers beside it.
type WithMovers<'s, M, Z, A> = JointSlam<'s, M, Z, A, Tracked<'s, <M as Motion>::Pose>>;
/// A filter that may have movers beside it.
type WithMoversIf<'s, M, Z, A> = JointSlam<'s, M, Z, A, Option<Tracked<'s, <M as Motion>::Pose>>>;

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>> JointSlam<'s, M, Z> {
    /// A filter over a state, which keeps what it holds: a fresh one must be [reset](Self::reset) first.
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
    /// The same with an archive behind it, for a map larger than the state: features that are farther than `reach_m` from the vehicle
    /// leave the state for the archive where there is little room, and come back when they may be in view again. `reach_m` is how
    /// far the farthest-looking detector sees on the ground, m. The archive keeps what it holds, and goes with the state: both must be
    /// handed in from the start, and whenever the filter is built anew.
    ///
    /// # Errors
    /// The reach is not finite or not positive.
    pub fn with_archive<const CAPACITY: usize>(
        self,
        archive: &'s mut JointArchive<M::Pose, CAPACITY>,
        reach_m: T,
    ) -> Result<WithArchive<'s, M, Z, V>, SetupError> {
        require(reach_m > T::ZERO && reach_m.is_finite(), "reach_m", "positive")?;
        let Self { motion, config, memory, movers, .. } = self;
        Ok(JointSlam { motion, config, memory, archive: archive.archived(reach_m), movers })
    }
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A> JointSlam<'s, M, Z, A> {
    /// The same for a place where others move about: what is born may stand or move, and does either. What moves is kept apart from the map; it
    /// takes the measurements that it causes from the static features, and says nothing of the pose. Of detectors, births that move count
    /// ([`Births::of_moving`](crate::Births::of_moving)). The movers keep what they hold, and go with the state: both must be handed
    /// in from the start, and whenever the filter is built anew.
    ///
    /// # Errors
    /// The configuration is out of range, or the state has room for more than 32768 features.
    pub fn with_movers<const CAPACITY: usize>(
        self,
        movers: &'s mut JointMovers<M::Pose, CAPACITY>,
        moving: MovingConfig<T>,
    ) -> Result<WithMovers<'s, M, Z, A>, SetupError> {
        moving.check()?;
        self.beside(movers.tracked(moving))
    }

    /// [`with_movers`](Self::with_movers) where there are movers, for a program that knows only when it runs whether anything moves.
    ///
    /// # Errors
    /// As there.
    pub fn with_movers_if<const CAPACITY: usize>(
        self,
        movers: Option<(&'s mut JointMovers<M::Pose, CAPACITY>, MovingConfig<T>)>,
    ) -> Result<WithMoversIf<'s, M, Z, A>, SetupError> {
        movers.as_ref().map_or(Ok(()), |(_, moving)| moving.check())?;
        self.beside(movers.map(|(movers, moving)| movers.tracked(moving)))
    }

    fn beside<V>(self, movers: V) -> Result<JointSlam<'s, M, Z, A, V>, SetupError> {
        let Self { motion, config, memory, archive, .. } = self;
        require(memory.landmarks.len() <= usize::from(MOVES), "FEATURES", "at most 32768 beside movers")?;
        Ok(JointSlam { motion, config, memory, archive, movers })
    }
}

impl<T, M, Z, A, V> JointSlam<'_, M, Z, A, V>
where
    T: Real,
    M: Motion<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
    A: Archive<M::Pose>,
    V: Movers<M::Pose>,
{
    /// The motion.
    #[must_use]
    pub fn motion(&self) -> &M {
        &self.motion
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

    /// Goes on with another tuning, between any two steps.
    ///
    /// # Errors
    /// It is out of range; the filter keeps the one it had.
    pub fn configure(&mut self, config: JointConfig<T>) -> Result<(), ConfigError> {
        config.check()?;
        self.config = config;
        Ok(())
    }

    /// Starts, or starts again: at `pose`, certain of it, without a feature.
    ///
    /// In single precision two places a hundredth of a millimetre apart are told from each other 100 m from the origin, a millimetre 10 km from it and half
    /// a metre at the northings of a survey grid: give poses and fixes relative to a place nearby.
    ///
    /// # Errors
    /// The pose is not finite, or a coordinate above 1e8; the state is as it was.
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

    /// Moves the vehicle for `dt` seconds under `control`.
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

    /// The pose and its covariance; `None` before the first reset.
    #[must_use]
    pub fn estimate_pose(&self) -> Option<PoseEstimate<M::Pose>> {
        let Memory { header, joint, .. } = &self.memory;
        header.started.then(|| PoseEstimate {
            mean: header.pose,
            covariance: Symmetric::from_fn(|row, column| joint.get(row, column)),
        })
    }

    /// The estimated features: those that are there, in sight or hidden, with at least the probability `extraction_existence`, and were
    /// detected twice. The weight is that probability. One that is missed is first taken for hidden, and stays; only as time goes by it is
    /// taken for gone: it leaves the estimate, and is remembered until it is found again or hardly there any more. Those in the archive are
    /// among them, as they were when they left the window.
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

    /// The estimated features that move, position and velocity, where they are by now: those that are there and move with at least the
    /// probability [`extraction_weight`](MovingConfig::extraction_weight). The weight is that probability, and the label that of the static feature that
    /// it was taken for as well.
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

    /// N̂: how many features there are, by their probabilities; of those in the archive, by what they were when they left the window.
    #[must_use]
    pub fn expected_features(&self) -> T {
        let near = self.memory.landmarks.iter().take(self.memory.header.len).map(|landmark| landmark.existence);
        let far = self.archive.kept().iter().map(|entry| entry.existence);
        near.chain(far).fold(T::ZERO, |sum, existence| sum + existence.total())
    }

    /// A hash of all that the filter knows: equal on every machine that was fed the same.
    #[must_use]
    pub fn digest(&self) -> u64 {
        let mut hash = Fnv::EMPTY;
        self.walk(&mut hash);
        hash.value()
    }

    /// How many features the state holds, likely ones or not, with those in the archive.
    #[must_use]
    pub fn held(&self) -> usize {
        self.memory.header.len + self.archive.kept().len()
    }

    /// The probability that the feature with this label is there; `None` where there is no such one.
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
