//! A folder for runs of the program.

use scphd_log::log::Log;
use scphd_log::log_folder;
use scphd_worlds::scenario;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A folder that is removed at the end of the test.
pub struct Place(TempDir);

impl Place {
    pub fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    /// A folder with the first scans of the survey in `log`.
    pub fn with_log(scans: usize) -> Self {
        let place = Self::new();
        log_folder::write(&survey_of(scans), &place.path("log")).unwrap();
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }

    /// A command of the program in this folder.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scphd-sim"));
        command.args(args).current_dir(self.0.path());
        command
    }

    pub fn run(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    pub fn succeeds(&self, args: &[&str]) -> Output {
        let output = self.run(args);
        assert!(output.status.success(), "{args:?}: {output:?}");
        output
    }

    /// The standard output of a successful command.
    pub fn prints(&self, args: &[&str]) -> String {
        String::from_utf8(self.succeeds(args).stdout).unwrap()
    }

    /// The standard error of a successful command.
    pub fn tells(&self, args: &[&str]) -> String {
        String::from_utf8(self.succeeds(args).stderr).unwrap()
    }

    /// The line on stderr of a command that must fail because of its input, without writing files.
    pub fn fails(&self, args: &[&str]) -> String {
        let before = all_names(self.0.path());
        let output = self.run(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {output:?}");
        assert!(output.stdout.is_empty(), "{args:?}: {output:?}");
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.starts_with("error: ") && error.lines().count() == 1, "{args:?}: {error}");
        assert_eq!(all_names(self.0.path()), before, "{args:?}");
        error
    }

    /// Each of the commands must fail with all parts of its message.
    pub fn refuses(&self, cases: &[(&[&str], &[&str])]) {
        for (args, parts) in cases {
            let error = self.fails(args);
            assert!(parts.iter().all(|part| error.contains(part)), "{args:?}: {error}");
        }
    }
}

pub fn survey_of(scans: usize) -> Log {
    let mut log = scenario::survey(3);
    log.scans.truncate(scans);
    log.truth.truncate(scans);
    log.odometry.truncate(2 * scans);
    log
}

/// The values in the row of a printed table with this name.
pub fn row<'t>(table: &'t str, name: &str) -> Vec<&'t str> {
    let row = table.lines().find_map(|line| line.trim_start().strip_prefix(name));
    row.unwrap_or_else(|| panic!("{name}: {table}")).split_whitespace().collect()
}

/// Names in a folder, sorted.
pub fn names(dir: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Paths in a folder and its subfolders.
fn all_names(dir: &Path) -> Vec<PathBuf> {
    let paths: Vec<PathBuf> = names(dir).into_iter().map(|name| dir.join(name)).collect();
    let inside = |path: &PathBuf| if path.is_dir() { all_names(path) } else { Vec::new() };
    let mut all: Vec<PathBuf> = paths.iter().flat_map(inside).collect();
    all.extend(paths);
    all
}

/// The object without times, which differ between runs.
pub fn timeless(mut figures: Value) -> Value {
    figures.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scan_us"));
    figures
}
