//! Encoded heads: at the front of a stream, and among its records.

use crate::bytes::{Bytes, CHECK, CRC};
use crate::error::StreamError;
use crate::front::{Begins, COUNTS, FRONT, MAGIC, Mark, RETUNED, SNAPSHOT, VERSION};
use crate::header::{Header, Parameters, Settings, UNKNOWN};
use crate::kind::Kind;
use crate::numbers::Numbers;
use crate::scalar::Scalar;
use core::marker::PhantomData;
use scphd::Real;
use scphd_vehicle::{Description, Invalid};

/// An encoded head. Decoded it would take more than a kilobyte of stack.
#[derive(Debug, Clone, Copy)]
pub struct Head<'a, K> {
    bytes: &'a [u8],
    /// The number type of the records.
    pub(crate) scalar: Scalar,
    /// Its purpose.
    pub(crate) begins: Begins,
    /// Its checksum.
    pub(crate) check: u32,
    /// The checksum of the record before it.
    pub(crate) before: u32,
    kind: PhantomData<K>,
}

impl<'a, K: Kind> Head<'a, K> {
    /// Takes a head from the front of some bytes.
    ///
    /// # Errors
    /// The bytes do not begin with a head that this code can read.
    #[inline(never)]
    pub(crate) fn take(bytes: &mut Bytes<'a>) -> Result<Self, StreamError> {
        let cut = StreamError::Truncated;
        let mut front = Bytes(bytes.0.first_chunk::<FRONT>().ok_or(cut)?);
        if front.array().ok_or(cut)? != MAGIC {
            return Err(StreamError::NotAStream);
        }
        let version = front.u16().ok_or(cut)?;
        if version != VERSION {
            return Err(StreamError::Version { found: version });
        }
        let length = usize::from(front.u16().ok_or(cut)?);
        let [scalar, code] = front.array().ok_or(cut)?;
        let begins = front.u16().ok_or(cut)?;
        // The length of the head depends on the vehicle.
        if code != K::CODE {
            return Err(StreamError::Vehicle { found: code });
        }
        if length != Header::<K>::LENGTH {
            return Err(StreamError::Header);
        }
        let whole = bytes.slice(length).ok_or(cut)?;
        let (content, check) = whole.split_last_chunk::<CHECK>().ok_or(cut)?;
        let check = u32::from_le_bytes(*check);
        if check != CRC.checksum(content) {
            return Err(StreamError::HeaderDamaged);
        }
        // The counts are decoded with the whole head.
        front.slice(3 * 4);
        let (scans, parts) = (front.u32().ok_or(cut)?, front.u32().ok_or(cut)?);
        let (digest, before) = (front.u64().ok_or(cut)?, front.u32().ok_or(cut)?);
        let begins = match begins {
            0 => Begins::Start,
            SNAPSHOT => Begins::Snapshot(Mark { scans, parts, digest }),
            RETUNED => Begins::Retuned,
            _ => return Err(StreamError::Header),
        };
        let scalar = match scalar {
            4 => Scalar::F32,
            8 => Scalar::F64,
            _ => return Err(StreamError::Header),
        };
        Ok(Self { bytes: whole, scalar, begins, check, before, kind: PhantomData })
    }

    /// Description of the snapshot that it begins, if any.
    #[must_use]
    pub fn mark(&self) -> Option<Mark> {
        match self.begins {
            Begins::Snapshot(mark) => Some(mark),
            _ => None,
        }
    }

    /// Decodes the head.
    #[must_use]
    pub fn decode(&self) -> Header<K> {
        let mut counts = Bytes(self.bytes.get(COUNTS..).unwrap_or_default());
        let mut count = || counts.u32().unwrap_or(UNKNOWN);
        let (scans, predictions, most_measurements) = (count(), count(), count());
        let mut numbers = self.numbers();
        let mut number = || numbers.next();
        Header {
            scalar: self.scalar,
            scans,
            predictions,
            most_measurements,
            begins: self.begins,
            settings: Numbers::take(&mut number).unwrap_or(Numbers::ZERO),
            models: Numbers::take(&mut number).unwrap_or(Numbers::ZERO),
            scan_interval_s: number().unwrap_or(0.0),
        }
    }

    /// Settings, models, and interval of the scans.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> + use<'a, K> {
        let (numbers, _) = self.bytes.get(FRONT..).unwrap_or_default().as_chunks();
        numbers.iter().map(|bytes| f64::from_le_bytes(*bytes))
    }
}

impl<K: Kind> Parameters<K> for Head<'_, K> {
    fn describe<T: Real>(&self, description: &mut Description<T>) -> Result<(), Invalid> {
        description.take_numbers(self.numbers())
    }

    fn models(&self) -> K::Models {
        let mut numbers = self.numbers().skip(Settings::COUNT);
        Numbers::take(&mut || numbers.next()).unwrap_or(Numbers::ZERO)
    }
}
