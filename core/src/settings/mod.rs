//! What a user tunes.

pub(crate) mod config;
pub(crate) mod likelihood;
pub(crate) mod plausible;
pub(crate) mod proposal;
