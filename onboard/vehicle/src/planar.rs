//! States of a planar vehicle: a pose, or a pose with the odometry correction.

use core::fmt::Debug;
use nalgebra::{SVector, Vector2, Vector3};
use scphd::models::{
    Calibrated, CalibratedPose, Fix, ModelError, Motion, OdometryCorrection, OdometryPrior, PlanarControl,
    PlanarMotion, PlanarPose, Pose, ScalarOf, SelfCalibrating, Sensor, TangentOf,
};
use scphd::numerics::Symmetric;
use scphd::{PoseEstimate, Real};

/// The state of a planar vehicle: [`PlanarPose`], or [`CalibratedPose`] with odometry calibration.
pub trait PlanarState: Pose<Position = Vector2<ScalarOf<Self>>> {
    /// The motion model for this state.
    type Moves: Motion<Pose = Self, Control = PlanarControl<ScalarOf<Self>>> + Debug;
    /// A sensor of a planar pose, adapted to this state.
    type Seen<S: Sensor<Pose = PlanarPose<ScalarOf<Self>>> + Debug>: Sensor<Pose = Self, Measurement = S::Measurement, Frame = S::Frame>
        + Debug;
    /// A fix of a planar pose, adapted to this state.
    type Fixed<F: Fix<Pose = PlanarPose<ScalarOf<Self>>>>: Fix<Pose = Self, Measurement = F::Measurement>;

    /// Adapts a sensor of a planar pose to this state.
    fn seen<S: Sensor<Pose = PlanarPose<ScalarOf<Self>>> + Debug>(sensor: S) -> Self::Seen<S>;
    /// Adapts a fix of a planar pose to this state.
    fn fixed<F: Fix<Pose = PlanarPose<ScalarOf<Self>>>>(fix: F) -> Self::Fixed<F>;
    /// The motion model; `None` if a prior of the odometry is missing, or is given and not used.
    ///
    /// # Errors
    /// The prior is out of range.
    fn moves(
        drive: PlanarMotion<ScalarOf<Self>>,
        prior: Option<OdometryPrior<ScalarOf<Self>>>,
    ) -> Result<Option<Self::Moves>, ModelError>;
    /// The pose, and the odometry correction.
    fn parts(&self) -> (PlanarPose<ScalarOf<Self>>, Option<OdometryCorrection<ScalarOf<Self>>>);
    /// An initial state and covariance, from those of the pose and the prior of the odometry.
    fn start(
        motion: &Self::Moves,
        pose: PlanarPose<ScalarOf<Self>>,
        covariance: &Symmetric<Vector3<ScalarOf<Self>>>,
    ) -> (Self, Symmetric<TangentOf<Self>>);
    /// This estimate relocated to another pose and covariance; the odometry correction and its covariance are unchanged.
    fn moved(
        from: &PoseEstimate<Self>,
        pose: PlanarPose<ScalarOf<Self>>,
        covariance: &Symmetric<Vector3<ScalarOf<Self>>>,
    ) -> (Self, Symmetric<TangentOf<Self>>);
    /// The covariance of the state from that of the pose, with zeros for the odometry correction.
    fn widened(covariance: &Symmetric<Vector3<ScalarOf<Self>>>) -> Symmetric<TangentOf<Self>>;
    /// The covariance of the pose.
    fn narrowed(covariance: &Symmetric<TangentOf<Self>>) -> Symmetric<Vector3<ScalarOf<Self>>>;
}

impl<T: Real> PlanarState for PlanarPose<T> {
    type Moves = PlanarMotion<T>;
    type Seen<S: Sensor<Pose = Self> + Debug> = S;
    type Fixed<F: Fix<Pose = Self>> = F;

    fn seen<S: Sensor<Pose = Self> + Debug>(sensor: S) -> S {
        sensor
    }

    fn fixed<F: Fix<Pose = Self>>(fix: F) -> F {
        fix
    }

    fn moves(drive: PlanarMotion<T>, prior: Option<OdometryPrior<T>>) -> Result<Option<PlanarMotion<T>>, ModelError> {
        Ok(prior.is_none().then_some(drive))
    }

    fn parts(&self) -> (Self, Option<OdometryCorrection<T>>) {
        (*self, None)
    }

    fn start(_: &PlanarMotion<T>, pose: Self, covariance: &Symmetric<Vector3<T>>) -> (Self, Symmetric<Vector3<T>>) {
        (pose, *covariance)
    }

    fn moved(_: &PoseEstimate<Self>, pose: Self, covariance: &Symmetric<Vector3<T>>) -> (Self, Symmetric<Vector3<T>>) {
        (pose, *covariance)
    }

    fn widened(covariance: &Symmetric<Vector3<T>>) -> Symmetric<Vector3<T>> {
        *covariance
    }

    fn narrowed(covariance: &Symmetric<Vector3<T>>) -> Symmetric<Vector3<T>> {
        *covariance
    }
}

/// The covariance of the state with these blocks for the pose and for the odometry correction.
fn joined<T: Real>(pose: &Symmetric<Vector3<T>>, odometry: &Symmetric<SVector<T, 6>>) -> Symmetric<SVector<T, 6>> {
    Symmetric::from_fn(|row, column| match (row < 3, column < 3) {
        (true, true) => pose.get(row, column),
        (false, false) => odometry.get(row, column),
        _ => T::ZERO,
    })
}

impl<T: Real> PlanarState for CalibratedPose<T> {
    type Moves = SelfCalibrating<PlanarMotion<T>, T>;
    type Seen<S: Sensor<Pose = PlanarPose<T>> + Debug> = Calibrated<S>;
    type Fixed<F: Fix<Pose = PlanarPose<T>>> = Calibrated<F>;

    fn seen<S: Sensor<Pose = PlanarPose<T>> + Debug>(sensor: S) -> Calibrated<S> {
        Calibrated(sensor)
    }

    fn fixed<F: Fix<Pose = PlanarPose<T>>>(fix: F) -> Calibrated<F> {
        Calibrated(fix)
    }

    fn moves(drive: PlanarMotion<T>, prior: Option<OdometryPrior<T>>) -> Result<Option<Self::Moves>, ModelError> {
        prior.map(|prior| SelfCalibrating::new(drive, prior)).transpose()
    }

    fn parts(&self) -> (PlanarPose<T>, Option<OdometryCorrection<T>>) {
        (self.vehicle, Some(self.odometry))
    }

    fn start(
        motion: &Self::Moves,
        pose: PlanarPose<T>,
        covariance: &Symmetric<Vector3<T>>,
    ) -> (Self, Symmetric<SVector<T, 6>>) {
        (Self::at(pose), joined(covariance, &motion.prior()))
    }

    fn moved(
        from: &PoseEstimate<Self>,
        vehicle: PlanarPose<T>,
        covariance: &Symmetric<Vector3<T>>,
    ) -> (Self, Symmetric<SVector<T, 6>>) {
        (Self { vehicle, odometry: from.mean.odometry }, joined(covariance, &from.covariance))
    }

    fn widened(covariance: &Symmetric<Vector3<T>>) -> Symmetric<SVector<T, 6>> {
        joined(covariance, &Symmetric::ZERO)
    }

    fn narrowed(covariance: &Symmetric<SVector<T, 6>>) -> Symmetric<Vector3<T>> {
        Symmetric::from_fn(|row, column| covariance.get(row, column))
    }
}
