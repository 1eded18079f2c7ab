//! The step `counts`: instructions of the host's benches, as callgrind counts them, against the committed ones.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::PACKAGE;
use crate::install;
use crate::noalloc;
use crate::process;
use crate::steps::Outcome;

/// The committed counts.
const FILE: &str = "benches/counts.toml";
/// Set to 1 to rewrite them.
const BLESS: &str = "SCPHD_BLESS";
/// By how much a count may rise before the step fails.
const TOLERANCE: f64 = 0.03;
/// The setups run under callgrind too, fifty times slower than elsewhere.
const LIMIT: Duration = Duration::from_secs(1800);
/// Steps that the benches count together.
const STEPS: f64 = 10.0;

/// The program that runs the benches in callgrind; its version is that of the library.
const RUNNER: &str = "gungraun-runner";

/// Counts with the compiler whose code was counted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Counts {
    compiler: String,
    /// Instructions of a step, a motion and a scan.
    instructions: BTreeMap<String, u64>,
}

/// The step.
pub fn step() -> Outcome {
    match compare() {
        Ok(note) => Outcome::Passed(note),
        Err(reason) => Outcome::Failed(reason),
    }
}

fn compare() -> Result<String, String> {
    let path = process::root().join(FILE);
    let counted = count()?;
    if std::env::var_os(BLESS).is_some_and(|value| value == "1") {
        let text = toml::to_string(&counted).map_err(|error| error.to_string())?;
        let head = "# Instructions of a step, a motion and a scan, on the host; `cargo xtask counts` compares them, and rewrites\n\
                    # them where the environment variable SCPHD_BLESS is 1.\n";
        std::fs::write(&path, format!("{head}{text}")).map_err(|error| format!("{}: {error}", path.display()))?;
        return Ok(format!("{FILE} rewritten"));
    }
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let committed: Counts = toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    for (name, count) in &counted.instructions {
        let before =
            committed.instructions.get(name).map_or_else(|| "new".to_owned(), |before| change(*before, *count));
        println!("{name:24} {count:>12}  {before}");
    }
    if counted.compiler != committed.compiler {
        return Ok(format!("NOT COMPARED: {FILE} is of {}, this is {}", committed.compiler, counted.compiler));
    }
    let worse = committed.risen(&counted);
    if worse.is_empty() { Ok(format!("{} counts", counted.instructions.len())) } else { Err(worse.join("; ")) }
}

impl Counts {
    /// The counts that have risen by more than the tolerance, or are gone.
    fn risen(&self, now: &Self) -> Vec<String> {
        let each = self.instructions.iter().filter_map(|(name, &before)| match now.instructions.get(name) {
            None => Some(format!("{name} is no longer counted")),
            Some(&now) if now as f64 > before as f64 * (1.0 + TOLERANCE) => {
                Some(format!("{name} has risen from {before} to {now} instructions"))
            }
            Some(_) => None,
        });
        each.collect()
    }
}

/// In percent.
fn change(before: u64, now: u64) -> String {
    format!("{:+.2} %", 100.0 * (now as f64 / before.max(1) as f64 - 1.0))
}

/// Runs the benches in callgrind.
fn count() -> Result<Counts, String> {
    if process::read(process::command("valgrind").arg("--version")).is_err() {
        install::packages(&["valgrind"])?;
    }
    let tools = runner()?;
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::iter::once(tools).chain(std::env::split_paths(&path));
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
    let compiler = process::read(process::command(noalloc::rustc()).arg("--version"))?;
    Ok(Counts { compiler, instructions })
}

/// All instructions of a bench; beside those of an earlier run, where there was one.
fn total(summary: &serde_json::Value) -> Option<u64> {
    let metrics = &summary["profiles"][0]["summaries"]["total"]["summary"]["Callgrind"]["Ir"]["metrics"];
    let count = if metrics["Left"].is_null() { &metrics["Both"][0] } else { &metrics["Left"] };
    count["Int"].as_u64()
}

/// The folder of the runner, which is installed there in the version of the library.
fn runner() -> Result<PathBuf, String> {
    let lock = std::fs::read_to_string(process::root().join("Cargo.lock")).map_err(|error| error.to_string())?;
    let version = locked_version(&lock, RUNNER).ok_or_else(|| format!("Cargo.lock has no {RUNNER}"))?;
    let tools = process::own_target_dir("tools");
    if process::read(process::command(tools.join("bin").join(RUNNER)).arg("--version"))
        .is_ok_and(|found| found.ends_with(&version))
    {
        return Ok(tools.join("bin"));
    }
    let mut install = process::cargo();
    install.args(["install", RUNNER, "--locked", "--force", "--version", &version, "--root"]).arg(&tools);
    install.arg("--target-dir").arg(Path::new(&tools).join("build"));
    process::run(&mut install)?;
    Ok(tools.join("bin"))
}

/// The version that a lock file has of a package.
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
        Counts { compiler: "rustc".into(), instructions }
    }

    #[test]
    fn a_rise_and_a_loss_fail_and_a_fall_does_not() {
        let committed = counts(&[("same", 1000), ("less", 1000), ("little", 1000), ("more", 1000), ("gone", 1000)]);
        let now = counts(&[("same", 1000), ("less", 10), ("little", 1029), ("more", 1031), ("new", 7)]);
        let risen = committed.risen(&now);
        assert_eq!(risen.len(), 2);
        assert!(risen[0].starts_with("gone") && risen[1].starts_with("more"), "{risen:?}");
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
