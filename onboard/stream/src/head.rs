//! Heads among the records.

use crate::bytes::{Bytes, CHECK, CRC};
use crate::error::StreamError;
use crate::front::{BEGINS, FRONT, MAGIC, MARK, Mark, SNAPSHOT};
use crate::header::Header;
use crate::kind::Kind;

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
