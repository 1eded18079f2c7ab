//! Planar scans of any lidar: their directions, ends, returns and times.

mod world;

use proptest::prelude::*;
use scphd_lidar::{Assembler, Found, LaserScan, PostFinder, PostSettings, Scan, Sweep};
use std::f32::consts::{PI, TAU};
use world::{Draws, Lidar, World};

/// Half a degree between beams, over a full circle, from the rear to the left.
const BEAMS: usize = 720;
const ROUND: Sweep =
    Sweep { start_rad: -PI, increment_rad: TAU / BEAMS as f32, range_min_m: 0.05, range_max_m: 12.0, duration_s: 0.1 };

fn find(sweep: Sweep, ranges: &[f32]) -> Found<32> {
    let finder = PostFinder::new(PostSettings::of_radius(0.1)).unwrap();
    finder.find(&LaserScan::new(sweep, ranges, &[]).unwrap())
}

/// Range and bearing of all posts, sorted by bearing.
fn places(found: &Found<32>) -> Vec<[f32; 2]> {
    let mut places: Vec<[f32; 2]> = found.posts.iter().map(|post| [post.range_m, post.bearing_rad]).collect();
    places.sort_by(|one, other| one[1].total_cmp(&other[1]));
    places
}

fn are_near(one: &Found<32>, other: &Found<32>) {
    let (one, other) = (places(one), places(other));
    assert!(one.len() == other.len() && one.len() > 3, "{one:?} {other:?}");
    for (one, other) in one.iter().zip(&other) {
        assert!((one[0] - other[0]).abs() < 1e-4 && (one[1] - other[1]).abs() < 1e-4, "{one:?} {other:?}");
    }
}

/// A yard, and a scan of it.
fn yard(seed: u64) -> (World, Vec<f32>) {
    let mut draws = Draws::seeded(seed);
    let world = World::random(&mut draws, 15, 0.1, |[x, y]| x.hypot(y) > 0.7);
    let ranges = world::scan(&world, &mut draws, &ROUND, BEAMS, 0.0, |_| [0.0; 3]);
    (world, ranges)
}

#[test]
fn the_direction_and_the_first_beam_of_a_circle_do_not_matter() {
    for seed in 0..20 {
        let (_, ranges) = yard(seed);
        let found = find(ROUND, &ranges);
        assert_eq!(found.cut, 0);
        let mut reversed = ranges.clone();
        reversed.reverse();
        let back = Sweep {
            start_rad: ROUND.start_rad + ROUND.increment_rad * (BEAMS - 1) as f32,
            increment_rad: -ROUND.increment_rad,
            duration_s: -ROUND.duration_s,
            ..ROUND
        };
        let other = find(back, &reversed);
        are_near(&found, &other);
        let times = |found: &Found<32>| found.posts.iter().map(|post| post.before_end_s).sum::<f32>();
        assert!((times(&found) - times(&other)).abs() < 1e-4);
        for first in [1, 100, 359, 360, 500, 719] {
            let mut turned = ranges.clone();
            turned.rotate_left(first);
            let start_rad = ROUND.start_rad + ROUND.increment_rad * first as f32;
            are_near(&found, &find(Sweep { start_rad, ..ROUND }, &turned));
        }
    }
}

/// The encoding of a missing return has no effect, nor have ranges beyond the greatest one.
#[test]
fn all_encodings_of_a_missing_return_are_equal() {
    for seed in 0..20 {
        let (_, ranges) = yard(seed);
        let found = find(ROUND, &ranges);
        for empty in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 12.0, 0.01] {
            let told: Vec<f32> = ranges.iter().map(|&range| if range == 0.0 { empty } else { range }).collect();
            assert_eq!(find(ROUND, &told), found, "{empty}");
        }
    }
}

/// A part of a circle has the posts of the whole that are inside it, and none at its ends.
#[test]
fn the_ends_of_a_view_are_cut() {
    let (mut inside, mut cut) = (0, 0);
    for seed in 0..20 {
        let (_, ranges) = yard(seed);
        let whole = places(&find(ROUND, &ranges));
        for first in (0..BEAMS - 300).step_by(7) {
            let start_rad = ROUND.start_rad + ROUND.increment_rad * first as f32;
            let part = find(Sweep { start_rad, ..ROUND }, &ranges[first..first + 300]);
            let ends = [start_rad, start_rad + 299.0 * ROUND.increment_rad];
            let half = |range: f32| (0.1 / range).asin() + 4.0 * ROUND.increment_rad;
            let within =
                |[range, bearing]: &&[f32; 2]| *bearing > ends[0] + half(*range) && *bearing < ends[1] - half(*range);
            let found = places(&part);
            for post in whole.iter().filter(within) {
                assert!(found.iter().any(|other| (other[1] - post[1]).abs() < 1e-4), "{post:?} {found:?}");
                inside += 1;
            }
            assert!(found.iter().all(|post| whole.iter().any(|other| (other[1] - post[1]).abs() < 1e-4)));
            cut += part.cut;
        }
    }
    assert!(inside > 1000 && cut > 1000);
}

/// On a vehicle that drives on an arc, posts are moved to their positions at the end of the scan.
#[test]
fn the_motion_during_a_scan_is_compensated() {
    let (speed, rate) = (2.0, 0.5);
    let pose =
        |time: f64| [speed / rate * (rate * time).sin(), speed / rate * (1.0 - (rate * time).cos()), rate * time];
    let (mut errors, mut blurred, mut count) = (0.0_f64, 0.0_f64, 0.0);
    for seed in 0..20 {
        let (world, _) = yard(seed);
        let ranges = world::scan(&world, &mut Draws::seeded(seed), &ROUND, BEAMS, 0.0, pose);
        let [x, y, heading] = pose(f64::from(ROUND.duration_s));
        for post in &find(ROUND, &ranges).posts {
            let off = |[range, bearing]: [f32; 2]| {
                let direction = heading + f64::from(bearing);
                let [px, py] = [x + f64::from(range) * direction.cos(), y + f64::from(range) * direction.sin()];
                world.posts.iter().map(|post| (post[0] - px).hypot(post[1] - py)).fold(f64::INFINITY, f64::min)
            };
            errors += off(post.at_end(speed as f32, rate as f32)).powi(2);
            blurred += off([post.range_m, post.bearing_rad]).powi(2);
            count += 1.0;
        }
    }
    let [errors, blurred] = [errors, blurred].map(|squares: f64| (squares / count).sqrt());
    assert!(count > 100.0 && errors < 0.03 && blurred > 0.1, "{errors} {blurred} {count}");
}

/// A revolution of an LD06 and the same ranges as a laser scan give the same posts.
#[test]
fn an_ld06_is_one_source_of_scans() {
    let mut draws = Draws::seeded(3);
    let world = World::random(&mut draws, 15, 0.1, |[x, y]| x.hypot(y) > 0.7);
    let (mut lidar, mut assembler) = (Lidar::started(draws), Assembler::<1024>::new());
    let mut revolutions = 0;
    while lidar.time_s < 2.0 {
        let Some(revolution) = assembler.push(&lidar.packet(&world, |_| [0.0; 3])) else { continue };
        let beams = || (0..revolution.beams()).map(|number| revolution.beam(number).unwrap());
        let ranges: Vec<f32> = beams().map(|beam| beam.range_m).collect();
        let intensities: Vec<f32> = beams().map(|beam| beam.intensity).collect();
        let sweep = Sweep {
            start_rad: beams().next().unwrap().bearing_rad,
            increment_rad: revolution.step_rad(),
            duration_s: revolution.before_end_s(0),
            ..ROUND
        };
        let finder = PostFinder::new(PostSettings::of_radius(0.1)).unwrap();
        let from_bytes = finder.find::<32, _>(revolution);
        let from_ranges = finder.find::<32, _>(&LaserScan::new(sweep, &ranges, &intensities).unwrap());
        // The laser scan has no ends at the seam.
        assert!(from_bytes.posts.len() > 5 && from_ranges.posts.len() >= from_bytes.posts.len());
        for post in &from_bytes.posts {
            // Angles of an LD06 are multiples of a hundredth of a degree, and the speed of its motor varies by a percent.
            let same = |other: &&scphd_lidar::Post| {
                (post.range_m - other.range_m).abs() < 5e-3 && (post.bearing_rad - other.bearing_rad).abs() < 0.02
            };
            let other = from_ranges.posts.iter().find(same).expect("the same post");
            assert_eq!((post.points, post.intensity), (other.points, other.intensity));
            assert!((post.before_end_s - other.before_end_s).abs() < 1e-3);
        }
        revolutions += 1;
    }
    assert!(revolutions > 15);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// For any ranges and any geometry, the posts are within the limits.
    #[test]
    fn nothing_panics(
        ranges in prop::collection::vec(prop_oneof![4 => 0.9..1.1_f32, 2 => 0.0..20.0_f32, 1 => any::<f32>()], 0..80),
        start_rad in -10.0..10.0_f32,
        increment_rad in prop_oneof![-1.0..1.0_f32, Just(TAU / 79.0), Just(-TAU / 40.0), Just(f32::MIN_POSITIVE)],
        range_max_m in prop_oneof![1.0..30.0_f32, Just(f32::INFINITY)],
        duration_s in -1.0..1.0_f32,
        radius in 1e-3..2.0_f32,
        min_intensity in 0.0..2.0_f32,
    ) {
        let sweep = Sweep { start_rad, increment_rad, range_min_m: 0.05, range_max_m, duration_s };
        prop_assume!(increment_rad != 0.0);
        let finder = PostFinder::new(PostSettings { min_intensity, ..PostSettings::of_radius(radius) }).unwrap();
        for intensities in [&[][..], &ranges] {
            let scan = LaserScan::new(sweep, &ranges, intensities).unwrap();
            for post in finder.find::<4, _>(&scan).posts {
                prop_assert!(post.range_m.is_finite() && post.bearing_rad.abs() < PI + 1e-3);
                prop_assert!((0.0..=1.0).contains(&post.before_end_s) && usize::from(post.points) <= ranges.len());
                prop_assert!(post.at_end(3.0, 1.0).iter().all(|x| x.is_finite()));
            }
        }
    }
}
