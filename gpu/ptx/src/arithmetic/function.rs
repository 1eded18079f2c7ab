//! A function of registers.

/// A function by its number of operands.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Function {
    One(fn(u64) -> u64),
    Two(fn(u64, u64) -> u64),
    Three(fn(u64, u64, u64) -> u64),
}

/// The register value of a predicate: 0 or 1.
pub(super) fn predicate(holds: bool) -> u64 {
    u64::from(holds)
}
