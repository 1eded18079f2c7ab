//! Settings of an underwater vehicle with a stereo camera, and the order of its inputs.

pub mod models;
pub mod settings;
pub mod timeline;
#[cfg(test)]
mod worlds;
