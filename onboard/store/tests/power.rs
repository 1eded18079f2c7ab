//! Power failures at every word and every page: the old or the new snapshot is found and complete, for any content of the
//! interrupted word or page.

#[path = "common/flash.rs"]
mod flash;

use embassy_futures::block_on;
use flash::{Chip, Cut, PowerLost};
use scphd_store::{Store, StoreError};

/// Pages of 256 bytes.
type Small<const WORD: usize> = Chip<WORD, 256, 12>;
type Newest = Option<(u32, Vec<u8>)>;

const CUTS: [Cut; 6] = [Cut::Before, Cut::First, Cut::Second, Cut::Faint, Cut::Noise, Cut::After];

/// Bytes that identify their snapshot, with odd lengths.
fn content(generation: usize, len: usize) -> Vec<u8> {
    (0..len + generation % 7).map(|at| (at * 31 + generation * 101 + at / 251) as u8).collect()
}

fn open<const WORD: usize, const BANKS: usize>(flash: &mut Small<WORD>) -> Store<&mut Small<WORD>, BANKS> {
    Store::new(flash, 0..Small::<WORD>::LEN).unwrap()
}

fn write<const WORD: usize, const BANKS: usize>(
    flash: &mut Small<WORD>,
    bytes: &[u8],
) -> Result<u32, StoreError<PowerLost>> {
    let mut store = open::<WORD, BANKS>(flash);
    block_on(async {
        let mut draft = store.begin().await?;
        for part in bytes.chunks(37) {
            draft.push(part).await?;
        }
        Ok(draft.commit().await?.generation())
    })
}

/// Generation and bytes of the newest snapshot, read in pieces.
fn newest<const WORD: usize, const BANKS: usize>(flash: &mut Small<WORD>) -> Newest {
    let mut store = open::<WORD, BANKS>(flash);
    let found = block_on(store.found()).unwrap();
    let newest = *found.newest()?;
    let mut bytes = vec![0; newest.len()];
    for (place, part) in bytes.chunks_mut(53).enumerate() {
        block_on(store.read(&newest, 53 * place, part)).unwrap();
    }
    Some((newest.generation(), bytes))
}

/// Writes a number of snapshots, with a power failure of every type at every word and page; after every `again`-th failure, a
/// second one while the same snapshot is written again. Returns the number of failures.
fn every_cut<const WORD: usize, const BANKS: usize>(len: usize, snapshots: usize, again: usize) -> usize {
    let mut whole = Small::<WORD>::new();
    let mut cuts = 0;
    for generation in 1..=snapshots {
        let (old, new) = (newest::<WORD, BANKS>(&mut whole), content(generation, len));
        let expected = Some((generation as u32, new.clone()));
        let mut complete = whole.failing(usize::MAX - 1, Cut::Before);
        assert_eq!(write::<WORD, BANKS>(&mut complete, &new), Ok(generation as u32));
        assert_eq!(newest::<WORD, BANKS>(&mut complete), expected);
        for (after, cut) in (0..complete.done()).flat_map(|after| CUTS.map(|cut| (after, cut))) {
            let at = format!("{generation}, {after} of {}, {cut:?}", complete.done());
            let mut failing = whole.failing(after, cut);
            assert_eq!(write::<WORD, BANKS>(&mut failing, &new), Err(StoreError::Flash(PowerLost)), "{at}");
            let mut restarted = failing.restarted();
            let found = newest::<WORD, BANKS>(&mut restarted);
            // The words of the head are the last ones, and only some of them have content.
            let ending = complete.done() - after <= 32 / WORD;
            assert!(found == old || (ending && found == expected), "{at}");
            assert!(!(after + 1 == complete.done() && cut == Cut::After) || found == expected, "{at}");
            if again > 0 && after % again == 0 {
                a_second_cut::<WORD, BANKS>(&restarted, &found, &new, complete.done(), again);
            }
            // The store can be used again.
            let next = found.map_or(1, |(generation, _)| generation + 1);
            assert_eq!(write::<WORD, BANKS>(&mut restarted, &content(99, len)), Ok(next), "{at}");
            assert_eq!(newest::<WORD, BANKS>(&mut restarted), Some((next, content(99, len))), "{at}");
            cuts += 1;
        }
        whole = complete.restarted();
    }
    cuts
}

/// A second power failure.
fn a_second_cut<const WORD: usize, const BANKS: usize>(
    restarted: &Small<WORD>,
    found: &Newest,
    new: &[u8],
    words: usize,
    step: usize,
) {
    for after in (0..words + 8).step_by(step) {
        let mut failing = restarted.failing(after, Cut::Faint);
        let taken = write::<WORD, BANKS>(&mut failing, new).is_ok();
        let twice = newest::<WORD, BANKS>(&mut failing.restarted());
        let is_new = twice.as_ref().is_some_and(|(_, bytes)| *bytes == new);
        assert!(is_new || (!taken && twice == *found), "{after}");
    }
}

#[test]
fn a_brown_out_at_any_time_leaves_the_old_or_the_new_one() {
    let cuts = every_cut::<4, 2>(600, 5, 0) + every_cut::<4, 4>(500, 9, 0);
    assert!(cuts > 12_000, "{cuts}");
}

/// Words of one byte, as in an external flash, up to 32 bytes, as in a microcontroller.
#[test]
fn all_word_sizes() {
    let cuts = every_cut::<1, 3>(300, 4, 0) + every_cut::<8, 3>(700, 5, 0) + every_cut::<32, 3>(700, 5, 0);
    assert!(cuts > 10_000, "{cuts}");
}

#[test]
fn a_second_brown_out_while_the_same_snapshot_is_written() {
    every_cut::<8, 2>(260, 4, 3);
    every_cut::<8, 4>(260, 6, 5);
}
