//! The store without power failures.

#[path = "common/flash.rs"]
mod flash;

use embassy_futures::block_on;
use flash::{Chip, PowerLost};
use nalgebra::Vector2;
use scphd::models::{ControlNoise, PlanarPose, RangeBearingWindow, Sensing, Step, Unicycle, UnicycleControl};
use scphd::snapshot::RestoreError;
use scphd::{Births, Config, Detector, DetectorMemory, ScPhd, memory};
use scphd_store::{Snapshot, Store, StoreError};

type Small = Chip<4, 256, 12>;

fn put<const BANKS: usize>(
    store: &mut Store<&mut Small, BANKS>,
    bytes: &[u8],
) -> Result<Snapshot, StoreError<PowerLost>> {
    block_on(async {
        let mut draft = store.begin().await?;
        draft.push(bytes).await?;
        draft.commit().await
    })
}

fn all<const BANKS: usize>(
    store: &mut Store<&mut Small, BANKS>,
    of: &Snapshot,
) -> Result<Vec<u8>, StoreError<PowerLost>> {
    let mut bytes = vec![0; of.len()];
    block_on(store.read(of, 0, &mut bytes)).map(|()| bytes)
}

#[test]
fn one_snapshot_is_kept_for_each_bank() {
    let mut chip = Small::new();
    let mut store = Store::<_, 3>::new(&mut chip, 0..Small::LEN).unwrap();
    assert_eq!((store.capacity(), block_on(store.found()).unwrap().newest()), (4 * 256 - 32, None));
    let written: Vec<_> = (1..=7_u8).map(|n| put(&mut store, &vec![n; 100 * usize::from(n)]).unwrap()).collect();
    let found = block_on(store.found()).unwrap();
    let mut next = found.newest();
    for snapshot in written[4..].iter().rev() {
        assert_eq!(next, Some(snapshot));
        let n = snapshot.generation() as u8;
        assert_eq!(all(&mut store, snapshot).unwrap(), vec![n; 100 * usize::from(n)]);
        next = found.before(snapshot);
    }
    assert_eq!(next, None);
    // An overwritten snapshot cannot be read, which is reported.
    assert_eq!(all(&mut store, &written[3]), Err(StoreError::Missing));
    let last = written[6];
    assert_eq!(block_on(store.read(&last, 699, &mut [0; 2])), Err(StoreError::Missing));
    assert_eq!(block_on(store.read(&last, usize::MAX, &mut [0; 2])), Err(StoreError::Missing));
    assert_eq!(block_on(store.read(&last, 700, &mut [])), Ok(()));
}

#[test]
fn too_long_or_cancelled_drafts_leave_the_newest() {
    let mut chip = Small::new();
    let mut store = Store::<_, 2>::new(&mut chip, 256..Small::LEN).unwrap();
    // Eleven pages, five for each bank.
    assert_eq!(store.capacity(), 5 * 256 - 32);
    let first = put(&mut store, &[1; 5 * 256 - 32]).unwrap();
    assert_eq!(put(&mut store, &[2; 5 * 256 - 31]), Err(StoreError::Full));
    let mut draft = block_on(store.begin()).unwrap();
    assert_eq!(block_on(draft.push(&[3; 1000])), Ok(()));
    assert_eq!(block_on(draft.push(&[3; 300])), Err(StoreError::Full));
    assert_eq!(block_on(draft.push(&[3])), Err(StoreError::GivenUp));
    assert_eq!(block_on(draft.commit()), Err(StoreError::GivenUp));
    let _ = block_on(store.begin()).unwrap();
    assert_eq!(block_on(store.found()).unwrap().newest(), Some(&first));
    assert_eq!(all(&mut store, &first).unwrap(), [1; 5 * 256 - 32]);
    let empty = put(&mut store, &[]).unwrap();
    assert!(empty.is_empty() && block_on(store.found()).unwrap().newest() == Some(&empty));
    assert_eq!(store.destroy().bytes()[..256], [0xff; 256], "out of its range");
}

/// After a changed bit in the flash, the previous snapshot is found.
#[test]
fn a_damaged_snapshot_is_ignored() {
    let mut chip = Small::new();
    let mut store = Store::<_, 2>::new(&mut chip, 0..Small::LEN).unwrap();
    let (first, second) = (put(&mut store, &[7; 300]).unwrap(), put(&mut store, &[8; 300]).unwrap());
    let start = 6 * 256;
    // All bytes of the head that have content, and all bytes of the snapshot.
    for at in (start..start + 20).chain(start + 32..start + 332) {
        let mut spoilt = chip.clone();
        spoilt.bytes()[at] ^= 1 << (at % 8);
        let mut store = Store::<_, 2>::new(&mut spoilt, 0..Small::LEN).unwrap();
        assert_eq!(block_on(store.found()).unwrap().newest(), Some(&first), "{at}");
        assert_eq!(put(&mut store, &[9; 10]).unwrap().generation(), second.generation());
    }
}

/// A worn page: its bank is skipped.
#[test]
fn a_worn_page_is_detected_before_the_commit() {
    // The fifth page, in the second of three banks.
    let mut chip = Small::new().worn(5);
    let mut store = Store::<_, 3>::new(&mut chip, 0..Small::LEN).unwrap();
    let first = put(&mut store, &[1; 900]).unwrap();
    assert_eq!(put(&mut store, &[2; 900]), Err(StoreError::Worn));
    assert_eq!(block_on(store.found()).unwrap().newest(), Some(&first));
    let second = put(&mut store, &[3; 900]).unwrap();
    assert_eq!((second.generation(), all(&mut store, &second).unwrap()), (2, vec![3; 900]));
    assert_eq!(block_on(store.found()).unwrap().before(&second), Some(&first));
}

#[test]
fn an_unsuitable_flash_is_refused() {
    let of = |range| Store::<_, 2>::new(&mut Small::new(), range).err();
    assert_eq!(of(0..512), None);
    for (start, end) in [(0, 511), (1, 2048), (0, Small::LEN + 256), (512, 256), (0, 0)] {
        assert_eq!(of(start..end), Some(StoreError::Range), "{start}..{end}");
    }
    let mut odd = Chip::<3, 96, 8>::new();
    assert_eq!(Store::<_, 2>::new(&mut odd, 0..768).err(), Some(StoreError::Word));
}

memory! {
    type Memory: Unicycle<f32> { particles: 8, samples: 1, features { pages: 32, pages_per_map: 4, in_view: 64 } }
}
const KIND: u32 = 0x0b0e;

/// A filter is saved to the flash and restored.
#[test]
fn a_filter_restored_from_flash_continues_with_the_same_bits() {
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05)).unwrap();
    let window = RangeBearingWindow::full_circle(12.0, 0.9).unwrap();
    let sensing = Sensing::range_bearing([0.1, 0.01], window, 2.0).unwrap();
    let config = Config::blind(8, 1);
    let mut scratch = [(); 2].map(|()| DetectorMemory::<Vector2<f32>, 8>::new());
    let [mut eyes, mut other_eyes] = scratch
        .each_mut()
        .map(|memory| Detector::new(sensing, Births::of_static(0.002)).unwrap().over(memory).unwrap());
    let mut states = [(); 2].map(|()| Box::new(Memory::new()));
    let [mut slam, mut other] = states.each_mut().map(|state| ScPhd::new(motion, config, &mut **state).unwrap());
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0), 1).unwrap();
    let mut chip = flash::Flash::new();
    let mut digests = Vec::new();
    for step in 0..40 {
        let control = UnicycleControl { speed_mps: 1.0, rate_radps: 0.1 };
        let scan = [Vector2::new(5.0, 1.0 - 0.02 * step as f32), Vector2::new(7.0, -0.5), Vector2::new(3.0, 2.5)];
        slam.predict(&control, 0.1).unwrap();
        if step % 10 == 9 {
            // A new store each time.
            let mut store = Store::<_, 2>::new(&mut chip, 0..flash::Flash::LEN).unwrap();
            let mut draft = block_on(store.begin()).unwrap();
            slam.save(KIND, |bytes| block_on(draft.push(bytes))).unwrap();
            block_on(draft.commit()).unwrap();
            let mut store = Store::<_, 2>::new(&mut chip, 0..flash::Flash::LEN).unwrap();
            let newest = *block_on(store.found()).unwrap().newest().unwrap();
            let len = other.restore(KIND, |at, into| block_on(store.read(&newest, at, into))).unwrap();
            assert_eq!(len, newest.len());
            let beyond = other.restore(KIND, |at, into| block_on(store.read(&newest, newest.len() + at, into)));
            assert_eq!(beyond, Err(RestoreError::Source(StoreError::Missing)));
        } else if step > 9 {
            other.predict(&control, 0.1).unwrap();
        }
        slam.scan(&mut eyes, &scan).unwrap();
        if step >= 9 {
            other.scan(&mut other_eyes, &scan).unwrap();
            assert_eq!(other.digest(), slam.digest(), "{step}");
        }
        digests.push(slam.digest());
    }
    digests.dedup();
    assert_eq!(digests.len(), 40);
}
