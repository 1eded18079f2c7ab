//! NVIDIA's assembler: registers and memory of each kernel, and modules for certain architectures.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::outcome::Missing;
use crate::process;
use crate::python::{self, Environment};

/// The package with the assembler, without other parts of the compiler.
const PACKAGE: [&str; 1] = ["nvidia-cuda-nvcc>=13.0,<14"];
/// Path of the assembler among the packages.
const PLACE: &str = "nvidia/cu13/bin/ptxas";
/// Architectures for which modules are assembled: Ampere and Hopper for data centres.
const CARDS: [&str; 2] = ["sm_80", "sm_90"];

/// Greatest usage: 1.2 times the figures in docs/gpu.md, except for registers, where it is the limit of a thread.
const LIMITS: Usage =
    Usage { registers: 255, stack: 3_530, spill_stores: 1_360, spill_loads: 1_900, shared: 0, constant: 1_260 };

/// Greatest usage of any kernel of a module for each thread, including its callees; in bytes, except for registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Usage {
    /// Registers of four bytes.
    registers: u64,
    /// Stack of the kernel and its callees.
    stack: u64,
    /// Spilled registers, stores and loads, as counted in the code of all functions.
    spill_stores: u64,
    spill_loads: u64,
    /// Shared memory of a block.
    shared: u64,
    /// Constants with arguments, if the assembler reports them.
    constant: u64,
}

/// The assembler.
pub struct Ptxas {
    program: PathBuf,
    version: String,
}

impl Ptxas {
    /// The assembler in the project's Python environment, which is created if necessary.
    pub fn obtain() -> Result<Self, Missing> {
        let environment = Environment::of(&python::interpreter()?)?;
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
            println!("{card}: {usage}");
            for Kernel { name, registers, stack } in kernels(&said) {
                println!("  {name}: {registers} registers, {stack} bytes of stack");
            }
            if let Some(beyond) = usage.beyond(&LIMITS) {
                return Err(format!("{card}: the module takes more than it may: {beyond}"));
            }
            all.push(format!("{card}: {usage}"));
        }
        Ok(all.join("; "))
    }
}

impl Usage {
    fn fields(&self) -> [(&'static str, u64); 6] {
        [
            ("registers", self.registers),
            ("bytes of stack", self.stack),
            ("bytes of spill stores", self.spill_stores),
            ("bytes of spill loads", self.spill_loads),
            ("bytes of shared memory", self.shared),
            ("bytes of constants", self.constant),
        ]
    }

    /// The first field above its limit.
    fn beyond(&self, limits: &Self) -> Option<String> {
        let pairs = self.fields().into_iter().zip(limits.fields());
        let mut beyond = pairs.filter(|((_, used), (_, limit))| used > limit);
        beyond.next().map(|((name, used), (_, limit))| format!("{used} {name}, of {limit}"))
    }
}

impl fmt::Display for Usage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fields = self.fields().map(|(name, used)| format!("{used} {name}"));
        f.write_str(&fields.join(", "))
    }
}

/// Usage of a kernel for each thread, including its callees.
#[derive(Debug, PartialEq, Eq)]
struct Kernel<'s> {
    name: &'s str,
    registers: u64,
    stack: u64,
}

/// Usage of each kernel, from the assembler's output.
fn kernels(said: &str) -> Vec<Kernel<'_>> {
    let mut all: Vec<Kernel<'_>> = Vec::new();
    for line in said.lines() {
        if let Some(name) = line.split("entry function '").nth(1).and_then(|rest| rest.split('\'').next()) {
            all.push(Kernel { name, registers: 0, stack: 0 });
        } else if let Some(kernel) = all.last_mut().filter(|kernel| kernel.registers == 0)
            && line.contains("Used ")
        {
            (kernel.registers, kernel.stack) = (number(line, "registers"), number(line, "bytes cumulative stack size"));
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
    let mut usage = Usage::default();
    for line in said.lines() {
        let number = |after: &str| number(line, after);
        usage.registers = usage.registers.max(number("registers"));
        usage.stack = usage.stack.max(number("bytes cumulative stack size")).max(number("bytes stack frame"));
        usage.spill_stores += number("bytes spill stores");
        usage.spill_loads += number("bytes spill loads");
        usage.shared = usage.shared.max(number("bytes smem"));
        // Arguments and constants are in different banks.
        usage.constant = usage.constant.max(number("bytes cmem[0]") + number("bytes cmem[2]"));
    }
    if usage.registers == 0 { Err("it says nothing of a kernel") } else { Ok(usage) }
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
        let usage =
            Usage { registers: 255, stack: 7824, spill_stores: 1934, spill_loads: 2012, shared: 64, constant: 1104 };
        assert_eq!(usage_of(SAID), Ok(usage));
        assert_eq!(kernels(SAID), [Kernel { name: "scphd_runs", registers: 255, stack: 7824 }]);
        assert!(usage_of("ptxas info    : 1609 bytes gmem").is_err());
        let unknown = "ptxas warning : Stack size for entry function 'x' cannot be statically determined";
        assert!(usage_of(&format!("{SAID}{unknown}")).is_err());
    }

    #[test]
    fn a_module_above_a_limit_is_reported() {
        let limits = Usage { registers: 255, stack: 100, ..Usage::default() };
        assert_eq!(limits.beyond(&limits), None);
        let beyond = Usage { stack: 101, ..limits }.beyond(&limits);
        assert_eq!(beyond.as_deref(), Some("101 bytes of stack, of 100"));
    }
}
