//! Fixes of a log as models of the core.

use super::contract::{Refusal, refusal};
use nalgebra::{Vector1, Vector2};
use scphd::errors::ObserveError;
use scphd::fixes::FixReport;
use scphd::models::{AuvPose, Fix, HeadingFix, Motion, PlanarPose, Pose, PositionFix, ScalarOf};
use scphd::numerics::{Symmetric, Vector};
use scphd::storage::{Movers, NoArchive};
use scphd::{JointSlam, MultiHypothesisSlam, PoseEstimate, Real, ScPhd};
use scphd_log::dimensions::{Covariance, Dimensions, Planar, Underwater};
use scphd_log::log::{FixNoise, PoseFix};
use scphd_vehicle::PlanarState;
use std::convert::Infallible;
use std::fmt::Debug;

/// What a relocation does with the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Map {
    Kept,
    Dropped,
}

/// A filter of the core that processes any fix.
pub(crate) trait Observes<P: Pose> {
    /// Processes a fix. Returns whether it was within its gate.
    fn take<F: Fix<Pose = P>>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<ScalarOf<P>>, ObserveError>;

    /// Sets the estimate that `place` makes of the present one, with or without the map.
    fn put(&mut self, map: Map, place: impl FnOnce(PoseEstimate<P>) -> PoseEstimate<P>) -> Result<(), Refusal>;
}

/// Fixes and relocation of a filter, by its methods of the same names.
macro_rules! observes {
    ($($seed:expr)?) => {
        fn take<F: Fix<Pose = M::Pose>>(
            &mut self,
            fix: &F,
            measured: &F::Measurement,
        ) -> Result<FixReport<ScalarOf<M::Pose>>, ObserveError> {
            self.observe(fix, measured)
        }

        fn put(
            &mut self,
            map: Map,
            place: impl FnOnce(PoseEstimate<M::Pose>) -> PoseEstimate<M::Pose>,
        ) -> Result<(), Refusal> {
            let now = self.estimate_pose().ok_or_else(|| refusal("not started"))?;
            let PoseEstimate { mean, covariance } = place(now);
            match map {
                Map::Kept => self.relocate(mean, &covariance),
                Map::Dropped => self.reset_within(mean, &covariance $(, $seed)?),
            }
            .map_err(refusal)
        }
    };
}

/// Seed of a filter that starts again in a log: not that of its start, but the same in every run.
const RESTART_SEED: u64 = 0x5ca7_7e12;

impl<M: Motion> Observes<M::Pose> for ScPhd<'_, M> {
    observes!(RESTART_SEED);
}

impl<M, Z, V> Observes<M::Pose> for JointSlam<'_, M, Z, NoArchive, V>
where
    M: Motion,
    Z: Vector<Scalar = ScalarOf<M::Pose>>,
    V: Movers<M::Pose>,
{
    observes!();
}

impl<M, Z, V, const OTHERS: usize> Observes<M::Pose> for MultiHypothesisSlam<'_, M, Z, V, OTHERS>
where
    M: Motion,
    Z: Vector<Scalar = ScalarOf<M::Pose>>,
    V: Movers<M::Pose>,
{
    observes!();
}

/// A pose type with fixes in logs of this kind.
pub(crate) trait Fixed<D: Dimensions>: Pose {
    type Models: Copy + Debug;

    /// Passes a fix to a filter. Returns whether it was within its gate.
    fn observe(filter: &mut impl Observes<Self>, models: &Self::Models, fix: &D::Fix) -> Result<bool, Refusal>;

    /// Sets the pose of a filter to that of its fixes.
    fn relocate(
        filter: &mut impl Observes<Self>,
        map: Map,
        pose: &D::Pose,
        covariance: &Covariance<D::Pose>,
    ) -> Result<(), Refusal>;
}

/// The models of the fixes of a log in the plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlanarFixes<T: Real> {
    pub(super) position: Option<PositionFix<T>>,
    pub(super) heading: Option<HeadingFix<PlanarPose<T>>>,
}

impl<T: Real> PlanarFixes<T> {
    /// Creates the models for this noise.
    pub(crate) fn of(noise: &FixNoise) -> Result<Self, Refusal> {
        let real = T::from_f64;
        let gate = real(noise.gate());
        let position = |sigma_m| {
            let fix = PositionFix::new(real(sigma_m))?.gated(gate)?;
            if (noise.forward_m, noise.left_m) == (0.0, 0.0) {
                return Ok(fix);
            }
            fix.mounted(real(noise.forward_m), real(noise.left_m))
        };
        let heading = |sigma_rad| HeadingFix::new(real(sigma_rad))?.gated(gate);
        Ok(Self {
            position: noise.position_sigma_m.map(position).transpose().map_err(refusal)?,
            heading: noise.heading_sigma_rad.map(heading).transpose().map_err(refusal)?,
        })
    }
}

impl<P: PlanarState> Fixed<Planar> for P {
    type Models = PlanarFixes<P::Scalar>;

    fn observe(filter: &mut impl Observes<P>, models: &Self::Models, fix: &PoseFix) -> Result<bool, Refusal> {
        let unstated = |what| refusal(format_args!("fixes.{what}: not stated"));
        let report = match fix {
            PoseFix::Position(place) => {
                let model = models.position.ok_or_else(|| unstated("position_sigma_m"))?;
                filter.take(&P::fixed(model), &Vector2::from(place.map(P::Scalar::from_f64)))
            }
            PoseFix::Heading(heading) => {
                let model = models.heading.ok_or_else(|| unstated("heading_sigma_rad"))?;
                filter.take(&P::fixed(model), &Vector1::new(P::Scalar::from_f64(*heading)))
            }
        };
        Ok(report.map_err(refusal)?.accepted)
    }

    fn relocate(
        filter: &mut impl Observes<P>,
        map: Map,
        pose: &[f64; 3],
        covariance: &[[f64; 3]; 3],
    ) -> Result<(), Refusal> {
        let [x, y, heading] = pose.map(P::Scalar::from_f64);
        let covariance = Symmetric::from_fn(|row, column| P::Scalar::from_f64(covariance[row][column]));
        filter.put(map, |now| {
            let (mean, covariance) = P::moved(&now, PlanarPose::new(x, y, heading), &covariance);
            PoseEstimate { mean, covariance }
        })
    }
}

impl<T: Real> Fixed<Underwater> for AuvPose<T> {
    type Models = ();

    fn observe(_filter: &mut impl Observes<Self>, _models: &(), fix: &Infallible) -> Result<bool, Refusal> {
        match *fix {}
    }

    fn relocate(
        _filter: &mut impl Observes<Self>,
        _map: Map,
        _pose: &<Underwater as Dimensions>::Pose,
        _covariance: &Covariance<<Underwater as Dimensions>::Pose>,
    ) -> Result<(), Refusal> {
        Err(refusal("under water there are no fixes"))
    }
}
