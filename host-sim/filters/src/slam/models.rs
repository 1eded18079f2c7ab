//! The core's models for the settings of a log, and conversion of results to the host's types.

use super::contract::PoseAndCovariance;
use super::fixes::Fixed;
use scphd::models::{AuvPose, MeasurementModel, Motion, PlanarPose, Pose};
use scphd::numerics::{Symmetric, Vector};
use scphd::{Component, Detector, PoseEstimate, Real};
use scphd_log::dimensions::{Coordinates, Dimensions};
use scphd_reference::space;
use scphd_score::record::{MapFeature, MovingFeature};

/// Models of motion, sensors and fixes, and the initial pose.
pub(crate) struct Models<D: Dimensions, M: Motion<Pose: Fixed<D>>, X: MeasurementModel<Pose = M::Pose>> {
    pub(crate) motion: M,
    pub(crate) detectors: Vec<Detector<X>>,
    pub(crate) fixes: <M::Pose as Fixed<D>>::Models,
    pub(crate) start: M::Pose,
    /// Converts a control of the log.
    pub(crate) control: fn(D::Control) -> M::Control,
}

/// Converts measurements to vectors of the core.
pub(super) fn measured<D: Dimensions, Z: Vector>(detections: &[D::Measurement]) -> Vec<Z> {
    detections.iter().map(|z| Z::with(|k| Z::Scalar::from_f64(z.as_ref()[k]))).collect()
}

/// The upper left block of a covariance, or all of it.
pub fn full<V: Vector, const N: usize>(covariance: &Symmetric<V>) -> [[f64; N]; N] {
    std::array::from_fn(|row| std::array::from_fn(|column| covariance.get(row, column).to_f64()))
}

pub(super) fn pose_of<D: Dimensions, P: Pose>(estimate: &PoseEstimate<P>) -> PoseAndCovariance<D> {
    let mean = estimate.mean.coordinates();
    (
        D::Pose::with(|k| mean.at(k).to_f64()),
        D::Pose::square(|row, column| estimate.covariance.get(row, column).to_f64()),
    )
}

/// An estimated static feature.
pub fn feature_of<D: Dimensions, V: Vector>(feature: &Component<V>) -> MapFeature<D> {
    MapFeature {
        id: feature.label,
        weight: feature.ln_weight.exp().to_f64(),
        mean: D::Position::with(|k| feature.mean.at(k).to_f64()),
        covariance: D::Position::square(|row, column| feature.covariance.get(row, column).to_f64()),
    }
}

/// An estimated moving feature.
pub fn moving_of<D: Dimensions, V: Vector>(feature: &Component<V>) -> MovingFeature<D> {
    MovingFeature {
        id: feature.label,
        weight: feature.ln_weight.exp().to_f64(),
        position: D::Position::with(|k| feature.mean.at(k).to_f64()),
        velocity: D::Position::with(|k| feature.mean.at(D::Position::COUNT + k).to_f64()),
        covariance: D::Position::square(|row, column| feature.covariance.get(row, column).to_f64()),
    }
}

/// A pose with a counterpart in the reference.
pub trait Referred: Pose {
    type Reference: Copy;

    /// The pose in double precision.
    fn referred(&self) -> Self::Reference;
}

impl<T: Real> Referred for PlanarPose<T> {
    type Reference = [f64; 3];

    fn referred(&self) -> [f64; 3] {
        [self.x_m, self.y_m, self.heading_rad].map(T::to_f64)
    }
}

impl<T: Real> Referred for AuvPose<T> {
    type Reference = space::Pose;

    fn referred(&self) -> space::Pose {
        let Self { x_m, y_m, z_m, yaw_rad, yaw_rate_radps, roll_rad, pitch_rad } = *self;
        space::Pose {
            position: [x_m, y_m, z_m].map(T::to_f64),
            yaw: yaw_rad.to_f64(),
            yaw_rate: yaw_rate_radps.to_f64(),
            roll: roll_rad.to_f64(),
            pitch: pitch_rad.to_f64(),
        }
    }
}
