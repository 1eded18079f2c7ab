//! Errors of the store.

use core::fmt;

/// Errors of the store. The newest snapshot is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StoreError<E> {
    /// An error of the flash.
    Flash(E),
    /// The range does not begin at a page, has less than a page for each bank, or ends beyond the flash.
    Range,
    /// The read or write size of the flash does not divide 32 bytes.
    Word,
    /// The snapshot is longer than a bank.
    Full,
    /// A part of the draft could not be written, so that it cannot be committed.
    GivenUp,
    /// The data read back differs from the data written: the flash is worn. The next draft uses another bank, if there are more
    /// than two.
    Worn,
    /// The requested data is not in the flash: the snapshot is shorter, or was overwritten.
    Missing,
}

impl<E: fmt::Debug> fmt::Display for StoreError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Flash(error) => return write!(f, "the flash returned an error: {error:?}"),
            Self::Range => "the flash range does not begin at a page, is too small, or is beyond the flash",
            Self::Word => "the read or write size of the flash does not divide 32 bytes",
            Self::Full => "the snapshot is longer than a bank",
            Self::GivenUp => "a part of the snapshot could not be written",
            Self::Worn => "the data read back differs from the data written",
            Self::Missing => "the requested data is not in the flash, or was overwritten",
        })
    }
}

impl<E: fmt::Debug> core::error::Error for StoreError<E> {}
