//! Inputs of boards: streams of logs, and hardware in the loop.

pub mod hil;
pub mod stream;
