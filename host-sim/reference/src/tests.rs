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
