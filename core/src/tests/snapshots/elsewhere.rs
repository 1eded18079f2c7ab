//! Snapshots of the joint map; and neither filter accepts those of the other.

use super::world::{KIND, lidar, motion, saved, start, world};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;

type Joint<T, const FEATURES: usize, const NUMBERS: usize> =
    JointState<PlanarPose<T>, Vector2<T>, FEATURES, NUMBERS, 32>;
type Roomy<T> = Joint<T, 40, { joint_numbers(3, 2, 40) }>;
type Roomier<T> = Joint<T, 55, { joint_numbers(3, 2, 55) }>;

/// Without occlusion, so that there are few features besides the posts and the capacity suffices.
fn config<T: Real>() -> JointConfig<T> {
    JointConfig { persistence: Persistence::FOR_EVER, occlusion_factor: T::ONE, ..JointConfig::default() }
}

fn joint_goes_on<T: Real>() -> usize {
    let dt = T::from_f64(0.1);
    let eyes = Detector::new(lidar::<T>(), Births::of_static(T::from_f64(0.002))).unwrap();
    let (mut first, mut longest) = (Box::new(Roomy::<T>::new()), 0);
    let mut unbroken = JointSlam::new(motion(), config(), &mut *first).unwrap();
    assert_eq!(unbroken.save(KIND, |_| Ok::<(), ()>(())), Err(SaveError::NotStarted));
    unbroken.reset(start()).unwrap();
    for inputs in world::<T>(300).chunks(50) {
        let bytes = saved(|sink| unbroken.save(KIND, sink));
        let n = unbroken.held();
        let scalars = 20 + 8 * n + (3 + 2 * n) * (4 + 2 * n) / 2;
        assert_eq!(bytes.len(), 4 * (17 + n) + size_of::<T>() * scalars, "as docs/snapshot.md has it");
        longest = longest.max(bytes.len());
        let (mut same, mut another) = (Box::new(Roomy::<T>::new()), Box::new(Roomier::<T>::new()));
        let mut broken = [
            JointSlam::new(motion(), config(), &mut *same).unwrap(),
            JointSlam::new(motion(), config(), &mut *another).unwrap(),
        ];
        for broken in &mut broken {
            broken.restore(KIND, from_slice(&bytes)).unwrap();
            assert_eq!(saved(|sink| broken.save(KIND, sink)), bytes);
        }
        for step in inputs {
            unbroken.predict(&step.odometry, dt).unwrap();
            let report = unbroken.scan(&eyes, &step.scan).unwrap();
            for broken in &mut broken {
                broken.predict(&step.odometry, dt).unwrap();
                assert_eq!(broken.scan(&eyes, &step.scan).unwrap(), report);
                assert_eq!(broken.digest(), unbroken.digest());
            }
        }
    }
    longest
}

#[test]
fn a_joint_map_continues_with_the_same_bits() {
    let [single, double] = [joint_goes_on::<f32>(), joint_goes_on::<f64>()];
    std::println!("{single} and {double} bytes");
    assert!([single, double].iter().all(|len| (2048..16 * 1024).contains(len)), "{single} {double}");
}

#[test]
fn a_joint_map_without_room_is_unchanged() {
    type Small = Joint<f32, 2, { joint_numbers(3, 2, 2) }>;
    let eyes = Detector::new(lidar::<f32>(), Births::of_static(0.002)).unwrap();
    let (mut roomy, mut small) = (Box::new(Roomy::<f32>::new()), Box::new(Small::new()));
    let mut large = JointSlam::new(motion(), JointConfig::default(), &mut *roomy).unwrap();
    let mut little = JointSlam::new(motion(), JointConfig::default(), &mut *small).unwrap();
    large.reset(start()).unwrap();
    little.reset(start()).unwrap();
    world::<f32>(3).iter().for_each(|step| assert!(large.scan(&eyes, &step.scan).is_ok()));
    let (before, bytes) = (little.digest(), saved(|sink| large.save(KIND, sink)));
    let needed = large.held();
    assert!(needed > 2);
    let error = RestoreError::NoRoom { what: "features", needed, capacity: 2 };
    assert_eq!(little.restore(KIND, from_slice(&bytes)), Err(error));
    let refused = |bit: usize| {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(large.restore(KIND, from_slice(&damaged)).is_err(), "bit {bit}");
    };
    (0..8 * bytes.len()).for_each(refused);
    assert_eq!((little.digest(), large.audit()), (before, Ok(())));
    // Neither filter accepts a snapshot of the other.
    let mut state = Box::new(State::<PlanarPose<f32>, 4, 4, MapMemory<Static<Vector2<f32>>, 4, 8, 4, 32>>::new());
    let mut mixture = ScPhd::new(motion(), Config::blind(4, 1), &mut *state).unwrap();
    assert_eq!(mixture.restore(KIND, from_slice(&bytes)), Err(RestoreError::Content));
    mixture.reset(start(), 1).unwrap();
    assert_eq!(little.restore(KIND, from_slice(&saved(|sink| mixture.save(KIND, sink)))), Err(RestoreError::Content));
}
