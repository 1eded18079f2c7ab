//! Snapshots with correct checksums that no filter has written: none breaks an invariant or causes a panic.

use super::damaged::{Memory, config, worked};
use super::world::{KIND, Scratch, detector, lidar, motion, saved, start, world};
use crate::snapshot::frame;
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec::Vec;

/// Corrects the checksums.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let words: [[u8; 4]; frame::WORDS] = core::array::from_fn(|word| bytes[4 * word..4 * word + 4].try_into().unwrap());
    bytes[4 * frame::WORDS..frame::HEAD].copy_from_slice(&frame::Head::check(&words));
    let mut check = frame::check();
    check.update(words.as_flattened());
    let end = bytes.len() - 4;
    check.update(&bytes[frame::HEAD..end]);
    bytes[end..].copy_from_slice(&check.finalize().to_le_bytes());
    bytes
}

/// Values that replace a word.
fn replacements(word: u32) -> impl Iterator<Item = u32> {
    let strange = [
        0,
        1,
        2,
        3,
        7,
        8,
        9,
        0xffff,
        1 << 31,
        1 << 31 | 8,
        1 << 31 | 9,
        u32::MAX,
        0x7fc0_0000,
        0x7f80_0000,
        0xff80_0000,
    ];
    let large = [1e30_f32, -1e30, 1e9, -1.0, 0.0, -0.0, 1e-38].map(f32::to_bits);
    let near = [word.wrapping_add(1), word.wrapping_sub(1), word ^ 1 << 31, word ^ 1 << 30, word ^ 1 << 16];
    strange.into_iter().chain(large).chain(near).filter(move |&other| other != word)
}

/// Replaces every word of a snapshot, one at a time. Returns the number of snapshots that were restored, and of all.
fn replace_all(bytes: &[u8], mut restores: impl FnMut(&[u8]) -> bool) -> [usize; 2] {
    assert_eq!(sealed(bytes.to_vec()), bytes);
    let mut counts = [0; 2];
    for at in (0..bytes.len() - 4).step_by(4).filter(|at| *at != 4 * frame::WORDS) {
        let word = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        for other in replacements(word) {
            let mut crafted = bytes.to_vec();
            crafted[at..at + 4].copy_from_slice(&other.to_le_bytes());
            counts[0] += usize::from(restores(&sealed(crafted)));
            counts[1] += 1;
        }
    }
    counts
}

#[test]
fn no_word_of_a_mixture_does_harm() {
    let mut state = Box::new(Memory::new());
    let mut slam = worked(&mut state);
    let bytes = saved(|sink| slam.save(KIND, sink));
    let (mut scratch, steps) = (Scratch::new(), world::<f32>(3));
    let mut eyes = detector(&mut scratch, false);
    let [taken, all] = replace_all(&bytes, |crafted| {
        let mut state = Box::new(Memory::new());
        let mut slam = ScPhd::new(motion(), config(), &mut *state).unwrap();
        if slam.restore(KIND, from_slice(crafted)).is_err() {
            assert_eq!((slam.particles(), slam.audit()), (0, Ok(())));
            return false;
        }
        assert_eq!(slam.audit(), Ok(()));
        for step in &steps {
            let _ = slam.predict(&step.odometry, 0.1);
            slam.scan(&mut eyes, &step.scan).unwrap();
        }
        assert_eq!(slam.audit(), Ok(()));
        true
    });
    assert!(taken > 0 && 4 * taken < 3 * all, "{taken} of {all}");
}

#[test]
fn no_word_of_an_informed_filter_with_movers_does_harm() {
    type Movers = State<
        PlanarPose<f32>,
        2,
        4,
        MapMemory<Static<Vector2<f32>>, 2, 6, 3, 24>,
        MapMemory<Dynamic<Vector2<f32>>, 2, 6, 3, 24>,
    >;
    let fresh = || Box::new(Movers::new());
    let config = Config { samples: 2, ..Config::informed(2) };
    let (mut scratch, steps) = (Scratch::new(), world::<f32>(3));
    let mut eyes = detector(&mut scratch, true);
    let mut state = fresh();
    let mut slam = ScPhd::new(motion(), config, &mut *state).unwrap();
    slam.reset(start(), 3).unwrap();
    for step in &steps {
        slam.scan(&mut eyes, &step.scan[..3]).unwrap();
        slam.predict(&step.odometry, 0.1).unwrap();
    }
    let bytes = saved(|sink| slam.save(KIND, sink));
    let [taken, all] = replace_all(&bytes, |crafted| {
        let mut state = fresh();
        let mut slam = ScPhd::new(motion(), config, &mut *state).unwrap();
        let taken = slam.restore(KIND, from_slice(crafted)).is_ok();
        assert_eq!((slam.audit(), slam.particles()), (Ok(()), if taken { 2 } else { 0 }));
        for step in steps.iter().filter(|_| taken) {
            slam.scan(&mut eyes, &step.scan).unwrap();
            let _ = slam.predict(&step.odometry, 0.1);
        }
        taken
    });
    assert!(taken > 0 && taken < all, "{taken} of {all}");
}

#[test]
fn no_word_of_a_joint_map_does_harm() {
    type Joint = JointState<PlanarPose<f32>, Vector2<f32>, 5, { joint_numbers(3, 2, 5) }, 32>;
    let eyes = Detector::new(lidar::<f32>(), Births::of_static(0.002)).unwrap();
    let steps = world::<f32>(3);
    let mut state = Box::new(Joint::new());
    let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    slam.reset(start()).unwrap();
    for step in &steps {
        slam.scan(&eyes, &step.scan[..3]).unwrap();
        slam.predict(&step.odometry, 0.1).unwrap();
    }
    let bytes = saved(|sink| slam.save(KIND, sink));
    let [taken, all] = replace_all(&bytes, |crafted| {
        let mut state = Box::new(Joint::new());
        let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
        let taken = slam.restore(KIND, from_slice(crafted)).is_ok();
        assert_eq!((slam.audit(), slam.estimate_pose().is_some()), (Ok(()), taken));
        for step in steps.iter().filter(|_| taken) {
            slam.scan(&eyes, &step.scan).unwrap();
            let _ = slam.predict(&step.odometry, 0.1);
        }
        taken
    });
    assert!(taken > 0 && taken < all, "{taken} of {all}");
}
