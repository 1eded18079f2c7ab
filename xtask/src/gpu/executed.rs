//! Executes the module on the host, instruction by instruction: compares its bits with those of the host, and counts
//! instructions.

use crate::process;
use std::path::Path;
use std::process::Command;

/// A column of the program's counts, and the greatest sum of it over the kernels of a run: 1.2 times what was counted when it was set.
type Limit = (usize, u64);

/// The columns of instructions of all warps, and of the longest warp of each launch.
const WARPS: usize = 2;
const LONGEST: usize = 3;

/// The runs: arguments of the program, and a limit of instructions.
const CHECKS: [(&str, Option<Limit>); 6] = [
    ("check thesis-dynamic --runs 32 --scans 10", Some((WARPS, 137_600_000))),
    ("check survey --particles 32 --runs 2 --scans 40", None),
    ("check thesis-dynamic --particles 64 --scans 20 --watch", Some((LONGEST, 40_800_000))),
    ("check thesis-dynamic --particles 1024 --scans 2 --watch", None),
    ("check thesis-dynamic --filter joint --runs 2 --scans 60 --watch", Some((LONGEST, 196_500_000))),
    ("check survey --filter joint --runs 2 --scans 60", Some((LONGEST, 148_500_000))),
];

/// Executes the module in a folder and compares the results. Returns the number of comparisons.
pub fn check(modules: &Path, cargo: impl Fn(&str) -> Command) -> Result<String, String> {
    for (words, limit) in CHECKS {
        let mut command = cargo("run");
        command.args(["--release", "--"]).args(words.split(' ')).args(["--device", "ptx", "--modules"]).arg(modules);
        let said = process::read(&mut command)?;
        println!("{said}");
        limit.map_or(Ok(()), |limit| hold(limit, &said))?;
    }
    Ok(format!("executed on the host, {} comparisons with its digests: equal", CHECKS.len()))
}

/// Checks the counts in the program's output.
fn hold((column, most): Limit, said: &str) -> Result<(), String> {
    let kernels = said.lines().filter(|line| line.starts_with("scphd_"));
    let counts = kernels.map(|line| line.split_whitespace().nth(column)?.parse::<u64>().ok());
    let taken: u64 = counts.sum::<Option<u64>>().filter(|&sum| sum > 0).ok_or("it has counted nothing")?;
    if taken > most { Err(format!("{taken} instructions, of {most} at most")) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, WARPS, hold};

    #[test]
    fn counts_are_compared_with_limits() {
        let said = "\
kernel       instructions  of warps  longest warp
scphd_a      320           10        5
scphd_b      31            1         1

2 digests";
        assert_eq!(hold((WARPS, 11), said), Ok(()));
        assert!(hold((WARPS, 10), said).is_err());
        assert_eq!(hold((LONGEST, 6), said), Ok(()));
        assert!(hold((LONGEST, 5), said).is_err());
        assert!(hold((WARPS, 11), "2 digests").is_err());
    }
}
