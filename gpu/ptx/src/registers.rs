//! Names of registers.

use crate::instruction::Register;
use std::collections::HashMap;

/// The registers that a function has declared. A name in an inner block hides the earlier one.
#[derive(Debug, Default)]
pub(crate) struct Registers {
    all: HashMap<String, Register>,
    pub(crate) count: Register,
}

impl Registers {
    pub(crate) fn declare(&mut self, name: impl Into<String>) {
        self.all.insert(name.into(), self.count);
        self.count += 1;
    }

    pub(crate) fn find(&self, name: &str) -> Option<Register> {
        self.all.get(name).copied()
    }
}
