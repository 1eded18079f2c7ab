//! NVIDIA's assembler: registers and memory of each kernel, and modules for certain architectures.

use crate::outcome::Missing;
use crate::process;
use crate::python::Environment;
use std::path::{Path, PathBuf};

/// The package with the assembler, without other parts of the compiler.
const PACKAGE: [&str; 1] = ["nvidia-cuda-nvcc>=13.0,<14"];
/// Path of the assembler among the packages.
const PLACE: &str = "nvidia/cu13/bin/ptxas";
/// Architectures for which modules are assembled: Ampere and Hopper for data centres.
const CARDS: [&str; 2] = ["sm_80", "sm_90"];

/// What the assembler counts for each thread of a kernel and its callees: the greatest figure allowed, which is 1.2 times what it
/// counted when this was set, except for registers, where it is the limit of a thread. Spilled registers are counted in the code of all functions,
/// shared memory is that of a block, and constants are those with arguments, if the assembler reports them.
const LIMITS: [(u64, &str); 6] = [
    (255, "registers"),
    (4_690, "bytes of stack"),
    (3_600, "bytes of spill stores"),
    (7_640, "bytes of spill loads"),
    (0, "bytes of shared memory"),
    (1_660, "bytes of constants"),
];

/// Greatest usage of any kernel of a module, in the order of [`LIMITS`].
type Usage = [u64; LIMITS.len()];

pub struct Ptxas {
    program: PathBuf,
    version: String,
}

impl Ptxas {
    /// The assembler in the project's Python environment, which is created if necessary.
    pub fn obtain() -> Result<Self, Missing> {
        let environment = Environment::obtain()?;
        environment.equip_alone(&PACKAGE)?;
        let program = environment.packages().map_err(Missing)?.join(PLACE);
        let said = process::read(process::command(&program).arg("--version")).map_err(Missing)?;
        let version = said.lines().find_map(|line| line.split("release ").nth(1)).unwrap_or("of no known release");
        Ok(Self { version: version.to_owned(), program })
    }

    /// Assembles the module for each architecture. Returns the usage in a line; fails if it is above the limits.
    pub fn assemble(&self, module: &Path, folder: &Path) -> Result<String, String> {
        println!("ptxas {}", self.version);
        let mut all = Vec::new();
        for card in CARDS {
            let mut command = process::command(&self.program);
            command.args(["--verbose", "--fmad", "false", "--gpu-name", card, "--output-file"]);
            command.arg(folder.join(format!("scphd-{card}.cubin"))).arg(module);
            let output = command.output().map_err(|error| format!("{}: {error}", self.program.display()))?;
            let said = String::from_utf8_lossy(&output.stderr);
            if !output.status.success() {
                return Err(format!("ptxas for {card}: {said}"));
            }
            let usage = usage_of(&said).map_err(|reason| format!("ptxas for {card}: {reason}: {said}"))?;
            let line = shown(&usage);
            println!("{card}: {line}");
            for (name, registers, stack) in kernels(&said) {
                println!("  {name}: {registers} registers, {stack} bytes of stack");
            }
            if let Some(beyond) = beyond(&usage) {
                return Err(format!("{card}: the module takes more than it may: {beyond}"));
            }
            all.push(format!("{card}: {line}"));
        }
        Ok(all.join("; "))
    }
}

fn shown(usage: &Usage) -> String {
    let figures = LIMITS.iter().zip(usage).map(|((_, name), used)| format!("{used} {name}"));
    figures.collect::<Vec<_>>().join(", ")
}

/// The first figure above its limit.
fn beyond(usage: &Usage) -> Option<String> {
    let ((limit, name), used) = LIMITS.iter().zip(usage).find(|((limit, _), used)| *used > limit)?;
    Some(format!("{used} {name}, of {limit}"))
}

/// Name, registers and bytes of stack of each kernel for each thread, its callees included, from the assembler's output.
fn kernels(said: &str) -> Vec<(&str, u64, u64)> {
    let mut all: Vec<(&str, u64, u64)> = Vec::new();
    for line in said.lines() {
        if let Some(name) = line.split("entry function '").nth(1).and_then(|rest| rest.split('\'').next()) {
            all.push((name, 0, 0));
        } else if let Some((_, registers @ 0, stack)) = all.last_mut()
            && line.contains("Used ")
        {
            (*registers, *stack) = (number(line, "registers"), number(line, "bytes cumulative stack size"));
        }
    }
    all
}

/// The number before these words of a line; 0 if they are missing.
fn number(line: &str, after: &str) -> u64 {
    let part = line.split(',').find_map(|part| part.trim().strip_suffix(after));
    part.and_then(|part| part.split_whitespace().last()?.parse().ok()).unwrap_or(0)
}

/// Usage of a module, from the assembler's output: the maximum over kernels, and the sum of spills over functions.
fn usage_of(said: &str) -> Result<Usage, &'static str> {
    if said.contains("cannot be statically determined") {
        return Err("the stack of a kernel is not known");
    }
    let [mut registers, mut stack, mut spill_stores, mut spill_loads, mut shared, mut constant] = [0; LIMITS.len()];
    for line in said.lines() {
        let number = |after: &str| number(line, after);
        registers = number("registers").max(registers);
        stack = number("bytes cumulative stack size").max(number("bytes stack frame")).max(stack);
        spill_stores += number("bytes spill stores");
        spill_loads += number("bytes spill loads");
        shared = number("bytes smem").max(shared);
        // Arguments and constants are in different banks.
        constant = (number("bytes cmem[0]") + number("bytes cmem[2]")).max(constant);
    }
    if registers == 0 {
        return Err("it says nothing of a kernel");
    }
    Ok([registers, stack, spill_stores, spill_loads, shared, constant])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAID: &str = "\
ptxas info    : 1609 bytes gmem
ptxas info    : Compiling entry function 'scphd_runs' for 'sm_80'
ptxas info    : Function properties for scphd_runs
    7824 bytes stack frame, 20 bytes spill stores, 8 bytes spill loads
ptxas info    : Used 255 registers, used 0 barriers, 7824 bytes cumulative stack size, 64 bytes smem, 440 bytes cmem[0], 664 bytes cmem[2]
ptxas info    : Function properties for _RNvNtCs3run5scans
    0 bytes stack frame, 1914 bytes spill stores, 2004 bytes spill loads
";

    #[test]
    fn the_output_of_the_assembler_is_parsed() {
        assert_eq!(usage_of(SAID), Ok([255, 7824, 1934, 2012, 64, 1104]));
        assert_eq!(kernels(SAID), [("scphd_runs", 255, 7824)]);
        assert!(usage_of("ptxas info    : 1609 bytes gmem").is_err());
        let unknown = "ptxas warning : Stack size for entry function 'x' cannot be statically determined";
        assert!(usage_of(&format!("{SAID}{unknown}")).is_err());
    }

    #[test]
    fn a_module_above_a_limit_is_reported() {
        let mut usage = LIMITS.map(|(limit, _)| limit);
        assert_eq!(beyond(&usage), None);
        usage[1] += 1;
        assert_eq!(beyond(&usage).as_deref(), Some("4691 bytes of stack, of 4690"));
    }
}
