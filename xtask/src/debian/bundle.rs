//! Packages with the programs for a purpose.

/// Packages for a purpose.
#[derive(Debug, Clone, Copy)]
pub struct Bundle {
    /// Name of the folder to which they are unpacked.
    pub name: &'static str,
    /// Alternative sets of packages; the first set that is completely available is used.
    pub packages: &'static [&'static [&'static str]],
    /// Oldest suitable version of the first package.
    pub oldest: &'static str,
}
