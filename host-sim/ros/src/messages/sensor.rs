//! `sensor_msgs`.

use super::geometry::{QUATERNION, Quaternion, VECTOR3, Vector3};
use super::message;
use super::standard::{HEADER, Header};
use crate::definition::Definition;
use serde::{Deserialize, Serialize};

/// A field of the points of a cloud.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PointField {
    pub name: String,
    /// Its offset in a point, bytes.
    pub offset: u32,
    /// Its type: 1 to 6 are whole numbers of 1, 2 and 4 bytes, signed first, 7 is `float32`, 8 `float64`.
    pub datatype: u8,
    /// Number of elements.
    pub count: u32,
}

pub static POINT_FIELD: Definition = Definition {
    name: "sensor_msgs/msg/PointField",
    text: "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\n\
           uint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n",
    parts: &[],
};

/// Points with the same fields.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PointCloud2 {
    pub header: Header,
    /// Number of rows.
    pub height: u32,
    /// Number of points in a row.
    pub width: u32,
    pub fields: Vec<PointField>,
    /// Whether numbers are big-endian.
    pub is_bigendian: bool,
    /// Size of a point, bytes.
    pub point_step: u32,
    /// Size of a row, bytes.
    pub row_step: u32,
    /// The points.
    pub data: Vec<u8>,
    /// Whether all points are valid.
    pub is_dense: bool,
}

message!(
    PointCloud2,
    POINT_CLOUD2 = "sensor_msgs/msg/PointCloud2",
    "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n\
     bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
    [HEADER, POINT_FIELD]
);

/// A scan of a planar laser scanner.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LaserScan {
    /// Time of the first beam, and frame.
    pub header: Header,
    /// The direction of the first beam, rad, positive to the left.
    pub angle_min: f32,
    /// The direction of the last beam, rad.
    pub angle_max: f32,
    /// Angle between beams, rad.
    pub angle_increment: f32,
    /// Time between beams, s.
    pub time_increment: f32,
    /// Time between scans, s.
    pub scan_time: f32,
    /// Least range, m.
    pub range_min: f32,
    /// Greatest range, m.
    pub range_max: f32,
    /// Range of each beam, m; values outside the limits are invalid.
    pub ranges: Vec<f32>,
    /// Intensity of each beam; empty if unknown.
    pub intensities: Vec<f32>,
}

message!(
    LaserScan,
    LASER_SCAN = "sensor_msgs/msg/LaserScan",
    "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\nfloat32 time_increment\n\
     float32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\nfloat32[] intensities\n",
    [HEADER]
);

/// Measurements of an inertial measurement unit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Imu {
    pub header: Header,
    pub orientation: Quaternion,
    /// Its covariance, row by row, rad²; the first number is -1 if the orientation is unknown.
    pub orientation_covariance: [f64; 9],
    /// Angular velocity, rad/s.
    pub angular_velocity: Vector3,
    /// Its covariance, likewise.
    pub angular_velocity_covariance: [f64; 9],
    /// Acceleration, m/s².
    pub linear_acceleration: Vector3,
    /// Its covariance, likewise.
    pub linear_acceleration_covariance: [f64; 9],
}

message!(
    Imu,
    IMU = "sensor_msgs/msg/Imu",
    "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
     geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
     geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
    [HEADER, QUATERNION, VECTOR3]
);

/// Joints of a vehicle.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct JointState {
    pub header: Header,
    pub name: Vec<String>,
    /// Their positions, rad or m; empty if unknown.
    pub position: Vec<f64>,
    /// Their velocities, rad/s or m/s; empty if unknown.
    pub velocity: Vec<f64>,
    /// Their torques or forces, Nm or N; empty if unknown.
    pub effort: Vec<f64>,
}

message!(
    JointState,
    JOINT_STATE = "sensor_msgs/msg/JointState",
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
    [HEADER]
);

/// Status of a satellite receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct NavSatStatus {
    /// Below 0 without a position.
    pub status: i8,
    /// The used satellite systems, as bits.
    pub service: u16,
}

pub static NAV_SAT_STATUS: Definition = Definition {
    name: "sensor_msgs/msg/NavSatStatus",
    text: "int8 STATUS_NO_FIX=-1\nint8 STATUS_FIX=0\nint8 STATUS_SBAS_FIX=1\nint8 STATUS_GBAS_FIX=2\nint8 status\n\
           uint16 SERVICE_GPS=1\nuint16 SERVICE_GLONASS=2\nuint16 SERVICE_COMPASS=4\nuint16 SERVICE_GALILEO=8\nuint16 service\n",
    parts: &[],
};

/// A position by a satellite receiver, on the WGS 84 ellipsoid.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct NavSatFix {
    /// Time, and the frame of the antenna.
    pub header: Header,
    pub status: NavSatStatus,
    /// Latitude, degrees north.
    pub latitude: f64,
    /// Longitude, degrees east.
    pub longitude: f64,
    /// Height above the ellipsoid, m; NaN if unknown.
    pub altitude: f64,
    /// Covariance of east, north and up, m², row by row.
    pub position_covariance: [f64; 9],
    /// 0: the covariance is unknown, 1: approximated, 2: only the diagonal is known, 3: all is known.
    pub position_covariance_type: u8,
}

message!(
    NavSatFix,
    NAV_SAT_FIX = "sensor_msgs/msg/NavSatFix",
    "std_msgs/Header header\nsensor_msgs/NavSatStatus status\nfloat64 latitude\nfloat64 longitude\nfloat64 altitude\n\
     float64[9] position_covariance\nuint8 COVARIANCE_TYPE_UNKNOWN=0\nuint8 COVARIANCE_TYPE_APPROXIMATED=1\n\
     uint8 COVARIANCE_TYPE_DIAGONAL_KNOWN=2\nuint8 COVARIANCE_TYPE_KNOWN=3\nuint8 position_covariance_type\n",
    [HEADER, NAV_SAT_STATUS]
);

/// A compressed image.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CompressedImage {
    pub header: Header,
    pub format: String,
    pub data: Vec<u8>,
}

pub static COMPRESSED_IMAGE: Definition = Definition {
    name: "sensor_msgs/msg/CompressedImage",
    text: "std_msgs/Header header\nstring format\nuint8[] data\n",
    parts: &[&HEADER],
};
