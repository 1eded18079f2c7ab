//! Why a module cannot be read or launched.

use crate::memory::AccessError;

/// Why a text is no executable module.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line} of the module: {what}")]
pub struct ReadError {
    /// The line, from 1.
    pub line: usize,
    /// The reason.
    pub what: String,
}

/// Why a launch has failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LaunchError {
    /// The module has no such kernel.
    #[error("no kernel {0}")]
    NoKernel(String),
    /// The number of arguments is wrong.
    #[error("the kernel takes {takes} arguments, not {given}")]
    Arguments {
        /// Number of arguments that the kernel takes.
        takes: usize,
        /// Number of arguments that were given.
        given: usize,
    },
    /// A grid without threads, or a warp of 0 or more than 32.
    #[error("a grid of {0:?}")]
    Grid(Grid),
    /// An invalid access of a thread.
    #[error("line {line} of the module, thread {thread}: {error}")]
    Access {
        /// The line of the instruction.
        line: usize,
        /// The thread, from 0, over all blocks.
        thread: u32,
        /// The reason.
        error: AccessError,
    },
    /// The index of a switch is beyond its list of targets.
    #[error("line {line} of the module: nowhere to go for {index}")]
    Switch {
        /// The line of the instruction.
        line: usize,
        /// The index.
        index: u64,
    },
    /// Nested calls need more memory than a thread has.
    #[error("line {line} of the module: calls go too deep")]
    TooDeep {
        /// The line of the call.
        line: usize,
    },
}

/// The numbers of threads of a launch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// Number of blocks.
    pub blocks: u32,
    /// Threads of a block.
    pub block: u32,
    /// Threads of a warp, up to 32, as on cards. With 1, no thread waits for another, and the host is fastest.
    pub warp: u32,
}
