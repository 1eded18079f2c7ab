//! The motion of the joint reference compared with that of the other reference.

use super::*;
use crate::Vehicle;
use crate::{ControlNoise, FieldOfView, Motion, RangeBearing};
use std::f64::consts::PI;

const NOISE: ControlNoise =
    ControlNoise { speed_sigma_mps: 0.3, second_sigma: 0.05, speed_ratio: 0.1, second_ratio: 0.2, interval_s: 1.0 };

fn planar(vehicle: Vehicle) -> Planar {
    let field_of_view = FieldOfView {
        range_min_m: 0.0,
        range_max_m: 20.0,
        range_edge_m: 0.0,
        bearing_center_rad: 0.0,
        bearing_half_width_rad: PI,
        bearing_edge_rad: 0.0,
        p_near: 0.9,
        p_far: 0.9,
    };
    Planar {
        motion: Motion { vehicle, noise: NOISE },
        mounting: [0.0; 3],
        sensor: RangeBearing { range_sigma_m: 0.2, range_sigma_ratio: 0.0, bearing_sigma_rad: 0.02 },
        field_of_view,
        clutter_intensity: field_of_view.clutter_intensity(2.0),
    }
}

#[test]
fn its_motion_is_that_of_the_other_reference() {
    let car =
        Vehicle::Ackermann { wheelbase_m: 2.83, encoder_offset_m: 0.76, sensor_forward_m: 3.78, sensor_left_m: 0.5 };
    for vehicle in [car, Vehicle::Unicycle, Vehicle::UnicycleArc, Vehicle::Holonomic] {
        let models = planar(vehicle);
        let left = if vehicle == Vehicle::Holonomic { -1.2 } else { 0.0 };
        for second in [-0.5, -1e-5, 0.0, 3e-3, 0.4] {
            let (pose, control) = ([4.0, -1.0, 0.7], [2.0, second, left]);
            let moved = models.moved(&pose, &control, 0.4);
            let other = models.motion.step(pose, &control, 0.4);
            (0..3).for_each(|k| assert!((moved.pose[k] - other[k]).abs() < 1e-9, "{vehicle:?} {second}: {moved:?}"));
            // Its transition matrix by finite differences.
            for k in 0..3 {
                let at = |by: f64| {
                    let mut pose = pose;
                    pose[k] += by;
                    models.motion.step(pose, &control, 0.4)
                };
                let (ahead, behind) = (at(1e-6), at(-1e-6));
                (0..3).for_each(|row| {
                    let slope = (ahead[row] - behind[row]) / 2e-6;
                    assert!((slope - moved.transition[(row, k)]).abs() < 1e-7, "{vehicle:?} {second}: {row} {k}");
                });
            }
        }
    }
}
