//! Executes PTX on a host, for the subset that the compiler uses for scphd's kernels.
//!
//! [`Module::read`] reads the text of a module, [`Memory`] contains the buffers, and [`Module::launch`] runs a grid of threads
//! over them, in warps whose threads run together until they [diverge](Counts). Not modelled are physical registers and cycles,
//! which the text leaves to the device, and shared memory, which the kernels do not use. Unknown instructions are an error when the
//! module is read.
//!
//! Every access is checked, more strictly than on a device: it must lie within one buffer, be aligned to its size, and be in the
//! space that the instruction names. With [`Memory::watch`] it is also an error if two threads of a launch use the same byte and
//! one of them writes it.
//!
//! Meaning of the instructions: NVIDIA, Parallel Thread Execution ISA, version 9.0.
#![forbid(unsafe_code)]

mod decode;
mod errors;
mod flow;
mod instruction;
mod memory;
mod module;
mod operation;
mod warp;

pub use errors::{Counts, Fault, Grid, LaunchError, ReadError};
pub use memory::Memory;
pub use module::Module;
