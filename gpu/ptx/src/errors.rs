//! Why a module cannot be read or launched.

use crate::memory::AccessError;

/// Why a text is no module that can be executed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line} of the module: {what}")]
pub struct ReadError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong with it.
    pub what: String,
}

/// Why a launch has failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LaunchError {
    /// The module has no such kernel.
    #[error("no kernel {0}")]
    NoKernel(String),
    /// The kernel takes another number of them.
    #[error("the kernel takes {takes} arguments, not {given}")]
    Arguments {
        /// As many.
        takes: usize,
        /// Not so many.
        given: usize,
    },
    /// A grid without threads, or a warp of 0 or more than 32.
    #[error("a grid of {0:?}")]
    Grid(Grid),
    /// An access of a thread.
    #[error("line {line} of the module, thread {thread}: {error}")]
    Access {
        /// The line of the instruction.
        line: usize,
        /// The thread, from 0, over all blocks.
        thread: u32,
        /// What is wrong with it.
        error: AccessError,
    },
    /// A switch over more than there is.
    #[error("line {line} of the module: nowhere to go for {index}")]
    Switch {
        /// The line of the instruction.
        line: usize,
        /// What it was to switch by.
        index: u64,
    },
    /// Calls have gone deeper than a thread has memory for.
    #[error("line {line} of the module: calls go too deep")]
    TooDeep {
        /// The line of the call.
        line: usize,
    },
}

/// How many threads a launch is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// Number of blocks.
    pub blocks: u32,
    /// Threads of each.
    pub block: u32,
    /// Threads that go together, up to 32, as many as cards have. With one, nobody waits for anybody, and this host is done soonest.
    pub warp: u32,
}
