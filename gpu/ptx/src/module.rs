//! A module, and its launches.

use crate::decode::{Names, Token, decode, tokens, words};
use crate::errors::{Counts, Grid, LaunchError, ReadError};
use crate::instruction::{Code, SLOT};
use crate::memory::Memory;
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
        let (mut names, mut bodies, mut kernels) = (Names::default(), Vec::new(), HashMap::new());
        let mut rest = &tokens[..];
        while let Some(&Token { text, line }) = rest.first() {
            let until = |signs: &str| {
                let end = rest.iter().position(|token| signs.contains(token.text));
                end.ok_or_else(|| ReadError { line, what: "no end".into() })
            };
            let taken = match text {
                ".version" | ".target" | ".address_size" => 2,
                ".visible" | ".weak" | ".extern" | ";" => 1,
                ".global" | ".const" => {
                    let end = until(";")?;
                    let (name, bytes) = variable(&rest[..end])?;
                    names.variables.insert(name, memory.allocate(bytes));
                    end
                }
                ".func" | ".entry" => {
                    let start = until(";{")?;
                    let end = start + length(&rest[start..]);
                    let (name, parameters) = header(&rest[..start])?;
                    if end > start {
                        if text == ".entry" {
                            kernels.insert(name.to_owned(), bodies.len());
                        }
                        names.functions.insert(name, bodies.len());
                        bodies.push((&rest[start..end], parameters));
                    }
                    end
                }
                _ => return Err(ReadError { line, what: format!("`{text}` is not known") }),
            };
            rest = rest.get(taken..).unwrap_or(&[]);
        }
        let functions = bodies.into_iter().map(|(body, parameters)| decode(body, parameters, &names));
        Ok(Self { functions: functions.collect::<Result<_, _>>()?, kernels })
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
        let number = number.filter(|&number| self.functions[number].parameters == arguments.len());
        let number = number.filter(|_| blocks.checked_mul(block).is_some_and(|threads| threads > 0));
        let number = number.ok_or_else(|| LaunchError::Launch(kernel.to_owned(), arguments.len(), grid))?;
        memory.begin_launch();
        let mut counts = Counts::default();
        for at in 0..blocks {
            let warp =
                |first| Warp::new(&self.functions, number, Place { block: at, block_threads: block, first }, arguments);
            let mut warps: Vec<_> = (0..block).step_by(WIDTH).map(warp).collect();
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

/// Number of tokens of a block in braces; 0 if it does not begin here.
fn length(tokens: &[Token<'_>]) -> usize {
    let mut depth = 0;
    let inside = tokens.iter().take_while(|token| {
        depth += usize::from(token.text == "{");
        let inside = depth > 0;
        depth -= usize::from(inside && token.text == "}");
        inside
    });
    inside.count()
}

/// The name and the number of parameters of a function.
fn header<'t>(tokens: &[Token<'t>]) -> Result<(&'t str, usize), ReadError> {
    let wrong = |what: &str| ReadError { line: tokens[0].line, what: what.to_owned() };
    let mut sizes = tokens.windows(2).filter(|pair| pair[0].text == "[").map(|pair| pair[1].text.parse::<usize>());
    if !sizes.all(|size| size.is_ok_and(|size| size <= SLOT)) {
        return Err(wrong("a parameter is too large"));
    }
    // The returned value is in parentheses before the name.
    let returned = tokens.iter().position(|token| token.text == ")").filter(|_| tokens[1].text == "(");
    let mut words = words(&tokens[returned.unwrap_or(0) + 1..]).into_iter();
    let name = words.next().ok_or_else(|| wrong("a function without a name"))?;
    Ok((name, words.filter(|word| *word == ".param").count()))
}

/// A variable of the module, such as `.global .align 4 .b8 name[4] = {1, 2}`: its name and its bytes.
fn variable<'t>(tokens: &[Token<'t>]) -> Result<(&'t str, Vec<u8>), ReadError> {
    let wrong = |what: &str| ReadError { line: tokens[0].line, what: what.to_owned() };
    let [_, ".align", _, ".b8", name, count, ref given @ ..] = words(tokens)[..] else {
        return Err(wrong("no bytes with a name"));
    };
    let count = count.parse().map_err(|_| wrong("no number of bytes"))?;
    let given = given.iter().skip(1).map(|byte| byte.parse());
    let mut value: Vec<u8> = given.collect::<Result<_, _>>().map_err(|_| wrong("no bytes"))?;
    value.resize(count, 0);
    Ok((name, value))
}
