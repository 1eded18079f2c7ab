//! Memory faults under a joint map: detected damage is repaired, and valid data is unchanged.

use super::archive::{Entry, Split};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec::Vec;

const ROOM: usize = 24;
type Memory = JointState<PlanarPose<f32>, Vector2<f32>, ROOM, { joint_numbers(3, 2, ROOM) }, 16>;
type Slam<'s> = JointSlam<'s, Unicycle<f32>, Vector2<f32>>;

fn slam(state: &mut Memory) -> Slam<'_> {
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05)).unwrap();
    let mut slam = JointSlam::new(motion, JointConfig::default(), state).unwrap();
    slam.reset(PlanarPose::ZERO).unwrap();
    slam
}

fn drive(slam: &mut Slam<'_>, draws: &mut Noise, scans: usize) {
    let window = RangeBearingWindow::full_circle(20.0, 0.9).unwrap();
    let sensing = Sensing::range_bearing([0.1, 0.01], window, 0.5).unwrap();
    let eyes = Detector::new(sensing, Births::of_static(1e-3)).unwrap();
    for _ in 0..scans {
        slam.predict(&UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 }, 0.1).unwrap();
        let seen: Vec<_> = (0..10)
            .map(|k| {
                let noise = [0.1 * draws.normal::<f32>(), 0.01 * draws.normal::<f32>()];
                Vector2::new(4.0 + 1.4 * k as f32 + noise[0], wrap(0.6 * k as f32 + noise[1]))
            })
            .collect();
        slam.scan(&eyes, &seen).unwrap();
    }
}

#[test]
fn what_is_sound_is_left_to_the_bit_and_all_of_it_is_looked_at() {
    let mut states = [(); 2].map(|()| Box::new(Memory::new()));
    let [mut scrubbed, mut left] = states.each_mut().map(|state| slam(state));
    assert_eq!(
        slam(&mut Memory::new()).scrub(&mut Scrubber::new(), 9),
        Ok(Scrubbed { round: true, ..Scrubbed::default() })
    );
    let (mut scrubber, mut draws, mut rounds) = (Scrubber::new(), [1, 1].map(Noise::seeded), 0);
    for scan in 0..60 {
        let found = scrubbed.scrub(&mut scrubber, 1 + scan % 7).unwrap();
        assert!(found.is_clean() && found.health().is_good(), "{scan}: {found:?}");
        rounds += usize::from(found.round);
        drive(&mut scrubbed, &mut draws[0], 1);
        drive(&mut left, &mut draws[1], 1);
        assert_eq!((scrubbed.digest(), scrubbed.seal()), (left.digest(), left.seal()));
    }
    // A pose and ten features, at four parts a scan.
    assert!((15..=60).contains(&rounds), "{rounds}");
}

/// Damages the state, repairs it in one round of scrubbing, and continues the filter. Returns the result of scrubbing,
/// and the error of the position, m.
fn mended(damage: impl Fn(&mut Slam<'_>)) -> (Scrubbed, f32) {
    let mut state = Box::new(Memory::new());
    let (mut slam, mut draws) = (slam(&mut state), Noise::seeded(2));
    drive(&mut slam, &mut draws, 30);
    assert_eq!(slam.memory.header.len, 10);
    let seal = slam.seal();
    damage(&mut slam);
    let scrubbed = slam.scrub(&mut Scrubber::new(), 1 + ROOM).unwrap();
    assert!(slam.scrub(&mut Scrubber::new(), 1 + ROOM).unwrap().is_clean());
    assert!(scrubbed.is_clean() || scrubbed.health() == Health::STATE_REPAIRED);
    drive(&mut slam, &mut draws, 20);
    assert!(slam.scrub(&mut Scrubber::new(), 1 + ROOM).unwrap().is_clean());
    assert_ne!(slam.seal(), seal);
    let pose = slam.estimate_pose().unwrap().mean;
    (scrubbed, pose.x_m.hypot(pose.y_m))
}

#[test]
fn an_invalid_feature_is_dropped_and_the_others_stay() {
    let damages: [fn(&mut Slam<'_>); 6] = [
        |slam| slam.memory.landmarks[3].mean.x = f32::NAN,
        |slam| slam.memory.landmarks[3].existence.visible = 2.0,
        |slam| slam.memory.landmarks[3].existence.visible = 0.5,
        |slam| slam.memory.joint.set(9, 9, -1.0),
        // A variance that is far too small violates the bound with all features, a covariance with one.
        |slam| slam.memory.joint.set(9, 9, 1e-12),
        |slam| slam.memory.joint.set(9, 5, 1e20),
    ];
    for damage in damages {
        let (scrubbed, off_m) = mended(damage);
        assert_eq!((scrubbed.features, scrubbed.widened), (1, false));
        assert!(off_m < 0.3, "{off_m}");
    }
}

#[test]
fn an_invalid_covariance_of_the_pose_is_increased() {
    let damages: [fn(&mut Slam<'_>); 3] = [
        |slam| slam.memory.joint.set(2, 2, 1e-12),
        |slam| slam.memory.joint.set(2, 2, f32::NAN),
        |slam| slam.memory.joint.set(1, 0, 1e3),
    ];
    for damage in damages {
        let (scrubbed, off_m) = mended(damage);
        assert_eq!((scrubbed.features, scrubbed.widened), (0, true));
        assert!(off_m < 0.3, "{off_m}");
    }
}

#[test]
fn irreparable_damage_is_an_error_and_valid_numbers_change_the_seal() {
    type Damage = fn(&mut Slam<'_>);
    let damages: [(Damage, Flaw); 4] = [
        (|slam| slam.memory.header.len = usize::MAX, Flaw::Cursor),
        (|slam| slam.memory.header.waited_s = -1.0, Flaw::Cursor),
        (|slam| slam.memory.header.pose.x_m = 1e30, Flaw::Pose),
        (|slam| slam.memory.header.moved[0] = f32::NAN, Flaw::Pose),
    ];
    for (damage, flaw) in damages {
        let mut state = Box::new(Memory::new());
        let (mut slam, mut draws) = (slam(&mut state), Noise::seeded(2));
        drive(&mut slam, &mut draws, 3);
        damage(&mut slam);
        assert_eq!(slam.scrub(&mut Scrubber::new(), 3), Err(flaw));
    }
    let might_be: [Damage; 4] = [
        |slam| slam.memory.header.len -= 1,
        |slam| slam.memory.header.next_label ^= 1 << 20,
        |slam| slam.memory.header.watch.lost ^= true,
        |slam| slam.memory.header.pose.x_m += 1.0,
    ];
    for damage in might_be {
        let mut state = Box::new(Memory::new());
        let (mut slam, mut draws) = (slam(&mut state), Noise::seeded(2));
        drive(&mut slam, &mut draws, 3);
        let seal = slam.seal();
        damage(&mut slam);
        assert_ne!(slam.seal(), seal);
    }
}

/// A number of features above the capacity: every step ends, and uses the capacity.
#[test]
fn a_count_that_cannot_be_is_clamped_by_every_step() {
    let mut state = Box::new(Memory::new());
    let (mut slam, mut draws) = (slam(&mut state), Noise::seeded(2));
    for bit in [8, 31, 62, 63] {
        drive(&mut slam, &mut draws, 3);
        slam.memory.header.len ^= 1 << bit;
        drive(&mut slam, &mut draws, 1);
        assert!(slam.memory.header.len <= ROOM);
        slam.memory.header.len ^= 1 << bit;
        slam.scatter(&Symmetric::from_diagonal([0.01; 3])).unwrap();
        slam.reset(PlanarPose::ZERO).unwrap();
    }
}

#[test]
fn the_archive_is_scrubbed_too() {
    let mut state = Box::new(Memory::new());
    let mut archive = Box::new(JointArchive::<PlanarPose<f32>, 8>::new());
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05)).unwrap();
    let slam = Slam::new(motion, JointConfig::default(), &mut state).unwrap();
    let mut slam = slam.with_archive(&mut archive, 20.0).unwrap();
    slam.reset(PlanarPose::ZERO).unwrap();
    let known = Split { own: Symmetric::from_diagonal([0.01; 2]), ..Split::ZERO };
    let entry = |x: f32| Entry { mean: Vector2::new(x, 0.0), alone: known, given: known, ..Entry::ZERO };
    let mut view = Archive::view(&mut slam.archive).unwrap();
    [100.0, f32::NAN, 200.0].into_iter().for_each(|x| _ = view.put(entry(x)));
    let scrubbed = slam.scrub(&mut Scrubber::new(), 4).unwrap();
    assert_eq!((scrubbed.features, slam.held()), (1, 2));
    let view = Archive::view(&mut slam.archive).unwrap();
    view.index.len = 9;
    assert_eq!(slam.scrub(&mut Scrubber::new(), 4), Err(Flaw::Cursor));
}
