//! What can be all zero in a constant.

use core::fmt::Debug;

/// What can be all zero, in a constant.
pub trait Zero: Copy + PartialEq + Debug + Send + Sync + 'static {
    /// All zero.
    const ZERO: Self;
}

impl<X: Zero, const N: usize> Zero for [X; N] {
    const ZERO: Self = [X::ZERO; N];
}
