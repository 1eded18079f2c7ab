//! The measured cases: filters in worlds without an end, for the benches of time (`benches/time.rs`) and of instructions
//! (`benches/instructions.rs`), and for the figures and curves of `cargo xtask bench`.

pub mod cases;
pub mod figure;
mod rig;
mod world;

pub use rig::{Case, Rig};
pub use world::{Clutter, Course, Input, World};
