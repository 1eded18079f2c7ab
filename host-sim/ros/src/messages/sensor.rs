//! `sensor_msgs`.

use super::geometry::{QUATERNION, Quaternion, VECTOR3, Vector3};
use super::message;
use super::standard::{HEADER, Header};
use crate::definition::Definition;
use serde::{Deserialize, Serialize};

/// A number that every point of a cloud has.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PointField {
    /// Its name.
    pub name: String,
    /// Where it is in a point, bytes.
    pub offset: u32,
    /// Its type: 1 to 6 are whole numbers of 1, 2 and 4 bytes, signed first, 7 is `float32`, 8 `float64`.
    pub datatype: u8,
    /// How many there are.
    pub count: u32,
}

/// `sensor_msgs/msg/PointField`.
pub static POINT_FIELD: Definition = Definition {
    name: "sensor_msgs/msg/PointField",
    text: "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\n\
           uint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n",
    parts: &[],
};

/// Points, each with the same numbers.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PointCloud2 {
    /// When, in which frame.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Points of a row.
    pub width: u32,
    /// What a point has.
    pub fields: Vec<PointField>,
    /// Whether its numbers begin with the highest byte.
    pub is_bigendian: bool,
    /// Bytes of a point.
    pub point_step: u32,
    /// Bytes of a row.
    pub row_step: u32,
    /// The points.
    pub data: Vec<u8>,
    /// Whether all points are valid.
    pub is_dense: bool,
}

message!(
    /// `sensor_msgs/msg/PointCloud2`.
    PointCloud2, POINT_CLOUD2 = "sensor_msgs/msg/PointCloud2",
    "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n\
     bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
    [HEADER, POINT_FIELD]
);

/// A turn of a scanner in its plane.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LaserScan {
    /// When the first beam was measured, in which frame.
    pub header: Header,
    /// The direction of the first beam, rad, growing to the left.
    pub angle_min: f32,
    /// That of the last, rad.
    pub angle_max: f32,
    /// From beam to beam, rad.
    pub angle_increment: f32,
    /// From beam to beam, s.
    pub time_increment: f32,
    /// From scan to scan, s.
    pub scan_time: f32,
    /// Least range, m.
    pub range_min: f32,
    /// Greatest range, m.
    pub range_max: f32,
    /// Of each beam, m; what is beyond the limits is none.
    pub ranges: Vec<f32>,
    /// How strong each came back; empty where unknown.
    pub intensities: Vec<f32>,
}

message!(
    /// `sensor_msgs/msg/LaserScan`.
    LaserScan, LASER_SCAN = "sensor_msgs/msg/LaserScan",
    "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\nfloat32 time_increment\n\
     float32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\nfloat32[] intensities\n",
    [HEADER]
);

/// What an inertial measurement unit says.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Imu {
    /// When, in which frame.
    pub header: Header,
    /// How it is turned.
    pub orientation: Quaternion,
    /// Its covariance, row by row, rad²; the first number is -1 where the turn is unknown.
    pub orientation_covariance: [f64; 9],
    /// Rates of turn, rad/s.
    pub angular_velocity: Vector3,
    /// Their covariance, likewise.
    pub angular_velocity_covariance: [f64; 9],
    /// Acceleration, m/s².
    pub linear_acceleration: Vector3,
    /// Its covariance, likewise.
    pub linear_acceleration_covariance: [f64; 9],
}

message!(
    /// `sensor_msgs/msg/Imu`.
    Imu, IMU = "sensor_msgs/msg/Imu",
    "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
     geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
     geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
    [HEADER, QUATERNION, VECTOR3]
);

/// Joints of a vehicle.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct JointState {
    /// When.
    pub header: Header,
    /// Their names.
    pub name: Vec<String>,
    /// Where they are, rad or m; empty where unknown.
    pub position: Vec<f64>,
    /// How they move, rad/s or m/s; empty where unknown.
    pub velocity: Vec<f64>,
    /// What they push with, Nm or N; empty where unknown.
    pub effort: Vec<f64>,
}

message!(
    /// `sensor_msgs/msg/JointState`.
    JointState, JOINT_STATE = "sensor_msgs/msg/JointState",
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n", [HEADER]
);

/// Whether a satellite receiver knows where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct NavSatStatus {
    /// Below 0 where it does not.
    pub status: i8,
    /// Which satellites it uses, as bits.
    pub service: u16,
}

/// `sensor_msgs/msg/NavSatStatus`.
pub static NAV_SAT_STATUS: Definition = Definition {
    name: "sensor_msgs/msg/NavSatStatus",
    text: "int8 STATUS_NO_FIX=-1\nint8 STATUS_FIX=0\nint8 STATUS_SBAS_FIX=1\nint8 STATUS_GBAS_FIX=2\nint8 status\n\
           uint16 SERVICE_GPS=1\nuint16 SERVICE_GLONASS=2\nuint16 SERVICE_COMPASS=4\nuint16 SERVICE_GALILEO=8\nuint16 service\n",
    parts: &[],
};

/// Where a satellite receiver is, on the WGS 84 ellipsoid.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct NavSatFix {
    /// When, and the frame of the antenna.
    pub header: Header,
    /// Whether it knows.
    pub status: NavSatStatus,
    /// Degrees, to the north.
    pub latitude: f64,
    /// Degrees, to the east.
    pub longitude: f64,
    /// m above the ellipsoid; NaN where unknown.
    pub altitude: f64,
    /// Of east, north and up, m², row by row.
    pub position_covariance: [f64; 9],
    /// 0 where it is unknown, 1 a guess, 2 the diagonal alone, 3 whole.
    pub position_covariance_type: u8,
}

message!(
    /// `sensor_msgs/msg/NavSatFix`.
    NavSatFix, NAV_SAT_FIX = "sensor_msgs/msg/NavSatFix",
    "std_msgs/Header header\nsensor_msgs/NavSatStatus status\nfloat64 latitude\nfloat64 longitude\nfloat64 altitude\n\
     float64[9] position_covariance\nuint8 COVARIANCE_TYPE_UNKNOWN=0\nuint8 COVARIANCE_TYPE_APPROXIMATED=1\n\
     uint8 COVARIANCE_TYPE_DIAGONAL_KNOWN=2\nuint8 COVARIANCE_TYPE_KNOWN=3\nuint8 position_covariance_type\n",
    [HEADER, NAV_SAT_STATUS]
);

/// An image in a common format.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CompressedImage {
    /// When, in which frame.
    pub header: Header,
    /// Its format.
    pub format: String,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// `sensor_msgs/msg/CompressedImage`.
pub static COMPRESSED_IMAGE: Definition = Definition {
    name: "sensor_msgs/msg/CompressedImage",
    text: "std_msgs/Header header\nstring format\nuint8[] data\n",
    parts: &[&HEADER],
};
