//! The step `unit`: every test of the workspace, and how many of them had nothing to test with.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::Path;

use crate::outcome::{Outcome, Stop};
use crate::process;
use crate::web;

/// What is tested in one build: every package but this program's own, which is here without optimisation already. Other steps that take
/// something of this build have to name the same packages and features.
pub const PACKAGES: [&str; 5] = ["--workspace", "--exclude", "xtask", "--features", "scphd/embedded-hal"];

/// The step.
pub fn step() -> Outcome {
    test().into()
}

/// What the quick run tests: the libraries that vehicles link, the reference in lockstep with the filters, digests, and documents. The
/// rest of the simulator, studies on a GPU and measurements are left to the whole run.
const QUICK: [&str; 26] = [
    "--features",
    "scphd/embedded-hal",
    "--package",
    "scphd",
    "--package",
    "scphd-lidar",
    "--package",
    "scphd-link",
    "--package",
    "scphd-mavlink",
    "--package",
    "scphd-sequencer",
    "--package",
    "scphd-store",
    "--package",
    "scphd-stream",
    "--package",
    "scphd-vehicle",
    "--package",
    "scphd-reference",
    "--package",
    "scphd-lockstep",
    "--package",
    "scphd-digest",
    "--package",
    "scphd-documents",
];

/// The packages that are nothing but tests of whole runs.
pub const WHOLE_RUNS: [&str; 2] = ["scphd-digest", "scphd-lockstep"];

/// Of these packages the tests of each library, and those of the last three, which are nothing but tests.
const QUICK_TARGETS: [&str; 11] =
    ["--lib", "--test", "mixture", "--test", "joint", "--test", "digest", "--test", "links", "--test", "safety"];

/// The tests of the libraries.
pub fn quick() -> Result<Outcome, Stop> {
    counted(|list| {
        let mut cargo = process::cargo();
        cargo.args(["test", "--no-fail-fast"]).args(QUICK).args(QUICK_TARGETS);
        process::run(cargo.env(scphd_shared_data::SKIPPED, list))
    })
}

/// The examples of the library and of the guide.
pub fn examples() -> Result<Outcome, Stop> {
    let mut cargo = process::cargo();
    // The packages of the libraries' tests: with others, dependencies have other features and are built anew.
    cargo.args(["test", "--doc"]).args(QUICK);
    process::run(&mut cargo)?;
    Ok(Outcome::Passed(String::new()))
}

/// Does the tests, and counts those that had nothing to test with.
fn counted(tests: impl FnOnce(&Path) -> Result<(), String>) -> Result<Outcome, Stop> {
    let list = process::own_target_dir("skipped-tests.txt");
    fresh(&list).map_err(|error| format!("{}: {error}", list.display()))?;
    tests(&list)?;
    let text = fs::read_to_string(&list).map_err(|error| format!("{}: {error}", list.display()))?;
    let skipped = tests_in(&text);
    for test in &skipped {
        println!("skipped: {test}");
    }
    Ok(judge(skipped.len()))
}

fn test() -> Result<Outcome, Stop> {
    counted(|list| {
        let mut cargo = process::cargo();
        // Not with defmt: a test program has no logger to link with.
        cargo.args(["test", "--no-fail-fast"]).args(PACKAGES);
        process::run(cargo.env(scphd_shared_data::SKIPPED, list))?;
        let mut own = process::cargo();
        own.args(["test", "--package", "xtask", "--profile", "dev"]);
        process::run(own.env(scphd_shared_data::SKIPPED, list))?;
        // The other room of the filter on board, which streams fill in other ways.
        let crowded = ["test", "--package", "scphd-stream", "--features", "few-particles", "--test", "crowded"];
        process::run(process::cargo().args(crowded))?;
        process::run(&mut web::test())
    })
}

/// An empty file: what an earlier run has left does not count.
fn fresh(list: &Path) -> io::Result<()> {
    list.parent().map_or(Ok(()), fs::create_dir_all)?;
    fs::write(list, "")
}

/// A test that asks for several logs is noted several times.
fn tests_in(text: &str) -> BTreeSet<&str> {
    text.lines().collect()
}

fn judge(skipped: usize) -> Outcome {
    match skipped {
        0 => Outcome::Passed(String::new()),
        1 => Outcome::Partly("1 test skipped for want of logs".into()),
        _ => Outcome::Partly(format!("{skipped} tests skipped for want of logs")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_counts_once_however_many_logs_it_misses() {
        let text = "scphd-sim a::b\nscphd-sim a::b\nscphd a::b\nscphd-tests c\nscphd-sim a::b\n";
        assert_eq!(tests_in(text).len(), 3);
        assert_eq!(tests_in("").len(), 0);
    }

    #[test]
    fn a_skipped_test_shows_in_the_outcome() {
        assert_eq!(judge(0), Outcome::Passed(String::new()));
        assert_eq!(judge(2), Outcome::Partly("2 tests skipped for want of logs".into()));
    }
}
