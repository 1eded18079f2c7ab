//! A snapshot that is being written.

use crate::found::{Check, HEAD, Snapshot, check};
use crate::store::ROW;
use crate::{Store, StoreError};
use embedded_storage_async::nor_flash::NorFlash;

/// A snapshot that is being written. It is not found before it is [committed](Self::commit).
pub struct Draft<'s, S, const BANKS: usize> {
    store: &'s mut Store<S, BANKS>,
    /// The snapshot without its checksum.
    snapshot: Snapshot,
    check: Check,
    /// Number of erased bytes of the bank, of written bytes behind the head, and of bytes in the row buffer.
    erased: usize,
    written: usize,
    waiting: usize,
    /// Whether no operation has failed or was cancelled.
    whole: bool,
}

impl<S, const BANKS: usize> core::fmt::Debug for Draft<'_, S, BANKS> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Draft").field("snapshot", &self.snapshot).field("whole", &self.whole).finish_non_exhaustive()
    }
}

impl<S: NorFlash, const BANKS: usize> Store<S, BANKS> {
    /// Begins a new snapshot, in the bank of the oldest one. The newest one is unchanged until the new one is
    /// [committed](Draft::commit); a draft that is dropped before has no effect.
    ///
    /// # Errors
    /// As for [`found`](Self::found).
    pub async fn begin(&mut self) -> Result<Draft<'_, S, BANKS>, StoreError<S::Error>> {
        let mut found = match self.known {
            Some(found) => found,
            None => self.found().await?,
        };
        let newest = found.newest().copied();
        let behind = |bank: usize| (bank + 1) % BANKS;
        let bank = match (newest, self.turn) {
            (Some(newest), Some(turn)) if turn != newest.bank => turn,
            (Some(newest), _) => behind(newest.bank),
            (None, turn) => turn.unwrap_or(0),
        };
        if let Some(slot) = found.in_banks.get_mut(bank) {
            *slot = None;
        }
        (self.known, self.turn) = (Some(found), Some(bank));
        let generation = newest.map_or(1, |newest| newest.generation.wrapping_add(1));
        let snapshot = Snapshot { bank, generation, len: 0, check: 0 };
        Ok(Draft { store: self, snapshot, check: check(), erased: 0, written: 0, waiting: 0, whole: true })
    }
}

impl<S: NorFlash, const BANKS: usize> Draft<'_, S, BANKS> {
    /// Adds bytes. Pages are erased as they are reached.
    ///
    /// # Errors
    /// The capacity is exceeded, or the flash fails: the draft can then only be dropped.
    pub async fn push(&mut self, bytes: &[u8]) -> Result<(), StoreError<S::Error>> {
        // If the future is dropped before its end, the draft remains incomplete.
        if !core::mem::replace(&mut self.whole, false) {
            return Err(StoreError::GivenUp);
        }
        if self.snapshot.len().saturating_add(bytes.len()) > self.store.capacity() {
            return Err(StoreError::Full);
        }
        self.check.update(bytes);
        for &byte in bytes {
            if let Some(slot) = self.store.row.get_mut(self.waiting) {
                *slot = byte;
                self.waiting += 1;
                self.snapshot.len += 1;
            }
            if self.waiting == ROW {
                self.flush().await?;
            }
        }
        self.whole = true;
        Ok(())
    }

    /// Writes the buffered bytes. If the flash fails, the next draft uses another bank.
    async fn flush(&mut self) -> Result<(), StoreError<S::Error>> {
        let written = self.write_row().await;
        if written.is_err() {
            self.store.turn();
        }
        written
    }

    /// Writes the row buffer, padded to a whole word with erased bytes.
    async fn write_row(&mut self) -> Result<(), StoreError<S::Error>> {
        let len = self.waiting.next_multiple_of(S::WRITE_SIZE);
        self.erase_to(HEAD + self.written + len).await?;
        let place = self.store.place(self.snapshot.bank, HEAD + self.written);
        let row = self.store.row.get_mut(..len).ok_or(StoreError::Full)?;
        row.iter_mut().skip(self.waiting).for_each(|byte| *byte = 0xff);
        self.store.flash.write(place, row).await.map_err(StoreError::Flash)?;
        (self.written, self.waiting) = (self.written + len, 0);
        Ok(())
    }

    /// Erases the bank up to this byte, page by page, first the one with the old head.
    async fn erase_to(&mut self, end: usize) -> Result<(), StoreError<S::Error>> {
        while self.erased < end {
            let next = self.erased + S::ERASE_SIZE;
            let [from, to] = [self.erased, next].map(|at| self.store.place(self.snapshot.bank, at));
            self.store.flash.erase(from, to).await.map_err(StoreError::Flash)?;
            self.erased = next;
        }
        Ok(())
    }

    /// Completes the snapshot after it was read back: it is then the newest one.
    ///
    /// # Errors
    /// A push has failed, the flash fails, or the data read back differs. The previous snapshot is still the newest, unless the
    /// flash failed after the last word: [`found`](Store::found) then decides.
    pub async fn commit(mut self) -> Result<Snapshot, StoreError<S::Error>> {
        if !self.whole {
            return Err(StoreError::GivenUp);
        }
        // For an empty snapshot, only the page of the head.
        self.erase_to(HEAD).await?;
        if self.waiting > 0 {
            self.flush().await?;
        }
        let snapshot = Snapshot { check: self.check.finalize(), ..self.snapshot };
        let store = self.store;
        store.turn();
        if store.sum(&snapshot).await? != snapshot.check {
            return Err(StoreError::Worn);
        }
        // If the flash fails now, the banks are read again.
        let known = store.known.take();
        store.flash.write(store.place(snapshot.bank, 0), &snapshot.head()).await.map_err(StoreError::Flash)?;
        store.known = known.map(|mut found| {
            if let Some(slot) = found.in_banks.get_mut(snapshot.bank) {
                *slot = Some(snapshot);
            }
            found
        });
        Ok(snapshot)
    }
}
