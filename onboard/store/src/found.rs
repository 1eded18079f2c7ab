//! Complete snapshots, and their heads.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

/// Checksum of a head and of a snapshot: CRC-32 as in Ethernet and zip files.
static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);
/// A checksum in progress.
pub(crate) type Check = Digest<'static, u32, Table<1>>;

/// Number of bytes of a head: a multiple of the word size of every flash.
pub(crate) const HEAD: usize = 32;
/// Its first bytes.
const MAGIC: [u8; 4] = *b"SCPS";

/// An empty checksum.
pub(crate) fn check() -> Check {
    CRC.digest()
}

/// A complete snapshot in the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Snapshot {
    pub(crate) bank: usize,
    pub(crate) generation: u32,
    pub(crate) len: u32,
    /// Checksum of its bytes.
    pub(crate) check: u32,
}

impl Snapshot {
    /// Its generation: 1 for the first snapshot, and one more for each following one.
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Number of its bytes.
    pub fn len(&self) -> usize {
        usize::try_from(self.len).unwrap_or(usize::MAX)
    }

    /// Whether it has no bytes.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Its head: five words, the last of which is their checksum. The rest remains erased.
    pub(crate) fn head(&self) -> [u8; HEAD] {
        let said = [MAGIC, self.generation.to_le_bytes(), self.len.to_le_bytes(), self.check.to_le_bytes()];
        let check = CRC.checksum(said.as_flattened()).to_le_bytes();
        let mut head = [[0xff; 4]; HEAD / 4];
        head.iter_mut().zip(said.into_iter().chain([check])).for_each(|(slot, word)| *slot = word);
        let mut bytes = [0; HEAD];
        bytes.iter_mut().zip(head.as_flattened()).for_each(|(slot, &byte)| *slot = byte);
        bytes
    }

    /// Decodes a head; `None` if it is invalid.
    pub(crate) fn of_head(bank: usize, head: &[u8; HEAD]) -> Option<Self> {
        let (words, _) = head.as_chunks::<4>();
        let &[magic, generation, len, check, of_head, ..] = words else { return None };
        let own = CRC.checksum([magic, generation, len, check].as_flattened());
        let [generation, len, check, of_head] = [generation, len, check, of_head].map(u32::from_le_bytes);
        (magic == MAGIC && own == of_head).then_some(Self { bank, generation, len, check })
    }
}

/// The complete snapshots in the flash, newest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Found<const BANKS: usize> {
    /// The snapshot of each bank.
    pub(crate) in_banks: [Option<Snapshot>; BANKS],
}

impl<const BANKS: usize> Found<BANKS> {
    /// The last one that was committed.
    pub fn newest(&self) -> Option<&Snapshot> {
        self.in_banks.iter().flatten().max_by_key(|snapshot| snapshot.generation)
    }

    /// The one before `snapshot`, if a vehicle finds the latter invalid; `None` if there is none.
    #[must_use]
    pub fn before(&self, snapshot: &Snapshot) -> Option<&Snapshot> {
        let older = self.in_banks.iter().flatten().filter(|other| other.generation < snapshot.generation);
        older.max_by_key(|snapshot| snapshot.generation)
    }
}

#[cfg(test)]
mod tests {
    use super::{Found, HEAD, Snapshot};

    #[test]
    fn every_changed_bit_of_a_head_is_detected() {
        let snapshot = Snapshot { bank: 3, generation: 77, len: 12_345, check: 0xdead_beef };
        let head = snapshot.head();
        assert_eq!(Snapshot::of_head(3, &head), Some(snapshot));
        for bit in 0..160 {
            let mut damaged = head;
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Snapshot::of_head(3, &damaged), None, "bit {bit}");
        }
        assert_eq!(Snapshot::of_head(0, &[0xff; HEAD]), None);
        assert_eq!(Snapshot::of_head(0, &[0; HEAD]), None);
    }

    #[test]
    fn snapshots_are_in_order_newest_first() {
        let snapshot = |bank, generation| Some(Snapshot { bank, generation, len: 0, check: 0 });
        let found = Found { in_banks: [snapshot(0, 7), None, snapshot(2, 5), snapshot(3, 6)] };
        let mut order = std::vec::Vec::new();
        let mut next = found.newest();
        while let Some(snapshot) = next {
            order.push(snapshot.generation());
            next = found.before(snapshot);
        }
        assert_eq!(order, [7, 6, 5]);
    }
}
