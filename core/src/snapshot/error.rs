//! Why a snapshot was not taken, or not gone on from.

use crate::{Flaw, SetupError};
use core::fmt;

/// Why no snapshot was taken. The state is as it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveError<E> {
    /// There is nothing to save: the filter has not been reset yet.
    NotStarted,
    /// The state is damaged, and no sound snapshot is to be lost for it.
    Damaged(Flaw),
    /// The sink took no more.
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

/// Why a filter did not go on from a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RestoreError<E> {
    /// The source does not give what it is asked for: it ends too early, or fails.
    Source(E),
    /// It does not begin as a snapshot does.
    Foreign,
    /// It is of a version that this library does not read.
    Version {
        /// The version.
        found: u16,
    },
    /// A check does not agree: a bit has changed, or a part is missing.
    Damaged,
    /// It is of something else: another filter, scalar, pose or measurement.
    Content,
    /// It is of another kind of vehicle.
    Kind {
        /// The kind that was given when it was saved.
        found: u32,
    },
    /// It does not fit the memory.
    NoRoom {
        /// Of what there is too little.
        what: &'static str,
        /// How much it takes.
        needed: usize,
        /// How much there is.
        capacity: usize,
    },
    /// The configuration cannot go on from it.
    Setup(SetupError),
    /// The checks agree, but what it holds is no state that a filter leaves.
    Flawed(Flaw),
}

impl<E> RestoreError<E> {
    /// Whether so many of something fit.
    pub(crate) fn check_room(what: &'static str, needed: usize, capacity: usize) -> Result<(), Self> {
        if needed <= capacity { Ok(()) } else { Err(Self::NoRoom { what, needed, capacity }) }
    }
}

impl<E: fmt::Display> fmt::Display for RestoreError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Source(error) => error.fmt(f),
            Self::Foreign => f.write_str("this is no snapshot"),
            Self::Version { found } => write!(f, "the snapshot is of version {found}, which is not known"),
            Self::Damaged => f.write_str("the snapshot is damaged"),
            Self::Content => f.write_str("the snapshot is of another filter, scalar, pose or measurement"),
            Self::Kind { found } => write!(f, "the snapshot is of a vehicle of kind {found:#x}"),
            Self::NoRoom { what, needed, capacity } => {
                write!(f, "the snapshot needs {needed} {what}, and there is room for {capacity}")
            }
            Self::Setup(error) => error.fmt(f),
            Self::Flawed(flaw) => write!(f, "the snapshot holds no sound state: {flaw}"),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for RestoreError<E> {}
