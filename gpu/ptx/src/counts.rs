//! What a launch has taken.

/// Counts of a launch. A warp executes an instruction once for all of its threads that have come to it together; where their ways have
/// parted, once for each way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Instructions of all threads.
    pub instructions: u64,
    /// Instructions that warps have executed.
    pub warp_instructions: u64,
    /// Those of the warp with the most: the launch takes no less than their time.
    pub longest_warp: u64,
    /// Loads and stores of buffers that warps have executed.
    pub accesses: u64,
    /// Sectors of 32 bytes that these have touched: an access of 32 threads to neighbouring numbers of 4 bytes is 4 of them.
    pub sectors: u64,
    /// Loads and stores of the threads' own memory that warps have executed.
    pub local_accesses: u64,
    /// The most bytes of its own memory that a thread has used.
    pub deepest_stack: usize,
}

impl Counts {
    /// Threads of a warp that an instruction has been executed for, in the mean.
    #[must_use]
    pub fn threads_together(&self) -> f64 {
        self.instructions as f64 / self.warp_instructions.max(1) as f64
    }

    /// With those of another launch, after this one: the longest warps come one after the other.
    #[must_use]
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
