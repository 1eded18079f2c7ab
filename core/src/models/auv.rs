//! An underwater vehicle with a velocity log, a pressure sensor and an inertial unit (section 7.2.2).

use super::{AuvPose, Linearised, ModelError, Motion, require, rotation};
use crate::{Noise, Rates, Real, Symmetric, wrap};
use nalgebra::{Matrix3, SMatrix, Vector3, Vector5};

/// Reading of an instrument, with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading<T> {
    /// The value.
    pub value: T,
    /// Standard deviation of its error, above zero.
    pub sigma: T,
}

/// The control of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AuvControl<T: Real> {
    /// Velocity along the vehicle's axes, m/s, as estimated by the [`VelocityFilter`](crate::navigation::VelocityFilter).
    pub velocity_mps: Vector3<T>,
    /// Its covariance, m²/s².
    pub velocity_covariance: Symmetric<Vector3<T>>,
    /// Roll φ at the end of the step, rad, assumed exact.
    pub roll_rad: T,
    /// Pitch ψ at the end of the step, rad, assumed exact.
    pub pitch_rad: T,
    /// Mean yaw rate during the step, rad/s, if there is a gyroscope.
    pub yaw_rate_radps: Option<Reading<T>>,
    /// z at the end of the step, m, if there is a pressure sensor: minus the depth below the map's origin.
    pub z_m: Option<Reading<T>>,
}

impl<T: Real> AuvControl<T> {
    /// The control converted to another precision.
    #[must_use]
    pub fn rounded<U: Real>(&self) -> AuvControl<U> {
        let round = |number: T| U::from_f64(number.to_f64());
        let reading = |reading: Reading<T>| Reading { value: round(reading.value), sigma: round(reading.sigma) };
        AuvControl {
            velocity_mps: self.velocity_mps.map(round),
            velocity_covariance: Symmetric::from_fn(|row, column| round(self.velocity_covariance.get(row, column))),
            roll_rad: round(self.roll_rad),
            pitch_rad: round(self.pitch_rad),
            yaw_rate_radps: self.yaw_rate_radps.map(reading),
            z_m: self.z_m.map(reading),
        }
    }
}

/// The motion model (7.1): the vehicle has the given velocity, and a yaw rate that a random angular acceleration n_θ changes.
///
/// With a yaw rate from the inertial unit, n_θ is drawn given this reading, and the yaw is advanced with the new rate, which is the
/// mean rate of the step: θ + (θ̇ + n_θ Δt) Δt. With a depth from a pressure sensor, the velocity error is drawn given the depth.
/// Without either reading this is exactly (7.1). The readings are part of the control: they determine the density from which
/// particles are drawn, and not the weights of the particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Auv<T> {
    /// Standard deviation of n_θ, constant during a step, rad/s².
    yaw_acceleration_sigma_radps2: T,
    /// Correlation time of a velocity error, s; see [`Auv::new`].
    interval_s: T,
}

/// One step: its mean, the gains of the readings, and the covariance that remains to be sampled.
struct StepOf<T: Real> {
    pose: AuvPose<T>,
    /// Gain of z's reading on each coordinate of the position: the share of a deviation of z that is corrected.
    gain: Vector3<T>,
    /// Covariance of the position, m².
    covariance: Symmetric<Vector3<T>>,
    /// Gain of the yaw rate's reading.
    rate_gain: T,
    /// Share of n_θ Δt² by which the yaw changes: ½ for a uniform change of the rate (7.1), 1 if the reading is the mean rate of
    /// the step.
    yaw_share: T,
    /// Variance of n_θ given the reading.
    acceleration_variance: T,
    /// ∂position/∂yaw.
    by_yaw: Vector3<T>,
}

impl<T: Real> Auv<T> {
    /// A vehicle with this standard deviation of the yaw acceleration, rad/s², drawn once per step.
    ///
    /// Errors of a filtered velocity are correlated in time: over twice the time constant of the velocity filter they are almost
    /// constant. Each step therefore multiplies the standard deviation by √(interval/dt), so that the positions spread as with
    /// errors that are constant over the interval, at any rate of steps. Zero: one independent draw per step.
    ///
    /// # Errors
    /// Both must be finite, the first positive, the second not negative.
    pub fn new(yaw_acceleration_sigma_radps2: T, interval_s: T) -> Result<Self, ModelError> {
        let (zero, sigma) = (T::ZERO, yaw_acceleration_sigma_radps2);
        require(sigma > zero && sigma.is_finite(), "yaw_acceleration_sigma_radps2", "finite and positive")?;
        require(interval_s >= zero && interval_s.is_finite(), "interval_s", "finite and not negative")?;
        Ok(Self { yaw_acceleration_sigma_radps2, interval_s })
    }

    fn step(&self, pose: &AuvPose<T>, control: &AuvControl<T>, dt: T) -> StepOf<T> {
        // The vehicle has rotated from its last attitude to this one; the velocity refers to the attitude at the start (7.1).
        let turned: Matrix3<T> = rotation(pose.roll_rad, pose.pitch_rad, pose.yaw_rad);
        let moved = turned * (control.velocity_mps * dt);

        let raise = if self.interval_s > T::ZERO && dt > T::ZERO { self.interval_s / dt } else { T::ONE };
        let mut covariance = control.velocity_covariance.congruence(&turned).scaled(dt * dt * raise);
        let mut position = pose.position() + moved;
        let mut gain = Vector3::zeros();
        if let Some(reading) = control.z_m {
            let innovation_variance = covariance.get(2, 2) + reading.sigma * reading.sigma;
            if innovation_variance > T::ZERO {
                gain = Vector3::from_fn(|row, _| covariance.get(row, 2) / innovation_variance);
                position += gain * (reading.value - position.z);
                let open = covariance;
                covariance = Symmetric::from_fn(|row, column| {
                    let taken = gain.get(row).map_or(T::ZERO, |&share| share * open.get(2, column));
                    open.get(row, column) - taken
                });
            }
        }

        let acceleration_variance = self.yaw_acceleration_sigma_radps2 * self.yaw_acceleration_sigma_radps2;
        let (rate_gain, acceleration, yaw_share) = match control.yaw_rate_radps {
            Some(reading) if dt > T::ZERO => {
                let change_variance = acceleration_variance * dt * dt;
                let gain = change_variance / (change_variance + reading.sigma * reading.sigma);
                (gain, gain * (reading.value - pose.yaw_rate_radps) / dt, T::ONE)
            }
            _ => (T::ZERO, T::ZERO, T::from_f64(0.5)),
        };
        // A rotation of the initial pose rotates the displacement, including the correction by the reading of z.
        let [[dx, dy, _]] = (position - pose.position()).data.0;
        StepOf {
            pose: AuvPose {
                x_m: position.x,
                y_m: position.y,
                z_m: position.z,
                yaw_rad: wrap(pose.yaw_rad + (pose.yaw_rate_radps + yaw_share * acceleration * dt) * dt),
                yaw_rate_radps: pose.yaw_rate_radps + acceleration * dt,
                roll_rad: control.roll_rad,
                pitch_rad: control.pitch_rad,
            },
            gain,
            covariance,
            rate_gain,
            yaw_share,
            acceleration_variance: acceleration_variance * (T::ONE - rate_gain),
            by_yaw: Vector3::new(-dy, dx, T::ZERO),
        }
    }
}

/// Whether a covariance is positive semidefinite within rounding errors.
fn is_positive_semidefinite<T: Real>(covariance: &Symmetric<Vector3<T>>) -> bool {
    let trace = (0..3).fold(T::ZERO, |sum, k| sum + covariance.get(k, k));
    let rounding = Symmetric::from_diagonal([trace * T::EPSILON * T::from_f64(16.0); 3]);
    *covariance == Symmetric::ZERO || covariance.plus(&rounding).factor().is_some()
}

impl<T: Real> Motion for Auv<T> {
    type Pose = AuvPose<T>;
    type Control = AuvControl<T>;

    const TRANSLATION_INVARIANT: bool = true;

    fn admits(&self, control: &Self::Control) -> bool {
        let usable = |reading: Option<Reading<T>>| {
            reading.is_none_or(|r| r.value.is_finite() && r.sigma > T::ZERO && r.sigma.is_finite())
        };
        control.velocity_mps.iter().all(|v| v.is_finite())
            && is_positive_semidefinite(&control.velocity_covariance)
            && control.roll_rad.is_finite()
            && control.pitch_rad.is_finite()
            && usable(control.yaw_rate_radps)
            && usable(control.z_m)
    }

    /// The RMS speed from mean and covariance, because both move the particles.
    fn rates(&self, control: &Self::Control) -> Rates<T> {
        let variance = (0..3).fold(T::ZERO, |sum, axis| sum + control.velocity_covariance.get(axis, axis));
        let [[x, y, z]] = control.velocity_mps.data.0;
        let speed_mps = (x * x + y * y + z * z + variance).sqrt();
        Rates { speed_mps, turn_radps: control.yaw_rate_radps.map_or(T::ZERO, |reading| reading.value.abs()) }
    }

    fn propagate(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Self::Pose {
        self.step(pose, control, dt).pose
    }

    /// Four numbers are drawn: three for the position, then one for n_θ.
    fn sample(&self, pose: &Self::Pose, control: &Self::Control, dt: T, noise: &mut Noise) -> Self::Pose {
        let step = self.step(pose, control, dt);
        let drawn = Vector3::from_fn(|_, _| noise.normal());
        let offset = step.covariance.root() * drawn;
        let acceleration = step.acceleration_variance.sqrt() * noise.normal();
        let mean = step.pose;
        AuvPose {
            x_m: mean.x_m + offset.x,
            y_m: mean.y_m + offset.y,
            z_m: mean.z_m + offset.z,
            yaw_rad: wrap(mean.yaw_rad + step.yaw_share * acceleration * dt * dt),
            yaw_rate_radps: mean.yaw_rate_radps + acceleration * dt,
            ..mean
        }
    }

    fn linearise(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Linearised<Vector5<T>> {
        let step = self.step(pose, control, dt);
        let one = T::ONE;
        let (yaw_by_rate, rate_by_rate) = ((one - step.yaw_share * step.rate_gain) * dt, one - step.rate_gain);
        let transition = SMatrix::<T, 5, 5>::from_fn(|row, column| match (row, column) {
            (0..3, 2) => {
                let identity = if row == 2 { one } else { T::ZERO };
                identity - step.gain.get(row).copied().unwrap_or(T::ZERO)
            }
            (0..3, 3) => step.by_yaw.get(row).copied().unwrap_or(T::ZERO),
            (3, 4) => yaw_by_rate,
            (4, 4) => rate_by_rate,
            (row, column) if row == column => one,
            _ => T::ZERO,
        });
        let (to_yaw, to_rate) = (step.yaw_share * dt * dt, dt);
        let noise = Symmetric::from_fn(|row, column| match (row, column) {
            (0..3, 0..3) => step.covariance.get(row, column),
            (3, 3) => to_yaw * to_yaw * step.acceleration_variance,
            (4, 3) => to_rate * to_yaw * step.acceleration_variance,
            (4, 4) => to_rate * to_rate * step.acceleration_variance,
            _ => T::ZERO,
        });
        Linearised { transition, noise }
    }
}

#[cfg(test)]
mod tests {
    use super::{Auv, AuvControl, AuvPose, Reading};
    use crate::models::testing::check_samples;
    use crate::{Motion, Pose, Symmetric};
    use nalgebra::{SVector, Vector3};

    const POSE: AuvPose<f64> =
        AuvPose { x_m: 1.0, y_m: -2.0, z_m: -3.0, yaw_rad: 3.0, yaw_rate_radps: 0.4, roll_rad: 0.2, pitch_rad: -0.3 };

    fn control(aided: bool) -> AuvControl<f64> {
        AuvControl {
            velocity_mps: Vector3::new(0.5, -0.1, 0.05),
            velocity_covariance: Symmetric::from_fn(|row, column| if row == column { 0.01 } else { 0.002 }),
            roll_rad: 0.1,
            pitch_rad: 0.0,
            yaw_rate_radps: aided.then_some(Reading { value: 0.3, sigma: 0.05 }),
            z_m: aided.then_some(Reading { value: -3.02, sigma: 0.02 }),
        }
    }

    #[test]
    fn a_vehicle_without_readings_moves_by_the_equations() {
        let auv = Auv::new(0.5, 0.0).unwrap();
        let control = AuvControl { roll_rad: 0.0, pitch_rad: 0.0, ..control(false) };
        let start = AuvPose { roll_rad: 0.0, pitch_rad: 0.0, ..POSE };
        let moved = auv.propagate(&start, &control, 0.5);
        let (s, c) = start.yaw_rad.sin_cos();
        assert!((moved.x_m - (1.0 + 0.5 * (0.5 * c + 0.1 * s))).abs() < 1e-15);
        assert!((moved.y_m - (-2.0 + 0.5 * (0.5 * s - 0.1 * c))).abs() < 1e-15);
        assert!((moved.z_m - (-3.0 + 0.5 * 0.05)).abs() < 1e-15);
        assert!((moved.yaw_rad - (3.2 - core::f64::consts::TAU)).abs() < 1e-14);
        assert_eq!(moved.yaw_rate_radps, 0.4);
    }

    #[test]
    fn readings_are_weighted_by_their_noise() {
        let auv = Auv::new(0.5, 0.0).unwrap();
        let exact = AuvControl {
            yaw_rate_radps: Some(Reading { value: 0.3, sigma: 1e-9 }),
            z_m: Some(Reading { value: -2.9, sigma: 1e-9 }),
            ..control(false)
        };
        let moved = auv.propagate(&POSE, &exact, 0.1);
        assert!((moved.yaw_rate_radps - 0.3).abs() < 1e-12 && (moved.z_m + 2.9).abs() < 1e-12);
        assert!((moved.yaw_rad - 3.03).abs() < 1e-12);
        let worthless = AuvControl {
            yaw_rate_radps: Some(Reading { value: 9.0, sigma: 1e9 }),
            z_m: Some(Reading { value: 50.0, sigma: 1e9 }),
            ..control(false)
        };
        let moved = auv.propagate(&POSE, &worthless, 0.1);
        assert!(moved.difference(&auv.propagate(&POSE, &control(false), 0.1)).norm() < 1e-12, "{moved:?}");
        assert_eq!((moved.roll_rad, moved.pitch_rad), (0.1, 0.0));
    }

    /// P − P e eᵀ P / (P_zz + σ²), with e along z.
    #[test]
    fn a_depth_takes_its_share_of_the_covariance() {
        let auv = Auv::new(0.5, 0.0).unwrap();
        let (sigma, dt) = (0.02, 0.1);
        let depth = Some(Reading { value: -3.0, sigma });
        let level = AuvControl { roll_rad: 0.0, z_m: depth, ..control(false) };
        let start = AuvPose { yaw_rad: 0.0, roll_rad: 0.0, pitch_rad: 0.0, ..POSE };
        let noise = auv.linearise(&start, &level, dt).noise;
        let before = |row, column| level.velocity_covariance.get(row, column) * dt * dt;
        for (row, column) in [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2)] {
            let taken = before(row, 2) * before(2, column) / (before(2, 2) + sigma * sigma);
            assert!((noise.get(row, column) - (before(row, column) - taken)).abs() < 1e-15, "{row} {column}");
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let auv = Auv::new(0.5, 0.4).unwrap();
        for aided in [false, true] {
            let control = control(aided);
            let linearised = auv.linearise(&POSE, &control, 0.1);
            for k in 0..5 {
                let moved = |step: f64| {
                    let mut by = SVector::<f64, 5>::zeros();
                    by[k] = step;
                    auv.propagate(&POSE.displaced(&by), &control, 0.1)
                };
                let column = moved(1e-6).difference(&moved(-1e-6)) / 2e-6;
                assert!((column - linearised.transition.column(k)).norm() < 1e-8, "{aided}, column {k}: {column}");
            }
        }
    }

    #[test]
    fn samples_have_the_linearised_covariance() {
        let auv = Auv::new(0.5, 0.4).unwrap();
        for aided in [false, true] {
            check_samples(&auv, &POSE, &control(aided), 0.1, (40_000, 0.03));
        }
    }

    #[test]
    fn invalid_parameters_and_controls_are_refused() {
        let auv = Auv::new(0.5, 0.0).unwrap();
        assert!(auv.admits(&control(true)));
        let bad = Some(Reading { value: 0.1, sigma: 0.0 });
        assert!(!auv.admits(&AuvControl { z_m: bad, ..control(true) }));
        assert!(!auv.admits(&AuvControl { roll_rad: f64::NAN, ..control(true) }));
        let negative = Symmetric::from_diagonal([0.1, -0.1, 0.1]);
        assert!(!auv.admits(&AuvControl { velocity_covariance: negative, ..control(true) }));
        let crossed = Symmetric::from_fn(|row, column| if row == column { 0.01 } else { -0.02 });
        assert!(!auv.admits(&AuvControl { velocity_covariance: crossed, ..control(true) }));
        let common = Symmetric::from_fn(|_, _| 0.01);
        for semidefinite in [Symmetric::ZERO, common, Symmetric::from_diagonal([0.01, 0.0, 0.0])] {
            assert!(auv.admits(&AuvControl { velocity_covariance: semidefinite, ..control(true) }));
        }
        assert_eq!(Auv::new(0.0, 0.0).unwrap_err().field, "yaw_acceleration_sigma_radps2");
        assert_eq!(Auv::new(1.0, f64::NAN).unwrap_err().field, "interval_s");
    }
}
