//! Errors of the store.

/// Errors of the store. The newest snapshot is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StoreError<E> {
    /// An error of the flash.
    #[error("the flash returned an error: {0:?}")]
    Flash(E),
    /// The range does not begin at a page, has less than a page for each bank, or ends beyond the flash.
    #[error("the flash range does not begin at a page, is too small, or is beyond the flash")]
    Range,
    /// The read or write size of the flash does not divide 32 bytes.
    #[error("the read or write size of the flash does not divide 32 bytes")]
    Word,
    /// The snapshot is longer than a bank.
    #[error("the snapshot is longer than a bank")]
    Full,
    /// A part of the draft could not be written, so that it cannot be committed.
    #[error("a part of the snapshot could not be written")]
    GivenUp,
    /// The data read back differs from the data written: the flash is worn. The next draft uses another bank, if there are more
    /// than two.
    #[error("the data read back differs from the data written")]
    Worn,
    /// The requested data is not in the flash: the snapshot is shorter, or was overwritten.
    #[error("the requested data is not in the flash, or was overwritten")]
    Missing,
}
