//! Errors of saving and restoring snapshots.

use crate::{Flaw, SetupError};
use core::fmt;

/// Errors of saving a snapshot. The state is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveError<E> {
    /// The filter has not been reset yet.
    NotStarted,
    /// The state is damaged; no snapshot is written, so that it cannot replace a valid one.
    Damaged(Flaw),
    /// The sink returned an error.
    Sink(E),
}

impl<E: fmt::Display> fmt::Display for SaveError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStarted => f.write_str("the filter has not been reset yet"),
            Self::Damaged(flaw) => write!(f, "the state is damaged: {flaw}"),
            Self::Sink(error) => error.fmt(f),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for SaveError<E> {}

/// Errors of restoring a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RestoreError<E> {
    /// The source returned an error, or ended too early.
    Source(E),
    /// The bytes do not begin like a snapshot.
    Foreign,
    /// The snapshot has a format version that this library cannot read.
    Version {
        /// The version.
        found: u16,
    },
    /// A checksum is wrong: a bit has changed, or a part is missing.
    Damaged,
    /// The snapshot is that of another filter, scalar, pose or measurement.
    Content,
    /// The snapshot is that of another type of vehicle.
    Kind {
        /// The `kind` with which it was saved.
        found: u32,
    },
    /// The snapshot does not fit in the memory.
    NoRoom {
        /// The data that does not fit.
        what: &'static str,
        /// Its number in the snapshot.
        needed: usize,
        /// The capacity of the memory.
        capacity: usize,
    },
    /// The snapshot does not fit the configuration.
    Setup(SetupError),
    /// The checksums are right, but the content is not a valid state.
    Flawed(Flaw),
}

impl<E> RestoreError<E> {
    /// Checks a number against a capacity.
    pub(crate) fn check_room(what: &'static str, needed: usize, capacity: usize) -> Result<(), Self> {
        if needed <= capacity { Ok(()) } else { Err(Self::NoRoom { what, needed, capacity }) }
    }
}

impl<E: fmt::Display> fmt::Display for RestoreError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Source(error) => error.fmt(f),
            Self::Foreign => f.write_str("this is not a snapshot"),
            Self::Version { found } => {
                write!(f, "the snapshot has format version {found}, which this library cannot read")
            }
            Self::Damaged => f.write_str("the snapshot is damaged"),
            Self::Content => f.write_str("the snapshot is of another filter, scalar, pose or measurement"),
            Self::Kind { found } => write!(f, "the snapshot is of another type of vehicle: {found:#x}"),
            Self::NoRoom { what, needed, capacity } => {
                write!(f, "the snapshot needs {needed} {what}, but the memory has room for {capacity}")
            }
            Self::Setup(error) => error.fmt(f),
            Self::Flawed(flaw) => write!(f, "the snapshot is not a valid state: {flaw}"),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for RestoreError<E> {}
