//! Errors of reading a stream.

use crate::front::VERSION;

/// Errors of reading a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StreamError {
    /// The bytes do not begin like a stream.
    #[error("this is not a stream of filter inputs")]
    NotAStream,
    /// The stream has a format version that this code cannot read.
    #[error("the stream has version {found}, this code reads version {VERSION}")]
    Version {
        /// Its version.
        found: u16,
    },
    /// The stream is for another type of vehicle.
    #[error("the stream is for another type of vehicle: {found}")]
    Vehicle {
        /// The number of its type.
        found: u8,
    },
    /// The header has an unknown value, or another length.
    #[error("the stream header has an unknown value or length")]
    Header,
    /// The checksum of the header is wrong.
    #[error("the stream header is damaged")]
    HeaderDamaged,
    /// The bytes begin with a change of models or tuning: neither the start of a stream nor a snapshot.
    #[error("the stream begins with a change of models or tuning, not with a snapshot")]
    NoBeginning,
    /// The stream ends before its last record.
    #[error("the stream ends before its last record")]
    Truncated,
    /// A record has an unknown type, or its length does not fit its type.
    #[error("record {index} has an unknown type or a wrong length")]
    Record {
        /// Its index, from 0.
        index: u32,
    },
    /// The checksum of a record is wrong: it is damaged, or does not follow the previous one.
    #[error("record {index} is damaged, or the one before it is missing")]
    RecordDamaged {
        /// Its index, from 0.
        index: u32,
    },
}
