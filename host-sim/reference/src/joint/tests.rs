//! The models of the joint reference compared with those of the other reference, and its parts with closed forms.

use super::*;
use crate::Vehicle;
use crate::{ControlNoise, FieldOfView, Motion, RangeBearing, Sensor};
use std::f64::consts::PI;

const NOISE: ControlNoise =
    ControlNoise { speed_sigma_mps: 0.3, second_sigma: 0.05, speed_ratio: 0.1, second_ratio: 0.2, interval_s: 1.0 };

pub(super) fn planar(vehicle: Vehicle, mounting: [f64; 3]) -> Planar {
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
        mounting,
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
        let models = planar(vehicle, [0.0; 3]);
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

#[test]
fn its_measurements_are_those_of_the_other_reference() {
    let models = planar(Vehicle::Unicycle, [0.0; 3]);
    let (pose, place) = ([3.0, -2.0, 0.83], [7.0, 1.5]);
    let expected = models.expected(&pose, &place).unwrap();
    let (predicted, jacobian) = models.sensor.predicted(place, pose).unwrap();
    let (inverse, spread) = models.sensor.inverse(predicted, pose).unwrap();
    let own = models.inverse(&pose, expected.measurement.as_slice()).unwrap();
    let own_spread = &own.by_measurement * models.noise() * own.by_measurement.transpose();
    for row in 0..2 {
        assert!((expected.measurement[row] - predicted[row]).abs() < 1e-14);
        assert!((own.feature[row] - inverse[row]).abs() < 1e-13);
        for column in 0..2 {
            assert!((expected.by_feature[(row, column)] - jacobian[row][column]).abs() < 1e-14);
            assert!((own_spread[(row, column)] - spread[row][column]).abs() < 1e-14);
            // A shift of vehicle and landmark together does not change the measurement.
            assert!((expected.by_pose[(row, column)] + jacobian[row][column]).abs() < 1e-14);
        }
    }
    assert_eq!((expected.by_pose[(0, 2)], expected.by_pose[(1, 2)]), (0.0, -1.0));
}

#[test]
fn a_mounted_sensor_rotates_about_the_pose() {
    let models = planar(Vehicle::Unicycle, [-1.3, 0.4, 2.6]);
    let (pose, place) = ([3.0, -2.0, 0.83], [7.0, 1.5]);
    let expected = models.expected(&pose, &place).unwrap();
    for k in 0..3 {
        let at = |by: f64| {
            let mut pose = pose;
            pose[k] += by;
            models.expected(&pose, &place).unwrap().measurement
        };
        let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
        assert!((slope - expected.by_pose.column(k)).norm() < 1e-8);
    }
    let back = models.inverse(&pose, expected.measurement.as_slice()).unwrap();
    assert!((back.feature[0] - place[0]).hypot(back.feature[1] - place[1]) < 1e-12);
}

#[test]
fn landmarks_are_mapped_and_clutter_is_removed() {
    let config = Config {
        birth_intensity: 1e-3,
        birth_probability_min: 0.3,
        gate: 25.0,
        visible_s: 1e9,
        occluded_s: 1.0,
        lifetime_s: 1e9,
        occlusion_factor: 1.0,
        least_existence: 1e-3,
        least_tentative: 1e-3,
        merge_distance: 9.0,
        capacity: 40,
        moving: None,
    };
    let joint = Joint { config, models: planar(Vehicle::UnicycleArc, [0.0; 3]) };
    let mut state = joint.initial(vec![0.0; 3]);
    for step in 0..20 {
        joint.predict(&mut state, &[1.0, 0.0, 0.0], 0.1);
        let along = 0.1 * f64::from(step + 1);
        let elsewhere = [4.0 + 0.5 * f64::from(step), -2.0 + 0.3 * f64::from(step)];
        joint.scan(&mut state, &[&[along.hypot(5.0), 5.0_f64.atan2(-along)], &elsewhere]);
    }
    let found: Vec<usize> = (0..state.features.len()).filter(|&k| state.features[k].detections > 5.0).collect();
    assert_eq!(found.len(), 1);
    assert!((state.places[found[0]][1] - 5.0).abs() < 0.3 && (state.pose[0] - 2.0).abs() < 0.3);
    assert!((&state.covariance - state.covariance.transpose()).amax() < 1e-12);
}
