//! `sensor_msgs`.

use super::geometry::{Quaternion, Vector3};
use super::standard::Header;
use crate::definition::messages;

messages! {
    "sensor_msgs"
    /// A field of the points of a cloud.
    #[derive(Default)]
    PointField {
        "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\n\
         uint8 FLOAT64=8\n"
        name: String,
        /// Its offset in a point, bytes.
        offset: u32,
        datatype: u8,
        /// Number of elements.
        count: u32,
    }

    /// Points with the same fields.
    #[derive(Default)]
    PointCloud2 {
        header: Header,
        /// Number of rows, and of points in a row.
        height: u32,
        width: u32,
        fields: Vec<PointField>,
        is_bigendian: bool,
        /// Size of a point, and of a row, bytes.
        point_step: u32,
        row_step: u32,
        data: Vec<u8>,
        /// Whether all points are valid.
        is_dense: bool,
    }

    /// A scan of a planar laser scanner: m, rad, positive to the left, and s. Its time is that of the first beam.
    #[derive(Default)]
    LaserScan {
        header: Header,
        /// The directions of the first and the last beam, and the angle between beams.
        angle_min: f32,
        angle_max: f32,
        angle_increment: f32,
        /// Time between beams, and between scans.
        time_increment: f32,
        scan_time: f32,
        /// The limits of valid ranges.
        range_min: f32,
        range_max: f32,
        ranges: Vec<f32>,
        /// Empty if unknown.
        intensities: Vec<f32>,
    }

    /// Measurements of an inertial measurement unit: rad, rad/s and m/s². A covariance is in row order; if its first number is
    /// -1, the measurement is unknown.
    #[derive(Default)]
    Imu {
        header: Header,
        orientation: Quaternion,
        orientation_covariance: [f64; 9],
        angular_velocity: Vector3,
        angular_velocity_covariance: [f64; 9],
        linear_acceleration: Vector3,
        linear_acceleration_covariance: [f64; 9],
    }

    /// Joints of a vehicle by their names, in rad or m, with their derivatives, and Nm or N; lists are empty if unknown.
    #[derive(Default)]
    JointState { header: Header, name: Vec<String>, position: Vec<f64>, velocity: Vec<f64>, effort: Vec<f64>, }

    /// Status of a satellite receiver: below 0 without a position, and the used satellite systems, as bits.
    #[derive(Copy, Default)]
    NavSatStatus {
        "int8 STATUS_NO_FIX=-1\nint8 STATUS_FIX=0\nint8 STATUS_SBAS_FIX=1\nint8 STATUS_GBAS_FIX=2\n"
        status: i8,
        "uint16 SERVICE_GPS=1\nuint16 SERVICE_GLONASS=2\nuint16 SERVICE_COMPASS=4\nuint16 SERVICE_GALILEO=8\n"
        service: u16,
    }

    /// A position by a satellite receiver, on the WGS 84 ellipsoid, in the frame of its antenna.
    #[derive(Default)]
    NavSatFix {
        header: Header,
        status: NavSatStatus,
        /// Degrees north, and east.
        latitude: f64,
        longitude: f64,
        /// Height above the ellipsoid, m; NaN if unknown.
        altitude: f64,
        /// Covariance of east, north and up, m², row by row.
        position_covariance: [f64; 9],
        "uint8 COVARIANCE_TYPE_UNKNOWN=0\nuint8 COVARIANCE_TYPE_APPROXIMATED=1\nuint8 COVARIANCE_TYPE_DIAGONAL_KNOWN=2\n\
         uint8 COVARIANCE_TYPE_KNOWN=3\n"
        position_covariance_type: u8,
    }

    /// A compressed image.
    #[derive(Default)]
    CompressedImage { header: Header, format: String, data: Vec<u8>, }
}
