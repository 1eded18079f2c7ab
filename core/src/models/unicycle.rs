//! A vehicle controlled by speed and turn rate.

use super::{ByOdometry, ControlNoise, Linearised, ModelError, Motion, OdometryCorrection, PlanarPose};
use crate::{Noise, Rates, Real, wrap};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Integration of the controls of a [`Unicycle`] over one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// Straight along the heading at the start of the step, then a turn.
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

/// A vehicle that moves along its heading and can turn in place.
///
/// ```
/// use scphd::models::{ControlNoise, Motion, PlanarPose, Step, Unicycle, UnicycleControl};
///
/// let robot = Unicycle::new(Step::Arc, ControlNoise::NONE)?;
/// let quarter = core::f64::consts::FRAC_PI_2;
/// let turn = UnicycleControl { speed_mps: quarter, rate_radps: quarter };
/// let pose = robot.propagate(&PlanarPose::new(0.0, 0.0, 0.0), &turn, 1.0);
/// assert!((pose.x_m - 1.0).abs() < 1e-15 && (pose.y_m - 1.0).abs() < 1e-15);
/// # Ok::<(), scphd::models::ModelError>(())
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

impl<T: Real> Displacement<T> {
    /// ∂f/∂u.
    fn by_control(&self, dt: T) -> SMatrix<T, 3, 2> {
        let &Self { d_speed: [xv, yv], d_rate: [xw, yw], .. } = self;
        SMatrix::<T, 3, 2>::new(xv, xw, yv, yw, T::ZERO, dt)
    }
}

/// Half turn below which [`chord`] uses the series, rad: there its omitted terms are below the rounding errors of double
/// precision; above it the differences in the closed form keep four digits in single precision.
const SMALL_HALF_TURN_RAD: f64 = 0.05;

/// sin(a)/a, the ratio of the chord to the arc that turns by 2a, and its derivative.
pub(super) fn chord<T: Real>(a: T) -> (T, T) {
    let of = T::from_f64;
    if a.abs() < of(SMALL_HALF_TURN_RAD) {
        let q = a * a;
        let share = T::ONE - q * (of(1.0 / 6.0) - q * (of(1.0 / 120.0) - q * of(1.0 / 5040.0)));
        let slope = -a * (of(1.0 / 3.0) - q * (of(1.0 / 30.0) - q * (of(1.0 / 840.0) - q * of(1.0 / 45360.0))));
        (share, slope)
    } else {
        let (sine, cosine) = a.sin_cos();
        let share = sine / a;
        (share, (cosine - share) / a)
    }
}

impl<T: Real> Unicycle<T> {
    /// A motion model with this integration and noise.
    ///
    /// # Errors
    /// Every noise parameter must be finite and not negative.
    pub fn new(step: Step, noise: ControlNoise<T>) -> Result<Self, ModelError> {
        noise.check()?;
        Ok(Self { step, noise })
    }

    fn displacement(&self, heading: T, control: &UnicycleControl<T>, dt: T) -> Displacement<T> {
        let UnicycleControl { speed_mps: v, rate_radps: omega } = *control;
        // Along the chord of the arc: a length of dt sin(a)/a in the direction of the mean heading θ + a, with a = ω dt/2.
        let (length, d_length, along, d_along) = match self.step {
            Step::Euler => (dt, T::ZERO, heading, T::ZERO),
            Step::Arc => {
                let d_half_turn = T::from_f64(0.5) * dt;
                let half_turn = omega * d_half_turn;
                let (share, slope) = chord(half_turn);
                (dt * share, dt * slope * d_half_turn, heading + half_turn, d_half_turn)
            }
        };
        let (sine, cosine) = along.sin_cos();
        let (x, y) = (length * cosine, length * sine);
        Displacement {
            x: v * length * cosine,
            y: v * length * sine,
            d_speed: [x, y],
            d_rate: [v * (d_length * cosine - y * d_along), v * (d_length * sine + x * d_along)],
        }
    }
}

impl<T: Real> Motion for Unicycle<T> {
    type Pose = PlanarPose<T>;
    type Control = UnicycleControl<T>;

    const TRANSLATION_INVARIANT: bool = true;

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
        let moved =
            |[speed_mps, rate_radps]: [T; 2]| self.propagate(pose, &UnicycleControl { speed_mps, rate_radps }, dt);
        let by_control = || self.displacement(pose.heading_rad, control, dt).by_control(dt);
        self.noise.sample([control.speed_mps, control.rate_radps], dt, noise, moved, by_control)
    }

    fn linearise(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Linearised<Vector3<T>> {
        let displacement = self.displacement(pose.heading_rad, control, dt);
        let Displacement { x, y, .. } = displacement;
        let (one, zero) = (T::ONE, T::ZERO);
        // A rotation of the initial pose rotates the displacement.
        let transition = Matrix3::new(one, zero, -y, zero, one, x, zero, zero, one);
        let control_noise = self.noise.covariance([control.speed_mps, control.rate_radps], dt);
        Linearised { transition, noise: control_noise.congruence(&displacement.by_control(dt)) }
    }
}

impl<T: Real> ByOdometry for Unicycle<T> {
    fn corrected(control: &Self::Control, odometry: &OdometryCorrection<T>) -> Self::Control {
        let [speed_mps, rate_radps] = odometry.corrected([control.speed_mps, control.rate_radps]);
        UnicycleControl { speed_mps, rate_radps }
    }

    fn by_odometry(&self, pose: &Self::Pose, control: &Self::Control, corrected: &Self::Control, dt: T) -> Matrix3<T> {
        let by_control = self.displacement(pose.heading_rad, corrected, dt).by_control(dt);
        by_control * OdometryCorrection::by_itself([control.speed_mps, control.rate_radps])
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

    /// Also in single precision, where differences of sines would lose all digits of a slow turn.
    #[test]
    fn a_slow_turn_is_accurate_in_single_precision() {
        let exact = Unicycle::new(Step::Arc, ControlNoise::white(0.0, 0.05)).unwrap();
        let single = Unicycle::new(Step::Arc, ControlNoise::white(0.0, 0.05_f32)).unwrap();
        for turn in [0.0, 1e-7, 1.1e-4, 2e-4, 1e-3, 0.02, 0.0999, 0.1001, 0.3, 2.0_f64] {
            let control = UnicycleControl { speed_mps: 2.0, rate_radps: turn / 0.1 };
            let rounded = UnicycleControl { speed_mps: 2.0_f32, rate_radps: control.rate_radps as f32 };
            let (pose, start) = (PlanarPose::new(0.0, 0.0, 0.7), PlanarPose::new(0.0, 0.0, 0.7_f32));
            let (there, arrived) = (exact.propagate(&pose, &control, 0.1), single.propagate(&start, &rounded, 0.1));
            assert!(
                (there.x_m - f64::from(arrived.x_m)).abs() < 1e-7 && (there.y_m - f64::from(arrived.y_m)).abs() < 1e-7
            );
            let (q, q_single) =
                (exact.linearise(&pose, &control, 0.1).noise, single.linearise(&start, &rounded, 0.1).noise);
            for (row, column) in [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)] {
                let scale = (q.get(row, row) * q.get(column, column)).sqrt();
                let off = (q.get(row, column) - f64::from(q_single.get(row, column))).abs();
                assert!(off <= 1e-3 * scale, "{turn}: {row} {column}: {off} of {scale}");
            }
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let noise = ControlNoise { turn_sigma_ratio: 0.2, ..ControlNoise::white(0.3, 0.05) };
        for step in [Step::Euler, Step::Arc] {
            let robot = Unicycle::new(step, noise).unwrap();
            for heading in [-3.0, -1.2, 0.0, 0.6, 2.4] {
                for speed in [-1.0, 0.0, 4.0] {
                    for rate in [-0.5, -1e-5, 0.0, 0.02, 0.9, 7.0] {
                        let pose = PlanarPose::new(5.0, -7.0, heading);
                        let at = |[v, omega]: [f64; 2]| UnicycleControl { speed_mps: v, rate_radps: omega };
                        check_linearised(&robot, &pose, [speed, rate], at, noise.covariance([speed, rate], 0.4), 0.4);
                    }
                }
            }
        }
    }
}
