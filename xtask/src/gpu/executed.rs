//! The module executed on this machine, instruction by instruction: whether it has the host's bits, and what a device would execute.

use std::path::Path;
use std::process::Command;

use crate::process;

/// What is executed: the words of the program, and what it may take.
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

/// The most instructions that launches may take: 1.2 times what docs/gpu.md says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Limit {
    None,
    /// Of all warps.
    Warps(u64),
    /// Of the longest warp of each launch.
    Longest(u64),
}

/// Executes the module in a folder over everything that is to be compared; how many comparisons that were.
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
    /// Whether what the program has counted is within it.
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
    fn counts_are_held_to_limits() {
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
