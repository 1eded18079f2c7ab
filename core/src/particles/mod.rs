//! The parent process: particles and their samples.

pub(crate) mod candidate;
pub(crate) mod cursor;
pub(crate) mod predict;
pub(crate) mod propose;
pub(crate) mod resample;
pub(crate) mod select;
pub(crate) mod short;
