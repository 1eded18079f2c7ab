//! A vehicle that moves forwards and sideways and turns at the same time.

use super::control_noise::drawn;
use super::unicycle::chord;
use super::{ByOdometry, ControlNoise, Linearised, ModelError, Motion, OdometryCorrection, PlanarPose};
use crate::{Noise, Rates, Real, Symmetric, wrap};
use nalgebra::{Matrix3, Vector3};

/// Velocity in the body frame, and turn rate: `linear.x`, `linear.y` and `angular.z` of a ROS twist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HolonomicControl<T> {
    /// v_x, ahead, m/s.
    pub forward_mps: T,
    /// v_y, to the left, m/s.
    pub left_mps: T,
    /// ω, rad/s.
    pub rate_radps: T,
}

/// A vehicle that moves in any direction independently of its heading and turns at the same time: on mecanum or omnidirectional
/// wheels, on legs, or in the air. It moves along the exact arc of a constant control.
///
/// The noise of the speed is the same in both directions, and its relative part refers to the speed over ground √(v_x² + v_y²), so
/// that the noise does not depend on the direction of the body axes.
///
/// ```
/// use scphd::models::{ControlNoise, Holonomic, HolonomicControl, Motion, PlanarPose};
///
/// let robot = Holonomic::new(ControlNoise::NONE)?;
/// let aside = HolonomicControl { forward_mps: 0.0, left_mps: 2.0, rate_radps: 0.0 };
/// let pose = robot.propagate(&PlanarPose::new(1.0, 0.0, 0.0), &aside, 0.5_f32);
/// assert_eq!(pose, PlanarPose::new(1.0, 1.0, 0.0));
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Holonomic<T> {
    noise: ControlNoise<T>,
}

/// Displacement of one step in the frame of the map, and its derivatives.
struct Displacement<T> {
    x: T,
    y: T,
    /// ∂(x, y)/∂v_x; ∂(x, y)/∂v_y is this vector rotated to the left by a right angle.
    d_forward: [T; 2],
    /// ∂(x, y)/∂ω.
    d_rate: [T; 2],
}

impl<T: Real> Displacement<T> {
    /// Along the chord of the arc: dt sin(a)/a times the velocity, rotated by the mean heading θ + a, with a = ω dt/2.
    fn of(heading: T, control: &HolonomicControl<T>, dt: T) -> Self {
        let &HolonomicControl { forward_mps, left_mps, rate_radps } = control;
        let d_half_turn = T::from_f64(0.5) * dt;
        let half_turn = rate_radps * d_half_turn;
        let (share, slope) = chord(half_turn);
        let (sine, cosine) = (heading + half_turn).sin_cos();
        let (x_mps, y_mps) = (forward_mps * cosine - left_mps * sine, forward_mps * sine + left_mps * cosine);
        let (length, d_length) = (dt * share, dt * slope * d_half_turn);
        let (x, y) = (length * x_mps, length * y_mps);
        Self {
            x,
            y,
            d_forward: [length * cosine, length * sine],
            d_rate: [d_length * x_mps - y * d_half_turn, d_length * y_mps + x * d_half_turn],
        }
    }

    /// ∂f/∂u.
    fn by_control(&self, dt: T) -> Matrix3<T> {
        let &Self { d_forward: [x, y], d_rate: [x_by_rate, y_by_rate], .. } = self;
        Matrix3::new(x, -y, x_by_rate, y, x, y_by_rate, T::ZERO, T::ZERO, dt)
    }
}

impl<T: Real> Holonomic<T> {
    /// A motion model with this noise of the speed, in both directions, and of the turn rate.
    ///
    /// # Errors
    /// Every noise parameter must be finite and not negative.
    pub fn new(noise: ControlNoise<T>) -> Result<Self, ModelError> {
        noise.check()?;
        Ok(Self { noise })
    }

    /// Standard deviations of one draw of v_x, v_y and the turn rate.
    fn sigmas(&self, control: &HolonomicControl<T>, dt: T) -> [T; 3] {
        let [speed, rate] = self.noise.sigmas([speed(control), control.rate_radps], dt);
        [speed, speed, rate]
    }
}

/// Not inlined, so that an image contains the square root only once.
#[inline(never)]
fn speed<T: Real>(control: &HolonomicControl<T>) -> T {
    (control.forward_mps * control.forward_mps + control.left_mps * control.left_mps).sqrt()
}

impl<T: Real> Motion for Holonomic<T> {
    type Pose = PlanarPose<T>;
    type Control = HolonomicControl<T>;

    const TRANSLATION_INVARIANT: bool = true;

    fn admits(&self, control: &Self::Control) -> bool {
        speed(control).is_finite() && control.rate_radps.is_finite()
    }

    fn rates(&self, control: &Self::Control) -> Rates<T> {
        Rates { speed_mps: speed(control), turn_radps: control.rate_radps.abs() }
    }

    fn propagate(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Self::Pose {
        let Displacement { x, y, .. } = Displacement::of(pose.heading_rad, control, dt);
        PlanarPose {
            x_m: pose.x_m + x,
            y_m: pose.y_m + y,
            heading_rad: wrap(pose.heading_rad + control.rate_radps * dt),
        }
    }

    fn sample(&self, pose: &Self::Pose, control: &Self::Control, dt: T, noise: &mut Noise) -> Self::Pose {
        let moved = |numbers: Vector3<T>| {
            let [[forward_mps, left_mps, rate_radps]] = numbers.data.0;
            self.propagate(pose, &HolonomicControl { forward_mps, left_mps, rate_radps }, dt)
        };
        let by_control = || Displacement::of(pose.heading_rad, control, dt).by_control(dt);
        let told = Vector3::new(control.forward_mps, control.left_mps, control.rate_radps);
        let sigmas = Vector3::from(self.sigmas(control, dt));
        drawn(self.noise.lasts(), told, &sigmas, noise, moved, by_control)
    }

    fn linearise(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Linearised<Vector3<T>> {
        let displacement = Displacement::of(pose.heading_rad, control, dt);
        let Displacement { x, y, .. } = displacement;
        let (one, zero) = (T::ONE, T::ZERO);
        // A rotation of the initial pose rotates the displacement.
        let transition = Matrix3::new(one, zero, -y, zero, one, x, zero, zero, one);
        let variances = self.sigmas(control, dt).map(|sigma| sigma * sigma);
        let of_control = Symmetric::<Vector3<T>>::from_diagonal(variances);
        Linearised { transition, noise: of_control.congruence(&displacement.by_control(dt)) }
    }
}

impl<T: Real> ByOdometry for Holonomic<T> {
    fn corrected(control: &Self::Control, odometry: &OdometryCorrection<T>) -> Self::Control {
        let [forward_mps, rate_radps] = odometry.corrected([control.forward_mps, control.rate_radps]);
        let [left_mps, _] = odometry.corrected([control.left_mps, T::ZERO]);
        HolonomicControl { forward_mps, left_mps, rate_radps }
    }

    fn by_odometry(&self, pose: &Self::Pose, control: &Self::Control, corrected: &Self::Control, dt: T) -> Matrix3<T> {
        let by_control = Displacement::of(pose.heading_rad, corrected, dt).by_control(dt);
        let &HolonomicControl { forward_mps, left_mps, rate_radps } = control;
        let zero = T::ZERO;
        by_control * Matrix3::new(forward_mps, zero, zero, left_mps, zero, zero, zero, rate_radps, T::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::{Holonomic, HolonomicControl};
    use crate::models::testing::{check_linearised, check_samples};
    use crate::{ControlNoise, Motion, PlanarPose, Pose, Step, Symmetric, Unicycle, UnicycleControl};
    use nalgebra::Vector3;

    fn control([forward_mps, left_mps, rate_radps]: [f64; 3]) -> HolonomicControl<f64> {
        HolonomicControl { forward_mps, left_mps, rate_radps }
    }

    const NOISE: ControlNoise<f64> =
        ControlNoise { speed_sigma_ratio: 0.1, turn_sigma_ratio: 0.2, ..ControlNoise::white(0.3, 0.05) };

    #[test]
    fn without_a_speed_to_the_side_it_is_a_unicycle() {
        let (robot, unicycle) = (Holonomic::new(NOISE).unwrap(), Unicycle::new(Step::Arc, NOISE).unwrap());
        let start = PlanarPose::new(1.0, 2.0, 0.4);
        for rate_radps in [-0.8, -1e-5, 0.0, 1e-3, 0.5] {
            let (ahead, same) = (control([2.0, 0.0, rate_radps]), UnicycleControl { speed_mps: 2.0, rate_radps });
            let off = robot.propagate(&start, &ahead, 1.0).difference(&unicycle.propagate(&start, &same, 1.0));
            assert!(off.norm() < 1e-15, "{off}");
            assert_eq!(robot.rates(&ahead), unicycle.rates(&same));
        }
    }

    /// In short straight steps along the mean heading of each.
    #[test]
    fn the_arc_is_the_limit_of_many_short_steps() {
        let robot = Holonomic::new(NOISE).unwrap();
        let start = PlanarPose::new(1.0, 2.0, 0.4);
        for numbers in [[2.0, -1.0, 0.9], [0.0, 1.5, -2.0], [-0.5, 0.5, 1e-6], [1.0, 2.0, 0.0]] {
            let exact = robot.propagate(&start, &control(numbers), 1.5);
            let steps = 20_000;
            let [forward, left, rate] = numbers.map(|number| number * 1.5 / f64::from(steps));
            let (mut x, mut y, mut heading) = (1.0, 2.0, 0.4);
            for _ in 0..steps {
                let (s, c) = f64::sin_cos(heading + 0.5 * rate);
                (x, y, heading) = (x + c * forward - s * left, y + s * forward + c * left, heading + rate);
            }
            let off = exact.difference(&PlanarPose::new(x, y, heading));
            assert!(off.norm() < 1e-8, "{numbers:?}: {off}");
        }
    }

    /// Neither the motion nor its covariance depends on the direction of the vehicle's axes.
    #[test]
    fn motion_does_not_depend_on_the_body_axes() {
        let robot = Holonomic::new(NOISE).unwrap();
        let (start, turned) = (PlanarPose::new(1.0, 2.0, 0.4), PlanarPose::new(1.0, 2.0, 0.4 + 0.9));
        let (s, c) = f64::sin_cos(0.9);
        let told = control([1.2, -0.7, 0.5]);
        let as_told = control([c * 1.2 + s * -0.7, -s * 1.2 + c * -0.7, 0.5]);
        let (there, also) = (robot.propagate(&start, &told, 0.3), robot.propagate(&turned, &as_told, 0.3));
        assert!((there.x_m - also.x_m).abs() < 1e-14 && (there.y_m - also.y_m).abs() < 1e-14);
        let (q, q_turned) = (robot.linearise(&start, &told, 0.3).noise, robot.linearise(&turned, &as_told, 0.3).noise);
        assert!((q.to_matrix() - q_turned.to_matrix()).norm() < 1e-14);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let robot = Holonomic::new(NOISE).unwrap();
        for heading in [-3.0, -1.2, 0.0, 0.6, 2.4] {
            for [forward, left] in [[-1.0, 0.5], [0.0, 0.0], [0.0, 2.0], [4.0, -1.0]] {
                for rate in [-0.5, -1e-5, 0.0, 0.02, 0.9, 7.0_f64] {
                    let speed = f64::hypot(forward, left);
                    let of_speed = 0.09 + (0.1 * speed).powi(2);
                    let variances = [of_speed, of_speed, 0.0025 + (0.2 * rate).powi(2)];
                    let pose = PlanarPose::new(5.0, -7.0, heading);
                    let numbers = [forward, left, rate];
                    check_linearised(
                        &robot,
                        &pose,
                        numbers,
                        control,
                        Symmetric::<Vector3<f64>>::from_diagonal(variances),
                        0.4,
                    );
                }
            }
        }
    }

    #[test]
    fn samples_have_the_linearised_covariance() {
        let robot = Holonomic::new(ControlNoise { interval_s: 0.4, ..NOISE }).unwrap();
        let (pose, told) = (PlanarPose::new(5.0, -7.0, 0.6), control([0.8, -0.5, 0.6]));
        check_samples(&robot, &pose, &told, 0.1, (40_000, 0.03));
    }

    #[test]
    fn invalid_parameters_and_controls_are_refused() {
        let robot = Holonomic::new(ControlNoise::white(0.1_f32, 0.1)).unwrap();
        let admits =
            |forward_mps, left_mps, rate_radps| robot.admits(&HolonomicControl { forward_mps, left_mps, rate_radps });
        assert!(admits(1.0, -1.0, 0.3));
        assert!(!admits(f32::NAN, 0.0, 0.0) && !admits(0.0, f32::INFINITY, 0.0) && !admits(0.0, 0.0, f32::NAN));
        assert!(!admits(f32::MAX, f32::MAX, 0.0));
        assert_eq!(Holonomic::new(ControlNoise::white(-0.1, 0.1)).unwrap_err().field, "speed_sigma_mps");
    }
}
