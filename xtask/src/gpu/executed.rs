//! Executes the module on the host, instruction by instruction: compares its bits with those of the host, and counts
//! instructions.

use crate::firmware::streams;
use crate::process;
use std::path::Path;
use std::process::Command;

/// A column of the program's counts, and the greatest sum of it over the kernels of a run: at most 1.2 times what was counted when it
/// was set.
type Limit = (usize, u64);

/// The columns of instructions of all warps, and of the longest warp of each launch.
const WARPS: usize = 1;
const LONGEST: usize = 2;

/// The runs of every test: all kinds of filters, other scenarios and vehicles, and one with too few pages.
const FEW: [&str; 9] = [
    "check thesis-dynamic --particles 16384 --scans 1",
    "check thesis-dynamic --runs 3 --scans 30 --watch",
    "check survey --particles 32 --scans 60 --watch",
    "check thesis-dynamic --particles 64 --scans 8 --watch",
    "check thesis-dynamic --joint --runs 2 --scans 30 --watch",
    "check survey --joint --scans 30 --watch",
    "check worlds-exact --particles 4 --scans 60",
    "check worlds-exact --joint --scans 60",
    "check thesis-compare --particles 32 --scans 60",
];

/// Studies by the simulator, on the host and with the module.
const STUDIES: [&str; 3] = [
    "monte-carlo survey --filter core --particles 2 --runs 2 --input-sets 1",
    "monte-carlo worlds-exact --filter core --particles 1 --runs 1",
    "tune thesis-compare --particles 1 --samples 1 --rounds 1 --runs 1",
];

/// More runs: arguments of the program, and a limit of instructions.
const CHECKS: [(&str, Option<Limit>); 8] = [
    ("check thesis-dynamic --runs 32 --scans 10", Some((WARPS, 116_800_000))),
    ("check thesis-dynamic --scans 30", Some((LONGEST, 12_000_000))),
    ("check survey --particles 32 --runs 2 --scans 40", None),
    ("check thesis-dynamic --particles 64 --scans 20 --watch", Some((LONGEST, 8_300_000))),
    ("check thesis-dynamic --particles 1024 --scans 2 --watch", None),
    ("check thesis-dynamic --particles 4096 --scans 6", Some((LONGEST, 3_140_000))),
    ("check thesis-dynamic --joint --runs 2 --scans 60 --watch", Some((LONGEST, 173_000_000))),
    ("check survey --joint --runs 2 --scans 60", Some((LONGEST, 120_000_000))),
];

/// Output of the program, which executes the module in a folder.
fn read(words: &str, modules: &Path, cargo: impl Fn(&str) -> Command) -> Result<String, String> {
    let mut command = cargo("run");
    command.args(["--release", "--"]).args(words.split(' ')).args(["--device", "ptx", "--modules"]).arg(modules);
    process::read(&mut command)
}

/// Executes the module in a folder, several runs at a time, and compares the results. Returns the number of comparisons.
pub fn few(modules: &Path, cargo: impl Fn(&str) -> Command + Copy + Sync) -> Result<String, String> {
    let mut tests = cargo("test");
    process::run(tests.args(["--release", "--", "--ignored"]).env("SCPHD_GPU_MODULES", modules))?;
    // The program is built before several of them run.
    process::run(cargo("build").arg("--release"))?;
    let said = process::side_by_side(&FEW, |words| read(words, modules, cargo))?;
    said.iter().filter_map(|said| said.lines().last()).for_each(|line| println!("{line}"));
    for words in STUDIES {
        let of_host = process::read(streams::simulator()?.args(words.split(' ')))?;
        let mut simulator = streams::simulator()?;
        simulator.args(words.split(' ')).args(["--device", "ptx"]).env("SCPHD_GPU_MODULES", modules);
        same_study(&process::read(&mut simulator)?, &of_host).map_err(|why| format!("{words}: {why}"))?;
    }
    let (comparisons, studies) = (FEW.len(), STUDIES.len());
    Ok(format!("executed on the host, {comparisons} comparisons with its digests, and {studies} studies: equal"))
}

/// Compares the lines of two studies, but for the time of a scan.
fn same_study(executed: &str, of_host: &str) -> Result<(), String> {
    let lines = |said: &str| -> Vec<String> {
        said.lines().filter(|line| !line.starts_with(" scan, mean")).map(str::to_owned).collect()
    };
    let (executed, of_host) = (lines(executed), lines(of_host));
    if of_host.len() < 4 {
        return Err(format!("only {} lines of a study", of_host.len()));
    }
    if executed == of_host { Ok(()) } else { Err(format!("{executed:#?}, on the host {of_host:#?}")) }
}

/// The same for more runs, with counts of instructions.
pub fn check(modules: &Path, cargo: impl Fn(&str) -> Command + Copy) -> Result<String, String> {
    for (words, limit) in CHECKS {
        let said = read(words, modules, cargo)?;
        println!("{said}");
        limit.map_or(Ok(()), |limit| hold(limit, &said))?;
    }
    Ok(format!("{} more", CHECKS.len()))
}

/// Checks the counts in the program's output, without those of starts, and of predicted poses and digests, which only comparisons need.
fn hold((column, most): Limit, said: &str) -> Result<(), String> {
    let others = ["_start", "_furnish", "_forecast", "_digest"];
    let of_scans = |line: &&str| line.starts_with("scphd_") && !others.iter().any(|other| line.contains(other));
    let kernels = said.lines().filter(of_scans);
    let counts = kernels.map(|line| line.split_whitespace().nth(column)?.parse::<u64>().ok());
    let taken: u64 = counts.sum::<Option<u64>>().filter(|&sum| sum > 0).ok_or("it has counted nothing")?;
    if taken > most { Err(format!("{taken} instructions, of {most} at most")) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, WARPS, hold, same_study};

    #[test]
    fn studies_differ_in_time_alone() {
        let study = |error: &str, time: &str| {
            let row = |k| format!(" row {k}  1\n");
            let rows: String = (0..10).map(row).collect();
            format!("survey\n{rows} position error, mean (m)  {error}\n scan, mean (µs)  {time}\n")
        };
        assert_eq!(same_study(&study("4.139", "–"), &study("4.139", "219.8")), Ok(()));
        assert!(same_study(&study("4.138", "–"), &study("4.139", "–")).is_err());
        assert!(same_study("", "").is_err());
    }

    #[test]
    fn counts_are_compared_with_limits() {
        let said = "\
instructions of  all warps  longest warp
scphd_a          10         5
scphd_b          1          1
scphd_digest     9          9

2 digests";
        assert_eq!(hold((WARPS, 11), said), Ok(()));
        assert!(hold((WARPS, 10), said).is_err());
        assert_eq!(hold((LONGEST, 6), said), Ok(()));
        assert!(hold((LONGEST, 5), said).is_err());
        assert!(hold((WARPS, 11), "2 digests").is_err());
    }
}
