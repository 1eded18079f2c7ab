//! The cost of a launch.

/// Counts of a launch. A warp executes an instruction once for all of its threads that are on the same path, and once for each
/// path after they have diverged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Number of instructions of all threads.
    pub instructions: u64,
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
            instructions: self.instructions + next.instructions,
            warp_instructions: self.warp_instructions + next.warp_instructions,
            longest_warp: self.longest_warp + next.longest_warp,
        }
    }
}
