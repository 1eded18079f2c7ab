//! The filter as a ROS 2 node, in Rust only: the middleware is `ros2-client`, so that no ROS installation is needed.
//!
//! | file | |
//! |---|---|
//! | `parameters.rs`, `setup.rs` | parameter files and arguments, and their meaning |
//! | `describe.rs` | the wiring for a log |
//! | `memory.rs`, `maps.rs` | filters on the heap; map files |
//! | `engine.rs` | a filter behind a sequencer |
//! | `inputs.rs`, `outputs.rs` | messages as inputs, estimates as messages |
//! | `raw.rs`, `middleware.rs` | messages as bytes, topics and their qualities of service |
//! | `node.rs`, `services.rs`, `publish.rs` | the two programs |

pub mod describe;
pub mod engine;
pub mod inputs;
pub mod maps;
mod memory;
pub mod middleware;
pub mod node;
pub mod outputs;
pub mod parameters;
pub mod publish;
pub mod raw;
pub mod services;
pub mod setup;
