//! The step `counts`: compares instructions of the host's benches, counted by callgrind, with the committed ones.

use super::PACKAGE;
use crate::outcome::{Missing, Outcome, Stop};
use crate::tools::{Tool, VALGRIND};
use crate::{files, process, toolchain};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The committed counts.
const FILE: &str = "tests/benches/counts.toml";
/// Head of the file with committed counts.
const HEAD: &str = "\
# Instructions of a step, a motion and a scan, on the host; `cargo xtask counts` compares them, and rewrites them where
# the environment variable SCPHD_BLESS is 1. They are of this compiler and this kind of machine. A count may rise by
# `tolerance_percent` with the same compiler, and by `other_compiler_percent` with another; on another kind of machine
# nothing can be compared.
";
/// Time limit: the setups run under callgrind too, fifty times slower than otherwise.
const LIMIT: Duration = Duration::from_secs(1800);
/// Number of steps that the benches count together.
const STEPS: f64 = 10.0;

/// The program that runs the benches in callgrind; it must have the version of the library.
const RUNNER: &str = "gungraun-runner";

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

/// Runs the benches in callgrind.
fn count() -> Result<BTreeMap<String, u64>, Stop> {
    // Checks what may be missing before the build, which takes minutes.
    let valgrind = valgrind_folder(&VALGRIND.obtain()?)?;
    let folders = std::iter::once(runner()?).chain(valgrind);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = folders.chain(std::env::split_paths(&path));
    let path = std::env::join_paths(paths).map_err(|error| error.to_string())?;
    let mut bench = process::cargo();
    bench.env("PATH", path).env("GUNGRAUN_HOME", process::own_target_dir("gungraun"));
    bench.args(["bench", "--quiet", "--package", PACKAGE, "--bench", "instructions", "--", "--output-format=json"]);
    let output = process::capture_for(&mut bench, LIMIT)?;
    let mut instructions = BTreeMap::new();
    for line in String::from_utf8_lossy(&output).lines().filter(|line| line.starts_with('{')) {
        let summary: serde_json::Value = serde_json::from_str(line).map_err(|error| error.to_string())?;
        let id = summary["id"].as_str().ok_or("a count without a name")?;
        let total = total(&summary).ok_or_else(|| format!("no count of {id}"))?;
        instructions.insert(id.to_owned(), (total as f64 / STEPS).round() as u64);
    }
    if instructions.is_empty() {
        return Err("nothing was counted".into());
    }
    Ok(instructions)
}

/// A folder with a `valgrind` that finds its tools in the unpacked tree; without it, it looks for them in its installation path.
fn valgrind_folder(valgrind: &Tool) -> Result<Option<PathBuf>, String> {
    let Some(tree) = &valgrind.tree else { return Ok(None) };
    let folder = process::own_target_dir("valgrind");
    let script = folder.join("valgrind");
    let tools = tree.path("usr/libexec/valgrind");
    let text = format!("#!/bin/sh\nVALGRIND_LIB='{}' exec '{}' \"$@\"\n", tools.display(), valgrind.program.display());
    files::write(&script, text)?;
    process::read(process::command("chmod").arg("+x").arg(&script))?;
    Ok(Some(folder))
}

/// The total number of instructions of a bench; the file may also have those of an earlier run.
fn total(summary: &serde_json::Value) -> Option<u64> {
    let metrics = &summary["profiles"][0]["summaries"]["total"]["summary"]["Callgrind"]["Ir"]["metrics"];
    let count = if metrics["Left"].is_null() { &metrics["Both"][0] } else { &metrics["Left"] };
    count["Int"].as_u64()
}

/// The folder of the runner, installed in the version of the library.
fn runner() -> Result<PathBuf, Stop> {
    let lock = files::text(&process::root().join("Cargo.lock"))?;
    let version = locked_version(&lock, RUNNER).ok_or_else(|| format!("Cargo.lock has no {RUNNER}"))?;
    let tools = process::own_target_dir("tools");
    if process::read(process::command(tools.join("bin").join(RUNNER)).arg("--version"))
        .is_ok_and(|found| found.ends_with(&version))
    {
        return Ok(tools.join("bin"));
    }
    let mut install = process::cargo();
    // Without optimisation, which would take three times as long: it only starts the benches and reads the counts.
    install.args(["install", RUNNER, "--debug", "--locked", "--force", "--version", &version, "--root"]).arg(&tools);
    install.arg("--target-dir").arg(Path::new(&tools).join("build"));
    process::run(&mut install).map_err(|reason| Missing(format!("no {RUNNER} {version}: {reason}")))?;
    Ok(tools.join("bin"))
}

fn locked_version(lock: &str, package: &str) -> Option<String> {
    let lock: toml::Table = lock.parse().ok()?;
    let packages = lock.get("package")?.as_array()?;
    let found = packages.iter().find(|entry| entry.get("name").and_then(|name| name.as_str()) == Some(package))?;
    found.get("version")?.as_str().map(str::to_owned)
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
    fn counts_are_read_with_and_without_earlier_ones() {
        let summary = |metrics: &str| {
            let text = format!(
                r#"{{"profiles": [{{"summaries": {{"total": {{"summary": {{"Callgrind": {{"Ir": {{"metrics": {metrics}}}}}}}}}}}}}]}}"#
            );
            total(&serde_json::from_str(&text).unwrap())
        };
        assert_eq!(summary(r#"{"Left": {"Int": 7}}"#), Some(7));
        assert_eq!(summary(r#"{"Both": [{"Int": 8}, {"Int": 7}]}"#), Some(8));
        assert_eq!(summary("{}"), None);
    }

    #[test]
    fn the_projects_lock_file_names_the_runner() {
        let lock = std::fs::read_to_string(process::root().join("Cargo.lock")).unwrap();
        assert!(locked_version(&lock, RUNNER).is_some_and(|version| version.starts_with(char::is_numeric)));
    }
}
