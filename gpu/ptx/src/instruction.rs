//! Decoded instructions.

use crate::arithmetic::Function;
use crate::memory::Space;

/// The index of a register in its function.
pub(crate) type Register = u32;

/// The source of an operand.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Operand {
    Register(Register),
    Value(u64),
    /// An offset in the memory of the function's own variables, bytes.
    Variable(u32),
    /// An offset in its own parameters and returned values, bytes.
    Parameter(u32),
    /// An offset in those of the function that it calls next, or called last, bytes.
    Outgoing(u32),
    Special(Special),
}

/// A register with the thread's position in the grid.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Special {
    /// Index of the thread in its block.
    Thread,
    /// Index of the block.
    Block,
    /// Number of threads of a block.
    BlockThreads,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Address {
    pub(crate) base: Operand,
    pub(crate) offset: u64,
}

/// The condition of a branch: whether the register must be true or false.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Guard {
    pub(crate) register: Register,
    pub(crate) holds: bool,
}

#[derive(Debug, Clone)]
pub(crate) enum Action {
    Compute {
        function: Function,
        to: Register,
        of: [Operand; 3],
    },
    Load {
        space: Space,
        bytes: usize,
        to: Box<[Option<Register>]>,
        from: Address,
    },
    Store {
        space: Space,
        bytes: usize,
        of: Box<[Operand]>,
        to: Address,
    },
    /// An atomic change.
    Change {
        function: fn(u64, u64) -> u64,
        bytes: usize,
        to: Register,
        at: Address,
        of: Operand,
    },
    /// `meet` is where the threads that take the branch and the others reconverge.
    Branch {
        guard: Option<Guard>,
        to: usize,
        meet: usize,
    },
    Switch {
        index: Operand,
        to: Box<[usize]>,
        meet: usize,
    },
    Call {
        callee: usize,
    },
    Return,
    /// Waits for all threads of the block.
    Barrier,
}

#[derive(Debug, Clone)]
pub(crate) struct Instruction {
    pub(crate) action: Action,
    /// Its line in the text.
    pub(crate) line: usize,
}
