//! `geometry_msgs`. Lengths are in m, angles in rad, covariances in their products.

use super::message;
use super::standard::{HEADER, Header};
use crate::definition::Definition;
use serde::{Deserialize, Serialize};

/// A position, m.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are said above")]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

pub static POINT: Definition =
    Definition { name: "geometry_msgs/msg/Point", text: "float64 x\nfloat64 y\nfloat64 z\n", parts: &[] };

/// A vector: a shift (m), a velocity (m/s) or an angular velocity (rad/s).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are said above")]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

pub static VECTOR3: Definition =
    Definition { name: "geometry_msgs/msg/Vector3", text: "float64 x\nfloat64 y\nfloat64 z\n", parts: &[] };

/// A rotation, as a unit quaternion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are said above")]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

impl Quaternion {
    /// The rotation to the left by `yaw_rad` about the vertical.
    #[must_use]
    pub fn of_yaw(yaw_rad: f64) -> Self {
        let (sine, cosine) = (0.5 * yaw_rad).sin_cos();
        Self { x: 0.0, y: 0.0, z: sine, w: cosine }
    }

    /// The yaw of the rotation, rad in (−π, π]; 0 for the quaternion 0.
    #[must_use]
    pub fn yaw_rad(&self) -> f64 {
        let Self { x, y, z, w } = *self;
        f64::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    }

    /// The normalised quaternion; `None` if its norm is zero or not finite.
    #[must_use]
    pub fn unit(&self) -> Option<Self> {
        let Self { x, y, z, w } = *self;
        let length = (x * x + y * y + z * z + w * w).sqrt();
        let of = |number: f64| number / length;
        (length.is_finite() && length > 1e-6).then(|| Self { x: of(x), y: of(y), z: of(z), w: of(w) })
    }
}

pub static QUATERNION: Definition = Definition {
    name: "geometry_msgs/msg/Quaternion",
    text: "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    parts: &[],
};

/// A position and an orientation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    pub position: Point,
    pub orientation: Quaternion,
}

pub static POSE: Definition = Definition {
    name: "geometry_msgs/msg/Pose",
    text: "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    parts: &[&POINT, &QUATERNION],
};

/// A covariance of x, y, z and the rotations about them, row by row: m², m·rad, rad².
pub type Covariance6 = [[f64; 6]; 6];

/// A pose with its covariance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    pub pose: Pose,
    pub covariance: Covariance6,
}

pub static POSE_WITH_COVARIANCE: Definition = Definition {
    name: "geometry_msgs/msg/PoseWithCovariance",
    text: "geometry_msgs/Pose pose\nfloat64[36] covariance\n",
    parts: &[&POSE],
};

/// Velocities, m/s and rad/s.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Twist {
    /// m/s.
    pub linear: Vector3,
    /// rad/s.
    pub angular: Vector3,
}

pub static TWIST: Definition = Definition {
    name: "geometry_msgs/msg/Twist",
    text: "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
    parts: &[&VECTOR3],
};

/// Velocities with their covariance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    pub twist: Twist,
    pub covariance: Covariance6,
}

pub static TWIST_WITH_COVARIANCE: Definition = Definition {
    name: "geometry_msgs/msg/TwistWithCovariance",
    text: "geometry_msgs/Twist twist\nfloat64[36] covariance\n",
    parts: &[&TWIST],
};

/// A pose with a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PoseStamped {
    pub header: Header,
    pub pose: Pose,
}

message!(
    PoseStamped,
    POSE_STAMPED = "geometry_msgs/msg/PoseStamped",
    "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
    [HEADER, POSE]
);

/// Poses with a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PoseArray {
    pub header: Header,
    pub poses: Vec<Pose>,
}

message!(
    PoseArray,
    POSE_ARRAY = "geometry_msgs/msg/PoseArray",
    "std_msgs/Header header\ngeometry_msgs/Pose[] poses\n",
    [HEADER, POSE]
);

/// A pose with its covariance and a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PoseWithCovarianceStamped {
    pub header: Header,
    pub pose: PoseWithCovariance,
}

message!(
    PoseWithCovarianceStamped,
    POSE_WITH_COVARIANCE_STAMPED = "geometry_msgs/msg/PoseWithCovarianceStamped",
    "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n",
    [HEADER, POSE_WITH_COVARIANCE]
);

/// A shift and a rotation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Transform {
    /// The shift, m.
    pub translation: Vector3,
    pub rotation: Quaternion,
}

pub static TRANSFORM: Definition = Definition {
    name: "geometry_msgs/msg/Transform",
    text: "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    parts: &[&VECTOR3, &QUATERNION],
};

/// The transform of a frame into its parent.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TransformStamped {
    /// Time and parent frame.
    pub header: Header,
    /// The frame.
    pub child_frame_id: String,
    pub transform: Transform,
}

pub static TRANSFORM_STAMPED: Definition = Definition {
    name: "geometry_msgs/msg/TransformStamped",
    text: "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    parts: &[&HEADER, &TRANSFORM],
};

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
