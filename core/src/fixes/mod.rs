//! Fixes that are refused again and again: whether they are wrong, or the filter is.

mod heading_watch;
mod position_watch;
mod refused_way;
mod rule;
mod waited;

pub use heading_watch::HeadingWatch;
pub use position_watch::PositionWatch;
pub use rule::FixRule;
