//! What a head begins, and heads among the records.

use crate::bytes::{Bytes, CHECK, CRC};
use crate::header::{FRONT, Header, MAGIC};
use crate::kind::Kind;
use crate::reader::StreamError;

/// Where a head says what it begins, and the numbers for it.
const BEGINS: usize = 18;
pub(crate) const SNAPSHOT: u8 = 1;
pub(crate) const RETUNED: u8 = 2;
/// Where it says what it goes on from.
const MARK: usize = 52;

/// What a head stands before. A stream begins with one; further ones stand among its records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begins {
    /// The start: the filter is reset to the pose and the seed of the head.
    Start,
    /// A snapshot: a replay may begin here, with the state that follows in slices.
    Snapshot(Mark),
    /// Other models or another tuning, of the head, from here on.
    Retuned,
}

/// What a snapshot is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    /// Scans before it.
    pub scans: u32,
    /// What it has, a bit for each [`Part`](crate::Part).
    pub parts: u32,
    /// Digest of the state.
    pub digest: u64,
}

/// A head among the records, as it stands.
#[derive(Debug, Clone, Copy)]
pub struct Head<'a> {
    bytes: &'a [u8],
    /// Its own check.
    pub(crate) check: u32,
    /// The check of the record before it.
    pub(crate) before: u32,
}

impl<'a> Head<'a> {
    /// Takes the head off the front of some bytes, without a look at what it says; `None` where there is no sound one.
    pub(crate) fn take<K: Kind>(bytes: &mut Bytes<'a>) -> Option<Self> {
        let whole = bytes.slice(Header::<K>::LENGTH)?;
        let (content, check) = whole.split_last_chunk::<CHECK>()?;
        let check = u32::from_le_bytes(*check);
        let (front, _) = content.split_at_checked(FRONT)?;
        let (_, before) = front.split_last_chunk::<CHECK>()?;
        let sound = front.starts_with(&MAGIC) && check == CRC.checksum(content);
        sound.then_some(Self { bytes: whole, check, before: u32::from_le_bytes(*before) })
    }

    /// The snapshot behind it, if that is what it begins.
    #[must_use]
    pub fn mark(&self) -> Option<Mark> {
        if self.bytes.get(BEGINS) != Some(&SNAPSHOT) {
            return None;
        }
        let mut bytes = Bytes(self.bytes.get(MARK..)?);
        Some(Mark { scans: bytes.u32()?, parts: bytes.u32()?, digest: bytes.u64()? })
    }

    /// What it says.
    ///
    /// # Errors
    /// It is of another version, another kind of vehicle, or makes a choice that this code does not know.
    pub fn decode<K: Kind>(&self) -> Result<Header<K>, StreamError> {
        Header::decode(&mut Bytes(self.bytes)).map(|(header, _)| header)
    }
}
