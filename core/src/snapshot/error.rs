//! Errors of saving and restoring snapshots.

use crate::{Flaw, SetupError};

/// Errors of saving a snapshot. The state is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveError<E> {
    /// The filter has not been reset yet.
    #[error("the filter has not been reset yet")]
    NotStarted,
    /// The state is damaged; no snapshot is written, so that it cannot replace a valid one.
    #[error("the state is damaged: {0}")]
    Damaged(Flaw),
    /// The sink returned an error.
    #[error("{0}")]
    Sink(E),
}

/// Errors of restoring a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RestoreError<E> {
    /// The source returned an error, or ended too early.
    #[error("{0}")]
    Source(E),
    /// The bytes do not begin like a snapshot.
    #[error("this is not a snapshot")]
    Foreign,
    /// The snapshot has a format version that this library cannot read.
    #[error("the snapshot has format version {found}, which this library cannot read")]
    Version {
        /// The version.
        found: u16,
    },
    /// A checksum is wrong: a bit has changed, or a part is missing.
    #[error("the snapshot is damaged")]
    Damaged,
    /// The snapshot is that of another filter, scalar, pose or measurement.
    #[error("the snapshot is of another filter, scalar, pose or measurement")]
    Content,
    /// The snapshot is that of another type of vehicle.
    #[error("the snapshot is of another type of vehicle: {found:#x}")]
    Kind {
        /// The `kind` with which it was saved.
        found: u32,
    },
    /// The snapshot does not fit in the memory.
    #[error("the snapshot needs {needed} {what}, but the memory has room for {capacity}")]
    NoRoom {
        /// The data that does not fit.
        what: &'static str,
        /// Its number in the snapshot.
        needed: usize,
        /// The capacity of the memory.
        capacity: usize,
    },
    /// The snapshot does not fit the configuration.
    #[error(transparent)]
    Setup(SetupError),
    /// The checksums are right, but the content is not a valid state.
    #[error("the snapshot is not a valid state: {0}")]
    Flawed(Flaw),
}

impl<E> RestoreError<E> {
    /// Checks a number against a capacity.
    pub(crate) fn check_room(what: &'static str, needed: usize, capacity: usize) -> Result<(), Self> {
        if needed <= capacity { Ok(()) } else { Err(Self::NoRoom { what, needed, capacity }) }
    }
}
