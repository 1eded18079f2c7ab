//! Why a stream cannot be read.

use crate::front::VERSION;
use core::fmt;

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
    /// It is of a vehicle of another kind than it is read for.
    Vehicle {
        /// The vehicle it is of.
        found: u8,
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
    /// The check of a record fails: it is damaged, or does not follow the one before.
    RecordDamaged {
        /// Its place, counted from 0.
        index: u32,
    },
}

impl fmt::Display for StreamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAStream => f.write_str("this is no stream of filter inputs"),
            Self::Version { found } => write!(f, "the stream has version {found}, this code reads version {VERSION}"),
            Self::Vehicle { found } => write!(f, "the stream is of vehicle {found}, which is of another kind"),
            Self::Header => f.write_str("the head of the stream is of no form this code knows"),
            Self::HeaderDamaged => f.write_str("the head of the stream is damaged"),
            Self::Truncated => f.write_str("the stream ends before its last record"),
            Self::Record { index } => write!(f, "record {index} is of no form this code knows"),
            Self::RecordDamaged { index } => write!(f, "record {index} is damaged, or the one before it is missing"),
        }
    }
}

impl core::error::Error for StreamError {}
