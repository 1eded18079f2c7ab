//! Decodes the body of a function into instructions. Names of parameters, returned values and registers are those that LLVM gives.

use crate::errors::ReadError;
use crate::flow::find_meetings;
use crate::instruction::{Action, Address, Code, Instruction, Operand, Register, SLOT};
use crate::memory::Space;
use crate::operation::Operation;
use std::collections::HashMap;

/// A word or a sign, and its line, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Token<'t> {
    pub(crate) text: &'t str,
    pub(crate) line: usize,
}

/// All tokens of a text, without comments.
pub(crate) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut all = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        let mut rest = text.split("//").next().unwrap_or_default().trim_start();
        while let Some(first) = rest.chars().next() {
            let word = rest.find(|c: char| !c.is_ascii_alphanumeric() && !"_$%.@!+-".contains(c)).unwrap_or(rest.len());
            let (text, after) = rest.split_at(word.max(first.len_utf8()));
            all.push(Token { text, line });
            rest = after.trim_start();
        }
    }
    all
}

/// The names that a body may refer to.
#[derive(Debug, Default)]
pub(crate) struct Names<'t> {
    /// Number of every function with a body.
    pub(crate) functions: HashMap<&'t str, usize>,
    /// Addresses of variables.
    pub(crate) variables: HashMap<&'t str, u64>,
}

struct Decoder<'n, 't> {
    names: &'n Names<'t>,
    registers: HashMap<&'t str, Register>,
    /// The function's own variables, which LLVM declares as one, and their bytes.
    depot: (&'t str, usize),
    labels: HashMap<&'t str, usize>,
    lists: HashMap<&'t str, Vec<&'t str>>,
    /// Targets of branches, by the number of the instruction.
    targets: Vec<(usize, &'t str)>,
    instructions: Vec<Instruction>,
    /// The line of the present statement.
    line: usize,
}

/// Decodes the tokens between the braces of a function.
pub(crate) fn decode<'t>(body: &[Token<'t>], parameters: usize, names: &Names<'t>) -> Result<Code, ReadError> {
    let (registers, depot, labels, lists, targets, instructions) = Default::default();
    let mut decoder = Decoder { names, registers, depot, labels, lists, targets, instructions, line: 0 };
    for statement in body.split(|token| token.text == ";") {
        decoder.statement(statement)?;
    }
    decoder.resolve()?;
    let Decoder { registers, depot: (_, frame), mut instructions, .. } = decoder;
    find_meetings(&mut instructions);
    Ok(Code { instructions, registers: registers.len(), frame: frame.next_multiple_of(SLOT), parameters })
}

/// The words among tokens.
pub(crate) fn words<'t>(tokens: &[Token<'t>]) -> Vec<&'t str> {
    tokens.iter().map(|token| token.text).filter(|text| !"{}()[],".contains(text)).collect()
}

impl<'t> Decoder<'_, 't> {
    /// Decodes one statement, with the brackets of blocks and the labels before it.
    fn statement(&mut self, mut tokens: &[Token<'t>]) -> Result<(), ReadError> {
        while let [first, rest @ ..] = tokens {
            let labels = rest.first().is_some_and(|token| token.text == ":");
            if labels && rest.get(1).is_some_and(|token| token.text == ".branchtargets") {
                self.lists.insert(first.text, words(&rest[2..]));
                return Ok(());
            } else if labels {
                self.labels.insert(first.text, self.instructions.len());
                tokens = &rest[1..];
            } else if "{}".contains(first.text) {
                tokens = rest;
            } else {
                break;
            }
        }
        let Some(first) = tokens.first() else { return Ok(()) };
        self.line = first.line;
        match words(tokens)[..] {
            // Other registers are those whose names begin so.
            [".reg", _, name] if !name.starts_with('%') => drop(self.register(name)),
            [".local", .., name, bytes] => {
                self.depot = (name, bytes.parse().map_err(|_| self.wrong(bytes))?);
            }
            [declaration, ..] if declaration.starts_with('.') => {}
            ref words => self.instruction(words, tokens.iter().position(|token| token.text == "{"))?,
        }
        Ok(())
    }

    fn wrong(&self, what: &str) -> ReadError {
        ReadError { line: self.line, what: format!("`{what}` is not known") }
    }

    /// Decodes an instruction from its words without signs, and the place of its brace.
    fn instruction(&mut self, words: &[&'t str], brace: Option<usize>) -> Result<(), ReadError> {
        let unknown = self.wrong(&words.join(" "));
        let (guard, words) = match *words {
            [guard, ref words @ ..] if guard.starts_with('@') => {
                let (name, holds) = guard[1..].strip_prefix('!').map_or((&guard[1..], true), |name| (name, false));
                (Some((self.register(name), holds)), words)
            }
            ref words => (None, words),
        };
        let [mnemonic, ref operands @ ..] = *words else { return Err(unknown) };
        let (name, kinds) = mnemonic.split_once('.').unwrap_or((mnemonic, ""));
        let action = match (name, operands) {
            ("bra", &[label]) => {
                self.targets.push((self.instructions.len(), label));
                Action::Branch { guard, to: 0, meet: 0 }
            }
            _ if guard.is_some() => return Err(unknown),
            ("brx", &[index, list]) => {
                self.targets.push((self.instructions.len(), list));
                Action::Switch { index: self.operand(index)?, to: Box::default(), meet: 0 }
            }
            ("ret", []) => Action::Return,
            ("bar" | "barrier", ["0"]) => Action::Barrier,
            ("call", operands) => {
                let callee = operands.iter().find_map(|word| self.names.functions.get(word));
                Action::Call { callee: *callee.ok_or(unknown)? }
            }
            ("ld" | "st", operands) => self.access(name == "ld", kinds, operands)?,
            ("atom", &[to, at, of]) => {
                let kept = kinds.split('.').filter(|part| !["global", "relaxed", "sys", "gpu"].contains(part));
                let operation = self.operation(&kept.collect::<Vec<_>>().join("."), 2)?;
                let (bytes, to, at) = (self.bytes(kinds)?, self.register(to), self.address(at)?);
                Action::Change { operation, bytes, to, at, of: self.operand(of)? }
            }
            // The lower half and the upper one, an instruction for each.
            ("mov", &[low, high, of]) if brace == Some(1) => {
                let (operation, of, bits) = (self.operation("bfe.u64", 3)?, self.operand(of)?, 4 * self.bytes(kinds)?);
                for (to, first) in [(low, 0), (high, bits)].into_iter().filter(|(to, _)| *to != "_") {
                    let of = [of, Operand::Value(first as u64), Operand::Value(bits as u64)];
                    let action = Action::Compute { operation, to: self.register(to), of };
                    self.instructions.push(Instruction { action, line: self.line });
                }
                return Ok(());
            }
            ("mov", &[to, low, high]) if brace.is_some() => {
                let above = Operand::Value(1 << (4 * self.bytes(kinds)?));
                let of = [self.operand(high)?, above, self.operand(low)?];
                Action::Compute { operation: self.operation("mad.lo.u64", 3)?, to: self.register(to), of }
            }
            (_, &[to, ref operands @ ..]) => {
                let operation = self.operation(mnemonic, operands.len())?;
                let mut of = [Operand::Value(0); 3];
                for (operand, word) in of.iter_mut().zip(operands) {
                    *operand = self.operand(word)?;
                }
                Action::Compute { operation, to: self.register(to), of }
            }
            _ => return Err(unknown),
        };
        self.instructions.push(Instruction { action, line: self.line });
        Ok(())
    }

    fn access(&mut self, loads: bool, kinds: &str, operands: &[&'t str]) -> Result<Action, ReadError> {
        let (mut space, mut count) = (Space::Any, 1);
        for part in kinds.split('.') {
            match part {
                "global" => space = Space::Global,
                "local" | "param" => space = Space::Local,
                "v2" => count = 2,
                "v4" => count = 4,
                // The threads of one host see all accesses in order.
                "nc" | "relaxed" | "volatile" | "weak" | "sys" | "gpu" | "cta" => {}
                _ if kinds.ends_with(part) => {}
                _ => return Err(self.wrong(kinds)),
            }
        }
        let bytes = self.bytes(kinds)?;
        if operands.len() != count + 1 {
            return Err(self.wrong(kinds));
        }
        if loads {
            let to = operands[..count].iter().map(|word| (*word != "_").then(|| self.register(word))).collect();
            return Ok(Action::Load { space, bytes, to, from: self.address(operands[count])? });
        }
        let of = operands[1..].iter().map(|word| self.operand(word)).collect::<Result<_, _>>()?;
        Ok(Action::Store { space, bytes, of, to: self.address(operands[0])? })
    }

    fn operation(&self, mnemonic: &str, operands: usize) -> Result<Operation, ReadError> {
        let found = Operation::of(mnemonic).filter(|operation| operation.operands == operands);
        found.ok_or_else(|| self.wrong(mnemonic))
    }

    /// Bytes of the type at the end of a mnemonic.
    fn bytes(&self, mnemonic: &str) -> Result<usize, ReadError> {
        let bits = mnemonic.rsplit('.').next().and_then(|kind| kind.strip_prefix(['b', 'u', 's', 'f'])?.parse().ok());
        bits.filter(|bits| [8, 16, 32, 64].contains(bits)).map(|bits| bits / 8).ok_or_else(|| self.wrong(mnemonic))
    }

    fn register(&mut self, name: &'t str) -> Register {
        let next = self.registers.len();
        *self.registers.entry(name).or_insert(next)
    }

    fn operand(&mut self, word: &'t str) -> Result<Operand, ReadError> {
        let numbered = |prefix: &str| word.rsplit_once(prefix)?.1.parse::<u64>().ok();
        Ok(match word {
            "%tid.x" => Operand::Thread,
            "%ctaid.x" => Operand::Block,
            "%ntid.x" => Operand::BlockThreads,
            "retval0" => Operand::Outgoing(0),
            "func_retval0" => Operand::Parameter(0),
            _ if word.starts_with('%') || self.registers.contains_key(word) => Operand::Register(self.register(word)),
            _ if word == self.depot.0 => Operand::Variable(0),
            _ => {
                let slot = |number: u64| (number + 1) * SLOT as u64;
                let value = value_of(word).or_else(|| self.names.variables.get(word).copied()).map(Operand::Value);
                let own = || numbered("_param_").map(|number| Operand::Parameter(slot(number)));
                let found = value.or_else(own).or_else(|| numbered("param").map(|of| Operand::Outgoing(slot(of))));
                found.ok_or_else(|| self.wrong(word))?
            }
        })
    }

    /// The address of a word such as `%rd1+8`.
    fn address(&mut self, word: &'t str) -> Result<Address, ReadError> {
        let (base, offset) = word.split_once('+').unwrap_or((word, "0"));
        let offset = value_of(offset).ok_or_else(|| self.wrong(word))?;
        Ok((self.operand(base)?, offset))
    }

    /// Finds the targets of branches.
    fn resolve(&mut self) -> Result<(), ReadError> {
        for &(number, name) in &self.targets {
            let Instruction { action, line } = &mut self.instructions[number];
            let find = |name: &str| {
                let found = self.labels.get(name).copied();
                found.ok_or_else(|| ReadError { line: *line, what: format!("no label `{name}`") })
            };
            match action {
                Action::Branch { to, .. } => *to = find(name)?,
                Action::Switch { to, .. } => {
                    let list = self.lists.get(name).into_iter().flatten();
                    *to = list.map(|label| find(label)).collect::<Result<_, _>>()?;
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// The value of a number: decimal, hexadecimal, or the bits of one in single precision.
fn value_of(word: &str) -> Option<u64> {
    let word = word.strip_suffix('U').unwrap_or(word);
    if let Some(digits) = word.strip_prefix("0f").or_else(|| word.strip_prefix("0x")) {
        return u64::from_str_radix(digits, 16).ok();
    }
    word.parse().ok().or_else(|| word.parse::<i64>().ok().map(i64::cast_unsigned))
}

#[cfg(test)]
mod tests {
    use super::value_of;

    #[test]
    fn numbers() {
        let found = ["42", "-2", "0x123U", "0f3F800000", "18446744073709551615", "%r1", "-"].map(value_of);
        assert_eq!(found, [Some(42), Some(u64::MAX - 1), Some(0x123), Some(0x3f80_0000), Some(u64::MAX), None, None]);
    }
}
