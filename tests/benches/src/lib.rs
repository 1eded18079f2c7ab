//! The measured cases: filters in worlds without an end, for the benches of time (`benches/time.rs`) and of instructions
//! (`benches/instructions.rs`). The program of `cargo xtask bench` is an example of `scphd-tests`, because every program of this
//! package would be built for its benches.

pub mod cases;
mod rig;
mod world;

pub use rig::{Case, Rig};
pub use world::{Clutter, Course, Input, World};
