//! The front of a head: what stands at the same place in every stream.

/// The first bytes of every stream.
pub(crate) const MAGIC: [u8; 8] = *b"SCPHDLOG";
/// The version this code reads and writes.
pub(crate) const VERSION: u16 = 6;
/// Bytes before the numbers: magic, version, length, choices, counts, seed, what the stream goes on from.
pub(crate) const FRONT: usize = 72;

/// Where a head says what it begins, and the numbers for it.
pub(crate) const BEGINS: usize = 18;
pub(crate) const SNAPSHOT: u8 = 1;
pub(crate) const RETUNED: u8 = 2;
/// Where it says what it goes on from.
pub(crate) const MARK: usize = 52;

/// What a head stands before. A stream begins with one; further ones stand among its records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begins {
    /// The start: the filter is reset to the pose and the seed of the head.
    Start,
    /// A snapshot: a replay may begin here, with the state that follows in slices.
    Snapshot(Mark),
    /// Other models or another tuning, of the head, from here on.
    Retuned,
}

/// What a snapshot is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    /// Scans before it.
    pub scans: u32,
    /// What it has, a bit for each [`Part`](crate::Part).
    pub parts: u32,
    /// Digest of the state.
    pub digest: u64,
}
