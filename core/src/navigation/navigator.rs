//! From the readings of the instruments to the control of the particles.

use super::{VelocityFilter, VelocityNoise};
use crate::models::{AuvControl, ModelError, Reading, require};
use crate::{PredictError, Real};
use nalgebra::Vector3;

/// Readings of the instruments of an underwater vehicle at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instruments<T> {
    /// Roll φ, rad, from the inertial unit.
    pub roll_rad: T,
    /// Pitch ψ, rad, from the inertial unit.
    pub pitch_rad: T,
    /// Yaw rate from this time on, rad/s, from the gyroscope of the inertial unit.
    pub yaw_rate_radps: Reading<T>,
    /// Velocity along the vehicle's axes, m/s, from the Doppler log, if it has a measurement.
    pub velocity_mps: Option<[T; 3]>,
    /// z, m, from the pressure sensor, if it has a measurement.
    pub z_m: Option<T>,
}

/// A [`VelocityFilter`] with the latest readings of the instruments: computes, from each set of readings, the [`AuvControl`] of the
/// step that ends at its time.
///
/// ```
/// use scphd::models::Reading;
/// use scphd::navigation::{Instruments, Navigator, VelocityNoise};
///
/// let noise = VelocityNoise {
///     walk_mps_rts: 0.1_f64,
///     dvl_sigma_mps: 0.1,
///     z_sigma_m: 0.02,
///     gate_sigmas: 4.0,
///     outliers_believed: 5,
/// };
/// let mut navigator = Navigator::new(noise, -2.0, [0.0; 2]).unwrap();
/// let row = Instruments {
///     roll_rad: 0.0,
///     pitch_rad: 0.0,
///     yaw_rate_radps: Reading { value: 0.1, sigma: 0.02 },
///     velocity_mps: Some([0.3, 0.0, 0.0]),
///     z_m: Some(-2.0),
/// };
/// // The first readings have dt = 0.
/// assert_eq!(navigator.instruments(&row, 0.0), Ok(None));
/// let control = navigator.instruments(&row, 0.1).unwrap().unwrap();
/// assert!((control.velocity_mps.x - 0.3).abs() < 0.01);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Navigator<T: Real> {
    pub(super) velocity: VelocityFilter<T>,
    z_sigma_m: T,
    pub(super) roll_rad: T,
    pub(super) pitch_rad: T,
    pub(super) yaw_rate_radps: Option<Reading<T>>,
}

impl<T: Real> Navigator<T> {
    /// Starts at this z (m) with this roll and pitch (rad).
    ///
    /// # Errors
    /// The noise is out of range, or a number not finite.
    pub fn new(noise: VelocityNoise<T>, z_m: T, [roll_rad, pitch_rad]: [T; 2]) -> Result<Self, ModelError> {
        require(roll_rad.is_finite(), "roll_rad", "finite")?;
        require(pitch_rad.is_finite(), "pitch_rad", "finite")?;
        let (velocity, z_sigma_m) = (VelocityFilter::new(noise, z_m)?, noise.z_sigma_m);
        Ok(Self { velocity, z_sigma_m, roll_rad, pitch_rad, yaw_rate_radps: None })
    }

    /// Replaces the noise of the velocity and of the instruments. Allowed between any two sets of readings.
    ///
    /// # Errors
    /// The noise is out of range; the navigator keeps the previous one.
    pub fn retune(&mut self, noise: VelocityNoise<T>) -> Result<(), ModelError> {
        self.velocity.retune(noise)?;
        self.z_sigma_m = noise.z_sigma_m;
        Ok(())
    }

    /// The control of the `dt` seconds before these readings, `None` if `dt` is zero; then updates with the readings.
    ///
    /// A reading of the Doppler log or pressure sensor that is not finite is ignored.
    ///
    /// # Errors
    /// `dt` is negative or not finite, or roll, pitch or yaw rate is not finite; the navigator is unchanged.
    pub fn instruments(&mut self, row: &Instruments<T>, dt: T) -> Result<Option<AuvControl<T>>, PredictError> {
        let Instruments { roll_rad, pitch_rad, yaw_rate_radps, velocity_mps, z_m } = *row;
        let angles = [roll_rad, pitch_rad, yaw_rate_radps.value, yaw_rate_radps.sigma];
        if !angles.iter().all(|angle| angle.is_finite()) {
            return Err(PredictError::Control);
        }
        let z_m = z_m.filter(|z| z.is_finite());
        let reading = z_m.map(|value| Reading { value, sigma: self.z_sigma_m });
        let control = self.step([roll_rad, pitch_rad], reading, dt)?;
        if let Some(velocity) = velocity_mps {
            self.velocity.dvl(&Vector3::from(velocity));
        }
        if let Some(z) = z_m {
            self.velocity.z(z);
        }
        (self.roll_rad, self.pitch_rad, self.yaw_rate_radps) = (roll_rad, pitch_rad, Some(yaw_rate_radps));
        Ok(control)
    }

    /// The control of `dt` seconds without new readings, `None` if `dt` is zero.
    ///
    /// # Errors
    /// `dt` is negative or not finite; the navigator is unchanged.
    pub fn onward(&mut self, dt: T) -> Result<Option<AuvControl<T>>, PredictError> {
        self.step([self.roll_rad, self.pitch_rad], None, dt)
    }

    fn step(
        &mut self,
        [roll_rad, pitch_rad]: [T; 2],
        z_m: Option<Reading<T>>,
        dt: T,
    ) -> Result<Option<AuvControl<T>>, PredictError> {
        if !(dt >= T::ZERO && dt.is_finite()) {
            return Err(PredictError::TimeStep);
        }
        if dt == T::ZERO {
            return Ok(None);
        }
        let control = AuvControl {
            velocity_mps: self.velocity.velocity_mps(),
            velocity_covariance: self.velocity.covariance(),
            roll_rad,
            pitch_rad,
            yaw_rate_radps: self.yaw_rate_radps,
            z_m,
        };
        // The velocity refers to the attitude at the start of the step.
        self.velocity.predict(self.roll_rad, self.pitch_rad, dt);
        Ok(Some(control))
    }
}

#[cfg(test)]
mod tests {
    use super::super::velocity_filter::tests::NOISE;
    use super::{Instruments, Navigator};
    use crate::{PredictError, Reading, VelocityFilter, VelocityNoise};
    use nalgebra::Vector3;

    const ROW: Instruments<f64> = Instruments {
        roll_rad: 0.1,
        pitch_rad: -0.2,
        yaw_rate_radps: Reading { value: 0.3, sigma: 0.02 },
        velocity_mps: Some([0.4, 0.1, 0.0]),
        z_m: Some(-2.1),
    };

    #[test]
    fn a_step_has_the_previous_velocity_and_the_new_attitude_and_depth() {
        let mut navigator = Navigator::new(NOISE, -2.0, [0.0; 2]).unwrap();
        let mut velocity = VelocityFilter::new(NOISE, -2.0).unwrap();
        let first = navigator.instruments(&ROW, 0.1).unwrap().unwrap();
        assert_eq!(first.velocity_mps, Vector3::zeros());
        assert_eq!((first.roll_rad, first.pitch_rad), (0.1, -0.2));
        assert_eq!(
            (first.yaw_rate_radps, first.z_m.map(|z| (z.value, z.sigma))),
            (None, Some((-2.1, NOISE.z_sigma_m)))
        );
        velocity.predict(0.0, 0.0, 0.1);
        velocity.dvl(&Vector3::new(0.4, 0.1, 0.0));
        velocity.z(-2.1);
        let second = navigator.onward(0.05).unwrap().unwrap();
        assert_eq!((second.velocity_mps, second.velocity_covariance), (velocity.velocity_mps(), velocity.covariance()));
        assert_eq!((second.yaw_rate_radps, second.z_m), (Some(ROW.yaw_rate_radps), None));
        velocity.predict(0.1, -0.2, 0.05);
        assert_eq!(navigator.onward(0.05).unwrap().unwrap().velocity_mps, velocity.velocity_mps());
    }

    #[test]
    fn new_noise_applies_from_the_next_readings_on() {
        let mut navigator = Navigator::new(NOISE, -2.0, [0.0; 2]).unwrap();
        navigator.instruments(&ROW, 0.1).unwrap();
        let (mut same, before) = (navigator, navigator);
        let other = VelocityNoise { walk_mps_rts: 2.0 * NOISE.walk_mps_rts, z_sigma_m: 3.0 * NOISE.z_sigma_m, ..NOISE };
        navigator.retune(other).unwrap();
        let control = navigator.instruments(&ROW, 0.1).unwrap().unwrap();
        assert_eq!(control.z_m.map(|z| z.sigma), Some(other.z_sigma_m));
        same.instruments(&ROW, 0.1).unwrap();
        assert!(navigator.velocity.covariance().get(0, 0) > same.velocity.covariance().get(0, 0));
        let mut refused = before;
        assert!(refused.retune(VelocityNoise { dvl_sigma_mps: 0.0, ..NOISE }).is_err());
        assert_eq!(refused, before);
    }

    #[test]
    fn non_finite_input_changes_nothing() {
        let mut navigator = Navigator::new(NOISE, -2.0, [0.0; 2]).unwrap();
        navigator.instruments(&ROW, 0.0).unwrap();
        let before = navigator;
        let tilted = Instruments { roll_rad: f64::NAN, ..ROW };
        assert_eq!(navigator.instruments(&tilted, 0.1), Err(PredictError::Control));
        assert_eq!(navigator.instruments(&ROW, f64::INFINITY), Err(PredictError::TimeStep));
        assert_eq!(navigator.onward(-0.1), Err(PredictError::TimeStep));
        assert_eq!(navigator, before);
        let silent = Instruments { velocity_mps: None, z_m: None, ..ROW };
        let broken = Instruments { velocity_mps: Some([f64::NAN; 3]), z_m: Some(f64::NAN), ..ROW };
        let mut other = navigator;
        assert_eq!(navigator.instruments(&broken, 0.1), other.instruments(&silent, 0.1));
        assert_eq!(navigator.onward(0.1), other.onward(0.1));
        assert!(Navigator::new(NOISE, -2.0, [f64::NAN, 0.0]).is_err());
    }
}
