//! `fuzz OPERATIONS SEED [TARGET]` runs operations from this seed on, of all targets or of one; `fuzz session TARGET SEED
//! [OPERATION…]` repeats a session, or these of its operations, and prints them.

use scphd_tests::fuzz::{self, Target, counts};
use std::process::ExitCode;
use std::time::Instant;

const USAGE: &str = "usage: fuzz OPERATIONS SEED [TARGET] | fuzz session TARGET SEED [OPERATION...]
targets: mixture, joint, locator, snapshots, streams";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let Some(outcome) = asked(&words) else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failed) => {
            eprintln!("{failed}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the request; `None` if the arguments are invalid.
fn asked(words: &[&str]) -> Option<Result<(), Box<fuzz::Failed>>> {
    let target = |name: &str| Target::ALL.into_iter().find(|target| target.name() == name);
    Some(match words {
        ["session", name, seed, operations @ ..] => {
            let operations: Option<Vec<usize>> = operations.iter().map(|operation| operation.parse().ok()).collect();
            fuzz::replay(target(name)?, seed.parse().ok()?, &operations?)
        }
        [operations, seed] => all(&Target::ALL, operations.parse().ok()?, seed.parse().ok()?),
        [operations, seed, name] => all(&[target(name)?], operations.parse().ok()?, seed.parse().ok()?),
        _ => return None,
    })
}

/// Distributes the operations over the targets by their shares.
fn all(targets: &[Target], operations: u64, seed: u64) -> Result<(), Box<fuzz::Failed>> {
    let shares: u64 = targets.iter().map(|target| target.share()).sum();
    for target in targets {
        one(*target, (operations * target.share()).div_ceil(shares), seed)?;
    }
    println!("nothing panicked or hung, and every state was sound");
    Ok(())
}

fn one(target: Target, operations: u64, seed: u64) -> Result<(), Box<fuzz::Failed>> {
    let start = Instant::now();
    let step = (operations / 10).max(1);
    let mut next = step;
    let done = fuzz::run(target, operations, seed, &mut |done| {
        if done >= next || done >= operations {
            println!("{}: {done} operations, {:.0} s", target.name(), start.elapsed().as_secs_f64());
            next = done + step;
        }
    })?;
    println!(
        "{}: the longest operation took {:.1} ms; what they came to:",
        target.name(),
        1e3 * done.longest.as_secs_f64()
    );
    for ((operation, outcome), times) in counts::take() {
        println!("  {operation}: {outcome}: {times}");
    }
    Ok(())
}
