//! Other programs read the exported files of a run, and find the values of the run's own tables.
//!
//! `cargo xtask logs` installs them into an environment of their own and runs this test, which does not run without them.

#[path = "../folders/mod.rs"]
mod folders;

use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// The variable with the Python of the environment; `SCPHD_READERS_ALL` requests the large programs, too.
const PYTHON: &str = "SCPHD_READERS_PYTHON";

fn succeeds(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{command:?}\n{text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

#[test]
#[ignore = "needs Python packages: cargo xtask logs"]
fn other_programs_read_a_run() {
    let python = PathBuf::from(std::env::var_os(PYTHON).expect(PYTHON));
    let place = TempDir::new().unwrap();
    folders::put(&place.path().join("stereo"), &folders::stereo());
    let runs: [&[&str]; 3] = [
        &["run", "survey"],
        &["run", "thesis-dynamic", "--filter", "core", "--particles", "8"],
        &["replay", "stereo", "--particles", "8"],
    ];
    for (k, words) in runs.into_iter().enumerate() {
        let out = format!("out{k}");
        let (mcap, json) = (format!("{out}/run.mcap"), format!("{out}/run.json"));
        std::fs::create_dir(place.path().join(&out)).unwrap();
        let mut sim = Command::new(env!("CARGO_BIN_EXE_scphd-sim"));
        sim.args(words).args(["--out", &out, "--mcap", &mcap, "--json", &json, "--quiet"]);
        succeeds(sim.current_dir(place.path()));
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers/read.py");
        let mut reads = Command::new(&python);
        reads.arg(script).arg(&out).current_dir(place.path());
        reads.args(std::env::var_os("SCPHD_READERS_ALL").map(|_| "--all"));
        print!("{}", succeeds(&mut reads));
    }
}
