//! A pose without jumps, and its transformation to the map.

use scphd::Real;
use scphd::errors::{PredictError, ResetError};
use scphd::models::{Motion, Pose, PositionOf, ScalarOf, TangentOf};
use scphd::numerics::{Vector, Zero, wrap};

/// The transformation from the odometry frame to the map: map_T_odom = map pose ∘ odometry pose⁻¹, a rotation about the vertical
/// and a translation.
///
/// It applies to the coordinates of the position, which come first, and to the [heading](Pose::HEADING): x, y and heading of a
/// [`PlanarPose`](scphd::models::PlanarPose); x, y, z and yaw of an [`AuvPose`](scphd::models::AuvPose), whose roll and pitch,
/// given by its instruments, and yaw rate are the same in both frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFromOdom<P: Pose> {
    turn_rad: ScalarOf<P>,
    shift_m: PositionOf<P>,
}

impl<P: Pose> MapFromOdom<P> {
    /// Both frames are the same.
    pub const IDENTITY: Self = Self { turn_rad: ScalarOf::<P>::ZERO, shift_m: PositionOf::<P>::ZERO };

    /// The transformation between two poses of a vehicle at the same time.
    pub fn between(in_map: &P, in_odom: &P) -> Self {
        let turn_rad = P::HEADING.map_or(ScalarOf::<P>::ZERO, |heading| {
            wrap(in_map.coordinates().at(heading) - in_odom.coordinates().at(heading))
        });
        let turned = Self { turn_rad, ..Self::IDENTITY }.place(in_odom);
        let in_map = in_map.coordinates();
        Self { turn_rad, shift_m: PositionOf::<P>::with(|axis| in_map.at(axis) - turned.at(axis)) }
    }

    /// Transforms a pose from the odometry frame to the map.
    #[must_use]
    pub fn apply(&self, in_odom: &P) -> P {
        let (place, before) = (self.place(in_odom), in_odom.coordinates());
        in_odom.displaced(&TangentOf::<P>::with(|k| match k {
            _ if k < PositionOf::<P>::DIMENSION => place.at(k) - before.at(k),
            _ if Some(k) == P::HEADING => self.turn_rad,
            _ => ScalarOf::<P>::ZERO,
        }))
    }

    /// Transforms the position of a pose to the map.
    fn place(&self, in_odom: &P) -> PositionOf<P> {
        let from = in_odom.coordinates();
        let (sine, cosine) = self.turn_rad.sin_cos();
        PositionOf::<P>::with(|axis| {
            let turned = match axis {
                0 if P::HEADING.is_some() => cosine * from.at(0) - sine * from.at(1),
                1 if P::HEADING.is_some() => sine * from.at(0) + cosine * from.at(1),
                _ => from.at(axis),
            };
            turned + self.shift_m.at(axis)
        })
    }

    /// The rotation about the vertical, rad, in (−π, π].
    pub fn turn_rad(&self) -> ScalarOf<P> {
        self.turn_rad
    }

    /// Position of the odometry frame's origin in the map, m.
    pub fn shift_m(&self) -> PositionOf<P> {
        self.shift_m
    }
}

/// Size of a correction of the pose in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction<T> {
    /// Distance at the vehicle, m; at the origin, a rotation would appear as a great distance.
    pub distance_m: T,
    /// Rotation, rad, not negative.
    pub angle_rad: T,
}

/// A pose by odometry only, which never jumps, and its transformation to the map.
///
/// A controller follows the pose in the odometry frame, which drifts but never moves more than the vehicle. A planner works in
/// the map: it applies [`map_from_odom`](Self::map_from_odom) to the pose, and gets a jump with every correction. Both frames are
/// the same at the start.
///
/// Call it with the same predictions as the filter, and correct it with the filter's pose at the same time.
/// [`Sequencer::ahead`](crate::Sequencer::ahead) has the controls from then until now.
///
/// ```
/// use scphd::models::{ControlNoise, PlanarPose, Pose, Step, Unicycle, UnicycleControl};
/// use scphd_sequencer::SmoothOdometry;
///
/// let motion = Unicycle::new(Step::Arc, ControlNoise::NONE)?;
/// let mut odometry = SmoothOdometry::new(PlanarPose::new(0.0, 0.0, 0.0));
/// odometry.predict(&motion, &UnicycleControl { speed_mps: 1.0_f64, rate_radps: 0.0 }, 2.0)?;
///
/// // The filter says that the wheels have slipped.
/// let corrected = PlanarPose::new(1.5, 0.2, 0.1);
/// let correction = odometry.correct(&corrected)?;
/// assert!((correction.angle_rad - 0.1).abs() < 1e-15 && (correction.distance_m - 0.29_f64.sqrt()).abs() < 1e-15);
/// assert_eq!(odometry.pose(), PlanarPose::new(2.0, 0.0, 0.0));
/// assert!(odometry.in_map().distance_m(&corrected) < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmoothOdometry<P: Pose> {
    pose: P,
    map_from_odom: MapFromOdom<P>,
    corrections: u32,
    greatest: Correction<ScalarOf<P>>,
}

impl<P: Pose> SmoothOdometry<P> {
    /// A vehicle at this pose in both frames.
    pub const fn new(pose: P) -> Self {
        let greatest = Correction { distance_m: ScalarOf::<P>::ZERO, angle_rad: ScalarOf::<P>::ZERO };
        Self { pose, map_from_odom: MapFromOdom::IDENTITY, corrections: 0, greatest }
    }

    /// Predicts by `dt` seconds under `control` without noise; the filter's motion model can be used.
    ///
    /// # Errors
    /// The motion does not admit the control, `dt` is negative or not finite, or the result is not finite; the pose is unchanged.
    pub fn predict<M: Motion<Pose = P>>(
        &mut self,
        motion: &M,
        control: &M::Control,
        dt: ScalarOf<P>,
    ) -> Result<(), PredictError> {
        if !(dt >= ScalarOf::<P>::ZERO && dt.is_finite()) {
            return Err(PredictError::TimeStep);
        }
        if !motion.admits(control) {
            return Err(PredictError::Control);
        }
        let moved = motion.propagate(&self.pose, control, dt);
        if !moved.is_finite() {
            return Err(PredictError::Control);
        }
        self.pose = moved;
        Ok(())
    }

    /// Corrects the transformation with the pose that the filter has estimated in the map, for the time of the odometry pose.
    ///
    /// # Errors
    /// The pose is not finite; the transformation is unchanged.
    pub fn correct(&mut self, in_map: &P) -> Result<Correction<ScalarOf<P>>, ResetError> {
        if !in_map.is_finite() {
            return Err(ResetError::NonFinitePose);
        }
        let before = self.in_map();
        self.map_from_odom = MapFromOdom::between(in_map, &self.pose);
        let angle = P::HEADING.map_or(ScalarOf::<P>::ZERO, |heading| in_map.difference(&before).at(heading));
        let correction = Correction { distance_m: in_map.distance_m(&before), angle_rad: angle.abs() };
        self.corrections = self.corrections.saturating_add(1);
        let Correction { distance_m, angle_rad } = self.greatest;
        self.greatest = Correction {
            distance_m: distance_m.at_least(correction.distance_m),
            angle_rad: angle_rad.at_least(correction.angle_rad),
        };
        Ok(correction)
    }

    /// The pose in the odometry frame.
    pub fn pose(&self) -> P {
        self.pose
    }

    /// The pose in the map.
    pub fn in_map(&self) -> P {
        self.map_from_odom.apply(&self.pose)
    }

    /// The transformation from the odometry frame to the map.
    pub fn map_from_odom(&self) -> MapFromOdom<P> {
        self.map_from_odom
    }

    /// Number of corrections. Saturates at `u32::MAX`.
    pub fn corrections(&self) -> u32 {
        self.corrections
    }

    /// The greatest distance and the greatest angle of all corrections.
    pub fn greatest(&self) -> Correction<ScalarOf<P>> {
        self.greatest
    }
}
