//! Executes the module on the host, instruction by instruction: compares its bits with those of the host, and counts
//! instructions.

use std::path::Path;
use std::process::Command;

use crate::process;

/// The runs: arguments of the program, and a limit of instructions.
const CHECKS: [Check; 4] = [
    Check { words: &["check", "thesis-dynamic", "--runs", "32", "--scans", "10"], limit: Limit::Warps(156_000_000) },
    Check {
        words: &["check", "survey", "--particles", "32", "--runs", "2", "--scans", "40", "--warp", "1"],
        limit: Limit::None,
    },
    Check {
        words: &["large-check", "thesis-dynamic", "--particles", "64", "--scans", "20", "--watch"],
        limit: Limit::Longest(37_300_000),
    },
    Check {
        words: &["large-check", "thesis-dynamic", "--particles", "1024", "--scans", "2", "--watch"],
        limit: Limit::None,
    },
];

struct Check {
    words: &'static [&'static str],
    limit: Limit,
}

/// Greatest number of instructions of a run: 1.2 times the figure in docs/gpu.md.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Limit {
    None,
    /// Sum over all warps.
    Warps(u64),
    /// Sum over launches of their longest warps.
    Longest(u64),
}

/// Executes the module in a folder and compares the results. Returns the number of comparisons.
pub fn check(modules: &Path, cargo: impl Fn(&str) -> Command) -> Result<String, String> {
    for Check { words, limit } in CHECKS {
        let mut command = cargo("run");
        command.args(["--release", "--"]).args(words).args(["--device", "ptx", "--modules"]).arg(modules);
        let said = process::read(&mut command)?;
        println!("{said}");
        limit.hold(&said)?;
    }
    Ok(format!("executed on the host, {} comparisons with its digests: equal", CHECKS.len()))
}

impl Limit {
    /// Checks the counts in the program's output.
    fn hold(self, said: &str) -> Result<(), String> {
        let (column, most) = match self {
            Self::None => return Ok(()),
            Self::Warps(most) => (2, most),
            Self::Longest(most) => (4, most),
        };
        let kernels = said.lines().filter(|line| line.starts_with("scphd_"));
        let counts = kernels.map(|line| line.split_whitespace().nth(column)?.parse::<u64>().ok());
        let taken: u64 = counts.sum::<Option<u64>>().filter(|&sum| sum > 0).ok_or("it has counted nothing")?;
        if taken > most { Err(format!("{taken} instructions, of {most} at most")) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::Limit;

    #[test]
    fn counts_are_compared_with_limits() {
        let said = "\
kernel       instructions  of warps  together  longest warp  accesses
scphd_a      320           10        32.00     5             7
scphd_b      31            1         31.00     1             0

2 digests";
        assert_eq!(Limit::Warps(11).hold(said), Ok(()));
        assert!(Limit::Warps(10).hold(said).is_err());
        assert_eq!(Limit::Longest(6).hold(said), Ok(()));
        assert!(Limit::Longest(5).hold(said).is_err());
        assert!(Limit::Warps(11).hold("2 digests").is_err());
    }
}
