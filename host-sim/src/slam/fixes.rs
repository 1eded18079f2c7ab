//! Fixes of a log as the core takes them.

use super::contract::{Refusal, refusal};
use crate::dimensions::{Dimensions, Planar, Underwater};
use crate::log::{FixNoise, PoseFix};
use nalgebra::{Vector1, Vector2};
use scphd::{
    AuvPose, Calibrated, CalibratedPose, Fix, FixReport, HeadingFix, JointSlam, Motion, Movers, NoArchive,
    ObserveError, PlanarPose, Pose, PositionFix, Real, ScPhd, ScalarOf, Vector,
};
use std::convert::Infallible;
use std::fmt::Debug;

/// A filter of the core that takes any fix.
pub(crate) trait Observes<P: Pose> {
    /// Takes it in, if it lies within its gate.
    fn take<F: Fix<Pose = P> + Copy>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<ScalarOf<P>>, ObserveError>;
}

impl<M: Motion> Observes<M::Pose> for ScPhd<'_, M> {
    fn take<F: Fix<Pose = M::Pose> + Copy>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<ScalarOf<M::Pose>>, ObserveError> {
        self.observe(fix, measured)
    }
}

impl<M, Z, V> Observes<M::Pose> for JointSlam<'_, M, Z, NoArchive, V>
where
    M: Motion,
    Z: Vector<Scalar = ScalarOf<M::Pose>>,
    V: Movers<M::Pose>,
{
    fn take<F: Fix<Pose = M::Pose> + Copy>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<ScalarOf<M::Pose>>, ObserveError> {
        self.observe(fix, measured)
    }
}

/// A pose of which logs of this kind have fixes.
pub(crate) trait Fixed<D: Dimensions>: Pose {
    /// How they are modelled.
    type Models: Copy + Debug;

    /// Shows a fix to a filter: whether it was within its gate.
    fn observe(filter: &mut impl Observes<Self>, models: &Self::Models, fix: &D::Fix) -> Result<bool, Refusal>;
}

/// The models of what a log in the plane has fixes of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlanarFixes<T: Real> {
    position: Option<PositionFix<T>>,
    heading: Option<HeadingFix<PlanarPose<T>>>,
}

impl<T: Real> PlanarFixes<T> {
    /// Of this noise.
    pub(crate) fn of(noise: &FixNoise) -> Result<Self, Refusal> {
        let real = T::from_f64;
        let gate = noise.gate.map_or(Real::INFINITY, real);
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

impl<T: Real> Fixed<Planar> for PlanarPose<T> {
    type Models = PlanarFixes<T>;

    fn observe(filter: &mut impl Observes<Self>, models: &PlanarFixes<T>, fix: &PoseFix) -> Result<bool, Refusal> {
        let unstated = |what| refusal(format_args!("fixes.{what}: not stated"));
        let report = match fix {
            PoseFix::Position(place) => {
                let model = models.position.as_ref().ok_or_else(|| unstated("position_sigma_m"))?;
                filter.take(model, &Vector2::from(place.map(T::from_f64)))
            }
            PoseFix::Heading(heading) => {
                let model = models.heading.as_ref().ok_or_else(|| unstated("heading_sigma_rad"))?;
                filter.take(model, &Vector1::new(T::from_f64(*heading)))
            }
        };
        Ok(report.map_err(refusal)?.accepted)
    }
}

impl<T: Real> Fixed<Planar> for CalibratedPose<T> {
    type Models = PlanarFixes<T>;

    fn observe(filter: &mut impl Observes<Self>, models: &PlanarFixes<T>, fix: &PoseFix) -> Result<bool, Refusal> {
        PlanarPose::observe(&mut OfVehicle(filter), models, fix)
    }
}

/// A filter of a vehicle that learns what its odometry is off by, as one of its pose alone.
struct OfVehicle<'f, F>(&'f mut F);

impl<T: Real, O: Observes<CalibratedPose<T>>> Observes<PlanarPose<T>> for OfVehicle<'_, O> {
    fn take<F: Fix<Pose = PlanarPose<T>> + Copy>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<T>, ObserveError> {
        self.0.take(&Calibrated(*fix), measured)
    }
}

impl<T: Real> Fixed<Underwater> for AuvPose<T> {
    type Models = ();

    fn observe(_filter: &mut impl Observes<Self>, _models: &(), fix: &Infallible) -> Result<bool, Refusal> {
        match *fix {}
    }
}
