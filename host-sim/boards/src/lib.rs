//! What boards are fed with: streams of a log, and hardware in the loop.

pub mod hil;
pub mod stream;
