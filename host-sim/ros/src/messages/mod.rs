//! Messages, by the packages that define them.

mod ackermann;
mod diagnostic;
mod geometry;
mod navigation;
mod radar;
mod sensor;
mod standard;
mod transform;
mod vision;
mod visualization;

pub use ackermann::*;
pub use diagnostic::*;
pub use geometry::*;
pub use navigation::*;
pub use radar::*;
pub use sensor::*;
pub use standard::*;
pub use transform::*;
pub use vision::*;
pub use visualization::*;

use crate::definition::{Definition, Message};

/// The definitions of all messages with topics of their own.
pub const ALL: [&Definition; 15] = [
    AckermannDriveStamped::DEFINITION,
    Detection3DArray::DEFINITION,
    DiagnosticArray::DEFINITION,
    Imu::DEFINITION,
    JointState::DEFINITION,
    LaserScan::DEFINITION,
    MarkerArray::DEFINITION,
    NavSatFix::DEFINITION,
    Odometry::DEFINITION,
    PointCloud2::DEFINITION,
    PoseArray::DEFINITION,
    PoseStamped::DEFINITION,
    PoseWithCovarianceStamped::DEFINITION,
    RadarScan::DEFINITION,
    TFMessage::DEFINITION,
];

/// The struct of a message with the fields of its definition, and the definition.
macro_rules! message {
    ($(#[$about:meta])* $type:ident, $constant:ident = $name:literal, $text:literal, [$($part:path),*]) => {
        $(#[$about])*
        pub static $constant: $crate::definition::Definition =
            $crate::definition::Definition { name: $name, text: $text, parts: &[$(&$part),*] };

        impl $crate::definition::Message for $type {
            const DEFINITION: &'static $crate::definition::Definition = &$constant;
        }
    };
}
pub(crate) use message;
