//! Faults of a vehicle, injected: full memory, empty input, vanishing weights. None may cause a panic, a leak or an endless loop,
//! and each must be reported.

use crate::tests::alone::{Alone, Lidar, Models};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec::Vec;

type Car = Unicycle<f32>;
type Planar<'s, M> = Alone<'s, M, Lidar<f32>>;
/// Static and moving maps of the same capacities: particles, candidates, pages, pages a map, view.
type Compact<const N: usize, const C: usize, const P: usize, const M: usize, const V: usize> = State<
    PlanarPose<f32>,
    N,
    C,
    MapMemory<Static<Vector2<f32>>, N, P, M, V>,
    MapMemory<Dynamic<Vector2<f32>>, N, P, M, V>,
>;
type Roomy = Compact<8, 16, 256, 32, 256>;

fn models(clutter_per_scan: f32) -> Models<Car, Lidar<f32>> {
    let window = RangeBearingWindow::full_circle(20.0, 0.9).unwrap();
    Models {
        motion: Unicycle::new(Step::Euler, ControlNoise::white(0.3, 0.05)).unwrap(),
        sensing: Sensing::range_bearing([0.2, 0.02], window, clutter_per_scan).unwrap(),
    }
}

const AHEAD: UnicycleControl<f32> = UnicycleControl { speed_mps: 1.0, rate_radps: 0.1 };
const BIRTHS: Births<f32> = Births::of_static(0.01);
const ORIGIN: PlanarPose<f32> = PlanarPose::new(0.0, 0.0, 0.0);

fn config() -> Config<f32> {
    Config { particles: 8, samples: 2, ..Config::default() }
}

/// A filter at the origin, whose memory lives until the test ends.
fn started(models: Models<Car, Lidar<f32>>, births: Births<f32>, config: Config<f32>) -> Planar<'static, Car> {
    let mut filter = Planar::new(models, births, config, Box::leak(Box::new(Roomy::new()))).unwrap();
    filter.reset(ORIGIN, 1).unwrap();
    filter
}

/// Pseudo-random numbers in [0, 1) for inputs.
fn numbers(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    }
}

fn random_scan(number: &mut impl FnMut() -> f32, len: usize) -> Vec<Vector2<f32>> {
    (0..len).map(|_| Vector2::new(20.0 * number(), 6.2 * number() - 3.1)).collect()
}

fn check_consistent(filter: &mut Planar<'_, Car>) {
    let digest = filter.digest();
    assert_eq!(filter.audit(), Ok(()));
    assert_eq!(filter.digest(), digest, "the audit changed the state");
    let total: f32 = filter.candidates().iter().map(|candidate| candidate.ln_weight.exp()).sum();
    assert!((total - 1.0).abs() < 1e-5, "weights sum to {total}");
    for particle in 0..filter.particles() {
        check_map(filter.map(particle));
        check_map(filter.moving_map(particle));
    }
}

fn check_map<'c, N: Vector<Scalar = f32>>(map: impl Iterator<Item = &'c Component<N>>) {
    let mut labels = Vec::new();
    for component in map {
        assert!(component.ln_weight.is_finite() && component.mean.as_slice().iter().all(|x| x.is_finite()));
        assert!(component.covariance.factor().is_some(), "{component:?}");
        labels.push(component.label);
    }
    let components = labels.len();
    labels.sort_unstable();
    labels.dedup();
    assert_eq!(labels.len(), components, "two components have one label");
}

#[test]
fn an_audit_finds_damaged_memory() {
    let mut state = Box::new(Roomy::new());
    let mut filter = Planar::new(models(2.0), BIRTHS, config(), &mut *state).unwrap();
    assert_eq!(filter.audit(), Ok(()));
    filter.reset(ORIGIN, 1).unwrap();
    filter.predict(&AHEAD, 0.1).unwrap();
    filter.scan(&[Vector2::new(5.0, 1.0), Vector2::new(7.0, 0.0)]).unwrap();
    check_consistent(&mut filter);
    let held = filter.memory.static_maps.table.pages(0)[0];
    filter.memory.static_maps.pool.share(held);
    assert_eq!(filter.audit(), Err(Flaw::Pages));
    filter.memory.static_maps.pool.release(held);
    assert_eq!(filter.audit(), Ok(()));
    // Allocated although a map still holds it.
    let extra = filter.memory.static_maps.pool.take().unwrap().0;
    assert_eq!(filter.audit(), Err(Flaw::Pages));
    filter.memory.static_maps.pool.release(extra);
    filter.memory.candidates[1].ln_weight = 0.5;
    assert_eq!(filter.audit(), Err(Flaw::Weights));
    filter.memory.candidates[0].pose.x_m = f32::NAN;
    assert_eq!(filter.audit(), Err(Flaw::Pose));
    filter.reset(ORIGIN, 1).unwrap();
    filter.scan(&[Vector2::new(5.0, 1.0)]).unwrap();
    for page in filter.memory.static_maps.pool.held_mut() {
        page.change(|component| Some(Component { covariance: Symmetric::ZERO, ..*component }));
    }
    assert_eq!(filter.audit(), Err(Flaw::Component));
}

#[test]
fn nothing_works_before_the_first_reset() {
    let mut state = Box::new(Roomy::new());
    let mut filter = Planar::new(models(2.0), BIRTHS, config(), &mut *state).unwrap();
    assert_eq!(filter.predict(&AHEAD, 0.1), Err(PredictError::NotStarted));
    assert_eq!(filter.scan(&[]), Err(ScanError::NotStarted));
    assert_eq!(filter.load_map(&[]), Err(LoadMapError::NotStarted));
    assert!(filter.estimate_pose().is_none());
    assert_eq!(filter.reset(PlanarPose::new(f32::NAN, 0.0, 0.0), 1), Err(ResetError::NonFinitePose));
    assert!(filter.estimate_pose().is_none());
}

#[test]
fn a_configuration_that_does_not_fit_is_refused() {
    let mut state = Box::new(Roomy::new());
    let mut refused = |config| Planar::new(models(2.0), BIRTHS, config, &mut *state).map(|_| ()).unwrap_err();
    assert_eq!(
        refused(Config { particles: 9, ..config() }),
        SetupError::TooManyParticles { particles: 9, capacity: 8 }
    );
    assert_eq!(
        refused(Config { samples: 3, ..config() }),
        SetupError::TooManyCandidates { candidates: 24, capacity: 16 }
    );
    assert!(matches!(
        refused(Config { prune_weight: f32::NAN, ..config() }),
        SetupError::Config(ConfigError { field: "prune_weight", .. })
    ));
    assert!(matches!(refused(Config { samples: usize::MAX, ..config() }), SetupError::TooManyCandidates { .. }));
}

#[test]
fn refused_input_leaves_the_state_as_it_was() {
    let mut filter = started(models(2.0), BIRTHS, config());
    filter.predict(&AHEAD, 0.1).unwrap();
    filter.scan(&[Vector2::new(5.0, 1.0)]).unwrap();
    filter.predict(&AHEAD, 0.1).unwrap();
    let before = filter.digest();
    let control = |v, w| UnicycleControl { speed_mps: v, rate_radps: w };
    assert_eq!(filter.predict(&AHEAD, -0.1), Err(PredictError::TimeStep));
    assert_eq!(filter.predict(&AHEAD, f32::NAN), Err(PredictError::TimeStep));
    assert_eq!(filter.predict(&control(f32::INFINITY, 0.0), 0.0), Err(PredictError::Control));
    assert_eq!(filter.predict(&control(1.0, f32::NAN), 0.0), Err(PredictError::Control));
    let seen = [Vector2::new(5.0, 1.0), Vector2::new(f32::NAN, 1.0)];
    assert_eq!(filter.scan(&seen), Err(ScanError::NonFinite { index: 1 }));
    let many = [Vector2::new(5.0, 1.0); 65];
    assert_eq!(filter.scan(&many), Err(ScanError::TooManyMeasurements { measurements: 65, capacity: 64 }));
    assert_eq!(filter.reset(PlanarPose::new(0.0, f32::INFINITY, 0.0), 1), Err(ResetError::NonFinitePose));
    let bad = Component { covariance: Symmetric::ZERO, ..Component::ZERO };
    assert_eq!(filter.load_map(&[bad]), Err(LoadMapError::Component { index: 0 }));
    let good = Component { covariance: Symmetric::from_diagonal([1.0, 1.0]), ..Component::ZERO };
    let tagged = |label| Component { label, ..good };
    assert_eq!(filter.load_map(&[good, tagged(u32::MAX)]), Err(LoadMapError::Tag { index: 1 }));
    let heavy = Component { ln_weight: 1e30, ..good };
    assert_eq!(filter.load_map(&[heavy]), Err(LoadMapError::Component { index: 0 }));
    let far = Component { mean: Vector2::new(0.0, -2e8), ..good };
    assert_eq!(filter.load_map(&[far]), Err(LoadMapError::Component { index: 0 }));
    assert_eq!(filter.digest(), before);
}

#[test]
fn loaded_features_have_unique_labels() {
    let mut filter = started(models(2.0), BIRTHS, config());
    let tagged = |label| Component { label, covariance: Symmetric::from_diagonal([1.0, 1.0]), ..Component::ZERO };
    filter.load_map(&[tagged(4), tagged(7), tagged(4), tagged(0)]).unwrap();
    let labels: Vec<u32> = filter.map(0).map(|component| component.label).collect();
    assert_eq!(labels, [4, 7, 8, 0]);
    filter.scan(&[Vector2::new(9.0, 1.0)]).unwrap();
    check_consistent(&mut filter);
    // Features born after this have labels above the greatest label of a loaded feature.
    filter.load_map(&[tagged(ScPhd::<Car>::GREATEST_LOADED_LABEL), tagged(0)]).unwrap();
    filter.scan(&[Vector2::new(9.0, 1.0)]).unwrap();
    assert!(filter.map(0).any(|component| component.label > i32::MAX as u32));
    check_consistent(&mut filter);
}

#[test]
fn invalid_odometry_is_refused_and_reported_and_its_time_counts() {
    let mut filter = started(models(2.0), BIRTHS, config());
    filter.predict(&AHEAD, 0.1).unwrap();
    let (poses, noise) = (filter.candidates().to_vec(), filter.noise().cloned());
    let control = |v, w| UnicycleControl { speed_mps: v, rate_radps: w };
    let cases = [
        (control(1e18, 0.0), 0.1, PredictError::Implausible(Implausible::Speed)),
        (control(1.0, -1e3), 0.1, PredictError::Implausible(Implausible::TurnRate)),
        (AHEAD, 1e4, PredictError::Implausible(Implausible::Step)),
        (control(f32::NAN, 0.0), 0.1, PredictError::Control),
    ];
    for (control, dt, error) in cases {
        assert_eq!(filter.predict(&control, dt), Err(error));
    }
    assert_eq!((filter.candidates(), filter.noise()), (&poses[..], noise.as_ref()));
    // The time of the first prediction, and of all refused ones except the one that was too long.
    assert!((filter.waited_s() - 0.4).abs() < 1e-6);
    let report = filter.predict(&AHEAD, 0.1).unwrap();
    assert_eq!((report.refused, report.health), (4, Health::PREDICTION_REFUSED));
    let report = filter.scan(&[Vector2::new(5.0, 1.0)]).unwrap();
    assert!(report.refused == 4 && report.health.contains(Health::PREDICTION_REFUSED));
    let report = filter.scan(&[Vector2::new(5.0, 1.0)]).unwrap();
    assert!(report.refused == 0 && !report.health.contains(Health::PREDICTION_REFUSED));
    check_consistent(&mut filter);
}

#[test]
fn the_mean_pose_is_right_far_from_the_origin_and_in_an_unlikely_scan() {
    let mut state = Box::new(Roomy::new());
    // The likelihood of the measurements is very small.
    let mut filter = Planar::new(models(1e-7), Births::of_static(1e-9), config(), &mut *state).unwrap();
    filter.reset(PlanarPose::new(1000.0, -1000.0, 0.0), 1).unwrap();
    let mut number = numbers(5);
    let mut ln_least = 0.0_f32;
    for _ in 0..20 {
        filter.predict(&AHEAD, 0.1).unwrap();
        let report = filter.scan(&random_scan(&mut number, 64)).unwrap();
        ln_least = ln_least.min(report.ln_evidence);
        let (mut total, mut sum) = (0.0, Vector2::zeros());
        for Candidate { pose, ln_weight, .. } in filter.candidates() {
            let weight = f64::from(*ln_weight).exp();
            total += weight;
            sum += Vector2::new(f64::from(pose.x_m), f64::from(pose.y_m)) * weight;
        }
        assert!((total - 1.0).abs() < 1e-5, "{total}");
        let mean = filter.estimate_pose().unwrap().mean;
        let off = Vector2::new(f64::from(mean.x_m), f64::from(mean.y_m)) - sum / total;
        assert!(off.norm() < 1e-3, "{off}");
    }
    assert!(ln_least < -1000.0, "{ln_least}");
}

#[test]
fn a_step_of_no_length_changes_nothing() {
    let mut filter = started(models(2.0), BIRTHS, config());
    let before = filter.digest();
    let report = filter.predict(&AHEAD, 0.0).unwrap();
    assert_eq!((filter.digest(), report.candidates), (before, 8));
}

#[test]
fn a_pose_that_overflows_stays_where_it_was_and_is_reported() {
    let mut filter = started(models(2.0), BIRTHS, Config { plausible: Plausible::ANYTHING, ..config() });
    let report = filter.predict(&UnicycleControl { speed_mps: f32::MAX, rate_radps: 0.0 }, 10.0).unwrap();
    assert_eq!((report.rejected, report.health), (16, Health::POSE_REJECTED));
    assert!(filter.candidates().iter().all(|candidate| candidate.pose == ORIGIN));
}

#[test]
fn empty_scans_are_valid() {
    let mut filter = started(models(2.0), BIRTHS, config());
    for _ in 0..50 {
        filter.predict(&AHEAD, 0.1).unwrap();
        let report = filter.scan(&[]).unwrap();
        assert!(report.health.is_good(), "{:?}", report.health);
        assert_eq!((report.measurements, report.in_view, report.pages_used), (0, 0, 0));
        check_consistent(&mut filter);
    }
    let map = filter.estimate_map(&mut [Component::ZERO; 4]);
    assert_eq!((map.expected_features, map.features, map.left_out), (0.0, 0, 0));
}

#[test]
fn one_particle_is_valid() {
    let mut state = Box::new(Compact::<1, 1, 8, 8, 64>::new());
    let mut filter =
        Planar::new(models(2.0), BIRTHS, Config { particles: 1, ..Config::default() }, &mut *state).unwrap();
    filter.reset(ORIGIN, 1).unwrap();
    for _ in 0..20 {
        filter.predict(&AHEAD, 0.1).unwrap();
        let report = filter.scan(&[Vector2::new(10.0, 0.5)]).unwrap();
        assert!(!report.health.contains(Health::DEGENERATE));
        assert_eq!(report.n_eff, 1.0);
        check_consistent(&mut filter);
    }
}

#[test]
fn an_unexplained_scan_keeps_the_weights_and_is_reported() {
    unexplained(8, 2);
    // A single candidate is weighted by the update of its map.
    unexplained(1, 1);
}

fn unexplained(particles: usize, samples: usize) {
    // No clutter, no births, and the only feature out of view: all likelihoods are zero.
    let config = Config { particles, samples, ..config() };
    let mut filter = started(models(0.0), Births::NONE, config);
    let unit = Symmetric::from_diagonal([0.01, 0.01]);
    let feature = Component { label: 0, ln_weight: 0.0, mean: Vector2::new(25.0, 0.0), covariance: unit };
    filter.load_map(&[feature]).unwrap();
    filter.predict(&AHEAD, 0.1).unwrap();
    let report = filter.scan(&[Vector2::new(5.0, 3.0), Vector2::new(-1.0, 0.0)]).unwrap();
    assert!(report.health.contains(Health::UNEXPLAINED_SCAN), "{:?}", report.health);
    assert_eq!(report.ln_evidence, f32::NEG_INFINITY);
    assert_eq!(report.n_eff.round(), (particles * samples) as f32);
    check_consistent(&mut filter);
    // It continues when the feature comes into view.
    filter.predict(&UnicycleControl { speed_mps: 10.0, rate_radps: 0.0 }, 1.0).unwrap();
    let report = filter.scan(&[Vector2::new(14.9, 0.0)]).unwrap();
    assert!(report.ln_evidence.is_finite());
    check_consistent(&mut filter);
}

#[test]
fn a_measurement_without_inverse_is_weighted_but_gives_no_birth() {
    let mut filter = started(models(2.0), BIRTHS, config());
    let report = filter.scan(&[Vector2::new(-0.3, 0.0)]).unwrap();
    assert_eq!((report.no_birth, report.births), (report.maps_updated, 0));
    assert!(report.ln_evidence.is_finite());
}

#[test]
fn a_measurement_beyond_the_view_gives_no_birth() {
    let mut filter = started(models(2.0), BIRTHS, config());
    let report = filter.scan(&[Vector2::new(20.5, 0.0), Vector2::new(19.5, 0.0)]).unwrap();
    assert_eq!((report.no_birth, report.births), (report.maps_updated, report.maps_updated));
    assert_eq!(filter.map(0).count(), 1);
}

#[test]
fn full_memory_degrades_in_order_and_recovers() {
    // Capacity for a tenth of the features in the scans: 24 pages for 8 particles, 3 pages a map, 32 components in an update.
    let mut state = Box::new(Compact::<8, 16, 24, 3, 32>::new());
    let mut filter = Planar::new(models(0.5), Births::of_static(0.05), config(), &mut *state).unwrap();
    filter.reset(ORIGIN, 1).unwrap();
    let mut number = numbers(7);
    let mut seen = Health::GOOD;
    for _ in 0..300 {
        filter.predict(&AHEAD, 0.1).unwrap();
        let report = filter.scan(&random_scan(&mut number, 40)).unwrap();
        assert!(report.pages_used <= 24);
        assert_eq!(report.maps_updated + report.not_updated, report.survivors);
        seen |= report.health;
        check_consistent(&mut filter);
    }
    assert!(seen.contains(Health::PRUNING_TIGHTENED), "{seen:?}");
    // With fewer features, all warnings disappear.
    let mut last = Health::GOOD;
    for _ in 0..60 {
        filter.predict(&AHEAD, 0.1).unwrap();
        last = filter.scan(&[Vector2::new(15.0, 0.0)]).unwrap().health;
        check_consistent(&mut filter);
    }
    let lack = [Health::PRUNING_TIGHTENED, Health::MAP_NOT_UPDATED, Health::COMPONENTS_LOST];
    assert!(lack.iter().all(|&flag| !last.contains(flag)), "{last:?}");
}

#[test]
fn confirmed_features_outlive_clutter_when_memory_is_full() {
    // The two pages of a map have room for exactly the sixteen landmarks.
    let mut state = Box::new(Compact::<4, 4, 16, 2, 128>::new());
    let motionless = Models { motion: Unicycle::new(Step::Euler, ControlNoise::NONE).unwrap(), ..models(4.0) };
    let config = Config { particles: 4, ..Config::default() };
    let mut filter = Planar::new(motionless, Births::of_static(0.03), config, &mut *state).unwrap();
    filter.reset(ORIGIN, 1).unwrap();
    let landmarks: Vec<_> = (0..16).map(|k| Vector2::new(4.0 + 0.9 * k as f32, -3.0 + 0.4 * k as f32)).collect();
    let mut number = numbers(11);
    let mut tightened = 0;
    for step in 0..40 {
        let mut scan = landmarks.clone();
        if step > 10 {
            scan.extend(random_scan(&mut number, 8));
        }
        tightened += filter.scan(&scan).unwrap().tightened;
        check_consistent(&mut filter);
    }
    assert!(tightened > 0);
    let mut features = [Component::ZERO; 16];
    let map = filter.estimate_map(&mut features);
    assert_eq!(map.features, 16);
    for landmark in &landmarks {
        let at = Vector2::new(landmark.x * landmark.y.cos(), landmark.x * landmark.y.sin());
        let nearest = features.iter().map(|feature| (feature.mean - at).norm()).fold(f32::MAX, f32::min);
        assert!(nearest < 0.2, "the landmark at {at} was lost");
    }
}

#[test]
fn covariances_stay_positive_definite_over_a_million_updates() {
    // The hardest case for single precision: a static feature that is measured repeatedly from the same place, far away and in a
    // narrow range of angles, with standard deviations of 1 mm for the range and 0.1 rad for the bearing.
    let mut covariance = Symmetric::<Vector2<f32>>::from_diagonal([400.0, 400.0]);
    let noise = Symmetric::from_diagonal([1e-6, 1e-2]);
    let sensor = RangeBearing::new(1e-3_f32, 0.1).unwrap();
    let mut repaired = 0;
    for step in 0..1_000_000 {
        let frame = sensor.frame(&PlanarPose::new(0.0, 0.001 * (step % 100) as f32, 0.0));
        let expected = sensor.expect(&frame, &Vector2::new(30.0, 40.0)).unwrap();
        let innovation = covariance.congruence::<Vector2<f32>>(&expected.jacobian).plus(&noise).factor().unwrap();
        let correction = Correction::new::<Vector2<f32>>(&covariance, &expected.jacobian, &noise, &innovation);
        let corrected = correction.apply(&Component::ZERO, &Vector2::zeros(), 0.0).covariance;
        repaired += usize::from(correction.repaired());
        assert!(corrected.factor().is_some(), "step {step}: {corrected:?}");
        assert!(corrected.get(0, 0) <= covariance.get(0, 0) * 1.001);
        covariance = corrected;
    }
    std::println!("{repaired} repairs, {covariance:?}");
}

#[test]
fn a_probe_sees_the_stages_in_order_and_changes_nothing() {
    #[derive(Default)]
    struct Steps(Vec<(Stage, bool)>);
    impl Probe for Steps {
        fn enter(&mut self, stage: Stage) {
            self.0.push((stage, true));
        }
        fn leave(&mut self, stage: Stage) {
            self.0.push((stage, false));
        }
    }
    let digest = |steps: Option<&mut Steps>| {
        let mut state = Box::new(Roomy::new());
        let mut filter = Planar::new(models(2.0), BIRTHS, config(), &mut *state).unwrap();
        filter.reset(ORIGIN, 1).unwrap();
        let scan = [Vector2::new(5.0, 1.0)];
        match steps {
            Some(steps) => {
                filter.predict_with(&AHEAD, 0.1, steps).unwrap();
                filter.slam.scan_with(&mut filter.detector, &scan, steps).unwrap();
            }
            None => {
                filter.predict(&AHEAD, 0.1).unwrap();
                filter.scan(&scan).unwrap();
            }
        }
        filter.digest()
    };
    let mut steps = Steps::default();
    assert_eq!(digest(Some(&mut steps)), digest(None));
    let begun: Vec<Stage> = steps.0.iter().filter(|step| step.1).map(|step| step.0).collect();
    let (before_reduce, reduce) = begun.split_at(5);
    // Moving features are predicted at the scan.
    assert_eq!(before_reduce, [Stage::Predict, Stage::Predict, Stage::Weigh, Stage::Resample, Stage::Update]);
    assert!(!reduce.is_empty() && reduce.iter().all(|&stage| stage == Stage::Reduce));
    assert_eq!(steps.0.last(), Some(&(Stage::Update, false)));
    assert_eq!(steps.0.iter().filter(|step| !step.1).count(), begun.len());
}
