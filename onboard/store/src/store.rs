//! The store: its banks, and how they are read.

use crate::StoreError;
use crate::found::{Found, HEAD, Snapshot, check};
use core::ops::Range;
use embedded_storage_async::nor_flash::NorFlash;

/// Maximum number of bytes that are read or written at once.
pub(crate) const ROW: usize = 256;

/// Snapshots in a range of NOR flash.
///
/// `S` is the flash or a `&mut` of it; `BANKS` is the number of snapshots, at least two. The store takes about 300 bytes of RAM,
/// and its futures about the same.
#[derive(Debug)]
pub struct Store<S, const BANKS: usize = 2> {
    pub(crate) flash: S,
    start: u32,
    bank_len: u32,
    /// The complete snapshots, once the banks were read.
    pub(crate) known: Option<Found<BANKS>>,
    /// The bank of the next draft, if it is not the one behind the newest.
    pub(crate) turn: Option<usize>,
    pub(crate) row: [u8; ROW],
}

impl<S: NorFlash, const BANKS: usize> Store<S, BANKS> {
    /// A store in this range of the flash, in bytes, which begins at a page boundary. The pages are divided equally among the
    /// banks. Existing snapshots are kept, other content is ignored.
    ///
    /// # Errors
    /// The range or the flash cannot be used.
    pub fn new(flash: S, range: Range<u32>) -> Result<Self, StoreError<S::Error>> {
        const { assert!(BANKS >= 2, "the old snapshot stays while the new one is written") };
        if ![S::READ_SIZE, S::WRITE_SIZE].iter().all(|&word| word > 0 && HEAD.is_multiple_of(word)) {
            return Err(StoreError::Word);
        }
        let (page, banks) = (u32::try_from(S::ERASE_SIZE).unwrap_or(0), u32::try_from(BANKS).unwrap_or(u32::MAX));
        let len = range.end.saturating_sub(range.start);
        let pages = len.checked_div(page).unwrap_or(0) / banks;
        let within = usize::try_from(range.end).is_ok_and(|end| end <= flash.capacity());
        let whole = S::ERASE_SIZE.is_multiple_of(HEAD) && range.start.is_multiple_of(page);
        if !(pages > 0 && within && whole) {
            return Err(StoreError::Range);
        }
        Ok(Self { flash, start: range.start, bank_len: pages * page, known: None, turn: None, row: [0; ROW] })
    }

    /// The greatest length of a snapshot, bytes.
    pub fn capacity(&self) -> usize {
        usize::try_from(self.bank_len).unwrap_or(usize::MAX).saturating_sub(HEAD)
    }

    /// The complete snapshots in the flash. Reads all banks. A bank that the flash cannot read counts as empty.
    ///
    /// # Errors
    /// The flash cannot read any bank.
    pub async fn found(&mut self) -> Result<Found<BANKS>, StoreError<S::Error>> {
        let mut found = Found { in_banks: [None; BANKS] };
        let (mut failed, mut readable) = (None, false);
        for (bank, slot) in found.in_banks.iter_mut().enumerate() {
            match self.whole(bank).await {
                Ok(snapshot) => (*slot, readable) = (snapshot, true),
                Err(error) => failed = Some(error),
            }
        }
        match failed {
            Some(error) if !readable => Err(error),
            _ => {
                self.known = Some(found);
                Ok(found)
            }
        }
    }

    /// The snapshot in a bank, if it is complete.
    async fn whole(&mut self, bank: usize) -> Result<Option<Snapshot>, StoreError<S::Error>> {
        let mut head = [0; HEAD];
        self.flash.read(self.place(bank, 0), &mut head).await.map_err(StoreError::Flash)?;
        let Some(snapshot) = Snapshot::of_head(bank, &head).filter(|found| found.len() <= self.capacity()) else {
            return Ok(None);
        };
        Ok((self.sum(&snapshot).await? == snapshot.check).then_some(snapshot))
    }

    /// The checksum of the bytes of a snapshot.
    pub(crate) async fn sum(&mut self, of: &Snapshot) -> Result<u32, StoreError<S::Error>> {
        let (mut sum, mut at) = (check(), 0);
        while at < of.len() {
            let row = self.fetch(of, at).await?;
            sum.update(row);
            at += row.len().max(1);
        }
        Ok(sum.finalize())
    }

    /// Bytes of a snapshot from this position on, at most to the end of a row.
    async fn fetch(&mut self, of: &Snapshot, at: usize) -> Result<&[u8], StoreError<S::Error>> {
        let skipped = at % S::READ_SIZE;
        let start = at - skipped;
        let wanted = of.len().saturating_sub(start).min(ROW);
        let place = self.place(of.bank, HEAD + start);
        let row = self.row.get_mut(..wanted.next_multiple_of(S::READ_SIZE)).ok_or(StoreError::Missing)?;
        self.flash.read(place, row).await.map_err(StoreError::Flash)?;
        row.get(skipped..wanted).ok_or(StoreError::Missing)
    }

    /// Reads a part of a snapshot that was [found](Self::found).
    ///
    /// # Errors
    /// The snapshot ends before, was overwritten, or the flash fails.
    pub async fn read(&mut self, of: &Snapshot, at: usize, into: &mut [u8]) -> Result<(), StoreError<S::Error>> {
        let there = self.known.is_some_and(|found| found.in_banks.contains(&Some(*of)));
        let end = at.checked_add(into.len()).filter(|&end| there && end <= of.len());
        if end.is_none() {
            return Err(StoreError::Missing);
        }
        let (mut at, mut rest) = (at, into);
        // Every iteration reads at least one byte.
        while !rest.is_empty() {
            let row = self.fetch(of, at).await?;
            let len = rest.len().min(row.len()).max(1);
            let (now, later) = rest.split_at_mut_checked(len).ok_or(StoreError::Missing)?;
            now.iter_mut().zip(row).for_each(|(slot, &byte)| *slot = byte);
            (at, rest) = (at + len, later);
        }
        Ok(())
    }

    /// Moves the next draft to the next bank.
    pub(crate) fn turn(&mut self) {
        self.turn = self.turn.map(|bank| (bank + 1) % BANKS);
    }

    /// The address of a byte of a bank in the flash.
    pub(crate) fn place(&self, bank: usize, at: usize) -> u32 {
        let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        self.start.saturating_add(number(bank).saturating_mul(self.bank_len)).saturating_add(number(at))
    }

    /// Returns the flash.
    pub fn destroy(self) -> S {
        self.flash
    }
}
