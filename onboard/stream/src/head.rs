//! Heads among the records.

use crate::bytes::{Bytes, CHECK, CRC};
use crate::error::StreamError;
use crate::front::{BEGINS, FRONT, MAGIC, MARK, Mark, SNAPSHOT};
use crate::header::Header;
use crate::kind::Kind;

/// An encoded head among the records.
#[derive(Debug, Clone, Copy)]
pub struct Head<'a> {
    bytes: &'a [u8],
    /// Its checksum.
    pub(crate) check: u32,
    /// The checksum of the record before it.
    pub(crate) before: u32,
}

impl<'a> Head<'a> {
    /// Takes a head from the front of some bytes, without decoding it; `None` if there is no valid one.
    pub(crate) fn take<K: Kind>(bytes: &mut Bytes<'a>) -> Option<Self> {
        let whole = bytes.slice(Header::<K>::LENGTH)?;
        let (content, check) = whole.split_last_chunk::<CHECK>()?;
        let check = u32::from_le_bytes(*check);
        let (front, _) = content.split_at_checked(FRONT)?;
        let (_, before) = front.split_last_chunk::<CHECK>()?;
        let sound = front.starts_with(&MAGIC) && check == CRC.checksum(content);
        sound.then_some(Self { bytes: whole, check, before: u32::from_le_bytes(*before) })
    }

    /// Description of the snapshot that it begins, if any.
    #[must_use]
    pub fn mark(&self) -> Option<Mark> {
        if self.bytes.get(BEGINS) != Some(&SNAPSHOT) {
            return None;
        }
        let mut bytes = Bytes(self.bytes.get(MARK..)?);
        Some(Mark { scans: bytes.u32()?, parts: bytes.u32()?, digest: bytes.u64()? })
    }

    /// Decodes the head.
    ///
    /// # Errors
    /// It has another version, is for another kind of vehicle, or has an unknown choice.
    pub fn decode<K: Kind>(&self) -> Result<Header<K>, StreamError> {
        Header::decoded(&mut Bytes(self.bytes)).map(|(header, _)| header)
    }

    /// Decodes the head in place of another.
    pub(crate) fn decode_into<K: Kind>(&self, header: &mut Header<K>) -> Result<(), StreamError> {
        header.decode(&mut Bytes(self.bytes)).map(drop)
    }
}
