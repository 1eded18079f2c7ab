//! A car with a wheel encoder and a steering angle (5.25–5.27).

use super::{ByOdometry, ControlNoise, Linearised, ModelError, Motion, OdometryCorrection, PlanarPose, require};
use crate::{Noise, Rates, Real, wrap};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Geometry of an Ackermann vehicle. The pose is that of its sensor, not of its axle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AckermannGeometry<T> {
    /// Wheelbase L, m.
    pub wheelbase_m: T,
    /// Lateral offset H of the wheel encoder from the centreline, m.
    pub encoder_offset_m: T,
    /// Forward offset a of the sensor from the rear axle, m.
    pub sensor_forward_m: T,
    /// Leftward offset b of the sensor from the centreline, m.
    pub sensor_left_m: T,
}

/// Control: speed of the wheel with the encoder, and steering angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AckermannControl<T> {
    /// Wheel speed v_e, m/s.
    pub speed_mps: T,
    /// Steering angle α, rad, |α| < π/2.
    pub steering_rad: T,
}

/// The motion model of (5.25)–(5.27), with the sign of the x row corrected.
///
/// ```
/// use scphd::models::{Ackermann, AckermannControl, AckermannGeometry, ControlNoise, Motion, PlanarPose};
///
/// let geometry = AckermannGeometry {
///     wheelbase_m: 2.83, encoder_offset_m: 0.76, sensor_forward_m: 3.78, sensor_left_m: 0.5,
/// };
/// let car = Ackermann::new(geometry, ControlNoise::NONE)?;
/// let ahead = AckermannControl { speed_mps: 2.0, steering_rad: 0.0 };
/// let pose = car.propagate(&PlanarPose::new(0.0, 0.0, 0.0), &ahead, 0.5_f32);
/// assert_eq!(pose, PlanarPose::new(1.0, 0.0, 0.0));
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ackermann<T> {
    geometry: AckermannGeometry<T>,
    noise: ControlNoise<T>,
}

/// Speed of the centreline, its turn rate, and their derivatives with respect to (v_e, α).
struct Centreline<T> {
    speed: T,
    rate: T,
    d_speed: [T; 2],
    d_rate: [T; 2],
}

/// The heading of the car, and the lever arm of the sensor from the rear axle, rotated into the map.
struct Attitude<T> {
    sine: T,
    cosine: T,
    /// Forward × heading.
    across: T,
    /// Left × heading.
    along: T,
}

impl<T: Real> Attitude<T> {
    /// Velocity of the sensor in x and y, from the speed of the centreline and the turn rate.
    fn velocity(&self, speed: T, rate: T) -> (T, T) {
        (speed * self.cosine - rate * self.across, speed * self.sine + rate * self.along)
    }

    /// ∂f/∂u.
    fn by_control(&self, centreline: &Centreline<T>, dt: T) -> SMatrix<T, 3, 2> {
        let &Centreline { d_speed: [v, alpha], d_rate: [v_rate, alpha_rate], .. } = centreline;
        let ((xv, yv), (xa, ya)) = (self.velocity(v, v_rate), self.velocity(alpha, alpha_rate));
        SMatrix::<T, 3, 2>::new(dt * xv, dt * xa, dt * yv, dt * ya, dt * v_rate, dt * alpha_rate)
    }
}

impl<T: Real> Ackermann<T> {
    /// A motion model with this geometry and noise.
    ///
    /// # Errors
    /// The wheelbase must be positive, every other length and every noise parameter finite, noise not negative.
    pub fn new(geometry: AckermannGeometry<T>, noise: ControlNoise<T>) -> Result<Self, ModelError> {
        let AckermannGeometry { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } = geometry;
        require(wheelbase_m > T::ZERO && wheelbase_m.is_amount(), "wheelbase_m", "finite and positive")?;
        require(encoder_offset_m.is_finite(), "encoder_offset_m", "finite")?;
        require(sensor_forward_m.is_finite(), "sensor_forward_m", "finite")?;
        require(sensor_left_m.is_finite(), "sensor_left_m", "finite")?;
        noise.check()?;
        Ok(Self { geometry, noise })
    }

    /// (5.26), (5.27).
    fn centreline(&self, control: &AckermannControl<T>) -> Centreline<T> {
        let tangent = control.steering_rad.tan();
        let curvature = tangent / self.geometry.wheelbase_m;
        let scale = T::ONE / (T::ONE - curvature * self.geometry.encoder_offset_m);
        let speed = control.speed_mps * scale;
        let d_curvature = (T::ONE + tangent * tangent) / self.geometry.wheelbase_m;
        let d_speed = [scale, speed * scale * self.geometry.encoder_offset_m * d_curvature];
        let [d_speed_v, d_speed_alpha] = d_speed;
        let d_rate = [d_speed_v * curvature, d_speed_alpha * curvature + speed * d_curvature];
        Centreline { speed, rate: speed * curvature, d_speed, d_rate }
    }

    fn attitude(&self, heading_rad: T) -> Attitude<T> {
        let (sine, cosine) = heading_rad.sin_cos();
        let (a, b) = (self.geometry.sensor_forward_m, self.geometry.sensor_left_m);
        Attitude { sine, cosine, across: a * sine + b * cosine, along: a * cosine - b * sine }
    }
}

impl<T: Real> Motion for Ackermann<T> {
    type Pose = PlanarPose<T>;
    type Control = AckermannControl<T>;

    const TRANSLATION_INVARIANT: bool = true;

    fn admits(&self, control: &Self::Control) -> bool {
        let quarter_turn = T::PI * T::from_f64(0.5);
        control.speed_mps.is_finite()
            && control.steering_rad.abs() < quarter_turn
            && control.steering_rad.tan() * self.geometry.encoder_offset_m < self.geometry.wheelbase_m
    }

    fn rates(&self, control: &Self::Control) -> Rates<T> {
        let Centreline { speed, rate, .. } = self.centreline(control);
        Rates { speed_mps: speed.abs(), turn_radps: rate.abs() }
    }

    fn propagate(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Self::Pose {
        let Centreline { speed, rate, .. } = self.centreline(control);
        let (x_mps, y_mps) = self.attitude(pose.heading_rad).velocity(speed, rate);
        PlanarPose {
            x_m: pose.x_m + dt * x_mps,
            y_m: pose.y_m + dt * y_mps,
            heading_rad: wrap(pose.heading_rad + dt * rate),
        }
    }

    fn sample(&self, pose: &Self::Pose, control: &Self::Control, dt: T, noise: &mut Noise) -> Self::Pose {
        let moved =
            |[speed_mps, steering_rad]: [T; 2]| self.propagate(pose, &AckermannControl { speed_mps, steering_rad }, dt);
        let by_control = || self.attitude(pose.heading_rad).by_control(&self.centreline(control), dt);
        self.noise.sample([control.speed_mps, control.steering_rad], dt, noise, moved, by_control)
    }

    fn linearise(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Linearised<Vector3<T>> {
        let (attitude, centreline) = (self.attitude(pose.heading_rad), self.centreline(control));
        let (x_mps, y_mps) = attitude.velocity(centreline.speed, centreline.rate);
        let (one, zero) = (T::ONE, T::ZERO);
        // A rotation of the initial pose rotates the velocity.
        let transition = Matrix3::new(one, zero, dt * -y_mps, zero, one, dt * x_mps, zero, zero, one);
        let control_noise = self.noise.covariance([control.speed_mps, control.steering_rad], dt);
        Linearised { transition, noise: control_noise.congruence(&attitude.by_control(&centreline, dt)) }
    }
}

impl<T: Real> ByOdometry for Ackermann<T> {
    fn corrected(control: &Self::Control, odometry: &OdometryCorrection<T>) -> Self::Control {
        let [speed_mps, steering_rad] = odometry.corrected([control.speed_mps, control.steering_rad]);
        AckermannControl { speed_mps, steering_rad }
    }

    fn by_odometry(&self, pose: &Self::Pose, control: &Self::Control, corrected: &Self::Control, dt: T) -> Matrix3<T> {
        let by_control = self.attitude(pose.heading_rad).by_control(&self.centreline(corrected), dt);
        by_control * OdometryCorrection::by_itself([control.speed_mps, control.steering_rad])
    }
}

#[cfg(test)]
mod tests {
    use super::{Ackermann, AckermannControl, AckermannGeometry};
    use crate::models::testing::{check_linearised, check_samples};
    use crate::{ControlNoise, Motion, PlanarPose};

    fn victoria_park(noise: ControlNoise<f64>) -> Ackermann<f64> {
        let geometry =
            AckermannGeometry { wheelbase_m: 2.83, encoder_offset_m: 0.76, sensor_forward_m: 3.78, sensor_left_m: 0.5 };
        Ackermann::new(geometry, noise).unwrap()
    }

    #[test]
    fn the_sensor_moves_with_the_rigid_body() {
        // In the limit of a short step, every point of the car turns around the centre of curvature, which lies on
        // the rear axle's line at distance L / tan α to the left of the centreline.
        let car = victoria_park(ControlNoise::NONE);
        let (heading, steering, dt) = (0.7_f64, 0.3_f64, 1e-6);
        let start = PlanarPose::new(0.0, 0.0, heading);
        let end = car.propagate(&start, &AckermannControl { speed_mps: 3.0, steering_rad: steering }, dt);
        let radius = 2.83 / steering.tan();
        let rate = 3.0 / (radius - 0.76);
        // From the centre of curvature to the sensor, in the car's frame: (a, b − radius).
        let (forward, left) = (3.78, 0.5 - radius);
        let velocity = (-rate * left, rate * forward);
        let (s, c) = heading.sin_cos();
        let expected = (velocity.0 * c - velocity.1 * s, velocity.0 * s + velocity.1 * c);
        assert!((end.x_m / dt - expected.0).abs() < 1e-5, "{} {}", end.x_m / dt, expected.0);
        assert!((end.y_m / dt - expected.1).abs() < 1e-5);
        assert!(((end.heading_rad - heading) / dt - rate).abs() < 1e-5);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let noise = ControlNoise { interval_s: 0.2, speed_sigma_ratio: 0.1, ..ControlNoise::white(0.3, 0.05) };
        let car = victoria_park(noise);
        for heading in [-3.0, -1.2, 0.0, 0.6, 2.4] {
            for speed in [-1.0, 0.0, 4.0] {
                for steering in [-0.5, -0.1, 0.0, 0.4] {
                    let pose = PlanarPose::new(5.0, -7.0, heading);
                    let at = |[v, alpha]: [f64; 2]| AckermannControl { speed_mps: v, steering_rad: alpha };
                    check_linearised(
                        &car,
                        &pose,
                        [speed, steering],
                        at,
                        noise.covariance([speed, steering], 0.05),
                        0.05,
                    );
                }
            }
        }
    }

    /// For any ratio of interval and step: errors are added to the pose, so that a large steering error cannot reach the poles of
    /// the tangent.
    #[test]
    fn samples_of_correlated_errors_have_the_linearised_covariance() {
        for (interval_s, dt) in [(1.0, 0.025), (3.0, 0.025), (0.5, 1.0)] {
            let noise = ControlNoise { interval_s, speed_sigma_ratio: 0.1, ..ControlNoise::white(0.1, 0.05) };
            for steering_rad in [-0.5, 0.0, 0.3, 0.5] {
                let control = AckermannControl { speed_mps: 5.0, steering_rad };
                check_samples(&victoria_park(noise), &PlanarPose::new(3.0, -2.0, 0.7), &control, dt, (20_000, 0.05));
            }
        }
    }

    #[test]
    fn impossible_parameters_and_controls_are_named() {
        let mut geometry = victoria_park(ControlNoise::NONE).geometry;
        geometry.wheelbase_m = 0.0;
        assert_eq!(Ackermann::new(geometry, ControlNoise::NONE).unwrap_err().field, "wheelbase_m");
        let car = victoria_park(ControlNoise::NONE);
        let admits = |v, alpha| car.admits(&AckermannControl { speed_mps: v, steering_rad: alpha });
        assert!(admits(3.0, 0.5));
        assert!(!admits(f64::NAN, 0.5) && !admits(3.0, f64::NAN) && !admits(3.0, 1.6));
        // The inner wheel stands still: v_c is not defined (5.27).
        assert!(!admits(3.0, (2.83_f64 / 0.76).atan() + 1e-6));
    }
}
