//! `geometry_msgs`. Lengths are in m, angles in rad, velocities in m/s and rad/s, covariances in their products.

use super::standard::Header;
use crate::definition::messages;

messages! {
    "geometry_msgs"
    /// A position.
    #[derive(Copy, Default)]
    Point { x: f64, y: f64, z: f64, }

    /// A shift, a velocity or an angular velocity.
    #[derive(Copy, Default)]
    Vector3 { x: f64, y: f64, z: f64, }

    /// A rotation, as a unit quaternion.
    #[derive(Copy)]
    Quaternion { x: f64 = "0", y: f64 = "0", z: f64 = "0", w: f64 = "1", }

    /// A position and an orientation.
    #[derive(Copy, Default)]
    Pose { position: Point, orientation: Quaternion, }

    /// A pose with its covariance.
    #[derive(Copy, Default)]
    PoseWithCovariance { pose: Pose, covariance: Covariance6, }

    /// Velocities.
    #[derive(Copy, Default)]
    Twist { linear: Vector3, angular: Vector3, }

    /// Velocities with their covariance.
    #[derive(Copy, Default)]
    TwistWithCovariance { twist: Twist, covariance: Covariance6, }

    /// A pose with a time.
    #[derive(Default)]
    PoseStamped { header: Header, pose: Pose, }

    /// Poses with a time.
    #[derive(Default)]
    PoseArray { header: Header, poses: Vec<Pose>, }

    /// A pose with its covariance and a time.
    #[derive(Default)]
    PoseWithCovarianceStamped { header: Header, pose: PoseWithCovariance, }

    /// A shift and a rotation.
    #[derive(Copy, Default)]
    Transform { translation: Vector3, rotation: Quaternion, }

    /// The transform of the child frame into the frame of the header.
    #[derive(Default)]
    TransformStamped { header: Header, child_frame_id: String, transform: Transform, }
}

/// A covariance of x, y, z and the rotations about them, row by row.
pub type Covariance6 = [[f64; 6]; 6];

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

impl Quaternion {
    /// The rotation to the left by `yaw_rad` about the vertical.
    pub fn of_yaw(yaw_rad: f64) -> Self {
        let (sine, cosine) = (0.5 * yaw_rad).sin_cos();
        Self { x: 0.0, y: 0.0, z: sine, w: cosine }
    }

    /// The yaw of the rotation, rad in (−π, π]; 0 for the quaternion 0.
    pub fn yaw_rad(&self) -> f64 {
        let Self { x, y, z, w } = *self;
        f64::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    }

    /// The normalised quaternion; `None` if its norm is zero or not finite.
    pub fn unit(&self) -> Option<Self> {
        let Self { x, y, z, w } = *self;
        let length = (x * x + y * y + z * z + w * w).sqrt();
        let of = |number: f64| number / length;
        (length.is_finite() && length > 1e-6).then(|| Self { x: of(x), y: of(y), z: of(z), w: of(w) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_yaw_is_restored() {
        for k in -31..=31 {
            let yaw_rad = f64::from(k) * 0.1;
            assert!((Quaternion::of_yaw(yaw_rad).yaw_rad() - yaw_rad).abs() < 1e-15);
        }
        assert_eq!(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 }.unit(), None);
        assert_eq!(Quaternion { x: 0.0, y: 0.0, z: 3.0, w: 4.0 }.unit().unwrap().w, 0.8);
    }

    #[test]
    fn roll_and_pitch_do_not_change_the_yaw() {
        // Yaw 0.3, then pitch 0.2, then roll 0.1.
        let half = |angle: f64| (0.5 * angle).sin_cos();
        let ((sy, cy), (sp, cp), (sr, cr)) = (half(0.3), half(0.2), half(0.1));
        let turn = Quaternion {
            w: cr * cp * cy + sr * sp * sy,
            x: sr * cp * cy - cr * sp * sy,
            y: cr * sp * cy + sr * cp * sy,
            z: cr * cp * sy - sr * sp * cy,
        };
        assert!((turn.yaw_rad() - 0.3).abs() < 1e-15);
    }
}
