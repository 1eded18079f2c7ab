//! Instructions as they are executed.

use crate::arithmetic::Function;
use crate::memory::Space;

/// The number of a register in its function.
pub(crate) type Register = u32;

/// Where an operand comes from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Operand {
    Register(Register),
    Value(u64),
    /// So many bytes into the memory of the function's own variables.
    Frame(u32),
    Special(Special),
}

/// What a thread knows of its place.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Special {
    /// Its number in its block.
    Thread,
    /// The number of its block.
    Block,
    /// Threads of a block.
    BlockThreads,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Address {
    pub(crate) base: Operand,
    pub(crate) offset: u64,
}

/// A place among the parameters of a function.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Parameter {
    /// Its own, or what it returns.
    Own(usize),
    /// Those of the function that it calls next, or has called.
    Outgoing(usize),
}

/// Only threads take a branch for which the register holds, or does not.
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
    /// The lower half of so many bits, and the upper.
    Split {
        half: u32,
        to: [Option<Register>; 2],
        of: Operand,
    },
    Join {
        half: u32,
        to: Register,
        of: [Operand; 2],
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
    LoadParameter {
        bytes: usize,
        to: Box<[Option<Register>]>,
        from: Parameter,
    },
    StoreParameter {
        bytes: usize,
        of: Box<[Operand]>,
        to: Parameter,
    },
    /// A change that nobody comes between.
    Change {
        function: fn(u64, u64) -> u64,
        bytes: usize,
        to: Register,
        at: Address,
        of: Operand,
    },
    /// `meet` is where the threads that go on and those that do not come together again.
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
}

#[derive(Debug, Clone)]
pub(crate) struct Instruction {
    pub(crate) action: Action,
    /// Its line in the text.
    pub(crate) line: usize,
}
