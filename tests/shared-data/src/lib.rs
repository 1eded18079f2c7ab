//! Where the numbers of independent implementations and the recorded logs are. The former are in `tests/oracles`. The
//! latter belong to others and are not part of this repository; a test that needs one and does not find it passes, but
//! says so where `cargo xtask test` counts it.

use std::env;
use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::thread;

/// The environment variable that names the folder of the logs.
pub const FOLDER: &str = "SCPHD_DATA";
/// The environment variable that names the file to which a test without its log appends a line: its package and name.
pub const SKIPPED: &str = "SCPHD_SKIPPED";

/// The folder of the oracles.
const ORACLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../oracles");

/// The folder of the logs: the one that [`FOLDER`] names, otherwise `shared/data` beside the repository.
#[must_use]
pub fn folder() -> PathBuf {
    env::var_os(FOLDER).map_or_else(beside, PathBuf::from)
}

/// The folder `shared/data` beside the repository.
fn beside() -> PathBuf {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    folders.nth(3).unwrap_or(Path::new("..")).join("shared/data")
}

/// The path of the log, or of the file, `name`. Where there is none the test that asks is noted as skipped.
///
/// # Panics
/// The file that [`SKIPPED`] names cannot be written: a test that is skipped and not counted would pass for one that ran.
#[must_use]
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

/// The text of a file of numbers of independent implementations; `tests/oracles/README.md` says whose.
///
/// # Panics
/// It is not there: it is part of this repository, so that a test without it is broken.
#[must_use]
pub fn oracle(name: &str) -> String {
    let path = Path::new(ORACLES).join(name);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// In one write, because tests run beside each other.
fn append(path: &Path, line: &str) -> io::Result<()> {
    OpenOptions::new().create(true).append(true).open(path)?.write_all(line.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    /// Asks for what [`FOLDER`] has not; the test below runs it in a process of its own, with an environment of its own.
    #[test]
    #[ignore = "only as a part of a_log_that_is_not_there_is_counted"]
    fn asks() {
        assert_eq!(find("none-of-this-name"), None);
    }

    #[test]
    fn a_log_that_is_not_there_is_counted() {
        let file = env::temp_dir().join(format!("scphd-skipped-{}", std::process::id()));
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
