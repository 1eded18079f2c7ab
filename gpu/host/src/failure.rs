//! Why a command fails.

#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// There is no driver, or it has found no device.
    #[error("no CUDA device: {0}; --device ptx interprets the module on this machine")]
    NoDevice(String),
    #[error("{0}")]
    Other(String),
}

impl Failure {
    /// Something was refused.
    pub fn of(doing: impl std::fmt::Display, why: impl std::fmt::Display) -> Self {
        Self::Other(format!("{doing}: {why}"))
    }
}
