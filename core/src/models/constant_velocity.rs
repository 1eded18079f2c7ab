//! Motion of moving features (5.14): constant velocity with white acceleration noise.

use super::{ModelError, require};
use crate::{Component, Place, Real, Symmetric, Vector};

/// Constant-velocity model with white acceleration noise and a mean lifetime.
///
/// Two steps have exactly the same result as one step of the total length, so that steps can be accumulated and applied at once.
///
/// ```
/// use nalgebra::{Vector2, Vector4};
/// use scphd::models::ConstantVelocity;
/// use scphd::numerics::Symmetric;
/// use scphd::Component;
///
/// let motion = ConstantVelocity { acceleration_psd: 0.1_f64, lifetime_s: 100.0 };
/// let walker = Component {
///     mean: Vector4::new(0.0, 0.0, 1.0, -0.5),
///     covariance: Symmetric::from_diagonal([0.01, 0.01, 0.1, 0.1]),
///     ..Component::ZERO
/// };
/// let later = motion.advance::<Vector2<f64>>(&walker, 2.0).unwrap();
/// assert_eq!(later.mean, Vector4::new(2.0, -1.0, 1.0, -0.5));
/// assert!((later.ln_weight + 0.02).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConstantVelocity<T> {
    /// q, spectral density of the acceleration along each axis, m²/s³: after a time t the standard deviation of the velocity has
    /// grown to √(q t), and that of the position to √(q t³/3).
    pub acceleration_psd: T,
    /// τ, mean lifetime, s: the probability of survival of (5.14) is exp(−dt/τ). Infinite: features never vanish.
    pub lifetime_s: T,
}

impl<T: Real> ConstantVelocity<T> {
    /// Checks all fields, and returns the first that is out of range.
    ///
    /// # Errors
    /// The density must be finite and positive, the lifetime positive.
    pub fn check(&self) -> Result<(), ModelError> {
        self.check_as(["acceleration_psd", "lifetime_s"])
    }

    /// As [`check`](Self::check), with the names of the fields in the configuration that contains this model.
    pub(crate) fn check_as(&self, [psd, lifetime]: [&'static str; 2]) -> Result<(), ModelError> {
        require(self.acceleration_psd > T::ZERO && self.acceleration_psd.is_amount(), psd, "finite and positive")?;
        require(self.lifetime_s > T::ZERO, lifetime, "positive")
    }

    /// The component predicted by `dt` seconds, of a feature with positions `D`. `None` if it leaves the range of the scalar.
    #[must_use]
    pub fn advance<D: Place<Scalar = T>>(
        &self,
        component: &Component<D::Moving>,
        dt: T,
    ) -> Option<Component<D::Moving>> {
        let (d, p) = (D::DIMENSION, &component.covariance);
        let mean = D::Moving::with(|row| {
            let moved = if row < d { dt * component.mean.at(row + d) } else { T::ZERO };
            component.mean.at(row) + moved
        });
        let in_velocity = self.acceleration_psd * dt;
        let in_both = in_velocity * dt * T::from_f64(0.5);
        let in_position = in_velocity * dt * dt / T::from_f64(3.0);
        // F P Fᵀ + Q for `row` ≥ `column`, block by block.
        let covariance = Symmetric::from_fn(|row, column| {
            let noise = |same, q| if same { q } else { T::ZERO };
            let held = p.get(row, column);
            if row < d {
                let crossed = p.get(row, column + d) + p.get(row + d, column);
                held + dt * crossed + dt * dt * p.get(row + d, column + d) + noise(row == column, in_position)
            } else if column < d {
                held + dt * p.get(row, column + d) + noise(row == column + d, in_both)
            } else {
                held + noise(row == column, in_velocity)
            }
        });
        let (covariance, _) = covariance.kept_positive_definite()?;
        let ln_weight = component.ln_weight - dt / self.lifetime_s;
        let finite = mean.as_slice().iter().all(|coordinate| coordinate.is_finite());
        finite.then_some(Component { label: component.label, ln_weight, mean, covariance })
    }
}

#[cfg(test)]
mod tests {
    use super::ConstantVelocity;
    use crate::{Component, Symmetric};
    use nalgebra::{Matrix4, Vector2, Vector4};

    const MOTION: ConstantVelocity<f64> = ConstantVelocity { acceleration_psd: 0.3, lifetime_s: 20.0 };

    fn component() -> Component<Vector4<f64>> {
        let root = Matrix4::new(1.0, 0.2, -0.3, 0.1, 0.0, 0.8, 0.4, 0.2, 0.1, 0.0, 0.5, 0.3, 0.2, 0.1, 0.0, 0.7);
        let full = root * root.transpose();
        let covariance = Symmetric::from_fn(|row, column| full[(row, column)]);
        Component { label: 7, ln_weight: -0.2, mean: Vector4::new(1.0, 2.0, 0.5, -0.3), covariance }
    }

    #[test]
    fn one_step_is_that_of_the_matrices() {
        let dt = 0.7;
        let mut f = Matrix4::identity();
        (f[(0, 2)], f[(1, 3)]) = (dt, dt);
        let mut q = Matrix4::zeros();
        for axis in 0..2 {
            q[(axis, axis)] = dt * dt * dt / 3.0;
            (q[(axis, axis + 2)], q[(axis + 2, axis)]) = (dt * dt / 2.0, dt * dt / 2.0);
            q[(axis + 2, axis + 2)] = dt;
        }
        let (before, after) = (component(), MOTION.advance::<Vector2<f64>>(&component(), dt).unwrap());
        let expected = f * before.covariance.to_matrix() * f.transpose() + q * 0.3;
        assert!((after.covariance.to_matrix() - expected).norm() < 1e-14);
        assert!((after.mean - f * before.mean).norm() < 1e-15);
        assert!((after.ln_weight - (-0.2 - 0.7 / 20.0)).abs() < 1e-15);
        assert_eq!(after.label, 7);
    }

    #[test]
    fn two_steps_equal_one_of_their_total_length() {
        let first = MOTION.advance::<Vector2<f64>>(&component(), 0.3).unwrap();
        let twice = MOTION.advance::<Vector2<f64>>(&first, 1.1).unwrap();
        let once = MOTION.advance::<Vector2<f64>>(&component(), 1.4).unwrap();
        assert!((twice.mean - once.mean).norm() < 1e-14 && (twice.ln_weight - once.ln_weight).abs() < 1e-14);
        assert!((twice.covariance.to_matrix() - once.covariance.to_matrix()).norm() < 1e-13);
    }

    #[test]
    fn a_step_out_of_range_gives_no_component() {
        assert!(MOTION.advance::<Vector2<f64>>(&component(), 1e25).is_some());
        assert_eq!(MOTION.advance::<Vector2<f64>>(&component(), 1e160), None);
    }

    #[test]
    fn invalid_parameters_are_refused() {
        assert!(MOTION.check().is_ok());
        assert!(ConstantVelocity { lifetime_s: f64::INFINITY, ..MOTION }.check().is_ok());
        let bad = ConstantVelocity { acceleration_psd: 0.0, ..MOTION };
        assert_eq!(bad.check().unwrap_err().field, "acceleration_psd");
        assert_eq!(ConstantVelocity { lifetime_s: f64::NAN, ..MOTION }.check().unwrap_err().field, "lifetime_s");
    }
}
