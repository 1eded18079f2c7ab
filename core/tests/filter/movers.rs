//! Features that move, and their names, against closed forms and on small scenes.

use crate::alone::{Alone, Lidar, Models};
use crate::*;
use nalgebra::{Vector2, Vector4};
use std::collections::BTreeMap;

type Tracker<'s> = Alone<'s, KnownPose<PlanarPose<f64>>, Lidar<f64>>;
type Memory = State<
    PlanarPose<f64>,
    2,
    2,
    MapMemory<Static<Vector2<f64>>, 2, 64, 32, 512>,
    MapMemory<Dynamic<Vector2<f64>>, 2, 64, 32, 512>,
>;

const ORIGIN: PlanarPose<f64> = PlanarPose::new(0.0, 0.0, 0.0);
const DETECTION: f64 = 0.9;
const CLUTTER_PER_SCAN: f64 = 2.0;

fn models() -> Models<KnownPose<PlanarPose<f64>>, Lidar<f64>> {
    let window = RangeBearingWindow::full_circle(20.0, DETECTION).unwrap();
    Models { motion: KnownPose::new(), sensing: Sensing::range_bearing([0.1, 0.01], window, CLUTTER_PER_SCAN).unwrap() }
}

fn config() -> Config<f64> {
    Config {
        particles: 1,
        extraction_weight: 0.5,
        moving: MovingConfig { velocity_sigma_mps: 1.5, ..MovingConfig::walkers() },
        ..Config::default()
    }
}

const BIRTHS: Births<f64> = Births { of_static: 0.002, of_moving: 0.002 };

fn tracker<'s>(config: Config<f64>, memory: &'s mut Memory) -> Tracker<'s> {
    tracker_of(BIRTHS, config, memory)
}

fn tracker_of<'s>(births: Births<f64>, config: Config<f64>, memory: &'s mut Memory) -> Tracker<'s> {
    let mut filter = Tracker::new(models(), births, config, memory).unwrap();
    filter.reset(ORIGIN, 1).unwrap();
    filter
}

fn seen_at(place: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(place.norm(), place.y.atan2(place.x))
}

#[test]
fn births_of_both_kinds_share_a_measurement() {
    let mut memory = Box::new(Memory::new());
    let mut filter = tracker(config(), &mut memory);
    let report = filter.scan(&[Vector2::new(5.0, 0.3)]).unwrap();
    let kappa = CLUTTER_PER_SCAN / (20.0 * core::f64::consts::TAU);
    // κ, and a birth of either kind, explain the measurement (5.19).
    let weight = 0.002 / (kappa + 0.004);
    assert_eq!(report.births, 2);
    assert!((report.ln_evidence - (kappa + 0.004).ln()).abs() < 1e-14);
    let still = *filter.map(0).next().unwrap();
    let moving = *filter.moving_map(0).next().unwrap();
    assert!((still.ln_weight.exp() - weight).abs() < 1e-15 && (moving.ln_weight.exp() - weight).abs() < 1e-15);
    assert_eq!(moving.mean, Vector4::new(still.mean.x, still.mean.y, 0.0, 0.0));
    assert_eq!(moving.covariance.leading::<Vector2<f64>>(), still.covariance);
    assert_eq!((moving.covariance.get(3, 3), moving.covariance.get(3, 1)), (2.25, 0.0));
    assert_eq!(moving.label, still.label);
}

#[test]
fn births_that_nothing_explains_wait_one_scan_to_be_merged() {
    let mut memory = Box::new(Memory::new());
    let mut filter = tracker(config(), &mut memory);
    let close = [Vector2::new(5.0, 0.3), Vector2::new(5.001, 0.3)];
    let report = filter.scan(&close).unwrap();
    assert_eq!((report.births, report.merged), (4, 0));
    assert_eq!((filter.map(0).count(), filter.moving_map(0).count()), (2, 2));
    // Missed together, they are the two of each kind again, and one now.
    let born: f64 = filter.map(0).map(|birth| birth.ln_weight.exp()).sum();
    let report = filter.scan(&[]).unwrap();
    assert_eq!((report.births, report.merged), (0, 2));
    let merged = filter.map(0).next().unwrap().ln_weight.exp();
    assert!((merged - (1.0 - DETECTION) * born).abs() < 1e-15);
}

#[test]
fn births_that_something_explains_are_merged_at_once() {
    let place = Vector2::new(6.0, 0.0);
    let shared = |weight: f64| {
        let mut memory = Box::new(Memory::new());
        let config = Config { prune_weight: 1e-9, ..config() };
        let mut filter = tracker_of(Births::of_static(0.002), config, &mut memory);
        filter.load_map(&[landmark(weight, 6.0, 0.1)]).unwrap();
        let report = filter.scan(&[place]).unwrap();
        assert_eq!(report.births, 1);
        let by_feature = DETECTION * weight * density(place, 6.0, 0.1);
        (by_feature / (KAPPA + 0.002), report.merged, filter.map(0).count())
    };
    // The feature missed and detected, and the birth, are one.
    let (share, merged, left) = shared(0.5);
    assert!(share > 1e-3);
    assert_eq!((merged, left), (2, 1));
    // A feature on either side of what explains nothing.
    let (share, merged, left) = shared(1e-7);
    assert!(share < 1e-3, "{share}");
    assert_eq!((merged, left), (1, 2));
    let (more, merged, left) = shared(1e-7 * 1.01e-3 / share);
    assert!((more - 1.01e-3).abs() < 1e-12);
    assert_eq!((merged, left), (2, 1));
    let (less, merged, left) = shared(1e-7 * 0.99e-3 / share);
    assert!((less - 0.99e-3).abs() < 1e-12);
    assert_eq!((merged, left), (1, 2));
}

#[test]
fn a_moving_feature_is_weighed_where_it_has_moved_to() {
    let mut memory = Box::new(Memory::new());
    let mut filter = tracker_of(Births { of_static: 0.0, ..BIRTHS }, config(), &mut memory);
    filter.scan(&[Vector2::new(5.0, 0.0)]).unwrap();
    let born = *filter.moving_map(0).next().unwrap();
    // Two predictions are one of the summed time, taken when the scan comes.
    filter.predict(&ORIGIN, 0.3).unwrap();
    filter.predict(&ORIGIN, 0.5).unwrap();
    assert_eq!(filter.moving_map(0).next(), Some(&born));
    let moved = filter.config().moving.motion.advance::<Vector2<f64>>(&born, 0.8).unwrap();
    let z = Vector2::new(5.4, 0.02);
    let report = filter.scan(&[z]).unwrap();
    // By hand: range and bearing of a feature straight ahead at 5 m.
    let s = [moved.covariance.get(0, 0) + 0.01, moved.covariance.get(1, 1) / 25.0 + 0.0001];
    let exponent = 0.4_f64.powi(2) / s[0] + 0.02_f64.powi(2) / s[1];
    let density = (-0.5 * exponent).exp() / (core::f64::consts::TAU * (s[0] * s[1]).sqrt());
    let kappa = CLUTTER_PER_SCAN / (20.0 * core::f64::consts::TAU);
    let eta = kappa + 0.002 + DETECTION * moved.ln_weight.exp() * density;
    let expected = eta.ln() - DETECTION * moved.ln_weight.exp();
    assert!((report.ln_evidence - expected).abs() < 1e-12, "{} against {expected}", report.ln_evidence);
}

/// What becomes of something that stands for two minutes and then drives off for forty seconds: seconds after that
/// until the moving features within half a metre of it weigh half of one, until the static ones where it stood have weighed as
/// much for the last time, and the share of the scans before in which they did.
fn drives_off(speed_mps: f64, detection: f64, seed: u64) -> (f64, f64, f64) {
    const STANDS_S: f64 = 120.0;
    let mut memory = Box::new(Memory::new());
    let mut models = models();
    models.sensing.field_of_view = RangeBearingWindow::full_circle(20.0, detection).unwrap();
    // At a low p_D what has been missed several times must still be there.
    let config = Config { prune_weight: 1e-4, ..config() };
    let mut filter = Tracker::new(models, BIRTHS, config, &mut memory).unwrap();
    filter.reset(ORIGIN, 1).unwrap();
    let mut noise = Noise::seeded(seed);
    let stood = Vector2::new(6.0, 4.0);
    let (mut found_s, mut last_s, mut held) = (f64::INFINITY, 0.0_f64, 0);
    for step in 0..1600 {
        let t = 0.1 * f64::from(step) - STANDS_S;
        filter.predict(&ORIGIN, 0.1).unwrap();
        let place = stood - Vector2::new(speed_mps, 0.0) * t.max(0.0);
        let mut scan = Vec::new();
        if noise.uniform::<f64>() < detection {
            let z = seen_at(place);
            scan.push(Vector2::new(z.x + 0.1 * noise.normal::<f64>(), wrap(z.y + 0.01 * noise.normal::<f64>())));
        }
        for _ in 0..2 {
            let (range, bearing) = (noise.uniform::<f64>(), noise.uniform::<f64>());
            scan.push(Vector2::new(20.0 * range, wrap(core::f64::consts::TAU * bearing)));
        }
        filter.scan(&scan).unwrap();
        let near = |position: Vector2<f64>, at: Vector2<f64>, within| (position - at).norm() < within;
        let weight = |ln_weight: f64| ln_weight.exp();
        let still = filter.map(0).filter(|held| near(held.mean, stood, 0.3));
        let still: f64 = still.map(|held| weight(held.ln_weight)).sum();
        let moving = filter.moving_map(0).filter(|held| near(held.position(), place, 0.5));
        let moving: f64 = moving.map(|held| weight(held.ln_weight)).sum();
        if t < 0.0 {
            held += usize::from(still > 0.5);
        } else if still > 0.5 {
            last_s = t;
        }
        if t >= 0.0 && moving > 0.5 {
            found_s = t.min(found_s);
        }
    }
    (found_s, last_s, held as f64 / (10.0 * STANDS_S))
}

#[test]
fn what_has_stood_for_minutes_and_drives_off_is_found_and_its_place_forgotten() {
    // What creeps is forgotten where it stood, but seldom found to move: features that stand, one after the other, do as well.
    let creeps = f64::INFINITY;
    for (speed_mps, detection, longest_s, place_s, least_held) in [
        (0.5, 0.9, 2.0, 2.0, 0.8),
        (0.5, 0.3, 10.0, 2.0, 0.5),
        (0.06, 0.9, creeps, 15.0, 0.8),
        (0.06, 0.3, creeps, 15.0, 0.5),
    ] {
        for seed in 1..=10 {
            let (found_s, last_s, held) = drives_off(speed_mps, detection, seed);
            println!(
                "{speed_mps} m/s, p_D {detection}: held {held:.2}, moving after {found_s:.1} s, static until {last_s:.1} s"
            );
            assert!(found_s <= longest_s && last_s < place_s && held > least_held);
        }
    }
}

#[test]
fn what_moves_and_what_stands_are_told_apart_and_keep_their_names() {
    let mut memory = Box::new(Memory::new());
    let mut filter = tracker(config(), &mut memory);
    let mut noise = Noise::seeded(9);
    let landmarks = [Vector2::new(6.0, 4.0), Vector2::new(-3.0, 8.0), Vector2::new(2.0, -7.0)];
    let (start, velocity) = (Vector2::new(-10.0, -4.0), Vector2::new(1.2, 0.5));
    // How often each name was among the estimates. A landmark that the last scan missed is not among them.
    let mut still_names: BTreeMap<u32, usize> = BTreeMap::new();
    let mut moving_names: BTreeMap<u32, usize> = BTreeMap::new();
    for step in 0..100 {
        let t = 0.1 * f64::from(step);
        filter.predict(&ORIGIN, 0.1).unwrap();
        let walker = start + velocity * t;
        let mut scan: Vec<_> = landmarks.iter().chain([&walker]).copied().map(seen_at).collect();
        scan.retain_mut(|z| {
            z.x += 0.1 * noise.normal::<f64>();
            z.y = wrap(z.y + 0.01 * noise.normal::<f64>());
            noise.uniform::<f64>() < DETECTION
        });
        for _ in 0..2 {
            scan.push(Vector2::new(
                20.0 * noise.uniform::<f64>(),
                wrap(core::f64::consts::TAU * noise.uniform::<f64>()),
            ));
        }
        filter.scan(&scan).unwrap();
        if step < 20 {
            continue;
        }
        let mut still = [Component::ZERO; 8];
        let mut moving = [Component::ZERO; 8];
        let still_map = filter.estimate_map(&mut still);
        let moving_map = filter.estimate_moving(&mut moving);
        for found in &still[..still_map.features] {
            *still_names.entry(found.label).or_default() += 1;
            assert!(landmarks.iter().any(|landmark| (found.mean - landmark).norm() < 0.2), "{}", found.mean);
        }
        for found in &moving[..moving_map.features] {
            *moving_names.entry(found.label).or_default() += 1;
            assert!(
                (found.position::<Vector2<f64>>() - walker).norm() < 0.5,
                "{} from {walker}",
                found.position::<Vector2<f64>>()
            );
            assert!((Vector2::new(found.mean[2], found.mean[3]) - velocity).norm() < 0.5 || step < 50);
        }
    }
    // Now and then a copy that was not merged in time is estimated once under a name of its own.
    let lasting = |names: &BTreeMap<u32, usize>| names.values().filter(|&&count| count > 60).count();
    let passing = |names: &BTreeMap<u32, usize>| names.values().filter(|&&count| count <= 60).sum::<usize>();
    assert_eq!((lasting(&still_names), lasting(&moving_names)), (3, 1), "{still_names:?} {moving_names:?}");
    assert!(passing(&still_names) <= 2 && passing(&moving_names) <= 2, "{still_names:?} {moving_names:?}");
}

#[test]
fn out_of_view_a_moving_feature_is_forgotten_in_time() {
    let mut memory = Box::new(Memory::new());
    let mut filter = tracker(config(), &mut memory);
    for step in 0..20 {
        filter.predict(&ORIGIN, 0.1).unwrap();
        filter.scan(&[Vector2::new(10.0 + 0.12 * f64::from(step), 0.0), Vector2::new(5.0, 2.0)]).unwrap();
    }
    assert!(filter.moving_map(0).any(|component| component.ln_weight > 0.9_f64.ln()));
    // The sensor turns up a hundred metres away; nothing is in view.
    let elsewhere = PlanarPose::new(100.0, 0.0, 0.0);
    let (mut forgotten, mut pages_used) = (None, usize::MAX);
    for step in 1..1000 {
        filter.predict(&elsewhere, 0.1).unwrap();
        pages_used = filter.scan(&[]).unwrap().moving_pages_used;
        for component in filter.moving_map(0) {
            assert!((0..2).all(|axis| component.covariance.get(axis, axis).sqrt() <= 3.0));
        }
        if filter.moving_map(0).count() == 0 {
            forgotten = Some(step);
            break;
        }
    }
    // √(q t³/3) alone is 3 m after 6.5 s.
    assert!(forgotten.is_some_and(|step| step < 66), "{forgotten:?}");
    assert_eq!(pages_used, 0);
    assert!(filter.map(0).count() > 0, "what stands still stays");
}

#[test]
fn a_state_without_memory_for_it_refuses_to_track() {
    type Small = State<PlanarPose<f64>, 1, 1, MapMemory<Static<Vector2<f64>>, 1, 8, 8, 64>>;
    let mut memory = Box::new(Small::new());
    let tracker = Tracker::new(models(), BIRTHS, config(), &mut *memory);
    assert_eq!(tracker.map(|_| ()), Err(SetupError::NoRoomForMoving));
    let mut memory = Box::new(Small::new());
    let mut tracker = Tracker::new(models(), Births::of_static(0.002), config(), &mut *memory).unwrap();
    tracker.reset(ORIGIN, 1).unwrap();
    assert!(tracker.scan(&[]).is_ok());
    tracker.detector.adopt(Detector::new(models().sensing, BIRTHS).unwrap());
    assert_eq!(tracker.scan(&[]), Err(ScanError::NoRoomForMoving));
}

fn landmark(weight: f64, x: f64, sigma: f64) -> Component<Vector2<f64>> {
    let covariance = Symmetric::from_diagonal([sigma * sigma, sigma * sigma]);
    Component { ln_weight: weight.ln(), mean: Vector2::new(x, 0.0), covariance, ..Component::ZERO }
}

const KAPPA: f64 = CLUTTER_PER_SCAN / (20.0 * core::f64::consts::TAU);

/// N(z; ẑ, S) of a landmark straight ahead at x.
fn density(z: Vector2<f64>, x: f64, sigma: f64) -> f64 {
    let s = [sigma * sigma + 0.01, sigma * sigma / (x * x) + 0.0001];
    let exponent = (z.x - x).powi(2) / s[0] + z.y * z.y / s[1];
    (-0.5 * exponent).exp() / (core::f64::consts::TAU * (s[0] * s[1]).sqrt())
}
