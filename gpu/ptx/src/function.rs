//! A function or a kernel.

use crate::instruction::Instruction;
use crate::token::Token;

/// What is declared with a name and a size: a parameter or a variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Declared<'t> {
    pub(crate) name: &'t str,
    pub(crate) bytes: usize,
}

/// Parameters, and what is returned, lie at multiples of this.
const ALIGNMENT: usize = 16;

/// What a function takes, and before it what it returns.
#[derive(Debug, Clone, Default)]
pub(crate) struct Signature<'t> {
    pub(crate) returned: Vec<Declared<'t>>,
    pub(crate) taken: Vec<Declared<'t>>,
}

impl<'t> Signature<'t> {
    /// Where each of them lies, in this order.
    pub(crate) fn places(&self) -> impl Iterator<Item = (&'t str, usize)> + '_ {
        let all = self.returned.iter().chain(&self.taken);
        all.scan(0, |next, declared| {
            let place = *next;
            *next += aligned(declared.bytes);
            Some((declared.name, place))
        })
    }

    /// Bytes of all.
    pub(crate) fn bytes(&self) -> usize {
        self.returned.iter().chain(&self.taken).map(|declared| aligned(declared.bytes)).sum()
    }
}

pub(crate) fn aligned(bytes: usize) -> usize {
    bytes.next_multiple_of(ALIGNMENT)
}

/// The head of a function, and the tokens of its body.
#[derive(Debug, Clone)]
pub(crate) struct Header<'t> {
    pub(crate) name: &'t str,
    pub(crate) is_kernel: bool,
    pub(crate) signature: Signature<'t>,
    /// None where it is only announced.
    pub(crate) body: Option<&'t [Token<'t>]>,
}

/// A function that can be executed.
#[derive(Debug, Clone)]
pub(crate) struct Code {
    pub(crate) name: String,
    pub(crate) is_kernel: bool,
    pub(crate) instructions: Vec<Instruction>,
    /// How many registers it has.
    pub(crate) registers: usize,
    /// Bytes of its own variables.
    pub(crate) frame: usize,
    /// Bytes of its parameters and of what it returns.
    pub(crate) parameters: usize,
    /// Where the parameters of a kernel lie, and their bytes.
    pub(crate) taken: Vec<(usize, usize)>,
}
