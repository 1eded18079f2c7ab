//! Why the store cannot do what it is asked for.

use core::fmt;

/// Why the store cannot do what it is asked for. The newest snapshot is as it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StoreError<E> {
    /// The flash's own error.
    Flash(E),
    /// The range does not begin with a page, leaves no page for a bank, or ends beyond the flash.
    Range,
    /// What the flash reads or writes at once is no divisor of 32 bytes.
    Word,
    /// The snapshot is longer than a bank.
    Full,
    /// A part of the draft was not taken, so that it will never be whole.
    GivenUp,
    /// What was written does not read back: the flash is worn. The next draft goes to another bank, if there are more than two.
    Worn,
    /// What was asked for is not there: the snapshot ends before, or has been written over.
    Missing,
}

impl<E: fmt::Debug> fmt::Display for StoreError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Flash(error) => return write!(f, "the flash fails: {error:?}"),
            Self::Range => "the range of the flash is not one that can be used",
            Self::Word => "what the flash reads or writes at once is no divisor of 32 bytes",
            Self::Full => "the snapshot is longer than a bank",
            Self::GivenUp => "a part of the snapshot was not taken",
            Self::Worn => "what was written does not read back",
            Self::Missing => "that is not, or no longer, in the flash",
        })
    }
}

impl<E: fmt::Debug> core::error::Error for StoreError<E> {}
