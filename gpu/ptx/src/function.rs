//! A function or a kernel.

use crate::instruction::Instruction;
use crate::token::Token;

/// A declared parameter or variable: its name and its size.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Declared<'t> {
    pub(crate) name: &'t str,
    pub(crate) bytes: usize,
}

/// Alignment of parameters and returned values, bytes.
const ALIGNMENT: usize = 16;

/// The returned values and the parameters of a function, in this order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Signature<'t> {
    pub(crate) returned: Vec<Declared<'t>>,
    pub(crate) taken: Vec<Declared<'t>>,
}

impl<'t> Signature<'t> {
    /// The name and the offset of each, in this order.
    pub(crate) fn places(&self) -> impl Iterator<Item = (&'t str, usize)> + '_ {
        let all = self.returned.iter().chain(&self.taken);
        all.scan(0, |next, declared| {
            let place = *next;
            *next += aligned(declared.bytes);
            Some((declared.name, place))
        })
    }

    pub(crate) fn bytes(&self) -> usize {
        self.returned.iter().chain(&self.taken).map(|declared| aligned(declared.bytes)).sum()
    }
}

pub(crate) fn aligned(bytes: usize) -> usize {
    bytes.next_multiple_of(ALIGNMENT)
}

/// The header of a function, and the tokens of its body.
#[derive(Debug, Clone)]
pub(crate) struct Header<'t> {
    pub(crate) name: &'t str,
    pub(crate) is_kernel: bool,
    pub(crate) signature: Signature<'t>,
    /// `None` for a declaration without a body.
    pub(crate) body: Option<&'t [Token<'t>]>,
}

/// A function that can be executed.
#[derive(Debug, Clone)]
pub(crate) struct Code {
    pub(crate) name: String,
    pub(crate) is_kernel: bool,
    pub(crate) instructions: Vec<Instruction>,
    pub(crate) registers: usize,
    /// Bytes of its own variables.
    pub(crate) frame: usize,
    /// Bytes of its parameters and returned values.
    pub(crate) parameters: usize,
    /// Offset and bytes of each parameter of a kernel.
    pub(crate) taken: Vec<(usize, usize)>,
}
