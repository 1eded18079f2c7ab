//! Mounting of a sensor (extrinsic parameters).

use super::{ModelError, require};
use crate::Real;

/// Mounting of a sensor: the rigid transform from the vehicle's frame (x ahead, y to the left, z upwards, origin at the pose) to
/// the sensor's frame. Rotations in the order roll, pitch, yaw.
///
/// ```
/// use scphd::models::{Mounting, PlanarPose, Pose};
///
/// // A lidar 0.22 m ahead of the axle, turned by 30° to the left.
/// let mounting = Mounting::in_plane(0.22, 0.0, 30_f64.to_radians())?;
/// let (seat, _) = PlanarPose::new(1.0, 2.0, 0.0).mounted(&mounting);
/// assert_eq!((seat.x_m, seat.y_m), (1.22, 2.0));
/// assert!((seat.heading_rad - 30_f64.to_radians()).abs() < 1e-15);
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mounting<T> {
    forward_m: T,
    left_m: T,
    up_m: T,
    roll_rad: T,
    pitch_rad: T,
    yaw_rad: T,
}

/// Greatest distance of a sensor from the origin of its vehicle, m.
const FARTHEST_M: f64 = 1e4;

impl<T: Real> Mounting<T> {
    /// Mounting in the plane: position ahead and to the left of the vehicle's origin, m, and rotation to the left, rad.
    ///
    /// # Errors
    /// A length is not finite or above 10 km, or the angle is not within ±2π.
    pub fn in_plane(forward_m: T, left_m: T, yaw_rad: T) -> Result<Self, ModelError> {
        Self::in_space([forward_m, left_m, T::ZERO], [T::ZERO, T::ZERO, yaw_rad])
    }

    /// Mounting in space: position ahead, to the left and upwards, m, and roll, pitch and yaw, rad.
    ///
    /// # Errors
    /// A length is not finite or above 10 km, or an angle is not within ±2π.
    pub fn in_space(
        [forward_m, left_m, up_m]: [T; 3],
        [roll_rad, pitch_rad, yaw_rad]: [T; 3],
    ) -> Result<Self, ModelError> {
        let farthest = T::from_f64(FARTHEST_M);
        for (length, field) in [(forward_m, "forward_m"), (left_m, "left_m"), (up_m, "up_m")] {
            require(length.abs() <= farthest, field, "within 10 km")?;
        }
        for (angle, field) in [(roll_rad, "roll_rad"), (pitch_rad, "pitch_rad"), (yaw_rad, "yaw_rad")] {
            require(angle.abs() <= T::PI + T::PI, field, "within two times π")?;
        }
        Ok(Self { forward_m, left_m, up_m, roll_rad, pitch_rad, yaw_rad })
    }

    /// Position ahead, to the left and upwards, m.
    pub fn position_m(&self) -> [T; 3] {
        [self.forward_m, self.left_m, self.up_m]
    }

    /// Roll, pitch, yaw, rad.
    pub fn angles_rad(&self) -> [T; 3] {
        [self.roll_rad, self.pitch_rad, self.yaw_rad]
    }
}

#[cfg(test)]
mod tests {
    use super::Mounting;
    use crate::models::Mounted;
    use crate::models::testing::check_sensor;
    use crate::{
        Ackermann, AckermannControl, AckermannGeometry, AuvPose, ControlNoise, Motion, PlanarPose, Pose, RangeBearing,
        RangeBearingElevation, Sensor, rotation,
    };
    use nalgebra::{SVector, Vector2, Vector3};

    #[test]
    fn a_mounted_sensor_measures_from_its_own_pose() {
        let mounting = Mounting::in_plane(0.22, -0.1, 0.5).unwrap();
        let lidar = RangeBearing::new(0.1, 0.01).unwrap();
        let mounted = Mounted { sensor: &lidar, mounting: Some(mounting) };
        let pose = PlanarPose::new(2.0_f64, 1.0, 2.9);
        let (s, c) = pose.heading_rad.sin_cos();
        let seat = Vector2::new(2.0 + 0.22 * c + 0.1 * s, 1.0 + 0.22 * s - 0.1 * c);
        let feature = Vector2::new(-4.0, 3.0);
        let (dx, dy) = (feature.x - seat.x, feature.y - seat.y);
        let expected = mounted.expect(&mounted.frame(&pose), &feature).unwrap().measurement;
        assert!((expected.x - dx.hypot(dy)).abs() < 1e-14);
        assert!((crate::wrap(expected.y - (dy.atan2(dx) - 2.9 - 0.5))).abs() < 1e-14);
        let back = mounted.invert(&mounted.frame(&pose), &expected).unwrap().feature;
        assert!((back - feature).norm() < 1e-13);
    }

    #[test]
    fn derivatives_by_the_vehicles_pose_agree_with_differences() {
        let lidar = RangeBearing::new(0.1, 0.01).unwrap();
        for (forward, left, yaw) in [(0.22, 0.0, 0.52), (-3.0, 1.0, 3.1), (0.0, 0.0, -6.0)] {
            let mounting = Some(Mounting::in_plane(forward, left, yaw).unwrap());
            let mounted = Mounted { sensor: &lidar, mounting };
            for heading in [-3.1, 0.3, 2.0] {
                check_sensor(&mounted, &PlanarPose::new(3.0, -2.0, heading), &Vector2::new(9.0, 4.0), 1e-7);
            }
        }
    }

    #[test]
    fn a_mounting_in_space_agrees_too() {
        let sonar = RangeBearingElevation::new(0.05, 0.01, 0.01).unwrap();
        for angles in [[0.1, -0.3, 2.0], [0.0, core::f64::consts::FRAC_PI_2, 0.4], [3.0, 0.2, -3.0]] {
            let mounting = Some(Mounting::in_space([0.4, -0.2, 0.3], angles).unwrap());
            let mounted = Mounted { sensor: &sonar, mounting };
            let pose = AuvPose { roll_rad: 0.2, pitch_rad: -0.1, ..AuvPose::new(1.0, -2.0, 3.0, 0.7) };
            check_sensor(&mounted, &pose, &Vector3::new(4.0, 1.5, 1.0), 1e-7);
        }
    }

    /// Also with the x axis straight down, where the yaw is not unique.
    #[test]
    fn a_mounting_in_space_is_the_product_of_the_rotations() {
        let half = core::f64::consts::FRAC_PI_2;
        for angles in [[0.1, -0.3, 2.0], [0.0, half, 0.0], [1.0, half - 1e-9, -2.0], [-2.0, -half, 3.0]] {
            for (roll_rad, pitch_rad) in [(0.0, 0.0), (0.3, -0.2)] {
                let mounting = Mounting::in_space([0.4, -0.2, 0.3], angles).unwrap();
                let pose = AuvPose { roll_rad, pitch_rad, ..AuvPose::new(1.0, -2.0, 3.0, 2.5) };
                let (seat, _) = pose.mounted(&mounting);
                let of_vehicle = rotation(roll_rad, pitch_rad, 2.5);
                let product = of_vehicle * rotation(angles[0], angles[1], angles[2]);
                let found = rotation(seat.roll_rad, seat.pitch_rad, seat.yaw_rad);
                assert!((found - product).norm() < 1e-12, "{angles:?}: {found} {product}");
                let place = pose.position() + of_vehicle * Vector3::new(0.4, -0.2, 0.3);
                assert!((seat.position() - place).norm() < 1e-15);
            }
        }
    }

    /// (5.25) contains the lever arm of the sensor; the motion of the axle with a mounted sensor must agree with it.
    #[test]
    fn the_lever_arm_of_the_motion_is_a_mounting() {
        let geometry =
            AckermannGeometry { wheelbase_m: 2.83, encoder_offset_m: 0.76, sensor_forward_m: 3.78, sensor_left_m: 0.5 };
        let at_the_axle = AckermannGeometry { sensor_forward_m: 0.0, sensor_left_m: 0.0, ..geometry };
        let sensor = Ackermann::new(geometry, ControlNoise::NONE).unwrap();
        let axle = Ackermann::new(at_the_axle, ControlNoise::NONE).unwrap();
        let mounting = Mounting::in_plane(3.78, 0.5, 0.0).unwrap();
        let mut of_axle = PlanarPose::new(1.0, 2.0, 0.3);
        let mut of_sensor = of_axle.mounted(&mounting).0;
        for step in 0..20_000 {
            let control = AckermannControl { speed_mps: 3.0, steering_rad: 0.3 * (1e-3 * f64::from(step)).sin() };
            of_axle = axle.propagate(&of_axle, &control, 1e-4);
            of_sensor = sensor.propagate(&of_sensor, &control, 1e-4);
        }
        // Both are Euler steps, but of different points.
        let off = of_axle.mounted(&mounting).0.difference(&of_sensor);
        assert!(off.norm() < 2e-4, "{off}");
    }

    #[test]
    fn impossible_mountings_are_refused() {
        assert_eq!(Mounting::in_plane(f32::NAN, 0.0, 0.0).unwrap_err().field, "forward_m");
        assert_eq!(Mounting::in_plane(0.0, 1e5, 0.0_f32).unwrap_err().field, "left_m");
        assert_eq!(Mounting::in_plane(0.0, 0.0, 7.0_f32).unwrap_err().field, "yaw_rad");
        let tilted = Mounting::in_space([0.0; 3], [0.0_f32, 0.1, 0.0]).unwrap();
        assert_eq!(PlanarPose::check_mounting(&tilted).unwrap_err().field, "pitch_rad");
        let unmoved: SVector<f64, 3> = SVector::zeros();
        let pose = PlanarPose::new(1.0, 2.0, 3.0);
        let here = Mounting::in_plane(0.0, 0.0, 0.0).unwrap();
        assert_eq!(pose.mounted(&here).0.difference(&pose), unmoved);
    }
}
