//! Random measurements of the pose: position or height, heading, beacon.

use super::draw::Draw;
use super::worlds::{Drawn, FeatureOf, MeasurementOf, World};
use nalgebra::{Vector1, Vector2};
use scphd::errors::ObserveError;
use scphd::fixes::FixReport;
use scphd::models::{
    AuvPose, BeaconFix, Fix, HeadingFix, HeightFix, MeasurementModel, ModelError, Motion, Mounting, PlanarPose, Pose,
    PositionFix, ScalarOf, Sensor,
};
use scphd::numerics::Vector;
use scphd::storage::{Archive, Movers};
use scphd::{JointSlam, Real, ScPhd};
use std::fmt::{self, Debug, Formatter};

/// A filter that accepts fixes.
pub(super) trait Observer<P: Pose> {
    /// Updates the filter with a fix.
    fn take<F: Fix<Pose = P>>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<P::Scalar>, ObserveError>;
}

impl<M: Motion> Observer<M::Pose> for ScPhd<'_, M> {
    fn take<F: Fix<Pose = M::Pose>>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<ScalarOf<M::Pose>>, ObserveError> {
        self.observe(fix, measured)
    }
}

impl<M: Motion, Z: Vector<Scalar = ScalarOf<M::Pose>>, A: Archive<M::Pose>, V: Movers<M::Pose>> Observer<M::Pose>
    for JointSlam<'_, M, Z, A, V>
{
    fn take<F: Fix<Pose = M::Pose>>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<ScalarOf<M::Pose>>, ObserveError> {
        self.observe(fix, measured)
    }
}

/// The reason of a refusal: an invalid model, or an invalid measurement.
pub(super) enum Refused {
    Model,
    Observe(ObserveError),
}

impl Debug for Refused {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model => f.write_str("Model"),
            Self::Observe(error) => error.fmt(f),
        }
    }
}

impl From<ModelError> for Refused {
    fn from(_: ModelError) -> Self {
        Self::Model
    }
}

/// Poses with the fixes of their dimension.
pub(super) trait Placed: Pose {
    /// Applies a position or height fix near this pose.
    fn own(&self, draw: &mut Draw, observer: &mut impl Observer<Self>) -> Result<FixReport<ScalarOf<Self>>, Refused>;
}

fn near<T: Real>(draw: &mut Draw, at: T) -> T {
    let place = at.to_f64() + draw.even(-1.0, 1.0);
    T::from_f64(draw.spoilt(place))
}

fn gate<T: Real>(draw: &mut Draw) -> T {
    if draw.chance(0.5) { T::INFINITY } else { draw.real(1.0, 30.0) }
}

impl<T: Real> Placed for PlanarPose<T> {
    fn own(&self, draw: &mut Draw, observer: &mut impl Observer<Self>) -> Result<FixReport<T>, Refused> {
        let sigma = T::from_f64(draw.magnitude(1e-3, 5.0));
        let mut fix = PositionFix::new(sigma)?.gated(gate(draw))?;
        if draw.chance(0.3) {
            fix = fix.mounted(draw.real(-2.0, 2.0), draw.real(-1.0, 1.0))?;
        }
        let measured = Vector2::new(near(draw, self.x_m), near(draw, self.y_m));
        observer.take(&fix, &measured).map_err(Refused::Observe)
    }
}

impl<T: Real> Placed for AuvPose<T> {
    fn own(&self, draw: &mut Draw, observer: &mut impl Observer<Self>) -> Result<FixReport<T>, Refused> {
        let fix = HeightFix::new(T::from_f64(draw.magnitude(1e-3, 5.0)))?.gated(gate(draw))?;
        let measured = Vector1::new(near(draw, self.z_m));
        observer.take(&fix, &measured).map_err(Refused::Observe)
    }
}

type SensorOf<W> = <<W as World>::Sensing as MeasurementModel>::Sensor;

/// Applies a random fix near this pose.
pub(super) fn observe<T: Real, W: World<Scalar = T, Pose: Placed>>(
    draw: &mut Draw,
    sensor: &SensorOf<W>,
    pose: &W::Pose,
    observer: &mut impl Observer<W::Pose>,
) -> Result<FixReport<T>, Refused> {
    match draw.below(3) {
        0 => pose.own(draw, observer),
        1 => {
            let fix = HeadingFix::<W::Pose>::new(T::from_f64(draw.magnitude(1e-4, 1.0)))?.gated(gate(draw))?;
            let heading = W::Pose::HEADING.map_or(T::ZERO, |heading| pose.coordinates().at(heading));
            let measured = near(draw, heading);
            observer.take(&fix, &Vector1::new(measured)).map_err(Refused::Observe)
        }
        _ => {
            let place: FeatureOf<W> = W::feature(draw, pose);
            let mounting: Option<Mounting<T>> = if draw.chance(0.5) { Some(W::Pose::mounting(draw)?) } else { None };
            let fix = BeaconFix { sensor: *sensor, mounting, place, gate: gate(draw) };
            let measured: MeasurementOf<W> = match sensor.expect(&sensor.frame(pose), &place) {
                Some(expected) => Vector::with(|axis| near(draw, expected.measurement.at(axis))),
                None => W::clutter(draw),
            };
            observer.take(&fix, &measured).map_err(Refused::Observe)
        }
    }
}
