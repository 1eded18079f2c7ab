//! The filter as a node of ROS 2, in Rust alone: the middleware is `ros2-client`, so that no ROS has to be installed.
//!
//! | file | |
//! |---|---|
//! | `parameters.rs`, `setup.rs` | files and words of parameters, and what they say |
//! | `describe.rs` | the topics of a log |
//! | `memory.rs`, `maps.rs` | filters on the heap; maps of earlier drives |
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
