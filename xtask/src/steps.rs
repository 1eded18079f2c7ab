//! The steps of `cargo xtask test` and how they are run: all of them, even after a failure, then a summary.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::bench;
use crate::budget;
use crate::firmware;
use crate::process;
use crate::target;

/// What the command line says beside the steps.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Where the budget or the bench writes its figures.
    pub json: Option<PathBuf>,
}

/// One step, which can also be run by its name.
pub struct Step {
    /// The word on the command line.
    pub name: &'static str,
    /// What it checks, for the headline and the help.
    pub what: &'static str,
    run: fn(&Options) -> Outcome,
}

/// How a step ended.
pub enum Outcome {
    /// Everything it names was checked and held; the note adds what a reader of the summary should know.
    Passed(String),
    /// Nothing was checked, for this reason.
    Skipped(String),
    /// For this reason.
    Failed(String),
}

impl From<Result<(), String>> for Outcome {
    fn from(result: Result<(), String>) -> Self {
        match result {
            Ok(()) => Self::Passed(String::new()),
            Err(reason) => Self::Failed(reason),
        }
    }
}

/// Cheapest first, so that the common slips show early.
pub const STEPS: &[Step] = &[
    Step { name: "fmt", what: "formatting of every package", run: |_| fmt() },
    Step { name: "lint", what: "clippy on every package, warnings are errors", run: |_| lint() },
    Step { name: "doc", what: "documentation builds without a warning", run: |_| doc() },
    Step { name: "unit", what: "every test of the workspace, documentation examples included", run: |_| unit() },
    Step {
        name: "digest",
        what: "the filter's state is bit for bit the same in every build profile",
        run: |_| digest(),
    },
    Step {
        name: "target",
        what: "the core builds for a Cortex-M without std and without alloc",
        run: |_| target::step(),
    },
    Step {
        name: "proof",
        what: "firmware images link for every board without a panic and without an allocator",
        run: |_| firmware::proof(),
    },
    Step {
        name: "firmware",
        what: "after every scan the boards, in QEMU, have the same state as the host, bit for bit",
        run: |_| firmware::digests(),
    },
    Step { name: "budget", what: "flash, RAM, stack and instructions are within budgets.toml", run: budget::step },
    Step {
        name: "msrv",
        what: "the workspace builds with the oldest supported Rust, if that is installed",
        run: |_| msrv(),
    },
];

/// Steps that are not part of `test`: their times are of the machine and what else it does, their counts of the compiler.
pub const OTHERS: &[Step] = &[
    Step {
        name: "bench",
        what: "prints what a scan costs: time, growth, peers, instructions on the target; some minutes",
        run: bench::step,
    },
    Step {
        name: "counts",
        what: "instructions on the host, by callgrind, are those of benches/counts.toml",
        run: |_| bench::counts(),
    },
];

/// Runs the steps and prints the summary. `false` if one failed.
pub fn run(chosen: &[&Step], options: &Options) -> bool {
    let mut results = Vec::new();
    for (index, step) in chosen.iter().enumerate() {
        println!("\n=== [{}/{}] {}: {}", index + 1, chosen.len(), step.name, step.what);
        let started = Instant::now();
        let outcome = (step.run)(options);
        let elapsed = started.elapsed();
        println!("=== {}", verdict(step.name, &outcome, elapsed));
        results.push((step.name, outcome, elapsed));
    }

    println!("\n=== summary");
    for (name, outcome, elapsed) in &results {
        println!("{}", verdict(name, outcome, *elapsed));
    }
    let failed = results.iter().filter(|(_, outcome, _)| matches!(outcome, Outcome::Failed(_))).count();
    let skipped = results.iter().filter(|(_, outcome, _)| matches!(outcome, Outcome::Skipped(_))).count();
    println!("{} passed, {skipped} skipped, {failed} failed", results.len() - failed - skipped);
    failed == 0
}

/// One line of the summary.
fn verdict(name: &str, outcome: &Outcome, elapsed: Duration) -> String {
    let (word, note) = match outcome {
        Outcome::Passed(note) => ("ok", note),
        Outcome::Skipped(note) => ("skipped", note),
        Outcome::Failed(note) => ("FAILED", note),
    };
    let line = format!("{word:<8}{name:<9}{:>7.1} s  {note}", elapsed.as_secs_f64());
    line.trim_end().to_owned()
}

/// The firmware is a workspace of its own.
fn fmt() -> Outcome {
    let firmware = ["fmt", "--manifest-path", "firmware/Cargo.toml", "--", "--check"];
    let workspace = ["fmt", "--all", "--check"];
    let results = [&workspace[..], &firmware[..]].map(|arguments| process::run(process::cargo().args(arguments)));
    results.into_iter().collect::<Result<(), String>>().into()
}

fn lint() -> Outcome {
    let mut cargo = process::cargo();
    cargo.args(["clippy", "--workspace", "--all-targets", "--keep-going"]);
    cargo.args(["--features", "scphd/defmt,scphd/embedded-hal,scphd-stream/defmt", "--", "-D", "warnings"]);
    // The other room of the filter on board, which nothing but the firmware's images has.
    let mut few = process::cargo();
    few.args(["clippy", "--package", "scphd-stream", "--features", "few-particles", "--", "-D", "warnings"]);
    process::run(&mut cargo).and_then(|()| process::run(&mut few)).into()
}

fn doc() -> Outcome {
    let mut cargo = process::cargo();
    cargo.env("RUSTDOCFLAGS", "-D warnings").args(["doc", "--workspace", "--no-deps", "--keep-going"]);
    process::run(&mut cargo).into()
}

fn unit() -> Outcome {
    // Not with defmt: a test program has no logger to link with.
    let arguments = ["test", "--workspace", "--no-fail-fast", "--features", "scphd/embedded-hal"];
    process::run(process::cargo().args(arguments)).into()
}

/// The step `unit` has checked the digests at the optimisation of its own profile. A filter that is tuned in one
/// profile and flown in another must compute the same in both, so they are checked without optimisation and in a
/// release build too, where a fused operation, another order of a sum or another crate's `libm` would show.
fn digest() -> Outcome {
    let mut failures = Vec::new();
    for profile in [&["--profile", "dev"][..], &["--release"]] {
        let mut cargo = process::cargo();
        cargo.args(["test", "-p", "scphd-tests", "--test", "digest"]).args(profile);
        // A run that rewrites what it should compare with checks nothing.
        cargo.env_remove("SCPHD_BLESS");
        if let Err(reason) = process::run(&mut cargo) {
            failures.push(format!("{}: {reason}", profile.join(" ")));
        }
    }
    if failures.is_empty() { Outcome::Passed(String::new()) } else { Outcome::Failed(failures.join("; ")) }
}

/// Checks with the oldest supported toolchain, but only if rustup has it: fetching one is not a test's business.
fn msrv() -> Outcome {
    let oldest = env!("CARGO_PKG_RUST_VERSION");
    let listed = process::read(process::command("rustup").args(["toolchain", "list"])).unwrap_or_default();
    let Some(toolchain) = listed.split_whitespace().find(|name| is_version(name, oldest)) else {
        return Outcome::Skipped(format!("NOT CHECKED: no toolchain {oldest} is installed"));
    };
    // A toolchain's name is whatever its owner called it; the compiler itself knows better.
    let version = process::read(process::command("rustup").args(["run", toolchain, "rustc", "--version"]));
    match version {
        Ok(version) if version.split(' ').nth(1).is_some_and(|number| is_version(number, oldest)) => {}
        other => {
            return Outcome::Skipped(format!("NOT CHECKED: toolchain {toolchain} is not {oldest}: {other:?}"));
        }
    }
    let mut check = process::command("rustup");
    check.args(["run", toolchain, "cargo", "check", "--workspace", "--all-targets", "--target-dir"]);
    check.arg(process::own_target_dir("msrv")).env_remove("RUSTC");
    process::run(&mut check).into()
}

/// Whether `name` is the release `version`, any patch release of it, or a toolchain called after one.
fn is_version(name: &str, version: &str) -> bool {
    name.strip_prefix(version).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '-']))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAILS: Step = Step { name: "fails", what: "", run: |_| Outcome::Failed("on purpose".into()) };
    const SKIPS: Step = Step { name: "skips", what: "", run: |_| Outcome::Skipped("on purpose".into()) };
    const PASSES: Step = Step { name: "passes", what: "", run: |_| Outcome::Passed(String::new()) };

    #[test]
    fn one_failure_fails_the_run_and_a_skip_does_not() {
        assert!(run(&[&PASSES, &SKIPS], &Options::default()));
        assert!(!run(&[&FAILS, &PASSES], &Options::default()));
    }

    #[test]
    fn steps_after_a_failure_still_run() {
        use std::sync::atomic::{AtomicBool, Ordering};
        static REACHED: AtomicBool = AtomicBool::new(false);
        fn reach(_: &Options) -> Outcome {
            REACHED.store(true, Ordering::Relaxed);
            Outcome::Passed(String::new())
        }
        let reaches = Step { name: "reaches", what: "", run: reach };
        assert!(!run(&[&FAILS, &reaches], &Options::default()));
        assert!(REACHED.load(Ordering::Relaxed));
    }

    #[test]
    fn names_are_unique() {
        let mut names: Vec<&str> = STEPS.iter().map(|step| step.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), STEPS.len());
    }

    #[test]
    fn versions_match_whole_numbers() {
        assert!(is_version("1.89", "1.89"));
        assert!(is_version("1.89.0", "1.89"));
        assert!(is_version("1.89-x86_64-unknown-linux-gnu", "1.89"));
        assert!(!is_version("1.890.0", "1.89"));
        assert!(!is_version("stable-1.89", "1.89"));
    }
}
