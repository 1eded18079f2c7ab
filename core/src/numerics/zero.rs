//! Types with an all-zero constant.

use core::fmt::Debug;

/// A type with an all-zero constant.
pub trait Zero: Copy + PartialEq + Debug + Send + Sync + 'static {
    /// All zero.
    const ZERO: Self;
}

impl<X: Zero, const N: usize> Zero for [X; N] {
    const ZERO: Self = [X::ZERO; N];
}
