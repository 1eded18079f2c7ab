//! Error of a tuning.

/// A field of the [`Config`](crate::Config) is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[error("{field} must be {range}")]
pub struct ConfigError {
    /// Name of the field.
    pub field: &'static str,
    /// Its valid range.
    pub range: &'static str,
}
