//! The measured cases: filters in worlds without an end, for the bench of times (`benches/time.rs`) and for the program whose
//! instructions are counted (`src/bin/instructions.rs`). The program of `cargo xtask bench` is an example of `scphd-tests`, because
//! every program of this package is built for its benches.

pub mod cases;
mod rig;
mod world;

pub use rig::{Case, Rig};
pub use world::{Clutter, Course, Input, World};
