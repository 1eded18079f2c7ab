//! Decoded instructions, and the functions of them.

use crate::memory::Space;
use crate::operation::Operation;

/// The index of a register in its function.
pub(crate) type Register = usize;

/// The source of an operand.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Operand {
    Register(Register),
    Value(u64),
    /// An offset in the memory of the function's own variables, bytes.
    Variable(u64),
    /// An offset in its own parameters and returned value, bytes.
    Parameter(u64),
    /// An offset in those of the function that it calls next, or called last, bytes.
    Outgoing(u64),
    /// Index of the thread in its block.
    Thread,
    /// Index of the block.
    Block,
    /// Number of threads of a block.
    BlockThreads,
}

/// A base and an offset.
pub(crate) type Address = (Operand, u64);

#[derive(Debug, Clone)]
pub(crate) enum Action {
    Compute {
        operation: Operation,
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
        operation: Operation,
        bytes: usize,
        to: Register,
        at: Address,
        of: Operand,
    },
    /// The guard is a register, and whether it must be true or false. `meet` is where the threads that take the branch and the others
    /// reconverge.
    Branch {
        guard: Option<(Register, bool)>,
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

/// Bytes of a parameter or of a returned value.
pub(crate) const SLOT: usize = 16;

/// A function that can be executed. Its returned value is in the first slot, its parameters in the others.
#[derive(Debug, Clone)]
pub(crate) struct Code {
    pub(crate) instructions: Vec<Instruction>,
    pub(crate) registers: usize,
    /// Bytes of its own variables.
    pub(crate) frame: usize,
    /// Number of its parameters.
    pub(crate) parameters: usize,
}
