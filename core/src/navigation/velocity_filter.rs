//! Velocity of the vehicle from its Doppler log and its pressure sensor (section 7.2.2).

use super::Outcome;
use super::kalman::Kalman;
use crate::models::{ModelError, require, rotation};
use crate::{Real, Symmetric, Vector};
use nalgebra::{Matrix1x4, Matrix3x4, Matrix4, Vector1, Vector3, Vector4};

/// Process noise of the velocity, and noise of the instruments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityNoise<T> {
    /// Random walk of each velocity component, (m/s)/√s.
    pub walk_mps_rts: T,
    /// Standard deviation of each velocity component from the Doppler log, m/s.
    pub dvl_sigma_mps: T,
    /// Standard deviation of z from the pressure sensor, m.
    pub z_sigma_m: T,
    /// Gate: readings with a Mahalanobis distance above this number of standard deviations are rejected as outliers.
    pub gate_sigmas: T,
    /// Number of consecutive outliers after which the Doppler log or the pressure sensor is accepted again, because the filter must
    /// have diverged.
    pub outliers_believed: u16,
}

impl<T: Real> VelocityNoise<T> {
    /// Checks all fields, and returns the first that is out of range.
    ///
    /// # Errors
    /// All must be finite and positive.
    pub fn check(&self) -> Result<(), ModelError> {
        let usable = |x: T| x > T::ZERO && x.is_finite();
        require(usable(self.walk_mps_rts), "walk_mps_rts", "finite and positive")?;
        require(usable(self.dvl_sigma_mps), "dvl_sigma_mps", "finite and positive")?;
        require(usable(self.z_sigma_m), "z_sigma_m", "finite and positive")?;
        require(usable(self.gate_sigmas), "gate_sigmas", "finite and positive")?;
        require(self.outliers_believed > 0, "outliers_believed", "at least 1")
    }

    /// The gate as a squared Mahalanobis distance.
    pub(super) fn gate(&self) -> T {
        self.gate_sigmas * self.gate_sigmas
    }

    /// Increase of the variance of each velocity component in `dt` seconds, m²/s².
    pub(super) fn walked(&self, dt: T) -> T {
        self.walk_mps_rts * self.walk_mps_rts * dt
    }
}

/// Number of an instrument's readings that were rejected in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Outliers(pub(super) u16);

impl Outliers {
    /// No rejected reading, for a quantity with a known initial value.
    pub(super) const NONE: Self = Self(0);
    /// No reading so far of a quantity that only readings determine.
    pub(super) const NO_READING: Self = Self(u16::MAX);

    /// Counts the outcome of a reading. Returns whether the filter must start again from this reading, because too many in a
    /// row were rejected.
    ///
    /// The first reading, and one from which the filter has started again, may itself be an outlier: if the next reading is
    /// rejected, the filter starts again from that one.
    pub(super) fn counted(&mut self, outcome: Outcome, reading: &impl Vector, believed: u16) -> bool {
        if reading.as_slice().iter().any(|x| !x.is_finite()) {
            return false;
        }
        let is_first = *self == Self::NO_READING;
        let (rejected, start_again) = match outcome {
            Outcome::Rejected => (self.0.saturating_add(1), self.0.saturating_add(1) >= believed),
            Outcome::Accepted => (0, false),
        };
        self.0 = if is_first || start_again { believed.saturating_sub(1) } else { rejected };
        start_again
    }
}

/// Kalman filter of the velocity along the vehicle's axes, a random walk that a Doppler velocity log measures, and of z, which a
/// pressure sensor measures.
///
/// The state is (v_x, v_y, v_z, z). The vertical velocity in the map, which follows from the velocity, roll and pitch, changes z,
/// so that the pressure sensor alone keeps the vertical velocity observable. While the Doppler log has no bottom lock there are no
/// velocity measurements; the uncertainty then grows with the random walk, and with it the spread of the particles. Readings beyond
/// the gate are rejected.
///
/// ```
/// use nalgebra::Vector3;
/// use scphd::navigation::{Outcome, VelocityFilter, VelocityNoise};
///
/// let noise = VelocityNoise {
///     walk_mps_rts: 0.1_f32,
///     dvl_sigma_mps: 0.1,
///     z_sigma_m: 0.02,
///     gate_sigmas: 4.0,
///     outliers_believed: 5,
/// };
/// let mut filter = VelocityFilter::new(noise, -2.0)?;
/// for _ in 0..50 {
///     filter.predict(0.0, 0.0, 0.1);
///     assert_eq!(filter.dvl(&Vector3::new(0.3, 0.0, 0.0)), Outcome::Accepted);
/// }
/// assert_eq!(filter.dvl(&Vector3::new(5.0, 0.0, 0.0)), Outcome::Rejected);
/// assert!((filter.velocity_mps().x - 0.3).abs() < 0.01);
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityFilter<T: Real> {
    noise: VelocityNoise<T>,
    pub(super) state: Kalman<Vector4<T>>,
    pub(super) outliers: Outliers,
    pub(super) z_outliers: Outliers,
}

impl<T: Real> VelocityFilter<T> {
    /// A vehicle at this z, m, with zero velocity of standard deviation 1 m/s along each axis; the first reading is never rejected.
    ///
    /// # Errors
    /// The noise is out of range, or z not finite.
    pub fn new(noise: VelocityNoise<T>, z_m: T) -> Result<Self, ModelError> {
        noise.check()?;
        require(z_m.is_finite(), "z_m", "finite")?;
        let mean = Vector4::from([T::ZERO, T::ZERO, T::ZERO, z_m]);
        let (velocity, z) = (T::ONE, noise.z_sigma_m * noise.z_sigma_m);
        let covariance = Symmetric::from_diagonal([velocity, velocity, velocity, z]);
        let (outliers, z_outliers) = (Outliers::NO_READING, Outliers::NONE);
        Ok(Self { noise, state: Kalman { mean, covariance }, outliers, z_outliers })
    }

    /// Replaces the noise. Allowed between any two steps.
    ///
    /// # Errors
    /// The noise is out of range; the filter keeps the previous one.
    pub fn retune(&mut self, noise: VelocityNoise<T>) -> Result<(), ModelError> {
        noise.check()?;
        self.noise = noise;
        Ok(())
    }

    /// Predicts by `dt` seconds with this roll and pitch, rad.
    pub fn predict(&mut self, roll_rad: T, pitch_rad: T, dt: T) {
        let turned = rotation(roll_rad, pitch_rad, T::ZERO);
        let [[_, _, zx], [_, _, zy], [_, _, zz]] = turned.data.0;
        let mut transition = Matrix4::identity();
        for (element, share) in transition.row_mut(3).iter_mut().zip([zx, zy, zz]) {
            *element = share * dt;
        }
        let walk = self.noise.walked(dt);
        self.state.predict(&transition, &Symmetric::from_diagonal([walk, walk, walk, T::ZERO]));
    }

    /// Updates with the velocity from the Doppler log, along the vehicle's axes, m/s.
    pub fn dvl(&mut self, velocity_mps: &Vector3<T>) -> Outcome {
        let h = Matrix3x4::identity();
        let variance = self.noise.dvl_sigma_mps * self.noise.dvl_sigma_mps;
        let outcome = self.state.update(velocity_mps, &h, &Symmetric::from_diagonal([variance; 3]), self.noise.gate());
        if self.outliers.counted(outcome, velocity_mps, self.noise.outliers_believed) {
            let z_variance = self.state.covariance.get(3, 3);
            self.state.mean = Vector4::from([velocity_mps.x, velocity_mps.y, velocity_mps.z, self.z_m()]);
            self.state.covariance = Symmetric::from_diagonal([variance, variance, variance, z_variance]);
        }
        outcome
    }

    /// Updates with z from the pressure sensor, m.
    pub fn z(&mut self, z_m: T) -> Outcome {
        let h = Matrix1x4::new(T::ZERO, T::ZERO, T::ZERO, T::ONE);
        let variance = self.noise.z_sigma_m * self.noise.z_sigma_m;
        let reading = Vector1::new(z_m);
        let outcome = self.state.update(&reading, &h, &Symmetric::from_diagonal([variance]), self.noise.gate());
        if self.z_outliers.counted(outcome, &reading, self.noise.outliers_believed) {
            let [[x, y, z, _]] = self.state.mean.data.0;
            self.state.mean = Vector4::from([x, y, z, z_m]);
            let velocity = self.state.covariance;
            self.state.covariance = Symmetric::from_fn(|row, column| match (row, column) {
                (3, 3) => variance,
                (3, _) => T::ZERO,
                _ => velocity.get(row, column),
            });
        }
        outcome
    }

    /// Velocity along the vehicle's axes, m/s.
    pub fn velocity_mps(&self) -> Vector3<T> {
        let [[x, y, z, _]] = self.state.mean.data.0;
        Vector3::new(x, y, z)
    }

    /// Covariance of the velocity, m²/s².
    pub fn covariance(&self) -> Symmetric<Vector3<T>> {
        self.state.covariance.leading()
    }

    /// z, m.
    pub fn z_m(&self) -> T {
        let [[_, _, _, z]] = self.state.mean.data.0;
        z
    }

    /// Time constant of the filter, after which most of a change of the velocity is in the estimate, s: σ_v √(Δt) / q for a log
    /// that measures every `dvl_interval_s`.
    #[must_use]
    pub fn time_constant_s(noise: &VelocityNoise<T>, dvl_interval_s: T) -> T {
        noise.dvl_sigma_mps * dvl_interval_s.sqrt() / noise.walk_mps_rts
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::{Outcome, VelocityFilter, VelocityNoise};
    use crate::Noise;
    use nalgebra::Vector3;

    pub(crate) const NOISE: VelocityNoise<f64> = VelocityNoise {
        walk_mps_rts: 0.05,
        dvl_sigma_mps: 0.1,
        z_sigma_m: 0.02,
        gate_sigmas: 4.0,
        outliers_believed: 5,
    };

    #[test]
    fn it_converges_to_the_closed_form_and_is_consistent() {
        let (mut squares, mut variance, runs) = (0.0, 0.0, 400);
        for run in 0..runs {
            let mut noise = Noise::seeded(run);
            let mut filter = VelocityFilter::new(NOISE, 0.0).unwrap();
            let mut truth = Vector3::new(0.3, -0.1, 0.0);
            for _ in 0..100 {
                truth += Vector3::from_fn(|_, _| 0.05 * 0.1_f64.sqrt() * noise.normal::<f64>());
                filter.predict(0.0, 0.0, 0.1);
                filter.dvl(&(truth + Vector3::from_fn(|_, _| 0.1 * noise.normal::<f64>())));
            }
            squares += (filter.velocity_mps() - truth).norm_squared() / 3.0;
            variance = filter.covariance().get(0, 0);
        }
        // P = −q/2 + √(q²/4 + q r) before, P r/(P + r) after the reading, with q = 0.05² · 0.1 and r = 0.01 a step.
        let (q, r) = (0.000_25, 0.01_f64);
        let before = 0.5 * q + (0.25 * q * q + q * r).sqrt();
        assert!((variance - before * r / (before + r)).abs() < 1e-6, "{variance}");
        assert!((squares / runs as f64 / variance - 1.0).abs() < 0.12, "{squares} {variance}");
        assert!((VelocityFilter::time_constant_s(&NOISE, 0.1) - 0.632).abs() < 1e-3);
    }

    #[test]
    fn without_bottom_lock_the_variance_grows_except_the_vertical_with_pressure() {
        let mut filter = VelocityFilter::new(NOISE, -1.0).unwrap();
        for _ in 0..100 {
            filter.predict(0.0, 0.0, 0.1);
            filter.dvl(&Vector3::new(0.3, 0.0, -0.1));
        }
        let before = filter.covariance();
        let start = filter.z_m();
        for step in 1..=50 {
            filter.predict(0.0, 0.0, 0.1);
            assert_eq!(filter.z(start - 0.01 * f64::from(step)), Outcome::Accepted);
        }
        let after = filter.covariance();
        assert!((after.get(0, 0) - before.get(0, 0) - 0.05 * 0.05 * 5.0).abs() < 1e-9);
        assert!(after.get(2, 2) < 0.5 * after.get(0, 0));
        assert!((filter.velocity_mps().z + 0.1).abs() < 0.03, "{}", filter.velocity_mps());
    }

    #[test]
    fn outliers_are_rejected_until_they_persist() {
        let mut filter = VelocityFilter::new(NOISE, 0.0).unwrap();
        for _ in 0..50 {
            filter.predict(0.0, 0.0, 0.1);
            filter.dvl(&Vector3::new(0.3, 0.0, 0.0));
        }
        let before = filter;
        assert_eq!(filter.dvl(&Vector3::new(2.0, 0.0, 0.0)), Outcome::Rejected);
        assert_eq!(filter.dvl(&Vector3::new(f64::NAN, 0.0, 0.0)), Outcome::Rejected);
        assert_eq!(filter.velocity_mps(), before.velocity_mps());
        // A valid reading between them resets the count.
        assert_eq!(filter.dvl(&Vector3::new(0.3, 0.0, 0.0)), Outcome::Accepted);
        for _ in 0..5 {
            assert_eq!(filter.dvl(&Vector3::new(2.0, 0.1, 0.0)), Outcome::Rejected);
        }
        assert_eq!(filter.velocity_mps(), Vector3::new(2.0, 0.1, 0.0));
        assert_eq!(filter.dvl(&Vector3::new(2.0, 0.1, 0.0)), Outcome::Accepted);
        assert_eq!(filter.z(40.0), Outcome::Rejected);
    }

    #[test]
    fn a_first_reading_that_is_an_outlier_is_replaced_by_the_next() {
        let (good, bad) = (Vector3::new(0.3, 0.0, 0.0), Vector3::new(1.2, -0.8, 0.0));
        // At the start, and after persistent outliers: the last of them, from which the filter starts again, is another outlier.
        let mut known = VelocityFilter::new(NOISE, 0.0).unwrap();
        (0..50).for_each(|_| {
            known.predict(0.0, 0.0, 0.1);
            known.dvl(&(good * 5.0));
        });
        (0..4).for_each(|_| assert_eq!(known.dvl(&good), Outcome::Rejected));
        for mut filter in [VelocityFilter::new(NOISE, 0.0).unwrap(), known] {
            filter.predict(0.0, 0.0, 0.1);
            filter.dvl(&bad);
            assert!((filter.velocity_mps() - bad).norm() < 0.02);
            filter.predict(0.0, 0.0, 0.1);
            filter.dvl(&good);
            assert_eq!(filter.velocity_mps(), good);
            // After two consistent readings an outlier is rejected.
            assert_eq!(filter.dvl(&good), Outcome::Accepted);
            assert_eq!(filter.dvl(&bad), Outcome::Rejected);
            assert_eq!(filter.velocity_mps(), good);
        }
    }

    /// After a step of 1e25 s, and steps beyond the range of the scalar.
    #[test]
    fn it_recovers_from_any_step() {
        for dt in [1e25, 1e160, 1e300] {
            let mut filter = VelocityFilter::new(NOISE, -2.0).unwrap();
            let reading = Vector3::new(0.3, 0.0, 0.0);
            (0..50).for_each(|_| {
                filter.predict(0.1, 0.1, 0.1);
                filter.dvl(&reading);
                filter.z(-2.0);
            });
            filter.predict(0.1, 0.1, dt);
            (0..50).for_each(|_| {
                filter.predict(0.0, 0.0, 0.1);
                filter.dvl(&reading);
                filter.z(-2.0);
            });
            assert!((filter.velocity_mps() - reading).norm() < 0.05, "{dt}: {}", filter.velocity_mps());
            assert!((filter.z_m() + 2.0).abs() < 0.05, "{dt}: {}", filter.z_m());
            assert!(filter.covariance().factor().is_some() && filter.covariance().get(2, 2) < 0.01);
        }
    }

    #[test]
    fn bad_noise_is_named() {
        let field = |noise| VelocityFilter::new(noise, 0.0).unwrap_err().field;
        assert_eq!(field(VelocityNoise { dvl_sigma_mps: 0.0, ..NOISE }), "dvl_sigma_mps");
        assert_eq!(field(VelocityNoise { outliers_believed: 0, ..NOISE }), "outliers_believed");
        assert_eq!(VelocityFilter::new(NOISE, f64::NAN).unwrap_err().field, "z_m");
    }
}
