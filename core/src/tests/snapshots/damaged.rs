//! Everything that is not a complete snapshot of this filter is refused, and the state is unchanged.

use super::world::{KIND, Scratch, detector, motion, saved, start, world};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::string::ToString;
use std::vec::Vec;

pub(super) type Small<const N: usize, const PAGES: usize, const MAP: usize> =
    State<PlanarPose<f32>, N, N, MapMemory<Static<Vector2<f32>>, N, PAGES, MAP, 24>>;
pub(super) type Memory = Small<3, 8, 2>;
pub(super) type Slam<'s> = ScPhd<'s, Unicycle<f32>>;

pub(super) fn config() -> Config<f32> {
    Config::blind(3, 1)
}

/// A filter after two scans with a few measurements.
pub(super) fn worked(state: &mut Memory) -> Slam<'_> {
    let mut scratch = Scratch::new();
    let mut eyes = detector(&mut scratch, false);
    let mut slam = ScPhd::new(motion(), config(), state).unwrap();
    slam.reset(start(), 5).unwrap();
    for step in world::<f32>(2) {
        slam.predict(&step.odometry, 0.1).unwrap();
        slam.scan(&mut eyes, &step.scan[..4]).unwrap();
    }
    slam
}

/// A filter with another state.
fn held(state: &mut Memory) -> (Slam<'_>, u64) {
    let mut slam = ScPhd::new(motion(), config(), state).unwrap();
    slam.reset(PlanarPose::new(-4.0, 2.0, 0.0), 9).unwrap();
    slam.load_map(&[Component { covariance: Symmetric::from_diagonal([1.0; 2]), ..Component::ZERO }]).unwrap();
    let digest = slam.digest();
    (slam, digest)
}

fn snapshot() -> Vec<u8> {
    let mut state = Box::new(Memory::new());
    let mut slam = worked(&mut state);
    saved(|sink| slam.save(KIND, sink))
}

#[test]
fn every_bit_that_changes_and_every_end_that_is_missing_is_noticed() {
    let bytes = snapshot();
    assert!((200..2000).contains(&bytes.len()), "{}", bytes.len());
    let mut state = Box::new(Memory::new());
    let (mut slam, digest) = held(&mut state);
    let mut refused = |bytes: &[u8]| {
        let error = slam.restore(KIND, from_slice(bytes)).unwrap_err();
        assert_eq!((slam.digest(), slam.audit()), (digest, Ok(())), "{error}");
        error
    };
    for bit in 0..8 * bytes.len() {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let error = refused(&damaged);
        assert_eq!(error, if bit < 32 { RestoreError::Foreign } else { RestoreError::Damaged }, "bit {bit}");
    }
    for len in 0..bytes.len() {
        assert_eq!(refused(&bytes[..len]), RestoreError::Source(SliceEnd), "{len} bytes");
    }
    // Two words are swapped.
    for word in 0..bytes.len() / 4 - 1 {
        let mut swapped = bytes.clone();
        let (first, second) = swapped.split_at_mut(4 * word + 4);
        first[4 * word..].swap_with_slice(&mut second[..4]);
        assert!(swapped == bytes || matches!(refused(&swapped), RestoreError::Damaged | RestoreError::Foreign));
    }
    // Bytes behind the snapshot are ignored.
    let longer = [bytes.clone(), std::vec![0xff; 9]].concat();
    assert_eq!(slam.restore(KIND, from_slice(&longer)), Ok(bytes.len()));
    assert_ne!(slam.digest(), digest);
}

#[test]
fn other_vehicles_and_capacities_are_refused_with_the_reason() {
    let bytes = snapshot();
    let mut state = Box::new(Memory::new());
    let (mut slam, digest) = held(&mut state);
    assert_eq!(slam.restore(KIND + 1, from_slice(&bytes)), Err(RestoreError::Kind { found: KIND }));
    assert_eq!(slam.digest(), digest);
    // Another scalar; the same applies to another pose.
    type Double = State<PlanarPose<f64>, 3, 3, MapMemory<Static<Vector2<f64>>, 3, 8, 2, 24>>;
    let mut state = Box::new(Double::new());
    let mut double = ScPhd::new(motion::<f64>(), Config::blind(3, 1), &mut *state).unwrap();
    assert_eq!(double.restore(KIND, from_slice(&bytes)), Err(RestoreError::Content));
    // Too little memory for the snapshot, but enough for the present state.
    fn told<const N: usize, const PAGES: usize, const MAP: usize>(
        bytes: &[u8],
        config: Config<f32>,
    ) -> std::string::String {
        let mut state = Box::new(Small::<N, PAGES, MAP>::new());
        let mut slam = ScPhd::new(motion(), config, &mut *state).unwrap();
        slam.reset(start(), 1).unwrap();
        let digest = slam.digest();
        let error = slam.restore(KIND, from_slice(bytes)).unwrap_err();
        assert_eq!(slam.digest(), digest);
        error.to_string()
    }
    let particles = told::<2, 8, 2>(&bytes, Config::blind(2, 1));
    assert_eq!(particles, "the snapshot needs 3 particles, but the memory has room for 2");
    let pages = told::<3, 1, 1>(&bytes, config());
    assert!(pages.ends_with("pages, but the memory has room for 1"), "{pages}");
    let bytes = {
        let mut state = Box::new(Memory::new());
        let (mut slam, _) = held(&mut state);
        let component = Component { covariance: Symmetric::from_diagonal([1.0; 2]), ..Component::ZERO };
        slam.load_map(&[component; 9]).unwrap();
        saved(|sink| slam.save(KIND, sink))
    };
    let long = told::<3, 8, 1>(&bytes, config());
    assert_eq!(long, "the snapshot needs 2 pages in a map, but the memory has room for 1");
    let configured = told::<8, 8, 2>(&bytes, Config::blind(8, 1));
    assert!(configured.contains("3 particles, but 8 are configured"), "{configured}");
    // A blind filter does not accept poses with covariances, nor samples instead of particles.
    let mut informed = Box::new(Memory::new());
    let mut informed = ScPhd::new(motion(), Config::informed(3), &mut *informed).unwrap();
    informed.reset(start(), 1).unwrap();
    let bytes = saved(|sink| informed.save(KIND, sink));
    let mut state = Box::new(Memory::new());
    let (mut slam, digest) = held(&mut state);
    assert_eq!(slam.restore(KIND, from_slice(&bytes)), Err(RestoreError::Setup(SetupError::HeldCovariance)));
    assert_eq!(slam.digest(), digest);
}

/// After an error of the sink, and with a damaged state, the filter is unchanged.
#[test]
fn the_state_is_unchanged_if_saving_fails() {
    let mut state = Box::new(Memory::new());
    let mut slam: Slam<'_> = ScPhd::new(motion(), config(), &mut *state).unwrap();
    assert_eq!(slam.save(KIND, |_| Ok::<(), ()>(())), Err(SaveError::NotStarted));
    slam = worked(&mut state);
    let (digest, len) = (slam.digest(), slam.save(KIND, |_| Ok::<(), ()>(())).unwrap());
    for room in 0..len {
        let mut bytes = std::vec![0; room];
        assert_eq!(slam.save(KIND, into_slice(&mut bytes)), Err(SaveError::Sink(SliceEnd)));
        assert_eq!((slam.digest(), slam.audit()), (digest, Ok(())));
    }
    assert_eq!(slam.save(KIND, into_slice(&mut std::vec![0; len])), Ok(len));
    slam.memory.candidates[1].ln_weight = f32::NAN;
    assert_eq!(slam.save(KIND, |_| Ok::<(), ()>(())), Err(SaveError::Damaged(Flaw::Weights)));
}

/// A source whose second pass differs from the first: the state is lost, and the filter is as before a reset.
#[test]
fn a_source_that_changes_leaves_a_complete_state_or_none() {
    let bytes = snapshot();
    let mut state = Box::new(Memory::new());
    let (mut slam, _) = held(&mut state);
    let reads = {
        let (mut reads, mut source) = (0, from_slice(&bytes));
        let counted = |at: usize, into: &mut [u8]| {
            reads += 1;
            source(at, into)
        };
        slam.restore(KIND, counted).unwrap();
        reads
    };
    let digest = slam.digest();
    // The head is read once, all other bytes twice.
    let first_pass = reads / 2 + 1;
    for (failing, lies) in (1..=reads).flat_map(|read| [(read, false), (read, true)]) {
        slam.restore(KIND, from_slice(&bytes)).unwrap();
        let (mut read, mut source) = (0, from_slice(&bytes));
        let moody = |at: usize, into: &mut [u8]| {
            read += 1;
            source(at, into)?;
            match (read == failing, lies) {
                (true, false) => return Err(SliceEnd),
                (true, true) => into[1] ^= 0x10,
                _ => (),
            }
            Ok(())
        };
        assert!(slam.restore(KIND, moody).is_err(), "{failing}");
        if failing <= first_pass {
            assert_eq!(slam.digest(), digest);
        } else {
            assert_eq!((slam.particles(), slam.audit()), (0, Ok(())), "{failing}");
            assert_eq!(slam.predict(&world(1)[0].odometry, 0.1), Err(PredictError::NotStarted));
        }
    }
}
