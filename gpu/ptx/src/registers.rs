//! Names of registers.

use crate::instruction::Register;
use std::collections::HashMap;

/// The registers that a function has declared.
#[derive(Debug, Default)]
pub(crate) struct Registers<'t> {
    /// `%r<5>`: those from `%r0` to `%r4`, by what is before the number.
    rows: HashMap<&'t str, (Register, u32)>,
    single: HashMap<&'t str, Register>,
    count: Register,
}

impl<'t> Registers<'t> {
    /// How many there are.
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
    fn rows_and_single_ones() {
        let mut registers = Registers::default();
        registers.declare("%SP");
        registers.declare_row("%r", 3);
        registers.declare_row("%rd", 2);
        let found = ["%SP", "%r0", "%r2", "%rd1", "%r3", "%p0", "tmp"].map(|name| registers.find(name));
        assert_eq!(found, [Some(0), Some(1), Some(3), Some(5), None, None, None]);
        // A name of an inner block takes the place of the one before.
        registers.declare("tmp");
        registers.declare("tmp");
        assert_eq!((registers.find("tmp"), registers.count()), (Some(7), 8));
    }
}
