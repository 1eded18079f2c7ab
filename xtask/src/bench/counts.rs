//! The step `counts`: compares instructions on the host, counted by callgrind, with the committed ones.

use super::PACKAGE;
use crate::outcome::{Missing, Outcome, Stop};
use crate::{files, process, toolchain, tools};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

const FILE: &str = "tests/benches/counts.toml";
const HEAD: &str = "\
# Instructions of a step, a motion and a scan, on the host; `cargo xtask counts` compares them, and rewrites them where
# the environment variable SCPHD_BLESS is 1. They are of this compiler and this kind of machine. A count may rise by
# `tolerance_percent` with the same compiler, and by `other_compiler_percent` with another; on another kind of machine
# nothing can be compared.
";
/// Time limit: the setups run under callgrind too, fifty times slower than otherwise.
const LIMIT: Duration = Duration::from_secs(1800);
/// The program, which prints the names of its cases, and runs one of them.
const PROGRAM: &str = "instructions";
/// Number of steps that are counted together.
const STEPS: f64 = 10.0;

/// Counts, and the compiler of the counted code.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Counts {
    compiler: String,
    host: String,
    tolerance_percent: f64,
    other_compiler_percent: f64,
    /// Instructions of a step, a motion and a scan.
    instructions: BTreeMap<String, u64>,
}

pub fn step() -> Result<Outcome, Stop> {
    let path = process::root().join(FILE);
    let committed: Counts =
        toml::from_str(&files::text(&path)?).map_err(|error| format!("{}: {error}", path.display()))?;
    let compiler = process::read(process::rustc().arg("--version"))?;
    let counted = Counts { compiler, host: toolchain::host()?, instructions: count()?, ..committed.clone() };
    if process::is_blessing() {
        let text = toml::to_string(&counted).map_err(|error| error.to_string())?;
        files::write(&path, format!("{HEAD}{text}"))?;
        return Ok(Outcome::Passed(format!("{FILE} rewritten")));
    }
    for (name, count) in &counted.instructions {
        let before =
            committed.instructions.get(name).map_or_else(|| "new".to_owned(), |before| change(*before, *count));
        println!("{name:24} {count:>12}  {before}");
    }
    committed.judge(&counted)
}

impl Counts {
    /// Compares new counts with these.
    fn judge(&self, now: &Self) -> Result<Outcome, Stop> {
        if now.host != self.host {
            let reason = format!("counted, NOT COMPARED: {FILE} is of {}, this is {}", self.host, now.host);
            return Err(Missing(reason).into());
        }
        let same = now.compiler == self.compiler;
        let percent = if same { self.tolerance_percent } else { self.other_compiler_percent };
        let worse = self.risen(now, percent);
        let (set, number) = (&self.compiler, now.instructions.len());
        let other = format!(
            "of another compiler, so compared within {percent} %: counted with {set}, this is {}",
            now.compiler
        );
        match (worse.is_empty(), same) {
            (true, true) => Ok(Outcome::Passed(format!("{number} counts within {percent} %"))),
            (true, false) => Ok(Outcome::Passed(format!("{number} counts {other}"))),
            (false, true) => Err(worse.join("; ").into()),
            (false, false) => Err(format!("{}; {other}", worse.join("; ")).into()),
        }
    }

    /// The counts that have risen by more than this, that are missing, or that are not committed.
    fn risen(&self, now: &Self, percent: f64) -> Vec<String> {
        let each = self.instructions.iter().filter_map(|(name, &before)| match now.instructions.get(name) {
            None => Some(format!("{name} is no longer counted")),
            Some(&now) if now as f64 > before as f64 * (1.0 + percent / 100.0) => {
                Some(format!("{name} has risen from {before} to {now} instructions"))
            }
            Some(_) => None,
        });
        let new = now.instructions.keys().filter(|name| !self.instructions.contains_key(*name));
        each.chain(new.map(|name| format!("{name} is not in {FILE}"))).collect()
    }
}

/// The relative change, in percent.
fn change(before: u64, now: u64) -> String {
    format!("{:+.2} %", 100.0 * (now as f64 / before.max(1) as f64 - 1.0))
}

/// Runs each case in callgrind, as many at a time as there are cores.
fn count() -> Result<BTreeMap<String, u64>, Stop> {
    // Checks what may be missing before the build.
    tools::valgrind()?;
    let program = program()?;
    let cases = process::read(&mut process::command(&program))?;
    let cases: Vec<&str> = cases.lines().collect();
    let folder = process::own_target_dir("callgrind");
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let counted = process::side_by_side(&cases, |case| {
        let out = folder.join(case).with_extension("out");
        let mut callgrind = tools::valgrind()?;
        callgrind.args(["--quiet", "--tool=callgrind", "--toggle-collect=*counted_steps*"]);
        callgrind.arg(format!("--callgrind-out-file={}", out.display())).arg(&program).arg(case);
        process::run_for(&mut callgrind, LIMIT)?;
        let total = total(&files::text(&out)?).ok_or_else(|| format!("no count of {case} in {}", out.display()))?;
        Ok(((*case).to_owned(), (total as f64 / STEPS).round() as u64))
    })?;
    if counted.is_empty() {
        return Err("nothing was counted".into());
    }
    Ok(counted.into_iter().collect())
}

/// The program with the cases, in the profile of the benches.
fn program() -> Result<PathBuf, String> {
    let mut build = process::cargo();
    build.args(["build", "--quiet", "--profile", "bench", "--package", PACKAGE, "--bin", PROGRAM]);
    process::run(build.arg("--target-dir").arg(process::target_dir()))?;
    Ok(process::target_dir().join("release").join(PROGRAM))
}

/// The number of instructions in a file of callgrind.
fn total(text: &str) -> Option<u64> {
    let total = text.lines().find_map(|line| line.strip_prefix("totals: "))?.parse().ok();
    total.filter(|&instructions| instructions > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(rows: &[(&str, u64)]) -> Counts {
        let instructions = rows.iter().map(|&(name, count)| (name.to_owned(), count)).collect();
        let [compiler, host] = ["rustc 1", "here"].map(str::to_owned);
        Counts { compiler, host, tolerance_percent: 3.0, other_compiler_percent: 15.0, instructions }
    }

    #[test]
    fn increased_and_missing_counts_fail_and_decreased_ones_do_not() {
        let committed = counts(&[("same", 1000), ("less", 1000), ("little", 1000), ("more", 1000), ("gone", 1000)]);
        let now = counts(&[("same", 1000), ("less", 10), ("little", 1029), ("more", 1031), ("new", 7)]);
        let risen = committed.risen(&now, 3.0);
        assert_eq!(risen.len(), 3);
        assert!(
            risen[0].starts_with("gone") && risen[1].starts_with("more") && risen[2].starts_with("new"),
            "{risen:?}"
        );
    }

    #[test]
    fn another_compiler_has_more_tolerance_and_another_host_is_not_compared() {
        let committed = counts(&[("scan", 1000)]);
        let with = |compiler: &str, host: &str, count| {
            let now = Counts { compiler: compiler.into(), host: host.into(), ..counts(&[("scan", count)]) };
            committed.judge(&now)
        };
        assert!(with("rustc 1", "here", 1029).is_ok());
        assert!(matches!(with("rustc 1", "here", 1100), Err(Stop::Broken(_))));
        assert!(
            matches!(with("rustc 2", "here", 1100), Ok(Outcome::Passed(note)) if note.contains("another compiler"))
        );
        assert!(matches!(with("rustc 2", "here", 1160), Err(Stop::Broken(_))));
        assert!(matches!(with("rustc 1", "there", 1000), Err(Stop::Missing(note)) if note.contains("NOT COMPARED")));
    }

    #[test]
    fn a_count_is_the_total_of_a_file() {
        assert_eq!(total("events: Ir\nfn=(1) steps\n3 40\ntotals: 40\n"), Some(40));
        assert_eq!((total("events: Ir\n"), total("totals: 0\n")), (None, None));
    }
}
