//! Reads a stream record by record.

use crate::bytes::{Bytes, CRC};
use crate::{Header, Scalar};
use core::fmt;

/// The kinds of record.
pub(crate) const PREDICT: u8 = 1;
pub(crate) const SCAN: u8 = 2;
pub(crate) const END: u8 = 3;

/// One record.
#[derive(Debug, Clone)]
pub enum Record<'a> {
    /// The vehicle moved.
    Predict {
        /// Speed (m/s), then steering angle (rad) or turn rate (rad/s).
        control: [f64; 2],
        /// For how long, s.
        dt_s: f64,
    },
    /// A scan was taken.
    Scan(Measurements<'a>),
}

/// The measurements of one scan: range (m) and bearing (rad).
#[derive(Debug, Clone)]
pub struct Measurements<'a> {
    bytes: Bytes<'a>,
    scalar: Scalar,
}

impl Iterator for Measurements<'_> {
    type Item = [f64; 2];

    fn next(&mut self) -> Option<[f64; 2]> {
        Some([number(&mut self.bytes, self.scalar)?, number(&mut self.bytes, self.scalar)?])
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let len = self.bytes.0.len() / (2 * self.scalar.bytes());
        (len, Some(len))
    }
}

impl ExactSizeIterator for Measurements<'_> {}

/// One number of the payload.
fn number(bytes: &mut Bytes<'_>, scalar: Scalar) -> Option<f64> {
    match scalar {
        Scalar::F32 => bytes.f32().map(f64::from),
        Scalar::F64 => bytes.f64(),
    }
}

/// Why a stream cannot be read, or not on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StreamError {
    /// It does not begin as a stream does.
    NotAStream,
    /// It has another version than this code.
    Version {
        /// The version it has.
        found: u16,
    },
    /// A choice in the head is none this code knows, or the head has another length.
    Header,
    /// The check of the head fails.
    HeaderDamaged,
    /// It ends before its last record.
    Truncated,
    /// A record is of no kind this code knows, or its length does not fit its kind.
    Record {
        /// Its place, counted from 0.
        index: u32,
    },
    /// The check of a record fails.
    RecordDamaged {
        /// Its place, counted from 0.
        index: u32,
    },
}

impl fmt::Display for StreamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAStream => f.write_str("this is no stream of filter inputs"),
            Self::Version { found } => write!(f, "the stream has version {found}, this code reads version 1"),
            Self::Header => f.write_str("the head of the stream is of no form this code knows"),
            Self::HeaderDamaged => f.write_str("the head of the stream is damaged"),
            Self::Truncated => f.write_str("the stream ends before its last record"),
            Self::Record { index } => write!(f, "record {index} is of no form this code knows"),
            Self::RecordDamaged { index } => write!(f, "record {index} is damaged"),
        }
    }
}

impl core::error::Error for StreamError {}

/// Reads a stream that lies in memory as a whole.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    header: Header,
    rest: Bytes<'a>,
    index: u32,
}

impl<'a> Reader<'a> {
    /// Reads and checks the head. What follows the last record is not looked at, so that `bytes` may be a whole region
    /// of memory that a stream was loaded into.
    ///
    /// # Errors
    /// The bytes do not begin with the head of a stream that this code can read.
    pub fn open(bytes: &'a [u8]) -> Result<Self, StreamError> {
        let mut rest = Bytes(bytes);
        let header = Header::decode(&mut rest)?;
        Ok(Self { header, rest, index: 0 })
    }

    /// The head.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The next record; `None` after the last.
    ///
    /// # Errors
    /// The record is incomplete, damaged or unknown. The reader stays before it.
    pub fn read(&mut self) -> Result<Option<Record<'a>>, StreamError> {
        let index = self.index;
        let mut rest = self.rest.clone();
        let whole = rest.0;
        let kind = rest.u8().ok_or(StreamError::Truncated)?;
        let reserved = rest.u8().ok_or(StreamError::Truncated)?;
        let count = rest.u16().ok_or(StreamError::Truncated)?;
        let scalar = self.header.scalar;
        let numbers = match (kind, reserved, count) {
            (PREDICT, 0, 1) => 3,
            (SCAN, 0, count) => 2 * usize::from(count),
            (END, 0, 0) => 0,
            _ => return Err(StreamError::Record { index }),
        };
        let payload = rest.slice(numbers * scalar.bytes()).ok_or(StreamError::Truncated)?;
        let content = whole.get(..4 + payload.len()).ok_or(StreamError::Truncated)?;
        if rest.u32().ok_or(StreamError::Truncated)? != CRC.checksum(content) {
            return Err(StreamError::RecordDamaged { index });
        }
        let mut payload = Bytes(payload);
        let record = match kind {
            // The reader stays before the end, too: asked again, it says the same.
            END => return Ok(None),
            PREDICT => {
                let mut next = || number(&mut payload, scalar).ok_or(StreamError::Truncated);
                Record::Predict { control: [next()?, next()?], dt_s: next()? }
            }
            _ => Record::Scan(Measurements { bytes: payload, scalar }),
        };
        self.rest = rest;
        self.index = index.saturating_add(1);
        Ok(Some(record))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Writer;
    use std::vec::Vec;

    const CONTROL: [f64; 2] = [1.1, -0.2];
    const SCAN_OF_TWO: [[f64; 2]; 2] = [[3.3, 0.4], [5.5, -0.6]];

    fn stream(scalar: Scalar) -> Vec<u8> {
        let mut bytes = Vec::new();
        let header = Header { scalar, ..Header::EMPTY };
        let mut writer = Writer::start(&header, |piece: &[u8]| {
            bytes.extend_from_slice(piece);
            Ok::<(), ()>(())
        })
        .unwrap();
        writer.predict(CONTROL, 0.05).unwrap();
        writer.scan(&SCAN_OF_TWO).unwrap();
        writer.scan(&[]).unwrap();
        writer.end().unwrap();
        bytes
    }

    /// Every number of the stream, up to an error or its end.
    fn numbers(bytes: &[u8]) -> Result<Vec<f64>, StreamError> {
        let mut reader = Reader::open(bytes)?;
        let mut numbers = Vec::new();
        while let Some(record) = reader.read()? {
            match record {
                Record::Predict { control, dt_s } => numbers.extend([control[0], control[1], dt_s]),
                Record::Scan(measurements) => {
                    numbers.push(measurements.len() as f64);
                    numbers.extend(measurements.flatten());
                }
            }
        }
        Ok(numbers)
    }

    #[test]
    fn what_is_written_is_read() {
        let expected = [1.1, -0.2, 0.05, 2.0, 3.3, 0.4, 5.5, -0.6, 0.0];
        assert_eq!(numbers(&stream(Scalar::F64)).unwrap(), expected);
        assert_eq!(numbers(&stream(Scalar::F32)).unwrap(), expected.map(|x| f64::from(x as f32)));
    }

    #[test]
    fn what_follows_the_end_is_not_looked_at() {
        let mut bytes = stream(Scalar::F32);
        let expected = numbers(&bytes);
        bytes.extend([0xff; 100]);
        assert_eq!(numbers(&bytes), expected);
        let mut reader = Reader::open(&bytes).unwrap();
        (0..3).for_each(|_| assert!(reader.read().unwrap().is_some()));
        assert!(reader.read().unwrap().is_none() && reader.read().unwrap().is_none());
    }

    #[test]
    fn every_damage_and_every_cut_is_seen() {
        for scalar in [Scalar::F32, Scalar::F64] {
            let good = stream(scalar);
            for place in 0..good.len() {
                assert!(numbers(&good[..place]).is_err(), "cut at {place}");
                for bit in 0..8 {
                    let mut bytes = good.clone();
                    bytes[place] ^= 1 << bit;
                    assert!(numbers(&bytes).is_err(), "bit {bit} of byte {place}");
                }
            }
        }
    }

    #[test]
    fn whole_records_before_a_cut_can_be_read() {
        let bytes = stream(Scalar::F64);
        let mut reader = Reader::open(&bytes[..bytes.len() - 9]).unwrap();
        assert!(reader.read().unwrap().is_some() && reader.read().unwrap().is_some());
        assert_eq!(reader.read().unwrap_err(), StreamError::Truncated);
        assert_eq!(reader.read().unwrap_err(), StreamError::Truncated);
    }
}
