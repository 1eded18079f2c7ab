//! `ackermann_msgs`.

use super::standard::Header;
use crate::definition::messages;

messages! {
    "ackermann_msgs"
    /// Motion of a car by its wheels: m, rad and s.
    #[derive(Copy, Default)]
    AckermannDrive {
        /// Angle of a virtual wheel between the front wheels, positive to the left.
        steering_angle: f32,
        steering_angle_velocity: f32,
        speed: f32,
        acceleration: f32,
        jerk: f32,
    }

    /// The same with a time.
    #[derive(Default)]
    AckermannDriveStamped { header: Header, drive: AckermannDrive, }
}
