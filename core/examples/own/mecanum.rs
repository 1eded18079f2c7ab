//! A vehicle of one's own: a robot on four mecanum wheels, which moves ahead and aside and turns, all at once.

use nalgebra::{Matrix3, Vector3};
use scphd::Real;
use scphd::models::{Linearised, ModelError, Motion, PlanarPose, Pose, Rates};
use scphd::numerics::{Noise, Symmetric, wrap};

/// Errors of ahead, aside and turn, as shares of what the wheels say. Rollers slip more aside than ahead.
#[derive(Debug, Clone, Copy)]
pub struct Mecanum {
    pub shares: [f32; 3],
}

impl Mecanum {
    /// Standard deviations of the control. An error lasts for half a second, however often the wheels are read: a random walk of the pose.
    fn sigmas(&self, control: &Vector3<f32>, dt: f32) -> [f32; 3] {
        let raise = Real::sqrt(0.5 / dt);
        core::array::from_fn(|k| raise * (0.02 + (self.shares[k] * control[k]).abs()))
    }

    /// ∂f/∂u of a step that ends at `moved`.
    fn by_control(pose: &PlanarPose<f32>, moved: &PlanarPose<f32>, control: &Vector3<f32>, dt: f32) -> Matrix3<f32> {
        let (dx, dy) = (moved.x_m - pose.x_m, moved.y_m - pose.y_m);
        let (s, c) = Real::sin_cos(pose.heading_rad + 0.5 * control[2] * dt);
        Matrix3::new(c, -s, -0.5 * dy, s, c, 0.5 * dx, 0.0, 0.0, 1.0) * dt
    }
}

impl Motion for Mecanum {
    type Pose = PlanarPose<f32>;
    /// Ahead, m/s, to the left, m/s, and the turn rate, rad/s.
    type Control = Vector3<f32>;

    fn check(&self) -> Result<(), ModelError> {
        let usable = self.shares.iter().all(|share| (0.0..10.0).contains(share));
        if usable { Ok(()) } else { Err(ModelError::new("shares", "between 0 and 10")) }
    }

    fn admits(&self, control: &Vector3<f32>) -> bool {
        control.iter().all(|number| number.is_finite())
    }

    fn rates(&self, control: &Vector3<f32>) -> Rates<f32> {
        Rates { speed_mps: Real::sqrt(control[0] * control[0] + control[1] * control[1]), turn_radps: control[2].abs() }
    }

    fn propagate(&self, pose: &Self::Pose, control: &Vector3<f32>, dt: f32) -> Self::Pose {
        let [[ahead, left, turn]] = (control * dt).data.0;
        // The functions of `Real`, not those of std: they give the same bits on every machine.
        let (sine, cosine) = Real::sin_cos(pose.heading_rad + 0.5 * turn);
        let (x, y) = (cosine * ahead - sine * left, sine * ahead + cosine * left);
        PlanarPose::new(pose.x_m + x, pose.y_m + y, wrap(pose.heading_rad + turn))
    }

    fn sample(&self, pose: &Self::Pose, control: &Vector3<f32>, dt: f32, noise: &mut Noise) -> Self::Pose {
        // So large an error is no control that a robot could have: it is added where it takes the robot to.
        let errors = self.sigmas(control, dt).map(|sigma| sigma * noise.normal::<f32>());
        let moved = self.propagate(pose, control, dt);
        moved.displaced(&(Self::by_control(pose, &moved, control, dt) * Vector3::from(errors)))
    }

    fn linearise(&self, pose: &Self::Pose, control: &Vector3<f32>, dt: f32) -> Linearised<Vector3<f32>> {
        let moved = self.propagate(pose, control, dt);
        let (dx, dy) = (moved.x_m - pose.x_m, moved.y_m - pose.y_m);
        let by_control = Self::by_control(pose, &moved, control, dt);
        let of_control = Symmetric::<Vector3<f32>>::from_diagonal(self.sigmas(control, dt).map(|sigma| sigma * sigma));
        // To turn the start is to turn the way.
        let transition = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        Linearised { transition, noise: of_control.congruence(&by_control) }
    }
}
