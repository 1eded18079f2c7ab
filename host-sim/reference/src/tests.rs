//! Tests of whole steps and of a whole run.

use super::*;
use crate::Likelihood;
use crate::Vehicle;
use std::f64::consts::PI;

pub(super) const CONFIG: Config = Config {
    particles: 3,
    samples: 2,
    birth_intensity: 0.03,
    clutter_intensity: 0.01,
    resample_threshold: 0.0,
    prune_weight: 1e-5,
    merge_distance: 4.0,
    max_components: 50,
    remembering: Remembering::NOTHING,
    extraction_weight: 0.0,
    likelihood: Likelihood::SingleCluster,
    moving: MovingConfig {
        birth_intensity: 0.0,
        velocity_sigma_mps: 1.0,
        acceleration_psd: 0.1,
        lifetime_s: 100.0,
        spread_max_m: 3.0,
        extraction_weight: 0.0,
    },
};

pub(super) const SENSOR: RangeBearing =
    RangeBearing { range_sigma_m: 0.2, range_sigma_ratio: 0.0, bearing_sigma_rad: 0.02 };

/// A field of view of a kilometre in all directions.
pub(super) const WIDE_VIEW: FieldOfView = FieldOfView {
    range_min_m: 0.0,
    range_max_m: 1000.0,
    range_edge_m: 0.0,
    bearing_center_rad: 0.0,
    bearing_half_width_rad: PI,
    bearing_edge_rad: 0.0,
    p_near: 0.9,
    p_far: 0.9,
};

fn reference() -> Reference {
    Reference {
        config: CONFIG,
        motion: Motion {
            vehicle: Vehicle::Unicycle,
            noise: ControlNoise {
                speed_sigma_mps: 0.3,
                second_sigma: 0.1,
                speed_ratio: 0.0,
                second_ratio: 0.0,
                interval_s: 0.0,
            },
        },
        mounting: [0.0; 3],
        sensor: SENSOR,
        field_of_view: FieldOfView { range_max_m: 15.0, ..WIDE_VIEW },
    }
}

fn feature(weight: f64, mean: Vector) -> Component {
    Component { ln_weight: weight.ln(), mean, covariance: [[0.1, 0.0], [0.0, 0.1]] }
}

#[test]
fn zero_time_changes_nothing_and_draws_no_number() {
    let (reference, mut draws) = (reference(), OwnDraws::new(1));
    let mut state = reference.initial([1.0, 2.0, 3.0]);
    let before = state.clone();
    reference.predict(&mut state, &[1.0, 0.0, 0.0], 0.0, &mut draws);
    assert_eq!(state, before);
    assert_eq!(draws.uniform(), OwnDraws::new(1).uniform());
}

#[test]
fn first_prediction_makes_the_candidates_and_later_ones_move_them() {
    let (reference, mut draws) = (reference(), OwnDraws::new(1));
    let mut state = reference.initial([0.0; 3]);
    reference.predict(&mut state, &[1.0, 0.0, 0.0], 0.1, &mut draws);
    let first = state.candidates.clone().expect("candidates");
    assert_eq!(first.len(), 6);
    reference.predict(&mut state, &[1.0, 0.0, 0.0], 0.1, &mut draws);
    let second = state.candidates.clone().expect("candidates");
    assert_eq!(second.len(), 6);
    let mut again = OwnDraws::new(1);
    for before in &first {
        let noise = [again.normal(), again.normal()];
        let x = 0.1 * (1.0 + 0.3 * noise[0]);
        assert!((before.pose[0] - x).abs() < 1e-15);
        assert!((before.pose[2] - 0.1 * 0.1 * noise[1]).abs() < 1e-15);
        assert!((before.ln_weight - (1.0 / 6.0f64).ln()).abs() < 1e-15);
    }
    for (before, after) in first.iter().zip(&second) {
        let moved = reference.motion.sample(before.pose, &[1.0, 0.0, 0.0], 0.1, &mut again);
        assert_eq!(after.pose, moved);
        assert_eq!(after.ln_weight, before.ln_weight);
    }
}

#[test]
fn a_scan_without_prediction_weighs_the_particles() {
    let (reference, mut draws) = (reference(), OwnDraws::new(1));
    let mut state = reference.initial([0.0; 3]);
    let outcome = reference.scan(&mut state, &[[5.0, 0.0]], &mut draws);
    assert_eq!(outcome.weighing.ln_likelihoods.len(), 3);
    assert_eq!(outcome.selection.survivors, [0, 1, 2]);
    assert!((outcome.weighing.n_eff - 3.0).abs() < 1e-12);
    assert_eq!(draws.uniform(), OwnDraws::new(1).uniform());
    for particle in &state.particles {
        assert_eq!(particle.map.len(), 1);
        assert!((particle.map[0].weight() - 0.75).abs() < 1e-14);
    }
}

#[test]
fn candidates_are_weighed_with_their_parents_map() {
    let reference = reference();
    let mut state = reference.initial([0.0; 3]);
    for (i, particle) in state.particles.iter_mut().enumerate() {
        particle.map = vec![feature(0.2 * (i + 1) as f64, [5.0, 0.0])];
    }
    let pose = [0.0; 3];
    let ln_weight = -(6.0f64.ln());
    state.candidates = Some(vec![Candidate { pose, ln_weight }; 6]);
    let weighing = reference.weigh(&state, &[]);
    for (c, ln_likelihood) in weighing.ln_likelihoods.iter().enumerate() {
        let expected = -0.9 * 0.2 * (c / 2 + 1) as f64;
        assert!((ln_likelihood - expected).abs() < 1e-15);
    }
    let total: f64 = weighing.ln_weights.iter().map(|w| w.exp()).sum();
    assert!((total - 1.0).abs() < 1e-14);
}

#[test]
fn components_out_of_view_are_untouched() {
    let reference = reference();
    // One component below the pruning weight, two equal ones that would be merged, and one just out of view.
    let outside = [
        feature(1e-9, [40.0, 0.0]),
        feature(0.5, [0.0, 30.0]),
        feature(0.5, [0.0, 30.0]),
        feature(0.7, [15.000_1, 0.0]),
    ];
    let mut map = outside.to_vec();
    map.insert(1, feature(0.8, [5.0, 0.0]));
    let updated = reference.updated_maps(&[0.0; 3], &map, &[], &[[5.1, 0.0], [14.9, 0.0]]).0;
    assert_eq!(updated[..4], outside);
    assert!(updated[4..].iter().all(|c| c.mean[0] < 15.0));
}

#[test]
fn the_cap_counts_components_in_view() {
    let mut reference = reference();
    reference.config.max_components = 2;
    let mut map: Vec<Component> = (0..3).map(|i| feature(0.5, [30.0 + f64::from(i), 0.0])).collect();
    map.extend((0..5).map(|i| feature(0.5, [5.0, f64::from(i)])));
    assert_eq!(reference.updated_maps(&[0.0; 3], &map, &[], &[]).0.len(), 5);
}

#[test]
fn the_cap_counts_births_from_the_next_scan() {
    let mut reference = reference();
    reference.config.max_components = 2;
    let map: Vec<Component> = (0..5).map(|i| feature(0.5, [5.0, f64::from(i)])).collect();
    let measurements: Vec<Vector> = (2..6).map(|i| [5.0, f64::from(i)]).collect();
    let born = reference.updated_maps(&[0.0; 3], &map, &[], &measurements).0;
    assert_eq!(born.len(), 2 + 4);
    assert_eq!(reference.updated_maps(&[0.0; 3], &born, &[], &[]).0.len(), 2);
}

#[test]
fn births_on_unexplained_measurements_wait_one_scan() {
    let mut reference = reference();
    reference.config.moving.birth_intensity = 0.02;
    // Their distance is small compared with their uncertainty, and each is far from the feature.
    let measurements = [[5.01, 0.0], [5.0, 0.0]];
    let map = [feature(0.5, [0.0, 9.0])];
    let (still, moving) = reference.updated_maps(&[0.0; 3], &map, &[], &measurements);
    assert_eq!((still.len(), moving.len()), (3, 2));
    // Behind the feature although they are heavier, and in the order of the measurements.
    for ((still, moving), [range, _]) in still[1..].iter().zip(&moving).zip(measurements) {
        assert!((still.weight() - 0.03 / 0.06).abs() < 1e-14);
        assert!((moving.weight() - 0.02 / 0.06).abs() < 1e-14);
        assert_eq!((still.mean, moving.mean), ([range, 0.0], [range, 0.0, 0.0, 0.0]));
    }
    let (still, moving) = reference.updated_maps(&[0.0; 3], &still, &moving, &[]);
    assert_eq!((still.len(), moving.len()), (2, 1));
    assert!((still[0].weight() - 0.1).abs() < 1e-14);
}

#[test]
fn births_on_explained_measurements_are_reduced_in_the_same_scan() {
    let mut reference = reference();
    let (map, measurements) = ([feature(0.01, [5.0, 0.0])], [[5.1, 0.0]]);
    let eta = reference.sight([0.0; 3], &map, &[], &measurements).ln_eta[0].exp();
    let updated = |reference: &Reference| reference.updated_maps(&[0.0; 3], &map, &[], &measurements).0;
    let merged = updated(&reference);
    assert_eq!(merged.len(), 1);
    assert!((merged[0].weight() - (0.001 + 1.0 - 0.01 / eta)).abs() < 1e-14);
    // Without merging, the birth is between the detected feature and the missed one, by its weight.
    reference.config.merge_distance = 0.0;
    let apart: Vec<f64> = updated(&reference).iter().map(Component::weight).collect();
    assert_eq!(apart.len(), 3);
    for (weight, expected) in apart.iter().zip([1.0 - 0.04 / eta, 0.03 / eta, 0.001]) {
        assert!((weight - expected).abs() < 1e-14, "{apart:?}");
    }
    reference.config.max_components = 1;
    assert_eq!(updated(&reference).len(), 1);
}

#[test]
fn births_that_wait_are_pruned() {
    let mut reference = reference();
    reference.config.moving.birth_intensity = 0.02;
    // Their weights are 1/2 and 1/3.
    for (prune_weight, lengths) in [(0.3, (1, 1)), (0.4, (1, 0)), (0.6, (0, 0))] {
        reference.config.prune_weight = prune_weight;
        let (still, moving) = reference.updated_maps(&[0.0; 3], &[], &[], &[[5.0, 0.0]]);
        assert_eq!((still.len(), moving.len()), lengths);
    }
}

#[test]
fn weights_are_kept_if_the_scan_has_likelihood_zero() {
    let mut reference = reference();
    reference.config.birth_intensity = 0.0;
    reference.config.clutter_intensity = 0.0;
    let mut state = reference.initial([0.0; 3]);
    for (particle, weight) in state.particles.iter_mut().zip([0.2f64, 0.3, 0.5]) {
        particle.ln_weight = weight.ln();
    }
    let outcome = reference.scan(&mut state, &[[5.0, 0.0]], &mut OwnDraws::new(1));
    assert!(outcome.weighing.weights_kept);
    assert!((state.particles[2].ln_weight - 0.5f64.ln()).abs() < 1e-15);
    assert!(state.particles.iter().all(|particle| particle.map.is_empty()));
}

#[test]
fn resampling_copies_the_map_of_the_best_and_equalises_the_weights() {
    let mut reference = reference();
    reference.config.resample_threshold = 1.0;
    let mut state = reference.initial([0.0; 3]);
    for particle in &mut state.particles {
        particle.map = vec![feature(1.0, [5.0, 0.0])];
    }
    // Only candidate 3 is at the position of the measurement.
    let candidate = |x: f64| Candidate { pose: [x, 0.0, 0.0], ln_weight: -(6.0f64.ln()) };
    state.candidates = Some([-9.0, -8.0, 9.0, 0.0, 8.0, 7.0].map(candidate).to_vec());
    reference.config.birth_intensity = 1e-12;
    reference.config.clutter_intensity = 1e-12;
    let outcome = reference.scan(&mut state, &[[5.0, 0.0]], &mut OwnDraws::new(1));
    assert!(outcome.selection.resampled);
    assert_eq!(outcome.selection.survivors, [3, 3, 3]);
    assert!(state.candidates.is_none());
    for particle in &state.particles {
        assert_eq!(particle.pose, [0.0; 3]);
        assert!((particle.ln_weight + 3f64.ln()).abs() < 1e-15);
        assert_eq!(particle.map, state.particles[0].map);
        assert!((particle.map[0].weight() - 1.1).abs() < 1e-9);
    }
}

#[test]
fn estimated_map_is_that_of_the_heaviest_survivor() {
    let reference = reference();
    let mut state = reference.initial([0.0; 3]);
    let weighing = Weighing {
        ln_likelihoods: vec![0.0; 6],
        ln_weights: [0.1, 0.15, 0.4, 0.02, 0.13, 0.2].map(f64::ln).to_vec(),
        n_eff: 4.0,
        weights_kept: false,
    };
    let of = |survivors: [usize; 3]| Selection {
        resampled: false,
        survivors: survivors.to_vec(),
        ln_weights: vec![-(3f64.ln()); 3],
    };
    for (survivors, heaviest) in [([1, 2, 5], 1), ([1, 3, 4], 0), ([0, 3, 5], 2)] {
        reference.predict(&mut state, &[0.0, 0.0, 0.0], 0.1, &mut OwnDraws::new(1));
        reference.update(&mut state, &[], &weighing, &of(survivors));
        assert_eq!(state.heaviest, heaviest);
    }
}

/// One particle at rest without motion noise, with births of both kinds.
fn watching() -> Reference {
    let mut reference = reference();
    reference.motion.noise =
        ControlNoise { speed_sigma_mps: 0.0, second_sigma: 0.0, speed_ratio: 0.0, second_ratio: 0.0, interval_s: 0.0 };
    reference.config.particles = 1;
    reference.config.samples = 1;
    reference.config.birth_intensity = 0.001;
    reference.config.moving.birth_intensity = 0.001;
    reference
}

#[test]
fn moving_features_are_predicted_at_the_scan_in_one_step() {
    let reference = watching();
    let mut state = reference.initial([0.0; 3]);
    let covariance = [[0.1, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0], [0.0, 0.0, 0.2, 0.0], [0.0, 0.0, 0.0, 0.2]];
    let feature = Component { ln_weight: -0.1, mean: [5.0, 1.0, 1.0, -0.5], covariance };
    state.particles[0].moving = vec![feature];
    let mut draws = OwnDraws::new(1);
    for dt in [0.25, 0.0, 0.5] {
        reference.predict(&mut state, &[0.0, 0.0, 0.0], dt, &mut draws);
    }
    assert_eq!(state.waited_s, 0.75);
    assert_eq!(state.particles[0].moving, [feature]);
    assert_eq!(reference.moving_now(&state.particles[0].moving, state.waited_s)[0].mean, [5.75, 0.625, 1.0, -0.5]);
    assert_eq!(reference.estimate(&state).moving, reference.moving_now(&state.particles[0].moving, state.waited_s));

    let (predicted, weighing) =
        (reference.moving_now(&state.particles[0].moving, state.waited_s), reference.weigh(&state, &[]));
    assert!((weighing.ln_likelihoods[0] + 0.9 * predicted[0].weight()).abs() < 1e-15);
    reference.scan(&mut state, &[], &mut draws);
    assert_eq!(state.waited_s, 0.0);
    assert_eq!(state.particles[0].moving[0].mean, predicted[0].mean);
    assert!((state.particles[0].moving[0].weight() - 0.1 * predicted[0].weight()).abs() < 1e-15);
}

#[test]
fn moving_features_without_births_are_kept() {
    let mut reference = watching();
    reference.config.moving.birth_intensity = 0.0;
    let covariance = [[0.1, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0], [0.0, 0.0, 0.2, 0.0], [0.0, 0.0, 0.0, 0.2]];
    let feature = Component { ln_weight: 0.0, mean: [5.0, 0.0, 0.0, 0.0], covariance };
    let (still, moving) = reference.updated_maps(&[0.0; 3], &[], &[feature], &[[5.0, 0.0], [9.0, 1.0]]);
    assert_eq!(still.len(), 2);
    assert_eq!(moving.len(), 1);
    assert!((moving[0].weight() - 1.1).abs() < 0.02);
}

#[test]
fn moving_components_out_of_view_are_untouched() {
    let reference = watching();
    let outside = Component {
        ln_weight: -99.0,
        mean: [15.1, 0.0, -1.0, 0.0],
        covariance: [[0.1, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0], [0.0, 0.0, 0.2, 0.0], [0.0, 0.0, 0.0, 0.2]],
    };
    let (_, moving) = reference.updated_maps(&[0.0; 3], &[], &[outside], &[[14.9, 0.0]]);
    assert_eq!(moving[0], outside);
    assert_eq!(moving.len(), 2);
}

/// The heaviest component within half a metre, and its weight or 0.
fn heaviest_near<const N: usize>(map: &[Component<N>], place: Vector) -> (Option<Component<N>>, f64) {
    let near = |c: &&Component<N>| f64::hypot(c.mean[0] - place[0], c.mean[1] - place[1]) < 0.5;
    let heaviest = map.iter().filter(near).max_by(|a, b| a.ln_weight.total_cmp(&b.ln_weight)).copied();
    (heaviest, heaviest.map_or(0.0, |c| c.weight()))
}

/// Measurements without noise in every scan.
#[test]
fn ten_scans_distinguish_moving_from_static_features() {
    let reference = watching();
    let (velocity, dt) = ([0.6, 0.8], 0.5);
    let (mut walker, post) = ([4.0, -5.0], [6.0, 4.0]);
    let mut state = reference.initial([0.0; 3]);
    let mut draws = OwnDraws::new(1);
    for _ in 0..12 {
        walker = [walker[0] + dt * velocity[0], walker[1] + dt * velocity[1]];
        reference.predict(&mut state, &[0.0, 0.0, 0.0], dt / 2.0, &mut draws);
        reference.predict(&mut state, &[0.0, 0.0, 0.0], dt / 2.0, &mut draws);
        let scan = [walker, post].map(|place| SENSOR.predicted(place, [0.0; 3]).expect("not at the sensor").0);
        reference.scan(&mut state, &scan, &mut draws);
    }
    let particle = &state.particles[0];
    let (moving, moving_weight) = heaviest_near(&particle.moving, walker);
    let (_, still_weight) = heaviest_near(&particle.map, walker);
    let moving = moving.expect("a moving component at the walker");
    assert!(moving_weight > 0.9 && still_weight < 0.01, "{moving_weight} and {still_weight}");
    for (found, expected) in moving.mean[2..].iter().zip(velocity) {
        assert!((found - expected).abs() < 0.1, "{moving:?}");
    }
    let estimate = reference.estimate(&state);
    assert_eq!(estimate.moving[0].mean, moving.mean);

    // A static feature may be a moving one with zero velocity; the static one has the greater weight.
    let (still, still_weight) = heaviest_near(&particle.map, post);
    let (_, moving_weight) = heaviest_near(&particle.moving, post);
    assert!(still_weight > 5.0 * moving_weight, "{still_weight} and {moving_weight}");
    assert!((still.expect("a static component at the post").mean[0] - post[0]).abs() < 0.02);
}

/// A vehicle on a circle among eight landmarks, all always in view, with biased odometry, missed detections and clutter.
#[test]
fn run_alone_finds_the_map_and_corrects_the_odometry() {
    let landmarks: Vec<Vector> = (0..8)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * PI / 4.0).sin_cos();
            [8.0 * cos, 5.0 + 8.0 * sin]
        })
        .collect();
    let mut reference = reference();
    let clutter_rate = 2.0;
    reference.config = Config {
        particles: 50,
        samples: 2,
        birth_intensity: 0.002,
        clutter_intensity: reference.field_of_view.clutter_intensity(clutter_rate),
        resample_threshold: 0.5,
        ..CONFIG
    };
    let odometry_bias = [0.1, 0.01];
    let quiet =
        ControlNoise { speed_sigma_mps: 0.0, second_sigma: 0.0, speed_ratio: 0.0, second_ratio: 0.0, interval_s: 0.0 };
    let vehicle = Motion { noise: quiet, ..reference.motion };
    let (mut world, mut draws) = (OwnDraws::new(2), OwnDraws::new(3));
    let mut state = reference.initial([0.0; 3]);
    let (mut truth, mut dead_reckoning) = ([0.0; 3], [0.0; 3]);
    let control = [1.0, 0.2, 0.0];
    let read = [control[0] + odometry_bias[0], control[1] + odometry_bias[1], 0.0];
    for _ in 0..200 {
        truth = vehicle.step(truth, &control, 0.2);
        dead_reckoning = vehicle.step(dead_reckoning, &read, 0.2);
        reference.predict(&mut state, &read, 0.2, &mut draws);
        let mut scan = Vec::new();
        for landmark in &landmarks {
            let seen = reference.field_of_view.detection_probability(*landmark, truth);
            if world.uniform() < seen {
                let (exact, _) = SENSOR.predicted(*landmark, truth).expect("not on a landmark");
                scan.push([
                    exact[0] + SENSOR.range_sigma_m * world.normal(),
                    exact[1] + SENSOR.bearing_sigma_rad * world.normal(),
                ]);
            }
        }
        // Three times with the probability of a third of the rate: on average as many false measurements as the rate.
        for _ in 0..3 {
            if world.uniform() < clutter_rate / 3.0 {
                scan.push([15.0 * world.uniform(), PI * (2.0 * world.uniform() - 1.0)]);
            }
        }
        reference.scan(&mut state, &scan, &mut draws);
    }
    let estimate = reference.estimate(&state);
    let distance = |a: &[f64], b: &[f64]| f64::hypot(a[0] - b[0], a[1] - b[1]);
    let error = distance(&estimate.pose, &truth);
    let uncorrected = distance(&dead_reckoning, &truth);
    assert!(uncorrected > 2.0, "dead reckoning is off by {uncorrected} m");
    assert!(error < 0.5, "off by {error} m");
    // A landmark missed by the last scan keeps a tenth of its weight.
    let found = estimate.expected_features;
    assert!((found - 8.0).abs() < 2.5, "{found} features");
    for landmark in &landmarks {
        let nearest = state.particles[state.heaviest]
            .map
            .iter()
            .filter(|c| c.weight() > 0.05)
            .map(|c| distance(&c.mean, landmark))
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.7, "{landmark:?} is {nearest} m off");
    }
}
