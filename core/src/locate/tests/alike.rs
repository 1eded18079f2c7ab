//! Maps of which one part looks like another.

use super::world::{FEATURES, Map, Slam, World, room, slam};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;

type Memory = LocatorState<f32, FEATURES, 16>;

/// A world with these landmarks, in parts of its extent.
fn with(seed: u64, landmarks: impl Iterator<Item = [f64; 2]>) -> World {
    let mut world = World::of(seed, [4.0, 10.0]);
    let extent = world.extent_m;
    world.landmarks = landmarks.map(|place| place.map(|at| at * extent)).collect();
    world
}

/// The greatest probability of any place in so many scans, and whether one was found.
fn most_likely(world: &World, seed: u64, scans: usize) -> (f32, bool) {
    let sigma = 1e-3 * world.extent_m as f32;
    let surveyed = |&[x, y]: &[f64; 2]| Component {
        mean: Vector2::new(x as f32, y as f32),
        covariance: Symmetric::from_diagonal([sigma * sigma; 2]),
        ..Component::ZERO
    };
    let map: Map = world.landmarks.iter().map(surveyed).collect();
    let mut memory = Box::new(Memory::new());
    let mut locator = Locator::new(LocatorConfig::default(), &mut *memory).unwrap();
    locator.load_map(&map).unwrap();
    let mut room = room();
    let mut slam = slam(world, &mut room);
    slam.reset(PlanarPose::ZERO).unwrap();
    let (mut drive, radar) = (world.drive(seed), world.radar());
    let (mut most, mut found) = (0.0_f32, false);
    for _ in 0..scans {
        drive.scan(&mut slam, Slam::scan);
        let report = locator.update(&radar, &slam.estimate_pose().unwrap(), slam.features());
        most = most.max(report.likeliest.map_or(0.0, |place| place.probability));
        found |= report.found.is_some();
    }
    (most, found)
}

/// With any number of scans, because a square grid is the same after every quarter of a turn.
#[test]
fn in_a_grid_of_posts_it_is_never_sure() {
    for seed in 0..10 {
        let grid = (0..25).map(|k| [0.1 + 0.2 * f64::from(k % 5), 0.1 + 0.2 * f64::from(k / 5)]);
        let (most, found) = most_likely(&with(seed, grid), seed, 100);
        assert!(!found && most < 0.9, "seed {seed}: {most}");
    }
}

/// Two halves that are the same.
#[test]
fn of_two_places_that_are_alike_neither_is_sure() {
    for seed in 0..10 {
        let half: [[f64; 2]; 9] = [
            [0.05, 0.1],
            [0.2, 0.35],
            [0.42, 0.08],
            [0.31, 0.55],
            [0.1, 0.62],
            [0.45, 0.8],
            [0.22, 0.9],
            [0.07, 0.85],
            [0.38, 0.3],
        ];
        // The other half is this one, turned about the middle of the world.
        let landmarks = half.into_iter().flat_map(|[x, y]| [[x, y], [1.0 - x, 1.0 - y]]);
        let (most, found) = most_likely(&with(seed, landmarks), seed, 100);
        assert!(!found && most < 0.9, "seed {seed}: {most}");
    }
}
