//! Reports of fixes, and monitors of fixes that are rejected repeatedly: are the fixes wrong, or has the filter diverged?

mod heading_watch;
mod position_watch;
mod refused_way;
mod rule;
mod waited;

pub use crate::filter::observe::FixReport;
pub use heading_watch::HeadingWatch;
pub use position_watch::PositionWatch;
pub use rule::FixRule;
