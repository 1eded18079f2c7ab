//! Paths of the results of independent implementations and of the recorded logs. The former are in `tests/oracles`. The latter
//! belong to others and are not part of this repository; a test whose log is missing passes, but is counted as skipped by `cargo
//! xtask test`.

use std::env;
use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process;
use std::thread;

/// Environment variable with the folder of the logs.
pub const FOLDER: &str = "SCPHD_DATA";
/// Environment variable with the file to which a test without its log appends a line: its package and name.
pub const SKIPPED: &str = "SCPHD_SKIPPED";

const ORACLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../oracles");

/// The folder of the logs: that of [`FOLDER`], by default `shared/data` beside the repository.
pub fn folder() -> PathBuf {
    env::var_os(FOLDER).map_or_else(beside, PathBuf::from)
}

/// The folder `shared/data` beside the repository.
fn beside() -> PathBuf {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    folders.nth(3).unwrap_or(Path::new("..")).join("shared/data")
}

/// The path of the log or file `name`. If it is missing, the calling test is recorded as skipped.
pub fn find(name: &str) -> Option<PathBuf> {
    let path = folder().join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no {}", path.display());
    if let Some(file) = env::var_os(SKIPPED) {
        // The test harness names a thread after its test.
        let package = env::var("CARGO_PKG_NAME").unwrap_or_default();
        let line = format!("{package} {}\n", thread::current().name().unwrap_or("unnamed"));
        append(Path::new(&file), &line).unwrap_or_else(|error| panic!("{}: {error}", Path::new(&file).display()));
    }
    None
}

/// A file with results of independent implementations; `tests/oracles/README.md` has their sources.
pub fn oracle(name: &str) -> serde_json::Value {
    let path = Path::new(ORACLES).join(name);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The numbers of a list in an oracle.
pub fn numbers(value: &serde_json::Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|number| number.as_f64().expect("a number")).collect()
}

/// A new folder for files of a test, deleted when this value is dropped.
#[derive(Debug)]
pub struct Folder(pub PathBuf);

impl Folder {
    /// A folder with this word in its name.
    pub fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("scphd-{name}-{}", process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Self(path)
    }

    /// The sorted names of its files.
    pub fn names(&self) -> Vec<String> {
        let files = fs::read_dir(&self.0).expect("a folder");
        let name = |file: io::Result<fs::DirEntry>| file.expect("a file").file_name().to_string_lossy().into_owned();
        let mut names: Vec<String> = files.map(name).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Appends in a single write, because tests run in parallel.
fn append(path: &Path, line: &str) -> io::Result<()> {
    OpenOptions::new().create(true).append(true).open(path)?.write_all(line.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    /// Requests a missing log; run by the test below in a process with its own environment.
    #[test]
    #[ignore = "only as a part of a_log_that_is_not_there_is_counted"]
    fn asks() {
        assert_eq!(find("none-of-this-name"), None);
    }

    #[test]
    fn a_log_that_is_not_there_is_counted() {
        let file = env::temp_dir().join(format!("scphd-skipped-{}", process::id()));
        for expected in [1, 2] {
            let asking = Command::new(env::current_exe().unwrap())
                .args(["--ignored", "--exact", "tests::asks", "--nocapture"])
                .env(FOLDER, env::temp_dir())
                .env(SKIPPED, &file)
                .output()
                .unwrap();
            assert!(asking.status.success(), "{asking:?}");
            let notice = String::from_utf8(asking.stderr).unwrap();
            assert_eq!(notice.matches("skipped: no ").count(), 1, "{notice}");
            let lines = fs::read_to_string(&file).unwrap();
            assert_eq!(lines.lines().filter(|line| line.ends_with(" tests::asks")).count(), expected, "{lines}");
        }
        fs::remove_file(file).unwrap();
    }

    #[test]
    fn shared_data_is_beside_the_repository() {
        let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
        assert!(workspace.join("Cargo.lock").is_file());
        assert_eq!(beside(), workspace.parent().unwrap().join("shared/data"));
    }
}
