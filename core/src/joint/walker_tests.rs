//! A person who walks among landmarks: the effect on a joint map, and the moving-object tracks in every operation of the filter.

use super::course::{self, Course, motion};
use super::movers::{Mover, Movers};
use crate::tests::alone::Lidar;
use crate::*;
use nalgebra::{Vector2, Vector4};
use std::boxed::Box;
use std::vec::Vec;

type Pose64 = PlanarPose<f64>;
type Moved<'s, M> = JointSlam<'s, M, Vector2<f64>, NoArchive, Tracked<'s, Pose64>>;
fn lidar(of_moving: f64) -> Detector<Lidar<f64>> {
    course::lidar(1.0, Births { of_static: 1e-3, of_moving })
}

const ROOM: usize = 48;
type Car = JointState<Pose64, Vector2<f64>, ROOM, { joint_numbers(3, 2, ROOM) }, 32>;

/// Number of scans after which the tracks are scored.
const SETTLED: usize = 50;

#[derive(Debug, Default)]
struct Score {
    /// Scans with an estimated track within half a metre of the walker; `scans` is the number of scored scans.
    found: usize,
    scans: usize,
    /// Estimated tracks at other positions.
    wrong: usize,
    /// Number of features of the estimated map beyond the twelve landmarks, at the end.
    ghosts: usize,
    /// Greatest distance of a landmark from the nearest estimated feature, m.
    off_m: f64,
    /// Root mean square error of the pose, m.
    pose_m: f64,
}

fn drive(seed: u64, walks: bool, of_moving: f64) -> Score {
    let (mut state, mut movers) = (Box::new(Car::new()), JointMovers::<_, 32>::new());
    let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_movers(&mut movers, MovingConfig::walkers()).unwrap();
    let mut place = Course::new(seed, walks, 1);
    slam.reset(place.pose).unwrap();
    let (mut score, mut squares, scans) = (Score::default(), 0.0, 480);
    for scan in 0..scans {
        let (odometry, seen) = place.step(|_| false);
        slam.predict(&odometry, 0.1).unwrap();
        slam.scan(&lidar(of_moving), &seen).unwrap();
        squares += slam.estimate_pose().unwrap().mean.distance_m(&place.pose).powi(2);
        if scan < SETTLED {
            continue;
        }
        let near =
            |mover: &Component<Vector4<f64>>| walks && (mover.position::<Vector2<f64>>() - place.walker()).norm() < 0.5;
        score.found += usize::from(slam.moving().any(|mover| near(&mover)));
        score.wrong += slam.moving().filter(|mover| !near(mover)).count();
        score.scans += 1;
    }
    assert_eq!(slam.audit(), Ok(()));
    score.pose_m = (squares / f64::from(scans as u32)).sqrt();
    score.ghosts = slam.features().count().saturating_sub(12);
    score.off_m = (0..12).fold(0.0, |most: f64, k| {
        let distances = slam.features().map(|feature| (feature.mean - Course::landmark(k)).norm());
        most.max(distances.fold(f64::INFINITY, f64::min))
    });
    score
}

#[test]
fn a_walker_is_tracked_and_landmarks_stay_in_the_map() {
    let (mut found, mut scans, mut wrong, mut ghosts) = (0, 0, 0, 0);
    for seed in 0..6 {
        let score = drive(seed, true, 5e-4);
        // The walker passes over two landmarks and back, twice.
        assert!(score.off_m < 0.25 && score.pose_m < 0.15, "{seed}: {score:?}");
        (found, scans, wrong) = (found + score.found, scans + score.scans, wrong + score.wrong);
        ghosts += score.ghosts;
    }
    assert!(found * 10 > scans * 8, "{found} of {scans}");
    // A landmark may be taken for a slow object at first.
    assert!(wrong * 5 < scans, "{wrong} of {scans}");
    assert!(ghosts <= 1, "{ghosts}");
    // Without births of tracks, the path of the walker remains in the map, or the landmarks on it are displaced.
    let ghosts: usize = (0..6).map(|seed| drive(seed, true, 0.0).ghosts).sum();
    assert!(ghosts >= 2, "{ghosts}: this shows nothing");
}

#[test]
fn tracks_do_not_degrade_a_static_map() {
    let (mut wrong, mut scans, mut poses) = (0, 0, [0.0; 2]);
    for seed in 10..18 {
        let (with, without) = (drive(seed, false, 5e-4), drive(seed, false, 0.0));
        assert_eq!((with.ghosts, without.ghosts), (0, 0), "{seed}");
        assert!((with.off_m - without.off_m).abs() < 0.05, "{seed}: {with:?} {without:?}");
        (wrong, scans) = (wrong + with.wrong, scans + with.scans);
        poses = [poses[0] + with.pose_m, poses[1] + without.pose_m];
    }
    // Some of the twelve landmarks may be taken for slow objects at first.
    assert!(wrong * 5 < scans, "{wrong} of {scans}");
    assert!(poses[0] < 1.05 * poses[1], "{poses:?}");
}

/// Without births of tracks, the filter with tracks gives the same bits as the filter without.
#[test]
fn without_births_of_tracks_the_result_is_the_same() {
    let (mut state, mut alone, mut movers) = (Box::new(Car::new()), Box::new(Car::new()), JointMovers::<_, 8>::new());
    let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_movers(&mut movers, MovingConfig::walkers()).unwrap();
    let mut alone = JointSlam::new(motion(), JointConfig::default(), &mut *alone).unwrap();
    let mut place = Course::new(3, true, 1);
    slam.reset(place.pose).unwrap();
    alone.reset(place.pose).unwrap();
    for _ in 0..100 {
        let (odometry, seen) = place.step(|_| false);
        slam.predict(&odometry, 0.1).unwrap();
        alone.predict(&odometry, 0.1).unwrap();
        let (a, b) = (slam.scan(&lidar(0.0), &seen).unwrap(), alone.scan(&lidar(0.0), &seen).unwrap());
        assert_eq!(a, b);
        assert_eq!(slam.estimate_pose(), alone.estimate_pose());
    }
}

fn with_a_walker<R>(work: impl FnOnce(&mut Moved<'_, Unicycle<f64>>, &mut Course) -> R) -> R {
    let (mut state, mut movers) = (Box::new(Car::new()), JointMovers::<_, 32>::new());
    let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_movers(&mut movers, MovingConfig::walkers()).unwrap();
    let mut place = Course::new(1, true, 1);
    slam.reset(place.pose).unwrap();
    for _ in 0..60 {
        go(&mut slam, &mut place);
    }
    assert_eq!(slam.moving().count(), 1);
    work(&mut slam, &mut place)
}

fn go(slam: &mut Moved<'_, Unicycle<f64>>, place: &mut Course) {
    let (odometry, seen) = place.step(|_| false);
    slam.predict(&odometry, 0.1).unwrap();
    slam.scan(&lidar(5e-4), &seen).unwrap();
}

#[test]
fn a_snapshot_contains_the_tracks_and_the_filter_continues_with_the_same_bits() {
    with_a_walker(|slam, place| {
        slam.predict(&UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 }, 0.05).unwrap();
        let mut bytes = std::vec![0; 40_000];
        let len = slam.save(7, into_slice(&mut bytes)).unwrap();
        let bytes = &bytes[..len];
        let (mut state, mut movers) = (Box::new(Car::new()), JointMovers::<_, 16>::new());
        let other = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
        let mut other = other.with_movers(&mut movers, MovingConfig::walkers()).unwrap();
        assert_eq!(other.restore(7, from_slice(bytes)), Ok(len));
        assert_eq!((other.digest(), other.seal()), (slam.digest(), slam.seal()));
        for _ in 0..40 {
            let (odometry, seen) = place.step(|_| false);
            slam.predict(&odometry, 0.1).unwrap();
            other.predict(&odometry, 0.1).unwrap();
            assert_eq!(slam.scan(&lidar(5e-4), &seen), other.scan(&lidar(5e-4), &seen));
            assert_eq!(other.digest(), slam.digest());
        }
        // A filter without tracks refuses it, and is unchanged.
        let mut state = Box::new(Car::new());
        let mut without = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
        without.reset(PlanarPose::ZERO).unwrap();
        let digest = without.digest();
        let refused = without.restore(7, from_slice(bytes));
        assert!(matches!(refused, Err(RestoreError::NoRoom { what: "movers", .. })), "{refused:?}");
        assert_eq!(without.digest(), digest);
        let mut plain = std::vec![0; 40_000];
        let len = without.save(7, into_slice(&mut plain)).unwrap();
        // A snapshot without tracks removes those of the filter.
        assert_eq!(other.restore(7, from_slice(&plain[..len])), Ok(len));
        assert_eq!((other.moving().count(), other.movers.kept().len()), (0, 0));
    });
}

#[test]
fn reset_relocate_and_load_map_remove_tracks_and_scatter_adds_process_noise() {
    let few = Symmetric::from_diagonal([0.01; 3]);
    with_a_walker(|slam, _| {
        let before = slam.moving().next();
        slam.scatter(&few).unwrap();
        assert_eq!(slam.moving().next(), before);
        let (common, _) = slam.movers.common().unwrap();
        assert!(common.process_noise.get(0, 0) >= 0.01);
        slam.relocate(PlanarPose::ZERO, &few).unwrap();
        assert_eq!(slam.movers.kept().len(), 0);
    });
    with_a_walker(|slam, place| {
        slam.reset(place.pose).unwrap();
        assert_eq!(slam.movers.kept().len(), 0);
    });
    with_a_walker(|slam, _| {
        let map: Vec<_> = slam.features().collect();
        slam.load_map(&map).unwrap();
        assert_eq!(slam.movers.kept().len(), 0);
    });
}

#[test]
fn localise_updates_tracks_and_leaves_the_map_unchanged() {
    with_a_walker(|slam, place| {
        let map: Vec<_> = slam.features().collect();
        slam.load_map(&map).unwrap();
        let (mut found, scans) = (0, 60);
        for scan in 0..scans + 10 {
            let (odometry, seen) = place.step(|_| false);
            slam.predict(&odometry, 0.1).unwrap();
            slam.localise(&lidar(5e-4), &seen).unwrap();
            let near =
                |mover: Component<Vector4<f64>>| (mover.position::<Vector2<f64>>() - place.walker()).norm() < 0.5;
            found += usize::from(scan >= 10 && slam.moving().any(near));
        }
        assert!(found * 10 > scans * 8, "{found}");
        let after: Vec<_> = slam.features().map(|feature| (feature.label, feature.mean)).collect();
        assert_eq!(after, map.iter().map(|feature| (feature.label, feature.mean)).collect::<Vec<_>>());
    });
}

#[test]
fn damaged_tracks_are_repaired() {
    let damages: [fn(&mut Mover<Pose64>); 4] = [
        |mover| mover.component.mean.x = f64::NAN,
        |mover| mover.component.ln_weight = 3.0,
        |mover| mover.component.ln_weight = f64::NEG_INFINITY,
        |mover| mover.component.covariance = Symmetric::ZERO,
    ];
    for damage in damages {
        with_a_walker(|slam, place| {
            let (held, all) = (slam.movers.kept().len(), 1 + slam.held() + slam.movers.kept().len());
            assert!(slam.scrub(&mut Scrubber::new(), all).unwrap().is_clean());
            damage(&mut slam.movers.tracks().unwrap().kept_mut()[0]);
            assert!(slam.audit().is_err());
            let found = slam.scrub(&mut Scrubber::new(), all).unwrap();
            assert_eq!((found.features, slam.movers.kept().len()), (1, held - 1));
            assert_eq!(slam.audit(), Ok(()));
            go(slam, place);
        });
    }
    with_a_walker(|slam, place| {
        slam.movers.tracks().unwrap().common.process_noise = Symmetric::from_diagonal([f64::NAN; 3]);
        assert_eq!(slam.audit(), Err(Flaw::Pose));
        assert!(slam.scrub(&mut Scrubber::new(), 1).unwrap().widened);
        assert_eq!(slam.audit(), Ok(()));
        slam.movers.tracks().unwrap().common.len = 99;
        assert_eq!(slam.scrub(&mut Scrubber::new(), 1), Err(Flaw::Cursor));
        // A scan limits an invalid number of tracks to the capacity.
        go(slam, place);
        assert!(slam.movers.kept().len() <= 32);
    });
}

#[test]
fn tracks_without_room_are_reported_as_lost() {
    let (mut state, mut movers) = (Box::new(Car::new()), JointMovers::<_, 2>::new());
    let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_movers(&mut movers, MovingConfig::walkers()).unwrap();
    slam.reset(PlanarPose::ZERO).unwrap();
    let scan: Vec<_> = (0..6).map(|k| Vector2::new(3.0 + f64::from(k), 0.5 * f64::from(k))).collect();
    let report = slam.scan(&lidar(5e-4), &scan).unwrap();
    assert!(report.movers == 2 && report.lost == 4 && report.health.contains(Health::COMPONENTS_LOST), "{report:?}");
}
