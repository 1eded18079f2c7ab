//! What an underwater vehicle with a stereo camera is tuned with, and what its computer is told when.

pub mod models;
pub mod settings;
pub mod timeline;
#[cfg(test)]
mod worlds;
