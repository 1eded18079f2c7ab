//! Compares a prediction that is split at a scan with the whole one.

use scphd::models::{
    Ackermann, AckermannControl, AckermannGeometry, ControlNoise, Motion, PlanarPose, Pose, Step, Unicycle,
    UnicycleControl,
};

const START: PlanarPose<f64> = PlanarPose::new(3.0, -2.0, 0.7);

/// The poses after 0.1 s in one step, in two steps, and in a hundred.
fn ends<M: Motion<Pose = PlanarPose<f64>>>(motion: &M, control: M::Control) -> [PlanarPose<f64>; 3] {
    let part = |from: &PlanarPose<f64>, dt| motion.propagate(from, &control, dt);
    let fine = (0..100).fold(START, |pose, _| part(&pose, 0.001));
    [part(&START, 0.1), part(&part(&START, 0.037), 0.063), fine]
}

#[test]
fn along_an_arc_both_end_at_the_same_pose() {
    let motion = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    for (speed_mps, rate_radps) in [(2.0, 0.9), (-1.0, -3.0), (0.5, 0.0), (0.0, 2.0)] {
        let [whole, split, fine] = ends(&motion, UnicycleControl { speed_mps, rate_radps });
        assert!(split.difference(&whole).norm() < 1e-14 && fine.difference(&whole).norm() < 1e-13);
    }
}

#[test]
fn two_straight_steps_are_nearer_to_the_arc_than_one() {
    let euler = Unicycle::new(Step::Euler, ControlNoise::NONE).unwrap();
    let control = UnicycleControl { speed_mps: 2.0, rate_radps: 0.9 };
    let geometry =
        AckermannGeometry { wheelbase_m: 2.8, encoder_offset_m: 0.76, sensor_forward_m: 3.8, sensor_left_m: 0.5 };
    let car = Ackermann::new(geometry, ControlNoise::NONE).unwrap();
    for [whole, split, fine] in
        [ends(&euler, control), ends(&car, AckermannControl { speed_mps: 5.0, steering_rad: 0.3 })]
    {
        let [of_whole, of_split] = [whole, split].map(|pose| pose.difference(&fine).norm());
        assert!(of_split < 0.6 * of_whole && of_whole > 1e-3, "{of_split} {of_whole}");
    }
}

/// Straight ahead the variances of the parts add up: with correlated errors to that of the whole, with white noise to less.
#[test]
fn correlated_noise_spreads_as_in_the_whole_prediction() {
    let along = |interval_s, dt| {
        let noise = ControlNoise { interval_s, ..ControlNoise::white(0.2, 0.0) };
        let control = UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 };
        let motion = Unicycle::new(Step::Arc, noise).unwrap();
        motion.linearise(&PlanarPose::new(0.0, 0.0, 0.0), &control, dt).noise.get(0, 0)
    };
    let [lasting, white] =
        [0.1, 0.0].map(|interval_s| (along(interval_s, 0.037) + along(interval_s, 0.063)) / along(interval_s, 0.1));
    assert!((lasting - 1.0_f64).abs() < 1e-12);
    assert!((white - (0.37_f64.powi(2) + 0.63_f64.powi(2))).abs() < 1e-12);
}
