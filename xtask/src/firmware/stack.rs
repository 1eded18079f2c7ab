//! A bound of an image's stack depth for all inputs, from its code.

use super::image::Image;
use super::thumb::{Effect, decode};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use std::collections::BTreeMap;

/// The start of a program.
const ENTRY: &str = "Reset";
/// The only interrupt of the images.
const INTERRUPT: &str = "SysTick";
/// The exception frame that the processor pushes: 26 registers, and a word for alignment to eight bytes.
const INTERRUPT_FRAME: u32 = 4 * (26 + 1);

/// NOP, which compilers use as padding to a whole word.
const NO_OPERATION: u16 = 0xbf00;

#[derive(Debug, Default)]
struct Function {
    name: String,
    /// Sum of the stack use of its instructions, an upper bound, because not all of them may run.
    frame: u32,
    /// Targets of branches out of the function.
    callees: Vec<u32>,
    /// Reason why its frame or its callees are unknown.
    unknown: Option<&'static str>,
}

impl Image {
    /// Upper bound of the stack use of the deepest call chain, bytes, with an interrupt at its deepest point. An error if there
    /// is no bound: recursion, a call through a pointer, or a stack pointer that changes by a variable.
    pub fn stack_bound(&self) -> Result<u64, String> {
        let functions = self.functions()?;
        let deepest = |name: &str| {
            let found = functions.iter().find(|(_, function)| function.name == name);
            let (&address, _) = found.ok_or_else(|| format!("{} has no {name}", self.path.display()))?;
            depth(&functions, address, &mut BTreeMap::new())
        };
        Ok(u64::from(deepest(ENTRY)? + INTERRUPT_FRAME + deepest(INTERRUPT)?))
    }

    /// The functions of the image by address.
    fn functions(&self) -> Result<BTreeMap<u32, Function>, String> {
        let file = self.file()?;
        let text = file.sections().find(|section| section.kind() == SectionKind::Text && section.name() == Ok(".text"));
        let text = text.ok_or_else(|| format!("{} has no code", self.path.display()))?;
        let code = text.data().map_err(|error| error.to_string())?;
        let (start, end) = (text.address() as u32, (text.address() + text.size()) as u32);
        let mut places: BTreeMap<u32, (&str, u32)> = BTreeMap::new();
        // Addresses where data begins within the code, and where code continues.
        let mut is_code: BTreeMap<u32, bool> = BTreeMap::new();
        for symbol in file.symbols() {
            let (name, address) = (symbol.name().unwrap_or_default(), symbol.address() as u32 & !1);
            if !(start..end).contains(&address) {
                continue;
            }
            if name.starts_with("$t") || name.starts_with("$d") {
                is_code.insert(address, name.starts_with("$t"));
            } else if symbol.kind() == SymbolKind::Text {
                let place = places.entry(address).or_insert((name, 0));
                place.1 = place.1.max(symbol.size() as u32);
                if [ENTRY, INTERRUPT].contains(&name) {
                    place.0 = name;
                }
            }
        }
        let starts: Vec<u32> = places.keys().copied().collect();
        let half_word = |address: u32| -> u16 {
            let offset = (address - start) as usize;
            code.get(offset..offset + 2).map_or(0, |bytes| u16::from_le_bytes([bytes[0], bytes[1]]))
        };
        // A table of branches is aligned to words, and may be preceded by a NOP.
        let is_table = |address: u32| {
            let address = if half_word(address) == NO_OPERATION { address.next_multiple_of(4) } else { address };
            let (_, effect) = decode(address, half_word(address), half_word(address + 2));
            matches!(effect, Effect::GoesTo(_))
        };
        let mut functions = BTreeMap::new();
        for (&address, &(name, size)) in &places {
            // Functions in assembly have no size.
            let next = starts.get(starts.partition_point(|&other| other <= address)).copied().unwrap_or(end);
            let end = if size > 0 { address + size } else { next };
            let mut function =
                Function { name: format!("{:#}", rustc_demangle::demangle(name)), ..Function::default() };
            let mut place = address;
            while place < end {
                if is_code.range(..=place).next_back().is_some_and(|(_, &code)| !code) {
                    place += 2;
                    continue;
                }
                let (length, effect) = decode(place, half_word(place), half_word(place + 2));
                match effect {
                    Effect::None => {}
                    Effect::Takes(bytes) => function.frame += bytes,
                    Effect::GoesTo(target) if (address..end).contains(&target) => {}
                    Effect::GoesTo(target) => function.callees.push(target),
                    // The branches of the table are decoded like others.
                    Effect::GoesByTable if is_table(place + length) => {}
                    Effect::GoesByTable | Effect::GoesAnywhere => function.unknown = Some("calls through a pointer"),
                    Effect::SetsStack => function.unknown = Some("moves its stack by a variable"),
                }
                place += length;
            }
            functions.insert(address, function);
        }
        Ok(functions)
    }
}

/// Greatest stack depth of a function and its callees. `known` has the results so far, and `None` for the functions of the
/// present call chain.
fn depth(
    functions: &BTreeMap<u32, Function>,
    address: u32,
    known: &mut BTreeMap<u32, Option<u32>>,
) -> Result<u32, String> {
    // A branch into a function belongs to that function.
    let Some((&address, function)) = functions.range(..=address).next_back() else {
        return Err(format!("nothing at {address:#x}"));
    };
    match known.get(&address) {
        Some(Some(depth)) => return Ok(*depth),
        Some(None) => return Err(format!("{} calls itself", function.name)),
        None => {}
    }
    if let Some(reason) = function.unknown {
        return Err(format!("{} {reason}", function.name));
    }
    known.insert(address, None);
    let mut deepest = 0;
    for &callee in &function.callees {
        deepest = deepest.max(depth(functions, callee, known)?);
    }
    known.insert(address, Some(function.frame + deepest));
    Ok(function.frame + deepest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(frame: u32, callees: &[u32]) -> Function {
        Function { frame, callees: callees.to_vec(), ..Function::default() }
    }

    fn of(functions: Vec<(u32, Function)>) -> Result<u32, String> {
        depth(&functions.into_iter().collect(), 0, &mut BTreeMap::new())
    }

    #[test]
    fn the_deepest_chain_counts() {
        let functions = vec![
            (0, function(8, &[10, 20])),
            (10, function(100, &[])),
            (20, function(16, &[30, 10])),
            (30, function(90, &[])),
        ];
        assert_eq!(of(functions), Ok(8 + 16 + 100));
    }

    #[test]
    fn unbounded_stacks_are_errors() {
        assert!(of(vec![(0, function(8, &[10])), (10, function(8, &[0]))]).unwrap_err().contains("calls itself"));
        let pointer = Function { unknown: Some("calls through a pointer"), ..Function::default() };
        assert!(of(vec![(0, function(8, &[10])), (10, pointer)]).unwrap_err().contains("pointer"));
    }
}
