//! Dead reckoning without a map: the baseline of chapter 7.

use super::kalman::Kalman;
use super::velocity_filter::Outliers;
use super::{Outcome, VelocityNoise};
use crate::models::{ModelError, require};
use crate::{Real, Symmetric, rotation};
use nalgebra::{Matrix1x6, Matrix3x6, Matrix6, Vector1, Vector3, Vector6};

/// Dead reckoning with velocity log, pressure sensor and inertial unit (section 7.2.4): a Kalman filter of the position and of the
/// velocity along the vehicle's axes.
///
/// The attitude of the inertial unit, yaw included, is assumed exact: its errors cause errors of the position that the covariance
/// does not contain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeadReckoning<T: Real> {
    noise: VelocityNoise<T>,
    /// (x, y, z, v_x, v_y, v_z).
    state: Kalman<Vector6<T>>,
    outliers: Outliers,
    z_outliers: Outliers,
}

impl<T: Real> DeadReckoning<T> {
    /// Starts at an exactly known position, m.
    ///
    /// # Errors
    /// The noise is out of range, or the position not finite.
    pub fn new(noise: VelocityNoise<T>, position_m: Vector3<T>) -> Result<Self, ModelError> {
        noise.check()?;
        require(position_m.iter().all(|x| x.is_finite()), "position_m", "finite")?;
        let (zero, one) = (T::ZERO, T::ONE);
        let mean = Vector6::from([position_m.x, position_m.y, position_m.z, zero, zero, zero]);
        let covariance = Symmetric::from_diagonal([zero, zero, zero, one, one, one]);
        let (outliers, z_outliers) = (Outliers::NO_READING, Outliers::NONE);
        Ok(Self { noise, state: Kalman { mean, covariance }, outliers, z_outliers })
    }

    /// Predicts by `dt` seconds with this attitude, rad.
    pub fn predict(&mut self, roll_rad: T, pitch_rad: T, yaw_rad: T, dt: T) {
        let mut transition = Matrix6::identity();
        transition.fixed_view_mut::<3, 3>(0, 3).copy_from(&(rotation(roll_rad, pitch_rad, yaw_rad) * dt));
        let (zero, walk) = (T::ZERO, self.noise.walked(dt));
        self.state.predict(&transition, &Symmetric::from_diagonal([zero, zero, zero, walk, walk, walk]));
    }

    /// Updates with the velocity from the Doppler log, along the vehicle's axes, m/s.
    pub fn dvl(&mut self, velocity_mps: &Vector3<T>) -> Outcome {
        let variance = self.noise.dvl_sigma_mps * self.noise.dvl_sigma_mps;
        let h = Matrix3x6::from_fn(|row, column| if column == row + 3 { T::ONE } else { T::ZERO });
        let noise = Symmetric::from_diagonal([variance; 3]);
        let outcome = self.state.update(velocity_mps, &h, &noise, self.noise.gate());
        if self.outliers.counted(outcome, velocity_mps, self.noise.outliers_believed) {
            let [[x, y, z, ..]] = self.state.mean.data.0;
            self.state.mean = Vector6::from([x, y, z, velocity_mps.x, velocity_mps.y, velocity_mps.z]);
            let position = self.state.covariance.leading::<Vector3<T>>();
            self.state.covariance = Symmetric::from_fn(|row, column| match (row, column) {
                (0..3, 0..3) => position.get(row, column),
                _ if row == column => variance,
                _ => T::ZERO,
            });
        }
        outcome
    }

    /// Updates with z from the pressure sensor, m.
    pub fn z(&mut self, z_m: T) -> Outcome {
        let variance = self.noise.z_sigma_m * self.noise.z_sigma_m;
        let h = Matrix1x6::from_fn(|_, column| if column == 2 { T::ONE } else { T::ZERO });
        let reading = Vector1::new(z_m);
        let outcome = self.state.update(&reading, &h, &Symmetric::from_diagonal([variance]), self.noise.gate());
        if self.z_outliers.counted(outcome, &reading, self.noise.outliers_believed) {
            let [[x, y, _, vx, vy, vz]] = self.state.mean.data.0;
            self.state.mean = Vector6::from([x, y, z_m, vx, vy, vz]);
            let held = self.state.covariance;
            self.state.covariance = Symmetric::from_fn(|row, column| match (row, column) {
                (2, 2) => variance,
                (2, _) | (_, 2) => T::ZERO,
                _ => held.get(row, column),
            });
        }
        outcome
    }

    /// Position, m.
    pub fn position_m(&self) -> Vector3<T> {
        let [[x, y, z, ..]] = self.state.mean.data.0;
        Vector3::new(x, y, z)
    }

    /// Covariance of the position, m², from the errors of the velocity only.
    pub fn covariance(&self) -> Symmetric<Vector3<T>> {
        self.state.covariance.leading()
    }
}

#[cfg(test)]
mod tests {
    use super::super::velocity_filter::tests::NOISE;
    use super::{DeadReckoning, Outcome};
    use crate::Noise;
    use nalgebra::Vector3;

    /// With an exact yaw, the error is the integral of the velocity log's noise, and agrees with the covariance.
    #[test]
    fn the_error_agrees_with_the_covariance() {
        let (mut squares, mut variance, runs) = (0.0, 0.0, 400);
        for run in 0..runs {
            let mut noise = Noise::seeded(run);
            let mut truth = Vector3::new(1.0, 2.0, -3.0);
            let mut filter = DeadReckoning::new(NOISE, truth).unwrap();
            let velocity = Vector3::new(0.3, 0.0, 0.0);
            for step in 0..300 {
                let yaw = 0.01 * f64::from(step);
                filter.dvl(&(velocity + Vector3::from_fn(|_, _| 0.1 * noise.normal::<f64>())));
                filter.z(truth.z + 0.02 * noise.normal::<f64>());
                filter.predict(0.0, 0.0, yaw, 0.1);
                truth += Vector3::new(yaw.cos(), yaw.sin(), 0.0) * 0.03;
            }
            squares += (filter.position_m() - truth).xy().norm_squared() / 2.0;
            variance = filter.covariance().get(0, 0);
        }
        // White noise of 0.1 m/s at 10 Hz over 30 s gives a variance of 0.1² · 0.1 · 30 = 0.03 m²; over a time much longer than
        // its time constant the filter cannot be better.
        let measured = squares / runs as f64;
        assert!((measured / 0.03 - 1.0).abs() < 0.2, "{measured}");
        // The filter assumes a random walk of the velocity, but here the velocity is constant.
        assert!(variance > 0.9 * measured && variance < 1.5 * measured, "{variance} {measured}");
    }

    #[test]
    fn a_wrong_yaw_rotates_the_path() {
        let mut filter = DeadReckoning::new(NOISE, Vector3::new(0.0, 0.0, -1.0)).unwrap();
        for _ in 0..200 {
            filter.predict(0.0, 0.0, 0.25, 0.1);
            filter.dvl(&Vector3::new(0.5, 0.0, 0.0));
        }
        let position = filter.position_m();
        assert!((position.y.atan2(position.x) - 0.25).abs() < 1e-9, "{position}");
        assert!((position.xy().norm() - 10.0).abs() < 0.2);
        assert!(DeadReckoning::new(NOISE, Vector3::new(f64::NAN, 0.0, 0.0)).is_err());
    }

    #[test]
    fn a_constant_depth_is_accepted_after_several_rejections() {
        let mut filter = DeadReckoning::new(NOISE, Vector3::zeros()).unwrap();
        let outcomes: [Outcome; 6] = core::array::from_fn(|_| filter.z(-30.0));
        assert_eq!(outcomes[..5], [Outcome::Rejected; 5]);
        assert_eq!((outcomes[5], filter.position_m()), (Outcome::Accepted, Vector3::new(0.0, 0.0, -30.0)));
    }

    #[test]
    fn a_constant_velocity_is_accepted_after_several_rejections() {
        let mut filter = DeadReckoning::new(NOISE, Vector3::zeros()).unwrap();
        for _ in 0..20 {
            filter.predict(0.0, 0.0, 0.0, 0.1);
            filter.dvl(&Vector3::new(0.0, 0.0, 0.0));
        }
        let fast = Vector3::new(3.0, 0.0, 0.0);
        let outcomes: [Outcome; 6] = core::array::from_fn(|_| filter.dvl(&fast));
        assert_eq!(outcomes[..5], [Outcome::Rejected; 5]);
        assert_eq!(outcomes[5], Outcome::Accepted);
    }
}
