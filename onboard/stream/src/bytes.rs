//! Little-endian numbers in a slice of bytes.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

/// Checksum of the header and of every record: CRC-32 as in Ethernet and zip files.
pub(crate) static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);
/// Number of its bytes.
pub(crate) const CHECK: usize = 4;

/// The checksum of a record's bytes, with that of the previous record or head included, so that the order of records is checked
/// too.
pub(crate) fn chained(before: u32, bytes: &[u8]) -> u32 {
    let mut check = CRC.digest();
    check.update(&before.to_le_bytes());
    check.update(bytes);
    check.finalize()
}

/// Writes bytes and their checksum to a sink; after the first error, nothing more.
pub(crate) struct Checked<F, E> {
    sink: F,
    check: Digest<'static, u32, Table<1>>,
    state: Result<(), E>,
}

impl<E, F: FnMut(&[u8]) -> Result<(), E>> Checked<F, E> {
    /// A head.
    pub(crate) fn new(sink: F) -> Self {
        Self { sink, check: CRC.digest(), state: Ok(()) }
    }

    /// A record behind one with this checksum.
    pub(crate) fn behind(before: u32, sink: F) -> Self {
        let mut record = Self::new(sink);
        record.check.update(&before.to_le_bytes());
        record
    }

    pub(crate) fn put(&mut self, bytes: &[u8]) {
        self.check.update(bytes);
        if self.state.is_ok() {
            self.state = (self.sink)(bytes);
        }
    }

    /// Writes the checksum, and returns it.
    ///
    /// # Errors
    /// The first error of the sink.
    pub(crate) fn end(mut self) -> Result<u32, E> {
        self.state?;
        let check = self.check.finalize();
        (self.sink)(&check.to_le_bytes())?;
        Ok(check)
    }
}

/// Reads numbers from the front of a slice; `None` at its end.
#[derive(Debug, Clone)]
pub(crate) struct Bytes<'a>(pub(crate) &'a [u8]);

impl<'a> Bytes<'a> {
    pub(crate) fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    pub(crate) fn slice(&mut self, len: usize) -> Option<&'a [u8]> {
        let (first, rest) = self.0.split_at_checked(len)?;
        self.0 = rest;
        Some(first)
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(crate) fn f64(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }

    pub(crate) fn f32(&mut self) -> Option<f32> {
        self.array().map(f32::from_le_bytes)
    }
}
