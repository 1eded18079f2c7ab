//! Launches, what they cost, and why a module cannot be read or launched.

/// Why a text is no executable module.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line} of the module: {what}")]
pub struct ReadError {
    pub line: usize,
    pub what: String,
}

/// Why a launch has failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LaunchError {
    /// There is no such kernel with so many arguments, or the grid has no threads.
    #[error("no kernel {0} with {1} arguments for {2:?}")]
    Launch(String, usize, Grid),
    #[error("line {line} of the module, thread {thread}: {fault}")]
    Fault {
        line: usize,
        /// The thread, from 0, over all blocks.
        thread: u32,
        fault: Fault,
    },
}

/// Something invalid, with the address of an access, which a device might not report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    #[error("{0:#x} is not within a buffer")]
    Outside(u64),
    #[error("{0:#x} is not aligned")]
    Unaligned(u64),
    /// The instruction is for the other space.
    #[error("{0:#x} is not in the space that the instruction names")]
    Space(u64),
    /// Another thread has written there since the last barrier, or has read what this one writes.
    #[error("{0:#x} is used by two threads of a launch")]
    Race(u64),
    #[error("a switch leads nowhere")]
    Switch,
    #[error("not all threads of the warp reach the barrier together")]
    Barrier,
    /// Nested calls need more memory than a thread has.
    #[error("calls go too deep")]
    TooDeep,
}

/// The numbers of threads of a launch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    pub blocks: u32,
    /// Threads of a block, in warps of 32.
    pub block: u32,
}

/// Counts of a launch. A warp executes an instruction once for all of its threads that are on the same path, and once for each
/// path after they have diverged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Number of instructions that warps have executed.
    pub warp_instructions: u64,
    /// Number of instructions of the block with the most, in which warps wait for each other at barriers, and each barrier for the
    /// slowest: a lower bound of the launch's time. Of a block of one warp, that warp's.
    pub longest_warp: u64,
}

impl Counts {
    /// The sum with the counts of a later launch. The longest warps run one after the other.
    #[must_use]
    pub fn and(self, next: Self) -> Self {
        Self {
            warp_instructions: self.warp_instructions + next.warp_instructions,
            longest_warp: self.longest_warp + next.longest_warp,
        }
    }
}
