//! Runs the programs of `cargo test` side by side. Cargo runs them one after the other, so that every program whose longest test
//! outlasts its others leaves cores without work.

use crate::process;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A message of cargo's build: the executable of a test, if it has one.
#[derive(Deserialize)]
struct Message {
    manifest_path: Option<PathBuf>,
    package_id: Option<String>,
    executable: Option<PathBuf>,
    target: Option<Target>,
}

#[derive(Deserialize)]
struct Target {
    name: String,
    kind: Vec<String>,
}

struct Program {
    path: PathBuf,
    /// Folder and name of its package, which cargo tells the programs that it runs.
    folder: PathBuf,
    package: String,
    /// Kind and name of its target, for messages.
    target: String,
}

/// Builds the tests that these arguments select, with `cargo test`, and runs them, as many programs at a time as there are cores.
/// Prints the output of each program when it has ended, and fails with the names of all programs that failed.
/// Tests without their data are recorded in the file `skipped`.
pub fn run(arguments: &[&str], skipped: &Path) -> Result<(), String> {
    let mut build = process::cargo();
    // `target/cargo-timings` then has the build time of each crate.
    build.args(["test", "--no-run", "--timings", "--message-format", "json-render-diagnostics"]).args(arguments);
    let mut programs = programs(&process::read_loudly(&mut build)?)?;
    if programs.is_empty() {
        return Err("cargo built no test".into());
    }
    // The longest programs first, so that the last one is short: the claims, then unit tests of libraries.
    programs.sort_by_key(|program| (program.target != "test claims", !program.target.starts_with("lib")));
    let ran = process::side_by_side(&programs, |program| {
        let started = Instant::now();
        let mut command = process::command(&program.path);
        command.current_dir(&program.folder).env("CARGO_MANIFEST_DIR", &program.folder);
        let output = command.env("CARGO_PKG_NAME", &program.package).env(scphd_shared_data::SKIPPED, skipped).output();
        let output = output.map_err(|error| format!("{}: {error}", program.path.display()))?;
        let [said, complaint] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
        let elapsed = started.elapsed().as_secs_f32();
        println!("{} {}: {elapsed:.1} s\n{said}{complaint}", program.package, program.target);
        Ok((!output.status.success()).then(|| format!("{} {}", program.package, program.target)))
    })?;
    let failed: Vec<String> = ran.into_iter().flatten().collect();
    if failed.is_empty() { Ok(()) } else { Err(format!("failed tests: {}", failed.join(", "))) }
}

/// The test programs in cargo's messages.
fn programs(messages: &str) -> Result<Vec<Program>, String> {
    let mut programs = Vec::new();
    for line in messages.lines().filter(|line| line.starts_with('{')) {
        let message: Message = serde_json::from_str(line).map_err(|error| format!("{error}: {line}"))?;
        let (Some(path), Some(target), Some(manifest), Some(id)) =
            (message.executable, message.target, message.manifest_path, message.package_id)
        else {
            continue;
        };
        // Programs that the tests start are built with them.
        let is_test = path.parent().is_some_and(|folder| folder.ends_with("deps"))
            || target.kind.iter().any(|kind| kind == "example");
        let folder = manifest.parent().ok_or_else(|| format!("{} has no folder", manifest.display()))?.to_owned();
        let package = package(&id, &folder);
        let target = format!("{} {}", target.kind.join(" "), target.name);
        if is_test {
            programs.push(Program { path, folder, package, target });
        }
    }
    Ok(programs)
}

/// The name of a package in its identifier, `…#name@version`; without a name it is that of the folder.
fn package(id: &str, folder: &Path) -> String {
    let named = id.rsplit_once('#').and_then(|(_, end)| end.split_once('@')).map(|(name, _)| name.to_owned());
    named.unwrap_or_else(|| folder.file_name().unwrap_or_default().display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_that_tests_start_are_not_tests() {
        let message = |name: &str, kind: &str, executable: &str| {
            format!(
                r#"{{"reason":"compiler-artifact","package_id":"path+file:///a/tests#scphd-tests@0.1.0","manifest_path":"/a/tests/Cargo.toml","target":{{"name":"{name}","kind":["{kind}"]}},"executable":{executable}}}"#
            )
        };
        let messages = [
            message("fuzz", "bin", "\"/t/debug/fuzz\""),
            message("fuzz", "test", "\"/t/debug/deps/fuzz-1\""),
            message("scphd_tests", "lib", "null"),
            r#"{"reason":"build-finished","success":true}"#.to_owned(),
        ];
        let programs = programs(&messages.join("\n")).unwrap();
        assert_eq!(programs.len(), 1);
        assert_eq!((programs[0].package.as_str(), programs[0].target.as_str()), ("scphd-tests", "test fuzz"));
        assert_eq!(programs[0].folder, Path::new("/a/tests"));
    }

    #[test]
    fn a_package_without_a_name_has_that_of_its_folder() {
        assert_eq!(package("path+file:///a/xtask#0.1.0", Path::new("/a/xtask")), "xtask");
    }
}
