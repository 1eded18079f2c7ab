//! The front of a head: fields at the same position in every stream.

/// The first bytes of every stream.
pub(crate) const MAGIC: [u8; 8] = *b"SCPHDLOG";
/// The version that this code reads and writes.
pub(crate) const VERSION: u16 = 9;
/// Position of the counts, behind magic, version, length and choices.
pub(crate) const COUNTS: usize = 16;
/// Number of bytes before the numbers: after the counts the mark of a snapshot, and the previous checksum.
pub(crate) const FRONT: usize = COUNTS + 3 * 4 + 16 + 4;

/// The types of a head.
pub(crate) const SNAPSHOT: u16 = 1;
pub(crate) const RETUNED: u16 = 2;

/// Purpose of a head. A stream begins with one; others are among its records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begins {
    /// The start: the filter is reset to the pose and the seed of its settings.
    Start,
    /// A snapshot: a replay may begin here, with the state in the following slices.
    Snapshot(Mark),
    /// Changed models or tuning, which this head contains.
    Retuned,
}

/// Description of a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    /// Number of scans before it.
    pub scans: u32,
    /// Its parts, a bit for each [`Part`](crate::Part).
    pub parts: u32,
    /// Digest of the state.
    pub digest: u64,
}

impl Mark {
    /// That of a head that begins no snapshot.
    pub(crate) const NONE: Self = Self { scans: 0, parts: 0, digest: 0 };
}
