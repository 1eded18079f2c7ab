//! Decodes the tokens of a function's body into instructions.

use crate::arithmetic::{Function, function_of};
use crate::declared::{bytes_of, declared, matching};
use crate::errors::ReadError;
use crate::flow::find_meetings;
use crate::function::{Code, Declared, Header, Signature, aligned};
use crate::instruction::{Action, Address, Guard, Instruction, Operand, Register, Special};
use crate::memory::Space;
use crate::registers::Registers;
use crate::token::Token;
use std::collections::HashMap;

/// The names that a body may refer to.
pub(crate) struct Names<'a, 't> {
    /// Number and signature of every function.
    pub(crate) functions: &'a HashMap<&'t str, (usize, Signature<'t>)>,
    /// Addresses of variables.
    pub(crate) variables: &'a HashMap<&'t str, u64>,
}

struct Decoder<'a, 't> {
    names: &'a Names<'a, 't>,
    tokens: &'t [Token<'t>],
    at: usize,
    registers: Registers,
    own: HashMap<&'t str, usize>,
    outgoing: HashMap<&'t str, usize>,
    /// Offsets of the function's own variables.
    frame: HashMap<&'t str, u32>,
    frame_bytes: usize,
    labels: HashMap<&'t str, usize>,
    lists: HashMap<&'t str, Vec<&'t str>>,
    /// Targets of branches, by the number of the instruction.
    targets: Vec<(usize, &'t str)>,
    instructions: Vec<Instruction>,
}

pub(crate) fn decode<'t>(header: &Header<'t>, body: &'t [Token<'t>], names: &Names<'_, 't>) -> Result<Code, ReadError> {
    let mut decoder = Decoder {
        names,
        tokens: body,
        at: 0,
        registers: Registers::default(),
        own: header.signature.places().collect(),
        outgoing: HashMap::new(),
        frame: HashMap::new(),
        frame_bytes: 0,
        labels: HashMap::new(),
        lists: HashMap::new(),
        targets: Vec::new(),
        instructions: Vec::new(),
    };
    while decoder.at < body.len() {
        decoder.statement()?;
    }
    decoder.resolve()?;
    let returned = header.signature.returned.len();
    let places = header.signature.places().skip(returned).zip(&header.signature.taken);
    let taken = places.map(|((_, place), declared)| (place, declared.bytes)).collect();
    let mut instructions = decoder.instructions;
    find_meetings(&mut instructions);
    Ok(Code {
        name: header.name.to_owned(),
        is_kernel: header.is_kernel,
        instructions,
        registers: decoder.registers.count as usize,
        frame: aligned(decoder.frame_bytes),
        parameters: header.signature.bytes(),
        taken,
    })
}

impl<'t> Decoder<'_, 't> {
    fn peek(&self) -> &'t str {
        self.tokens.get(self.at).map_or("", |token| token.text)
    }

    fn next(&mut self) -> &'t str {
        let token = self.peek();
        self.at += 1;
        token
    }

    fn line(&self) -> usize {
        let at = self.at.min(self.tokens.len().saturating_sub(1));
        self.tokens.get(at).map_or(0, |token| token.line)
    }

    fn wrong(&self, what: impl Into<String>) -> ReadError {
        ReadError { line: self.line(), what: what.into() }
    }

    fn expect(&mut self, sign: &str) -> Result<(), ReadError> {
        if self.peek() != sign {
            return Err(self.wrong(format!("`{}` where `{sign}` is expected", self.peek())));
        }
        self.at += 1;
        Ok(())
    }

    /// Decodes one statement: a declaration, a label, an instruction, the beginning or the end of a block.
    fn statement(&mut self) -> Result<(), ReadError> {
        match self.peek() {
            "{" => {
                self.prepare_call()?;
                self.at += 1;
                Ok(())
            }
            "}" | ";" => {
                self.at += 1;
                Ok(())
            }
            ".reg" => self.declare_registers(),
            ".local" => self.declare_variable(),
            ".param" | ".pragma" | ".loc" => {
                self.skip_statement();
                Ok(())
            }
            name if self.tokens.get(self.at + 1).is_some_and(|token| token.text == ":") => {
                self.at += 2;
                if self.peek() == ".branchtargets" {
                    self.at += 1;
                    let list = self.words_until_semicolon();
                    self.lists.insert(name, list);
                } else {
                    self.labels.insert(name, self.instructions.len());
                }
                Ok(())
            }
            _ => self.instruction(),
        }
    }

    fn skip_statement(&mut self) {
        while self.at < self.tokens.len() && self.next() != ";" {}
    }

    /// The words of a list, up to its end.
    fn words_until_semicolon(&mut self) -> Vec<&'t str> {
        let mut words = Vec::new();
        while self.at < self.tokens.len() {
            match self.next() {
                ";" => break,
                "," => {}
                word => words.push(word),
            }
        }
        words
    }

    /// `.reg .b32 %r<5>;` or `.reg .b64 %SP, %SPL;`
    fn declare_registers(&mut self) -> Result<(), ReadError> {
        self.at += 2;
        loop {
            let name = self.next();
            if self.peek() == "<" {
                self.at += 1;
                let length = self.next();
                let length: u32 = length.parse().map_err(|_| self.wrong(format!("`{length}` registers")))?;
                self.expect(">")?;
                (0..length).for_each(|number| self.registers.declare(format!("{name}{number}")));
            } else {
                self.registers.declare(name);
            }
            match self.next() {
                "," => {}
                ";" => return Ok(()),
                sign => return Err(self.wrong(format!("`{sign}` after a register"))),
            }
        }
    }

    /// `.local .align 8 .b8 name[32];`
    fn declare_variable(&mut self) -> Result<(), ReadError> {
        let start = self.at;
        self.skip_statement();
        let Declared { name, bytes } = declared(&self.tokens[start..self.at - 1])?;
        self.frame.insert(name, self.frame_bytes as u32);
        self.frame_bytes = aligned(self.frame_bytes + bytes);
        Ok(())
    }

    /// Finds the parameters of the call in this block, if it contains one.
    fn prepare_call(&mut self) -> Result<(), ReadError> {
        let end = matching(self.tokens, self.at)?;
        let inner = &self.tokens[self.at + 1..end];
        let Some(call) = inner.iter().position(|token| token.text.split('.').next() == Some("call")) else {
            return Ok(());
        };
        let words: Vec<&str> =
            inner[call + 1..].iter().map(|token| token.text).take_while(|word| *word != ";").collect();
        let (groups, callee) = groups_of(&words);
        let callee = callee.ok_or_else(|| self.wrong("a call of nothing"))?;
        let names = self.names;
        let (_, signature) =
            names.functions.get(callee).ok_or_else(|| self.wrong(format!("no function `{callee}`")))?;
        let given: Vec<&str> = groups.concat();
        if given.len() != signature.returned.len() + signature.taken.len() {
            return Err(self.wrong(format!("{} parameters for `{callee}`", given.len())));
        }
        self.outgoing = given.into_iter().zip(signature.places().map(|(_, place)| place)).collect();
        Ok(())
    }

    fn instruction(&mut self) -> Result<(), ReadError> {
        let line = self.line();
        let mut mnemonic = self.next();
        let mut guard = None;
        if let Some(name) = mnemonic.strip_prefix('@') {
            let (name, holds) = name.strip_prefix('!').map_or((name, true), |name| (name, false));
            guard = Some(Guard { register: self.register_of(name)?, holds });
            mnemonic = self.next();
        }
        let (name, kinds) = mnemonic.split_once('.').unwrap_or((mnemonic, ""));
        let action = match name {
            "bra" => {
                let label = self.next();
                self.targets.push((self.instructions.len(), label));
                Action::Branch { guard, to: 0, meet: 0 }
            }
            _ if guard.is_some() => return Err(self.wrong(format!("`{mnemonic}` for some threads is not known"))),
            "brx" => {
                let index = self.operand()?;
                self.expect(",")?;
                let list = self.next();
                self.targets.push((self.instructions.len(), list));
                Action::Switch { index, to: Box::default(), meet: 0 }
            }
            "ret" => Action::Return,
            "bar" | "barrier" if self.peek() == "0" => {
                self.at += 1;
                Action::Barrier
            }
            "call" => {
                let words = self.words_until_semicolon();
                self.at -= 1;
                let callee = groups_of(&words).1.ok_or_else(|| self.wrong("a call of nothing"))?;
                let names = self.names;
                let (number, _) =
                    names.functions.get(callee).ok_or_else(|| self.wrong(format!("no function `{callee}`")))?;
                Action::Call { callee: *number }
            }
            "ld" | "st" => self.access(name == "ld", kinds)?,
            "atom" => self.change(kinds)?,
            "mov" if self.peek() == "{" => return self.split(kinds),
            "mov" if self.tokens.get(self.at + 2).is_some_and(|token| token.text == "{") => self.join(kinds)?,
            _ => self.compute(mnemonic)?,
        };
        self.expect(";")?;
        self.instructions.push(Instruction { action, line });
        Ok(())
    }

    fn compute(&mut self, mnemonic: &str) -> Result<Action, ReadError> {
        let function = function_of(mnemonic).ok_or_else(|| self.wrong(format!("`{mnemonic}` is not known")))?;
        let to = self.register()?;
        let operands = match function {
            Function::One(_) => 1,
            Function::Two(_) => 2,
            Function::Three(_) => 3,
        };
        let mut of = [Operand::Value(0); 3];
        for operand in &mut of[..operands] {
            self.expect(",")?;
            *operand = self.operand()?;
        }
        Ok(Action::Compute { function, to, of })
    }

    /// `mov.b64 {%r1, %r2}, %rd1`, an instruction for each half.
    fn split(&mut self, kinds: &str) -> Result<(), ReadError> {
        let (line, bytes) = (self.line(), self.bytes(kinds)?);
        let to = self.list(2, Self::register_or_none)?;
        self.expect(",")?;
        let value = self.operand()?;
        self.expect(";")?;
        let halves: [fn(u64) -> u64; 2] =
            if bytes == 8 { [|a| a & 0xffff_ffff, |a| a >> 32] } else { [|a| a & 0xffff, |a| a >> 16 & 0xffff] };
        for (half, to) in halves.into_iter().zip(to) {
            let action = |to| Action::Compute { function: Function::One(half), to, of: [value; 3] };
            self.instructions.extend(to.map(|to| Instruction { action: action(to), line }));
        }
        Ok(())
    }

    /// `mov.b64 %rd1, {%r1, %r2}`
    fn join(&mut self, kinds: &str) -> Result<Action, ReadError> {
        let join: fn(u64, u64) -> u64 = if self.bytes(kinds)? == 8 {
            |low, high| high << 32 | low & 0xffff_ffff
        } else {
            |low, high| (high & 0xffff) << 16 | low & 0xffff
        };
        let to = self.register()?;
        self.expect(",")?;
        let of = self.list(2, Self::operand)?;
        Ok(Action::Compute { function: Function::Two(join), to, of: [of[0], of[1], of[1]] })
    }

    fn access(&mut self, loads: bool, kinds: &str) -> Result<Action, ReadError> {
        let (mut space, mut count, mut kind) = (Space::Any, 1, "");
        for part in kinds.split('.') {
            match part {
                "global" => space = Space::Global,
                "local" | "param" => space = Space::Local,
                "v2" => count = 2,
                "v4" => count = 4,
                // The threads of one host see all accesses in order.
                "nc" | "relaxed" | "volatile" | "weak" | "sys" | "gpu" | "cta" => {}
                _ if kind.is_empty() => kind = part,
                _ => return Err(self.wrong(format!("`{kinds}` is not known"))),
            }
        }
        let bytes = self.bytes(kind)?;
        if loads {
            let to = self.list(count, Self::register_or_none)?;
            self.expect(",")?;
            return Ok(Action::Load { space, bytes, to, from: self.address()? });
        }
        let to = self.address()?;
        self.expect(",")?;
        Ok(Action::Store { space, bytes, of: self.list(count, Self::operand)?, to })
    }

    /// `atom.max.u32 %r1, [%rd1], %r2`
    fn change(&mut self, kinds: &str) -> Result<Action, ReadError> {
        let kept = kinds.split('.').filter(|part| !["global", "relaxed", "sys", "gpu"].contains(part));
        let mnemonic = kept.collect::<Vec<_>>().join(".");
        let bytes = self.bytes(mnemonic.rsplit('.').next().unwrap_or_default())?;
        let Some(Function::Two(function)) = function_of(&mnemonic) else {
            return Err(self.wrong(format!("`atom.{kinds}` is not known")));
        };
        let to = self.register()?;
        self.expect(",")?;
        let at = self.address()?;
        self.expect(",")?;
        Ok(Action::Change { function, bytes, to, at, of: self.operand()? })
    }

    /// One element, or a list of them in braces.
    fn list<V>(&mut self, count: usize, each: fn(&mut Self) -> Result<V, ReadError>) -> Result<Box<[V]>, ReadError> {
        if count == 1 {
            return Ok([each(self)?].into());
        }
        let mut all = Vec::with_capacity(count);
        for place in 0..count {
            self.expect(if place == 0 { "{" } else { "," })?;
            all.push(each(self)?);
        }
        self.expect("}")?;
        Ok(all.into())
    }

    fn bytes(&self, kind: &str) -> Result<usize, ReadError> {
        bytes_of(kind).ok_or_else(|| self.wrong(format!("`{kind}` is no type")))
    }

    fn register_of(&self, name: &str) -> Result<Register, ReadError> {
        self.registers.find(name).ok_or_else(|| self.wrong(format!("no register `{name}`")))
    }

    fn register(&mut self) -> Result<Register, ReadError> {
        let name = self.next();
        self.register_of(name)
    }

    fn register_or_none(&mut self) -> Result<Option<Register>, ReadError> {
        match self.next() {
            "_" => Ok(None),
            name => self.register_of(name).map(Some),
        }
    }

    fn operand(&mut self) -> Result<Operand, ReadError> {
        let name = self.next();
        let special = match name {
            "%tid.x" => Some(Special::Thread),
            "%ctaid.x" => Some(Special::Block),
            "%ntid.x" => Some(Special::BlockThreads),
            _ => None,
        };
        if let Some(special) = special {
            return Ok(Operand::Special(special));
        }
        if let Some(register) = self.registers.find(name) {
            return Ok(Operand::Register(register));
        }
        if let Some(value) = value_of(name) {
            return Ok(Operand::Value(value));
        }
        if let Some(&offset) = self.frame.get(name) {
            return Ok(Operand::Variable(offset));
        }
        if let Some(&place) = self.outgoing.get(name) {
            return Ok(Operand::Outgoing(place as u32));
        }
        if let Some(&place) = self.own.get(name) {
            return Ok(Operand::Parameter(place as u32));
        }
        let found = self.names.variables.get(name).copied().map(Operand::Value);
        found.ok_or_else(|| self.wrong(format!("`{name}` is no operand")))
    }

    /// `+8`, if it is there.
    fn offset(&mut self) -> Result<u64, ReadError> {
        if self.peek() != "+" {
            return Ok(0);
        }
        self.at += 1;
        let offset = self.next();
        value_of(offset).ok_or_else(|| self.wrong(format!("`{offset}` is no offset")))
    }

    fn address(&mut self) -> Result<Address, ReadError> {
        self.expect("[")?;
        let base = self.operand()?;
        let offset = self.offset()?;
        self.expect("]")?;
        Ok(Address { base, offset })
    }

    /// Finds the targets of branches.
    fn resolve(&mut self) -> Result<(), ReadError> {
        let labels = &self.labels;
        let find = |name: &str, line| {
            let found = labels.get(name).copied();
            found.ok_or_else(|| ReadError { line, what: format!("no label `{name}`") })
        };
        for &(number, name) in &self.targets {
            let Instruction { action, line, .. } = &mut self.instructions[number];
            match action {
                Action::Branch { to, .. } => *to = find(name, *line)?,
                Action::Switch { to, .. } => {
                    let list = self.lists.get(name);
                    let list = list.ok_or_else(|| ReadError { line: *line, what: format!("no list `{name}`") })?;
                    *to = list.iter().map(|label| find(label, *line)).collect::<Result<_, _>>()?;
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// The words in each pair of parentheses of a call, and the callee's name outside them.
fn groups_of<'t>(words: &[&'t str]) -> (Vec<Vec<&'t str>>, Option<&'t str>) {
    let (mut groups, mut callee, mut inside) = (Vec::new(), None, false);
    for &word in words {
        match word {
            "(" => {
                groups.push(Vec::new());
                inside = true;
            }
            ")" => inside = false,
            "," => {}
            word if inside => groups.last_mut().into_iter().for_each(|group: &mut Vec<_>| group.push(word)),
            word => callee = callee.or(Some(word)),
        }
    }
    (groups, callee)
}

/// The value of a number: decimal, hexadecimal, or the bits of one in single precision.
fn value_of(word: &str) -> Option<u64> {
    if let Some(bits) = word.strip_prefix("0f") {
        return u32::from_str_radix(bits, 16).ok().map(u64::from);
    }
    let word = word.strip_suffix('U').unwrap_or(word);
    if let Some(digits) = word.strip_prefix("0x") {
        return u64::from_str_radix(digits, 16).ok();
    }
    word.parse().ok().or_else(|| word.parse::<i64>().ok().map(|negative| negative as u64))
}

#[cfg(test)]
mod tests {
    use super::{groups_of, value_of};

    #[test]
    fn numbers() {
        let found = ["42", "-2", "0x123U", "0f3F800000", "18446744073709551615", "%r1", "-"].map(value_of);
        assert_eq!(found, [Some(42), Some(u64::MAX - 1), Some(0x123), Some(0x3f80_0000), Some(u64::MAX), None, None]);
    }

    #[test]
    fn calls() {
        let of = |text: &'static str| groups_of(&text.split(' ').collect::<Vec<_>>());
        assert_eq!(
            of("( retval0 ) , f , ( param0 , param1 )"),
            (vec![vec!["retval0"], vec!["param0", "param1"]], Some("f"))
        );
        assert_eq!(of("f , ( param0 )"), (vec![vec!["param0"]], Some("f")));
        assert_eq!(of("f"), (vec![], Some("f")));
    }
}
