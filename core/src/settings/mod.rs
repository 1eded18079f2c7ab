//! The tuning of the filters.

pub(crate) mod config;
pub(crate) mod plausible;
pub(crate) mod proposal;

pub use crate::joint::{HypothesesConfig, Persistence};
pub use config::{Extraction, MovingConfig};
pub use plausible::Plausible;
pub use proposal::{Informed, Proposal};
