//! `fuzz OPERATIONS SEED` does that many operations from that seed on; `fuzz session SEED [OPERATION…]` does one session again,
//! or these of its operations, and prints them.

use scphd_tests::fuzz;
use std::process::ExitCode;
use std::time::Instant;

const USAGE: &str = "usage: fuzz OPERATIONS SEED | fuzz session SEED [OPERATION...]";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let Ok(numbers) = words
        .iter()
        .skip(usize::from(words.first().is_some_and(|word| word == "session")))
        .map(|word| word.parse())
        .collect()
    else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let numbers: Vec<u64> = numbers;
    let outcome = match (numbers.len() < words.len(), &numbers[..]) {
        (true, [seed, operations @ ..]) => {
            let operations: Vec<usize> = operations.iter().map(|&operation| operation as usize).collect();
            fuzz::replay(*seed, &operations)
        }
        (false, &[operations, seed]) => all(operations, seed),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failed) => {
            eprintln!("{failed}");
            ExitCode::FAILURE
        }
    }
}

fn all(operations: u64, seed: u64) -> Result<(), Box<fuzz::Failed>> {
    let start = Instant::now();
    let step = (operations / 20).max(1);
    let mut next = step;
    fuzz::run(operations, seed, &mut |done| {
        if done >= next || done >= operations {
            println!("{done} operations, {:.0} s", start.elapsed().as_secs_f64());
            next = done + step;
        }
    })?;
    println!("nothing panicked or hung, and every state was sound");
    Ok(())
}
