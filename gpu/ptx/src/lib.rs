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
//!
//! ```
//! use scphd_ptx::{Grid, Memory, Module};
//!
//! let text = "
//!     .version 7.0
//!     .target sm_80
//!     .address_size 64
//!     .visible .entry twice(.param .u64 twice_param_0)
//!     {
//!         .reg .b32 %r<3>;
//!         .reg .b64 %rd<4>;
//!         ld.param.b64 %rd1, [twice_param_0];
//!         mov.u32 %r1, %tid.x;
//!         mul.wide.u32 %rd2, %r1, 4;
//!         add.s64 %rd3, %rd1, %rd2;
//!         ld.global.b32 %r2, [%rd3];
//!         shl.b32 %r2, %r2, 1;
//!         st.global.b32 [%rd3], %r2;
//!         ret;
//!     }";
//! let mut memory = Memory::default();
//! let module = Module::read(text, &mut memory)?;
//! let numbers = memory.allocate(vec![1, 0, 0, 0, 21, 0, 0, 0]);
//! let counts = module.launch("twice", Grid { blocks: 1, block: 2 }, &[numbers], &mut memory)?;
//! assert_eq!(memory.bytes(numbers), [2, 0, 0, 0, 42, 0, 0, 0]);
//! assert_eq!((counts.warp_instructions, counts.instructions), (8, 16));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod decode;
mod errors;
mod flow;
mod instruction;
mod memory;
mod module;
mod operation;
mod races;
mod token;
mod warp;

pub use errors::{Counts, Fault, Grid, LaunchError, ReadError};
pub use memory::Memory;
pub use module::Module;
