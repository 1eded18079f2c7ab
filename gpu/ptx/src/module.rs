//! A module, and its launches.

use crate::counts::Counts;
use crate::declared::{declared, matching};
use crate::decode::{Names, decode};
use crate::errors::{Grid, LaunchError, ReadError};
use crate::function::{Code, Declared, Header, Signature};
use crate::memory::Memory;
use crate::token::{Token, tokens};
use crate::warp::{Place, WIDTH, Warp};
use std::collections::HashMap;

/// A module that was read from a text.
#[derive(Debug, Clone)]
pub struct Module {
    functions: Vec<Code>,
    kernels: HashMap<String, usize>,
}

impl Module {
    /// Reads a text, and allocates its variables in the memory, which the launches must use.
    ///
    /// # Errors
    /// The text contains something unknown.
    pub fn read(text: &str, memory: &mut Memory) -> Result<Self, ReadError> {
        let tokens = tokens(text);
        let Parts { headers, variables } = parts(&tokens, memory)?;
        let mut functions: HashMap<&str, (usize, Signature<'_>)> = HashMap::new();
        let mut bodies = Vec::new();
        for header in &headers {
            if let Some(body) = header.body {
                functions.insert(header.name, (bodies.len(), header.signature.clone()));
                bodies.push((header, body));
            }
        }
        let names = Names { functions: &functions, variables: &variables };
        let decoded = bodies.into_iter().map(|(header, body)| decode(header, body, &names));
        let functions = decoded.collect::<Result<Vec<_>, _>>()?;
        let kernels = functions.iter().enumerate().filter(|(_, code)| code.is_kernel);
        let kernels = kernels.map(|(number, code)| (code.name.clone(), number)).collect();
        Ok(Self { functions, kernels })
    }

    /// The names of the kernels, sorted.
    pub fn kernels(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.kernels.keys().map(String::as_str).collect();
        names.sort_unstable();
        names
    }

    /// Runs a kernel with these arguments, each in the lowest bits of a number: all threads of a grid, warp by warp, in order.
    ///
    /// # Errors
    /// There is no such kernel with these arguments, or a thread has done something invalid.
    pub fn launch(
        &self,
        kernel: &str,
        grid: Grid,
        arguments: &[u64],
        memory: &mut Memory,
    ) -> Result<Counts, LaunchError> {
        let Grid { blocks, block } = grid;
        let number = self.kernels.get(kernel).copied();
        let number = number.filter(|&number| self.functions[number].taken.len() == arguments.len());
        let number = number.filter(|_| blocks.checked_mul(block).is_some_and(|threads| threads > 0));
        let number = number.ok_or_else(|| LaunchError::Launch(kernel.to_owned(), arguments.len(), grid))?;
        memory.begin_launch();
        let mut counts = Counts::default();
        for block_number in 0..blocks {
            let of_first = |first| Place { block: block_number, block_threads: block, first };
            let warps = (0..block).step_by(WIDTH);
            let mut warps: Vec<_> =
                warps.map(|first| Warp::new(&self.functions, number, of_first(first), arguments)).collect();
            let (mut longest, mut waiting) = (0, true);
            while waiting {
                // From one barrier to the next, or to the end.
                let (mut slowest, mut wait) = (0, false);
                for warp in &mut warps {
                    let before = warp.counts.warp_instructions;
                    wait |= warp.run(memory)?;
                    slowest = slowest.max(warp.counts.warp_instructions - before);
                }
                longest += slowest;
                waiting = wait;
                if waiting {
                    memory.begin_launch();
                }
            }
            let longest_warp = counts.longest_warp.max(longest);
            counts = warps.iter().fold(counts, |counts, warp| counts.and(warp.counts));
            counts.longest_warp = longest_warp;
        }
        Ok(counts)
    }
}

/// The functions and variables of a text.
struct Parts<'t> {
    headers: Vec<Header<'t>>,
    variables: HashMap<&'t str, u64>,
}

fn parts<'t>(tokens: &'t [Token<'t>], memory: &mut Memory) -> Result<Parts<'t>, ReadError> {
    let mut found = Parts { headers: Vec::new(), variables: HashMap::new() };
    let mut at = 0;
    while let Some(&Token { text, line }) = tokens.get(at) {
        match text {
            ".version" | ".target" | ".address_size" => at += 2,
            ".visible" | ".weak" | ".extern" | "," => at += 1,
            ".func" | ".entry" => {
                let (header, end) = header(tokens, at, text == ".entry")?;
                found.headers.push(header);
                at = end;
            }
            ".global" | ".const" => {
                let length = tokens[at..].iter().position(|token| token.text == ";");
                let length = length.ok_or_else(|| ReadError { line, what: "no end".into() })?;
                let (name, bytes) = variable(&tokens[at..at + length])?;
                found.variables.insert(name, memory.allocate(&bytes));
                at += length + 1;
            }
            _ => return Err(ReadError { line, what: format!("`{text}` is not known") }),
        }
    }
    Ok(found)
}

/// A function from its name to its end, and the position after it.
fn header<'t>(tokens: &'t [Token<'t>], at: usize, is_kernel: bool) -> Result<(Header<'t>, usize), ReadError> {
    let line = tokens[at].line;
    let wrong = |what: &str| ReadError { line, what: what.to_owned() };
    let sign = |at: usize| tokens.get(at).map_or("", |token| token.text);
    let mut next = at + 1;
    let mut signature = Signature::default();
    if sign(next) == "(" {
        let end = matching(tokens, next)?;
        signature.returned = all_declared(&tokens[next + 1..end])?;
        next = end + 1;
    }
    let name = tokens.get(next).ok_or_else(|| wrong("a function without a name"))?.text;
    next += 1;
    if sign(next) == "(" {
        let end = matching(tokens, next)?;
        signature.taken = all_declared(&tokens[next + 1..end])?;
        next = end + 1;
    }
    // Attributes such as `.noreturn`.
    while sign(next).starts_with('.') {
        next += 1;
    }
    let (body, end) = match sign(next) {
        ";" => (None, next + 1),
        "{" => {
            let end = matching(tokens, next)?;
            (Some(&tokens[next + 1..end]), end + 1)
        }
        _ => return Err(wrong("a function without a body")),
    };
    Ok((Header { name, is_kernel, signature, body }, end))
}

fn all_declared<'t>(tokens: &'t [Token<'t>]) -> Result<Vec<Declared<'t>>, ReadError> {
    tokens.split(|token| token.text == ",").filter(|part| !part.is_empty()).map(declared).collect()
}

/// A variable of the module: its name and its bytes.
fn variable<'t>(tokens: &'t [Token<'t>]) -> Result<(&'t str, Vec<u8>), ReadError> {
    let Declared { name, bytes } = declared(tokens)?;
    let mut value = vec![0; bytes];
    let given = tokens.iter().position(|token| token.text == "=").map_or(&[][..], |sign| &tokens[sign + 1..]);
    let numbers = given.iter().filter(|token| !["{", "}", ","].contains(&token.text));
    for (place, token) in numbers.enumerate() {
        let number = token.text.parse::<u8>().ok();
        match (value.get_mut(place), number) {
            (Some(byte), Some(number)) => *byte = number,
            _ => return Err(ReadError { line: token.line, what: format!("`{}` is no byte of {name}", token.text) }),
        }
    }
    Ok((name, value))
}
