//! A vehicle driven by speed and turn rate.

use super::{ControlNoise, Linearised, ModelError, Motion, PlanarPose};
use crate::{Noise, Rates, Real, wrap};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// How a [`Unicycle`] integrates its controls over one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// Straight along the heading at the start of the step, then turn.
    Euler,
    /// Along the exact arc.
    Arc,
}

/// Speed and turn rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnicycleControl<T> {
    /// v, m/s.
    pub speed_mps: T,
    /// ω, rad/s.
    pub rate_radps: T,
}

/// A vehicle that moves along its heading and turns in place.
///
/// ```
/// use scphd::{ControlNoise, Motion, PlanarPose, Step, Unicycle, UnicycleControl};
///
/// let robot = Unicycle::new(Step::Arc, ControlNoise::NONE)?;
/// let quarter = core::f64::consts::FRAC_PI_2;
/// let turn = UnicycleControl { speed_mps: quarter, rate_radps: quarter };
/// let pose = robot.propagate(&PlanarPose::new(0.0, 0.0, 0.0), &turn, 1.0);
/// assert!((pose.x_m - 1.0).abs() < 1e-15 && (pose.y_m - 1.0).abs() < 1e-15);
/// # Ok::<(), scphd::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unicycle<T> {
    step: Step,
    noise: ControlNoise<T>,
}

/// Displacement of one step in the frame of the map, and its derivatives with respect to (v, ω).
struct Displacement<T> {
    x: T,
    y: T,
    d_speed: [T; 2],
    d_rate: [T; 2],
}

/// Below this turn in one step, rad, the arc is a chord along the mean heading (the error is of third order).
const SMALL_TURN_RAD: f64 = 1e-4;

impl<T: Real> Unicycle<T> {
    /// The model of a vehicle.
    ///
    /// # Errors
    /// Every noise figure must be finite and not negative.
    pub fn new(step: Step, noise: ControlNoise<T>) -> Result<Self, ModelError> {
        noise.check()?;
        Ok(Self { step, noise })
    }

    fn displacement(&self, heading: T, control: &UnicycleControl<T>, dt: T) -> Displacement<T> {
        let UnicycleControl { speed_mps: v, rate_radps: omega } = *control;
        let half = T::from_f64(0.5);
        let straight = |along: T, d_along: T| {
            let (sine, cosine) = along.sin_cos();
            Displacement {
                x: v * dt * cosine,
                y: v * dt * sine,
                d_speed: [dt * cosine, dt * sine],
                d_rate: [-v * dt * sine * d_along, v * dt * cosine * d_along],
            }
        };
        match self.step {
            Step::Euler => straight(heading, T::ZERO),
            Step::Arc if (omega * dt).abs() < T::from_f64(SMALL_TURN_RAD) => {
                straight(heading + half * omega * dt, half * dt)
            }
            Step::Arc => {
                let (s0, c0) = heading.sin_cos();
                let (s1, c1) = (heading + omega * dt).sin_cos();
                let (per_v_x, per_v_y) = ((s1 - s0) / omega, (c0 - c1) / omega);
                Displacement {
                    x: v * per_v_x,
                    y: v * per_v_y,
                    d_speed: [per_v_x, per_v_y],
                    d_rate: [v * (dt * c1 - per_v_x) / omega, v * (dt * s1 - per_v_y) / omega],
                }
            }
        }
    }
}

impl<T: Real> Motion for Unicycle<T> {
    type Pose = PlanarPose<T>;
    type Control = UnicycleControl<T>;

    fn admits(&self, control: &Self::Control) -> bool {
        control.speed_mps.is_finite() && control.rate_radps.is_finite()
    }

    fn rates(&self, control: &Self::Control) -> Rates<T> {
        Rates { speed_mps: control.speed_mps.abs(), turn_radps: control.rate_radps.abs() }
    }

    fn propagate(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Self::Pose {
        let Displacement { x, y, .. } = self.displacement(pose.heading_rad, control, dt);
        PlanarPose {
            x_m: pose.x_m + x,
            y_m: pose.y_m + y,
            heading_rad: wrap(pose.heading_rad + control.rate_radps * dt),
        }
    }

    fn sample(&self, pose: &Self::Pose, control: &Self::Control, dt: T, noise: &mut Noise) -> Self::Pose {
        let [speed_mps, rate_radps] = self.noise.perturb([control.speed_mps, control.rate_radps], dt, noise);
        self.propagate(pose, &UnicycleControl { speed_mps, rate_radps }, dt)
    }

    fn linearise(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Linearised<Vector3<T>> {
        let Displacement { x, y, d_speed: [xv, yv], d_rate: [xw, yw] } =
            self.displacement(pose.heading_rad, control, dt);
        let (one, zero) = (T::ONE, T::ZERO);
        // Turning the start turns the whole displacement.
        let transition = Matrix3::new(one, zero, -y, zero, one, x, zero, zero, one);
        let by_control = SMatrix::<T, 3, 2>::new(xv, xw, yv, yw, zero, dt);
        let control_noise = self.noise.covariance([control.speed_mps, control.rate_radps], dt);
        Linearised { transition, noise: control_noise.congruence(&by_control) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Step, Unicycle, UnicycleControl};
    use crate::models::testing::check_linearised;
    use crate::{ControlNoise, Motion, PlanarPose};

    #[test]
    fn the_arc_is_the_limit_of_many_short_steps() {
        let arc = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
        let euler = Unicycle::new(Step::Euler, ControlNoise::NONE).unwrap();
        let start = PlanarPose::new(1.0, 2.0, 0.4);
        for rate in [-0.8, -1e-5, 0.0, 1e-3, 0.5_f64] {
            let control = UnicycleControl { speed_mps: 2.0, rate_radps: rate };
            let exact = arc.propagate(&start, &control, 1.0);
            let steps = 100_000;
            let walked = (0..steps).fold(start, |pose, _| euler.propagate(&pose, &control, 1.0 / f64::from(steps)));
            assert!((exact.x_m - walked.x_m).abs() < 2e-5, "{rate}: {exact:?} {walked:?}");
            assert!((exact.y_m - walked.y_m).abs() < 2e-5);
            assert!((exact.heading_rad - walked.heading_rad).abs() < 1e-9);
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let noise = ControlNoise { turn_sigma_ratio: 0.2, ..ControlNoise::white(0.3, 0.05) };
        for step in [Step::Euler, Step::Arc] {
            let robot = Unicycle::new(step, noise).unwrap();
            for heading in [-3.0, -1.2, 0.0, 0.6, 2.4] {
                for speed in [-1.0, 0.0, 4.0] {
                    for rate in [-0.5, -1e-5, 0.0, 0.02, 0.9] {
                        let pose = PlanarPose::new(5.0, -7.0, heading);
                        let at = |[v, omega]: [f64; 2]| UnicycleControl { speed_mps: v, rate_radps: omega };
                        check_linearised(&robot, &pose, [speed, rate], at, noise.covariance([speed, rate], 0.4), 0.4);
                    }
                }
            }
        }
    }
}
