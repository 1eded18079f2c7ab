//! The step `unit`: all tests of the workspace, and the number of those without their data.

use crate::outcome::{Outcome, Stop};
use crate::{files, process, test_programs, web};
use std::collections::BTreeSet;
use std::path::Path;

/// Arguments of the build: all packages except this program, which is tested without optimisation. Other steps that use this
/// build must have the same packages and features.
pub const PACKAGES: [&str; 5] = ["--workspace", "--exclude", "xtask", "--features", "scphd/embedded-hal,scphd-sim/gpu"];

/// Tests of the quick run: the libraries of vehicles, filters in lockstep with their references, digests, and documents. The rest
/// of the simulator, GPU studies and measurements are only in the whole run.
const QUICK: &str = "--features scphd/embedded-hal --package scphd --package scphd-lidar --package scphd-link \
    --package scphd-mavlink --package scphd-sequencer --package scphd-store --package scphd-stream --package scphd-vehicle \
    --package scphd-reference --package scphd-lockstep --package scphd-digest --package scphd-documents";

/// Of these packages the tests of each library, and those of the last three, which contain only tests.
const QUICK_TARGETS: &str = "--lib --test mixture --test joint --test laps --test digest --test links --test safety";

/// Runs the tests of the libraries.
pub fn quick() -> Result<Outcome, Stop> {
    let arguments: Vec<&str> = QUICK.split(' ').chain(QUICK_TARGETS.split(' ')).collect();
    counted(|list| test_programs::run(&arguments, list))
}

/// Runs the examples of the library and of the guide.
pub fn examples() -> Result<Outcome, Stop> {
    let mut cargo = process::cargo();
    // With the packages of the libraries' tests: with other packages, dependencies have other features and are rebuilt.
    cargo.args(["test", "--doc"]).args(QUICK.split(' '));
    process::run(&mut cargo)?;
    Ok(Outcome::PASSED)
}

/// Runs the tests, and counts those without their data.
fn counted(tests: impl FnOnce(&Path) -> Result<(), String>) -> Result<Outcome, Stop> {
    let list = process::own_target_dir("skipped-tests.txt");
    // In place of that of an earlier run.
    files::write(&list, "")?;
    tests(&list)?;
    Ok(judge(&files::text(&list)?))
}

pub fn step() -> Result<Outcome, Stop> {
    counted(|list| {
        // Without defmt, because a test program has no logger to link with. With `--tests`: otherwise examples with tests are
        // compiled a second time, as programs that are not run.
        test_programs::run(&[&["--tests"][..], &PACKAGES].concat(), list)?;
        process::run(process::cargo().args(["test", "--no-fail-fast", "--doc"]).args(PACKAGES))?;
        let mut own = process::cargo();
        own.args(["test", "--package", "xtask", "--profile", "dev"]);
        process::run(own.env(scphd_shared_data::SKIPPED, list))?;
        // The other capacities of the vehicle's filter, which streams fill differently.
        let crowded = ["test", "--package", "scphd-stream", "--features", "few-particles", "--test", "crowded"];
        process::run(process::cargo().args(crowded))?;
        web::test()
    })
}

/// The outcome by the names of skipped tests; a test that needs several logs is recorded several times.
fn judge(list: &str) -> Outcome {
    let skipped: BTreeSet<&str> = list.lines().collect();
    for test in &skipped {
        println!("skipped: {test}");
    }
    match skipped.len() {
        0 => Outcome::PASSED,
        1 => Outcome::Partly("1 test skipped for want of logs".into()),
        number => Outcome::Partly(format!("{number} tests skipped for want of logs")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_skipped_test_shows_in_the_outcome_once() {
        assert_eq!(judge(""), Outcome::PASSED);
        let list = "scphd-sim a::b\nscphd-sim a::b\nscphd a::b\nscphd-tests c\nscphd-sim a::b\n";
        assert_eq!(judge(list), Outcome::Partly("3 tests skipped for want of logs".into()));
    }
}
