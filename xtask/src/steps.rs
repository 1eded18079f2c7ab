//! The steps of `cargo xtask test --all`, and how they run: all of them, even after a failure, then a summary.

use crate::options::Options;
use crate::outcome::{Outcome, Stop};
use crate::{bench, budget, capi, firmware, gpu, lint, msrv, package, peers, process, python, ros2, target, unit, web};
use std::time::{Duration, Instant};

/// A step, which can also be run by its name.
pub struct Step {
    pub name: &'static str,
    /// Description for the headline and the help.
    pub what: &'static str,
    pub run: fn(&Options) -> Result<Outcome, Stop>,
}

pub const fn step(name: &'static str, what: &'static str, run: fn(&Options) -> Result<Outcome, Stop>) -> Step {
    Step { name, what, run }
}

/// Fastest first, so that common errors show early.
pub const STEPS: &[Step] = &[
    step("fmt", "formatting of every package", |_| lint::fmt()),
    step("lint", "clippy on every package, warnings are errors", |_| lint::lint()),
    step("doc", "documentation builds without a warning", |_| lint::doc()),
    step("package", "the libraries can be packaged, each whole", |_| package::step()),
    step("unit", "every test of the workspace, documentation examples included", |_| unit::step()),
    step("target", "core and what is on board beside it build for a Cortex-M without std and without alloc", |_| {
        target::step()
    }),
    step("proof", "firmware images link for every board without a panic and without an allocator", |_| {
        firmware::proof()
    }),
    step("firmware", "after every scan the boards, in QEMU, have the same state as the host, bit for bit", |_| {
        firmware::digests()
    }),
    step(
        "capi",
        "the C library: its header, its symbols, C and C++ programs on the host and C on boards in QEMU",
        |_| capi::step(),
    ),
    step(
        "python",
        "the Python package: its wheel, its tests, the digests of the library; `python --all`: the studies too",
        |options| python::step(options.studies),
    ),
    step(
        "logs",
        "what a run writes is read by rosbags and evo as it was meant; `logs --all`: by rerun too",
        |options| peers::logs(options.studies),
    ),
    step(
        "mavlink",
        "pymavlink reads what is sent to flight stacks, writes what is read, and drives a vehicle over UDP",
        |_| peers::mavlink(),
    ),
    step("ros2", "the node of ROS 2: another DDS, in Python, receives the poses of a replay, to the bit", |_| {
        ros2::step()
    }),
    step("module", "the module for GPUs: its code, and its digests and outputs, executed on the host", |_| {
        gpu::module()
    }),
    step("budget", "flash, RAM, stack and instructions are within budgets.toml", budget::step),
    step("counts", "instructions on the host, by callgrind, are those of tests/benches/counts.toml", |_| {
        bench::counts()
    }),
    step("msrv", "nothing needs a newer Rust than the oldest supported", |_| msrv::step()),
];

/// Steps that are not part of `test`: the times of some depend on the machine and its load, some take long, one installs.
pub const OTHERS: &[Step] = &[
    step("bench", "prints what a scan costs on the host: time, growth, peers; some minutes", bench::step),
    step(
        "claims",
        "every figure of the documentation by the whole of its command, of which `unit` does a part; takes long",
        |_| claims(),
    ),
    step(
        "fuzz",
        "operations, snapshots, streams and log folders with hostile values, 20 million from seed 1, or `fuzz OPERATIONS SEED`",
        fuzz,
    ),
    step("hil", "the whole of thesis-dynamic to a target in QEMU over its serial port, scan by scan", |_| {
        firmware::hil()
    }),
    step(
        "rtos",
        "the filter as a task of an operating system, interrupted by odometry, in QEMU; the step `firmware` has it too",
        |_| firmware::rtos(),
    ),
    step("deny", "licences and sources of all dependencies are those of deny.toml; needs cargo-deny", |_| {
        package::deny()
    }),
    step(
        "web",
        "makes the page to try the filter in, and compares its digests with the host's in Node.js and in a browser without a window",
        |_| web::step(),
    ),
    step(
        "gpu",
        "the module for GPUs: the step `module`, more of it, what NVIDIA's assembler says of it, and a card where there is one",
        |_| gpu::step(),
    ),
    step(
        "install-c",
        "installs the C library: `install-c PREFIX`, `install-c PREFIX thumbv7em-none-eabihf`",
        |options| capi::install(&options.place),
    ),
];

/// Runs the steps and prints the summary. Returns `false` if a step failed or, in a strict run, if not everything was checked.
pub fn run(chosen: &[&Step], options: &Options) -> bool {
    let begun = Instant::now();
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
    println!("{}", line("total", "", begun.elapsed(), ""));
    let passed = results.iter().filter(|(_, outcome, _)| matches!(outcome, Ok(Outcome::Passed(_)))).count();
    let failed = results.iter().filter(|(_, outcome, _)| matches!(outcome, Err(Stop::Broken(_)))).count();
    let skipped = results.len() - passed - failed;
    if options.strict && skipped > 0 {
        println!("strict: a step that did not check everything is a failure");
    }
    println!("{passed} passed, {skipped} skipped, {failed} failed");
    failed == 0 && !(options.strict && skipped > 0)
}

/// A line of the summary.
fn verdict(name: &str, outcome: &Result<Outcome, Stop>, elapsed: Duration) -> String {
    let (word, note) = match outcome {
        Ok(Outcome::Passed(note)) => ("ok", note),
        Ok(Outcome::Partly(note)) => ("partly", note),
        Err(Stop::Missing(note)) => ("skipped", note),
        Err(Stop::Broken(note)) => ("FAILED", note),
    };
    line(word, name, elapsed, note)
}

fn line(word: &str, name: &str, elapsed: Duration, note: &str) -> String {
    let line = format!("{word:<8}{name:<10}{:>7.1} s  {note}", elapsed.as_secs_f64());
    line.trim_end().to_owned()
}

fn claims() -> Result<Outcome, Stop> {
    let mut cargo = process::cargo();
    cargo.args(["test", "--release", "--package", "scphd-sim", "--test", "claims", "--", "--ignored", "--nocapture"]);
    process::run(&mut cargo)?;
    Ok(Outcome::PASSED)
}

/// The tests run the same programs for a shorter time. One in a thousand operations is a log folder.
fn fuzz(options: &Options) -> Result<Outcome, Stop> {
    let [operations, seed] =
        [(0, 20_000_000), (1, 1)].map(|(place, default)| options.numbers.get(place).copied().unwrap_or(default));
    let mut cargo = process::cargo();
    cargo.args(["run", "--release", "--package", "scphd-tests", "--bin", "fuzz", "--"]);
    cargo.args([operations, seed].map(|number| number.to_string()));
    let mut folders = process::cargo();
    folders.args(["test", "--release", "--package", "scphd-sim", "--test", "damaged_logs", "--", "--nocapture"]);
    folders.env("SCPHD_DAMAGED_FOLDERS", (operations / 1000).max(1).to_string());
    process::run(&mut cargo)?;
    process::run(&mut folders)?;
    Ok(Outcome::PASSED)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Missing;
    use crate::quick;

    const FAILS: Step = step("fails", "", |_| Err("on purpose".into()));
    const SKIPS: Step = step("skips", "", |_| Err(Missing("on purpose".into()).into()));
    const PARTLY: Step = step("partly", "", |_| Ok(Outcome::Partly("on purpose".into())));
    const PASSES: Step = step("passes", "", |_| Ok(Outcome::PASSED));

    #[test]
    fn one_failure_fails_the_run_and_a_skip_does_not() {
        assert!(run(&[&PASSES, &SKIPS], &Options::default()));
        assert!(!run(&[&FAILS, &PASSES], &Options::default()));
    }

    #[test]
    fn a_strict_run_fails_where_something_was_not_checked() {
        let strict = Options { strict: true, ..Options::default() };
        assert!(run(&[&PASSES], &strict));
        assert!(!run(&[&PASSES, &SKIPS], &strict));
        assert!(!run(&[&PARTLY, &PASSES], &strict));
        assert!(run(&[&PARTLY, &PASSES], &Options::default()));
    }

    #[test]
    fn steps_after_a_failure_still_run() {
        use std::sync::atomic::{AtomicBool, Ordering};
        static REACHED: AtomicBool = AtomicBool::new(false);
        fn reach(_: &Options) -> Result<Outcome, Stop> {
            REACHED.store(true, Ordering::Relaxed);
            Ok(Outcome::PASSED)
        }
        let reaches = step("reaches", "", reach);
        assert!(!run(&[&FAILS, &reaches], &Options::default()));
        assert!(REACHED.load(Ordering::Relaxed));
    }

    #[test]
    fn names_are_unique() {
        let mut names: Vec<&str> = STEPS.iter().chain(OTHERS).chain(quick::STEPS).map(|step| step.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), STEPS.len() + OTHERS.len() + quick::STEPS.len());
    }
}
