//! Vehicles and their motion models.

/// Motion model and geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Vehicle {
    /// Equations 5.25–5.27 of the thesis; controls are encoder speed and steering angle.
    Ackermann {
        /// Wheelbase L, m.
        wheelbase_m: f64,
        /// Lateral offset H of the wheel encoder from the centreline, m.
        encoder_offset_m: f64,
        /// Forward offset a of the sensor from the rear axle, m.
        sensor_forward_m: f64,
        /// Leftward offset b of the sensor from the centreline, m.
        sensor_left_m: f64,
    },
    /// Euler step; controls are speed and turn rate.
    Unicycle,
    /// Exact arc; controls are speed and turn rate.
    UnicycleArc,
    /// Motion ahead, sideways and turning at once, exact arc; controls are speed ahead, turn rate and speed to the left.
    Holonomic,
}
