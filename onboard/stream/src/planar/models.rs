//! The models of a planar vehicle in the head of a stream.

use super::Planar;
use crate::Header;
use crate::numbers::numbers;

numbers! {
    /// Initial pose, geometry, noise and field of view of a planar vehicle.
    Models {
        /// Initial pose: x, m.
        start_x_m: f64,
        /// Initial pose: y, m.
        start_y_m: f64,
        /// Initial pose: heading, rad.
        start_heading_rad: f64,
        /// Wheelbase L, m; this and the next three are 0 for a unicycle.
        wheelbase_m: f64,
        /// Lateral offset H of the wheel encoder from the centreline, m.
        encoder_offset_m: f64,
        /// Forward offset a of the pose from the rear axle, m.
        sensor_forward_m: f64,
        /// Leftward offset b of the pose from the centreline, m.
        sensor_left_m: f64,
        /// Standard deviation of the speed, m/s.
        speed_sigma_mps: f64,
        /// Standard deviation of the speed relative to the speed.
        speed_sigma_ratio: f64,
        /// Standard deviation of the second control: steering angle, rad, or turn rate, rad/s.
        turn_sigma: f64,
        /// Standard deviation of the second control relative to its value.
        turn_sigma_ratio: f64,
        /// Correlation time of an odometry error, s.
        noise_interval_s: f64,
        /// The first sensor.
        sensor: SensorModels,
    }
}

numbers! {
    /// A sensor: its mounting, noise and field of view.
    SensorModels {
        /// Position ahead of the pose, m.
        mounted_forward_m: f64,
        /// Position to the left of the pose, m.
        mounted_left_m: f64,
        /// Rotation to the left, rad.
        mounted_yaw_rad: f64,
        /// Standard deviation of the range, m.
        range_sigma_m: f64,
        /// Standard deviation of the bearing, rad.
        bearing_sigma_rad: f64,
        /// Least range, m.
        range_min_m: f64,
        /// Greatest range, m.
        range_max_m: f64,
        /// Half width of the soft edges in range, m.
        range_edge_m: f64,
        /// Centre of the bearing window, rad.
        bearing_center_rad: f64,
        /// Half width of the bearing window, rad; π and above is a full circle.
        bearing_half_width_rad: f64,
        /// Half width of the soft edges in bearing, rad.
        bearing_edge_rad: f64,
        /// p_D at range zero.
        detection_near: f64,
        /// p_D at the greatest range.
        detection_far: f64,
        /// λ, mean number of false measurements in a scan.
        clutter_per_scan: f64,
    }
}

numbers! {
    /// A detector: its sensor, and its birth intensities.
    Sensor {
        /// Mounting, noise and field of view of the sensor.
        models: SensorModels,
        /// w_b of static features, 1/(m·rad).
        birth_intensity: f64,
        /// w_m of moving features, 1/(m·rad).
        moving_birth_intensity: f64,
    }
}

impl Sensor {
    /// The first detector, which is in the head.
    #[must_use]
    pub fn first(header: &Header<Planar>) -> Self {
        Self {
            models: header.models.sensor,
            birth_intensity: header.recursion.birth_intensity,
            moving_birth_intensity: header.moving.birth_intensity,
        }
    }
}
