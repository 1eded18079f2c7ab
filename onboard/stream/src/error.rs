//! Errors of reading a stream.

use crate::front::VERSION;
use core::fmt;

/// Errors of reading a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StreamError {
    /// The bytes do not begin like a stream.
    NotAStream,
    /// The stream has a format version that this code cannot read.
    Version {
        /// Its version.
        found: u16,
    },
    /// The stream is for another type of vehicle.
    Vehicle {
        /// The number of its type.
        found: u8,
    },
    /// The header has an unknown value, or another length.
    Header,
    /// The checksum of the header is wrong.
    HeaderDamaged,
    /// The bytes begin with a change of models or tuning: neither the start of a stream nor a snapshot.
    NoBeginning,
    /// The stream ends before its last record.
    Truncated,
    /// A record has an unknown type, or its length does not fit its type.
    Record {
        /// Its index, from 0.
        index: u32,
    },
    /// The checksum of a record is wrong: it is damaged, or does not follow the previous one.
    RecordDamaged {
        /// Its index, from 0.
        index: u32,
    },
}

impl fmt::Display for StreamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAStream => f.write_str("this is not a stream of filter inputs"),
            Self::Version { found } => write!(f, "the stream has version {found}, this code reads version {VERSION}"),
            Self::Vehicle { found } => write!(f, "the stream is for another type of vehicle: {found}"),
            Self::Header => f.write_str("the stream header has an unknown value or length"),
            Self::HeaderDamaged => f.write_str("the stream header is damaged"),
            Self::NoBeginning => {
                f.write_str("the stream begins with a change of models or tuning, not with a snapshot")
            }
            Self::Truncated => f.write_str("the stream ends before its last record"),
            Self::Record { index } => write!(f, "record {index} has an unknown type or a wrong length"),
            Self::RecordDamaged { index } => write!(f, "record {index} is damaged, or the one before it is missing"),
        }
    }
}

impl core::error::Error for StreamError {}
