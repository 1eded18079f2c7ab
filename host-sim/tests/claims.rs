//! The figures in the documentation: each figure of `tests/expected/claims.toml` is in its file, and its command gives it within
//! a factor of 1.2.
//!
//! Every test run executes a fast part of the commands, `cargo xtask claims` all of them.

use serde::Deserialize;
use serde_json::{Map, Value};
use std::fs;
use std::path::PathBuf;
use std::process::Command as Process;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Instant;

/// Greatest ratio of the figure of a command and the claimed one.
const MARGIN: f64 = 1.2;
/// Additional tolerance for a part of the runs, in standard deviations of its mean.
const SIGMAS: f64 = 2.0;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Claims {
    command: Vec<Command>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Command {
    run: String,
    quick: Option<String>,
    /// Required text in its output besides the figures.
    #[serde(default)]
    says: Vec<String>,
    claim: Vec<Claim>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Claim {
    key: String,
    #[serde(default)]
    of: Map<String, Value>,
    #[serde(default)]
    over: Over,
    figure: String,
    #[serde(default = "one")]
    scale: f64,
    #[serde(default = "readme")]
    file: String,
    text: String,
    #[serde(default)]
    spread: f64,
    #[serde(default)]
    least: bool,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Over {
    #[default]
    Mean,
    Rms,
    Greatest,
}

fn one() -> f64 {
    1.0
}

fn readme() -> String {
    "README.md".into()
}

fn read(path: &str) -> String {
    fs::read_to_string(PathBuf::from(ROOT).join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn claims() -> Vec<Command> {
    toml::from_str::<Claims>(&read("tests/expected/claims.toml")).expect("claims").command
}

impl Claim {
    fn figure(&self) -> f64 {
        self.figure.parse().unwrap_or_else(|_| panic!("a figure: {}", self.figure))
    }

    /// The greatest, or least, valid figure of all runs.
    fn bound(&self) -> f64 {
        if self.least { self.figure() / MARGIN } else { self.figure() * MARGIN }
    }

    /// The figure in the JSON of a command, and its number of runs; `None` if no object matches the claim.
    fn found(&self, json: &Value) -> Option<(f64, f64)> {
        let objects = json.as_array().map_or(std::slice::from_ref(json), |list| list);
        let is = |found: &Value, asked: &Value| match (found.as_str(), asked.as_str()) {
            (Some(found), Some(asked)) => found.ends_with(asked),
            _ => found == asked,
        };
        let taken: Vec<&Value> =
            objects.iter().filter(|object| self.of.iter().all(|(key, value)| is(&object[key], value))).collect();
        let value =
            |object: &&Value| self.scale * object[&self.key].as_f64().unwrap_or_else(|| panic!("{self:?}: null"));
        let values: Vec<f64> = taken.iter().map(value).collect();
        let mean = |power: i32| values.iter().map(|value| value.powi(power)).sum::<f64>() / values.len() as f64;
        let found = match self.over {
            Over::Mean => mean(1),
            Over::Rms => mean(2).sqrt(),
            Over::Greatest => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        };
        let runs = |object: &&Value| object["runs"].as_f64().unwrap_or(1.0);
        (!taken.is_empty()).then(|| (found, taken.iter().map(runs).sum()))
    }

    /// A line that compares the JSON of a command, with all runs or a part of them, with the claim; an error if the claim fails.
    /// The output of a part may lack the run of a claim.
    fn fault(&self, json: &Value, all: bool) -> Result<String, String> {
        let of = Value::from(self.of.clone());
        let Some((found, runs)) = self.found(json) else {
            let line = format!("{} {of}: no such run", self.key);
            return if all { Err(line) } else { Ok(line) };
        };
        let more = if all { 0.0 } else { SIGMAS * self.spread / runs.sqrt() };
        let bound = if self.least { self.bound() - more } else { self.bound() + more };
        let (key, over, figure) = (&self.key, self.over, &self.figure);
        let line = format!("{key} {of} {over:?}: {found:.4e} of {figure} claimed, bound {bound:.4e}");
        // Written so that NaN fails.
        let holds = if self.least { found >= bound } else { found <= bound };
        if holds { Ok(line) } else { Err(line) }
    }
}

impl Command {
    /// The arguments of a command with the folders of its logs; `None` if a folder is missing.
    fn words(command: &str) -> Option<Vec<String>> {
        let logs = ["victoria_park", "car_park", "mrclam_", "phd_slam3_", "thesis_cmp_", "starry_night"];
        let word = |word: &str| match logs.iter().any(|log| word.starts_with(log)) {
            true => Some(scphd_shared_data::find(word)?.to_str().expect("a name of a folder").to_owned()),
            false => Some(word.to_owned()),
        };
        command.split_whitespace().map(word).collect()
    }
}

/// The columns of a printed table, whose first one has the names of the rows, as JSON.
fn columns(table: &str) -> Value {
    let mut columns = [Map::new(), Map::new()];
    for line in table.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let Some((name, values)) = words.split_last_chunk::<2>() else { continue };
        for (column, value) in columns.iter_mut().zip(values) {
            let value = value.parse::<f64>().map_or_else(|_| Value::from(*value), Value::from);
            column.insert(name.join(" "), value);
        }
    }
    columns.map(Value::from).into_iter().collect()
}

/// Runs the program. Returns its JSON, and its output on stderr. `compare` only prints a table, for both precisions.
fn output(words: &[String]) -> (Value, String) {
    let mut process = Process::new(env!("CARGO_BIN_EXE_scphd-sim"));
    let is_printed = words[0] == "compare";
    let json: &[&str] = if is_printed { &[] } else { &["--json", "-"] };
    let output = process.args(words).args(json).current_dir(ROOT).output().expect("the program");
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    let json = match is_printed {
        true => columns(&String::from_utf8_lossy(&output.stdout)),
        false => serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{words:?}: {error}")),
    };
    (json, String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Executes all commands, as many in parallel as there are cores, and reports every claim that fails.
fn check(all: bool) {
    let commands = claims();
    let of = |command: &Command| if all { Some(command.run.clone()) } else { command.quick.clone() };
    // The logs are searched for here, in the thread with the test's name.
    let mut todo: Vec<(&Command, Vec<String>)> = commands
        .iter()
        .filter_map(|command| {
            let mut words = Command::words(&of(command)?)?;
            if words[0] == "monte-carlo" {
                words.extend(["--jobs", "1"].map(str::to_owned));
            }
            Some((command, words))
        })
        .collect();
    // Runs under water take the longest, then studies, and are started first.
    todo.sort_by_key(|(_, words)| (!words.iter().any(|word| word == "girona-tank"), words[0] != "monte-carlo"));
    let (next, faults) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let worker = || {
        while let Some((command, words)) = todo.get(next.fetch_add(1, Ordering::Relaxed)) {
            let started = Instant::now();
            let (json, said) = output(words);
            let mut lines = vec![format!("{}: {:.1} s", words.join(" "), started.elapsed().as_secs_f32())];
            let mut wrong = Vec::new();
            for claim in &command.claim {
                match claim.fault(&json, all) {
                    Ok(line) => lines.push(line),
                    Err(line) => wrong.push(line),
                }
            }
            wrong.extend(
                command
                    .says
                    .iter()
                    .filter(|says| all && !said.contains(*says))
                    .map(|says| format!("does not say: {says}")),
            );
            lines.extend(wrong.iter().map(|line| format!("WRONG: {line}")));
            println!("{}", lines.join("\n  "));
            faults.lock().unwrap().extend(wrong.into_iter().map(|line| format!("{}: {line}", command.run)));
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(worker);
        }
    });
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_part_of_every_claim_holds() {
    check(false);
}

#[test]
#[ignore = "takes long: cargo xtask claims"]
fn every_claim_holds() {
    check(true);
}

#[test]
fn every_figure_is_in_the_file_that_claims_it() {
    for claim in claims().iter().flat_map(|command| &command.claim) {
        // Line breaks are ignored.
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words(&claim.text).contains(&claim.figure), "{claim:?}");
        assert!(words(&read(&claim.file)).contains(&words(&claim.text)), "{} has no {:?}", claim.file, claim.text);
    }
}

#[test]
fn bounds_are_on_the_right_side() {
    let claim = |least: bool, spread: f64| -> Claim {
        let text = format!("key = \"x\"\nfigure = \"0.6\"\ntext = \"0.6\"\nleast = {least}\nspread = {spread}");
        toml::from_str(&text).unwrap()
    };
    let json = |values: [f64; 4]| Value::from(values.map(|x| serde_json::json!({ "x": x })).to_vec());
    assert!(claim(false, 0.0).fault(&json([0.7; 4]), true).is_ok());
    assert!(claim(false, 0.0).fault(&json([0.73; 4]), true).is_err());
    assert!(claim(true, 0.0).fault(&json([0.51; 4]), true).is_ok());
    assert!(claim(true, 0.0).fault(&json([0.49; 4]), true).is_err());
    // For four runs the tolerance is increased by their standard deviation.
    assert!(claim(false, 0.1).fault(&json([0.81; 4]), false).is_ok());
    assert!(claim(false, 0.1).fault(&json([0.81; 4]), true).is_err());
    assert!(claim(false, 0.1).fault(&json([0.83; 4]), false).is_err());
}
