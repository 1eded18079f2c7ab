//! The cost of a launch.

/// Counts of a launch. A warp executes an instruction once for all of its threads that are on the same path, and once for each
/// path after they have diverged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Number of instructions of all threads.
    pub instructions: u64,
    /// Number of instructions that warps have executed.
    pub warp_instructions: u64,
    /// Number of instructions of the warp with the most: a lower bound of the launch's time.
    pub longest_warp: u64,
    /// Number of loads and stores of buffers that warps have executed.
    pub accesses: u64,
    /// Number of sectors of 32 bytes that these accesses use: 4 for 32 threads that access consecutive numbers of 4 bytes.
    pub sectors: u64,
    /// Number of loads and stores of the threads' own memory that warps have executed.
    pub local_accesses: u64,
    /// Greatest number of bytes of its own memory that a thread has used.
    pub deepest_stack: usize,
}

impl Counts {
    /// Mean number of threads of a warp for which an instruction was executed.
    pub fn threads_together(&self) -> f64 {
        self.instructions as f64 / self.warp_instructions.max(1) as f64
    }

    /// The sum with the counts of a later launch. The longest warps run one after the other.
    pub fn and(self, next: Self) -> Self {
        Self {
            instructions: self.instructions + next.instructions,
            warp_instructions: self.warp_instructions + next.warp_instructions,
            longest_warp: self.longest_warp + next.longest_warp,
            accesses: self.accesses + next.accesses,
            sectors: self.sectors + next.sectors,
            local_accesses: self.local_accesses + next.local_accesses,
            deepest_stack: self.deepest_stack.max(next.deepest_stack),
        }
    }
}
