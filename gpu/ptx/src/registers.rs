//! Names of registers.

use crate::instruction::Register;
use std::collections::HashMap;

/// The registers that a function has declared.
#[derive(Debug, Default)]
pub(crate) struct Registers<'t> {
    /// Ranges such as `%r<5>`, from `%r0` to `%r4`, by the prefix before the number: first register, and length.
    rows: HashMap<&'t str, (Register, u32)>,
    single: HashMap<&'t str, Register>,
    count: Register,
}

impl<'t> Registers<'t> {
    pub(crate) fn count(&self) -> usize {
        self.count as usize
    }

    pub(crate) fn declare(&mut self, name: &'t str) {
        self.single.insert(name, self.count);
        self.count += 1;
    }

    pub(crate) fn declare_row(&mut self, name: &'t str, length: u32) {
        self.rows.insert(name, (self.count, length));
        self.count += length;
    }

    pub(crate) fn find(&self, name: &str) -> Option<Register> {
        if let Some(&register) = self.single.get(name) {
            return Some(register);
        }
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let &(first, length) = self.rows.get(stem)?;
        let number: u32 = name[stem.len()..].parse().ok()?;
        (number < length).then_some(first + number)
    }
}

#[cfg(test)]
mod tests {
    use super::Registers;

    #[test]
    fn ranges_and_single_registers() {
        let mut registers = Registers::default();
        registers.declare("%SP");
        registers.declare_row("%r", 3);
        registers.declare_row("%rd", 2);
        let found = ["%SP", "%r0", "%r2", "%rd1", "%r3", "%p0", "tmp"].map(|name| registers.find(name));
        assert_eq!(found, [Some(0), Some(1), Some(3), Some(5), None, None, None]);
        // A name in an inner block hides the earlier one.
        registers.declare("tmp");
        registers.declare("tmp");
        assert_eq!((registers.find("tmp"), registers.count()), (Some(7), 8));
    }
}
