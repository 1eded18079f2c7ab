//! The birth intensity of a measurement (5.9, 5.10).

use crate::detection::view::View;
use crate::models::noise_at;
use crate::numerics::range::is_within_range;
use crate::numerics::vector::applied;
use crate::{
    Component, CovarianceOf, InverseOf, Linear, Matrix, MeasurementModel, Place, Pose, PositionOf, Real, ScalarOf,
    Sensor, Symmetric, Vector,
};

/// The position of a newborn feature.
#[derive(Debug)]
pub(crate) struct Newborn<D: Place> {
    pub(crate) position: D,
    pub(crate) covariance: Symmetric<D>,
    /// Whether the covariance had to be repaired.
    pub(crate) repaired: bool,
}

impl<T: Real, D: Place<Scalar = T>> Newborn<D> {
    /// The feature at h⁻¹(z, x), with the covariance of the measurement and of the pose; `None` if there is no such feature in
    /// view. Not inlined, because several callers share it and its code is large.
    #[inline(never)]
    pub(crate) fn of<X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>>>(
        view: &View<'_, X>,
        pose_covariance: Option<&CovarianceOf<X::Pose>>,
        measured: &X::Measurement,
    ) -> Option<Self> {
        // A feature out of view cannot have caused the measurement; if it was born there it would never be missed, and would
        // remain in the map.
        let in_view = |inverse: &InverseOf<X::Sensor>| {
            view.sees(&inverse.feature, measured) && inverse.feature.as_slice().iter().all(|x| x.is_finite())
        };
        let inverse = view.sensor.invert(&view.frame, measured).filter(in_view)?;
        let mut noise = noise_at(view.sensor, measured);
        if let Some(pose_covariance) = pose_covariance
            && let Some(expected) = view.sensor.expect(&view.frame, &inverse.feature)
        {
            noise = noise.plus(&view.blur(pose_covariance, &inverse.feature, &expected));
        }
        // A covariance beyond the range of the scalar gives no birth either.
        let (covariance, repaired) = noise.congruence::<D>(&inverse.jacobian).kept_positive_definite()?;
        is_within_range(&inverse.feature).then_some(Self { position: inverse.feature, covariance, repaired })
    }

    /// As a static feature.
    pub(crate) fn still(&self, label: u32, ln_weight: T) -> Component<D> {
        Component { label, ln_weight, mean: self.position, covariance: self.covariance }
    }

    /// As a moving feature of unknown velocity.
    pub(crate) fn moving(&self, label: u32, ln_weight: T, velocity_sigma_mps: T) -> Component<D::Moving> {
        let velocity_variance = velocity_sigma_mps * velocity_sigma_mps;
        let covariance = Symmetric::from_fn(|row, column| {
            let velocity = if row == column { velocity_variance } else { T::ZERO };
            if row < D::DIMENSION { self.covariance.get(row, column) } else { velocity }
        });
        Component { label, ln_weight, mean: D::Moving::with(|row| self.position.at(row)), covariance }
    }
}

/// The rotation and displacement that keep features where they are as seen from the vehicle, when its pose is replaced by another:
/// about the vertical, because all particles have the same roll and pitch.
#[derive(Debug)]
pub(crate) struct Carried<D: Place> {
    rotation: Linear<D, D>,
    from: D,
    to: D,
}

impl<T: Real, D: Place<Scalar = T>> Carried<D> {
    pub(crate) fn between<P: Pose<Scalar = T, Position = D>>(from: &P, to: &P) -> Self {
        let ([.., before], [.., after]) = (from.on_ground(), to.on_ground());
        let (sine, cosine) = (after - before).sin_cos();
        let rotation = Matrix::with(|row, column| match (row, column) {
            (0, 0) | (1, 1) => cosine,
            (0, 1) => -sine,
            (1, 0) => sine,
            _ if row == column => T::ONE,
            _ => T::ZERO,
        });
        Self { rotation, from: place(from), to: place(to) }
    }

    /// The feature at the other pose; `None` if its position or covariance is then out of range.
    pub(crate) fn newborn(&self, position: &D, covariance: &Symmetric<D>) -> Option<Newborn<D>> {
        let position = self.to + applied::<D, D>(&self.rotation, &(*position - self.from));
        let (covariance, repaired) = covariance.congruence::<D>(&self.rotation).kept_positive_definite()?;
        is_within_range(&position).then_some(Newborn { position, covariance, repaired })
    }
}

/// The position of the vehicle in its map.
fn place<P: Pose>(pose: &P) -> PositionOf<P>
where
    ScalarOf<P>: Real,
{
    let [x, y, _] = pose.on_ground();
    Vector::with(|k| match k {
        0 => x,
        1 => y,
        _ => pose.height_m(),
    })
}
