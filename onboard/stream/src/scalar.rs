//! The number type of a stream.

/// The number type of the records' payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    /// Four bytes.
    F32,
    /// Eight bytes.
    F64,
}

impl Scalar {
    /// Number of bytes of one number.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}
