//! `cargo xtask test --changed`: the tests that may be affected by changes since the last commit.

use crate::outcome::{Outcome, Stop};
use crate::steps::{Step, step};
use crate::{lint, process, quick, unit};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Formatting, and tests of packages that were changed or depend on changed ones.
const STEPS: [Step; 2] = [
    step("fmt", "formatting of every package", |_| lint::fmt()),
    step("packages", "all tests of changed packages, the quick ones of packages that depend on these", |_| test()),
];

/// A package of the workspace.
#[derive(Debug, Deserialize)]
struct Package {
    name: String,
    manifest_path: PathBuf,
    dependencies: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    path: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

impl Package {
    fn folder(&self) -> &Path {
        self.manifest_path.parent().unwrap_or(Path::new(""))
    }
}

/// The changes since the last commit.
struct Change {
    /// Packages with a changed file.
    own: BTreeSet<String>,
    /// Packages with a changed file, and all that depend on them.
    all: BTreeSet<String>,
    /// The changed files.
    files: Vec<String>,
}

impl Change {
    fn read() -> Result<Self, String> {
        let git = |words: &[&str]| process::read(process::command("git").args(words));
        let changed =
            git(&["diff", "--name-only", "HEAD"])? + "\n" + &git(&["ls-files", "--others", "--exclude-standard"])?;
        let metadata = process::read(process::cargo().args(["metadata", "--no-deps", "--format-version", "1"]))?;
        let Metadata { packages } =
            serde_json::from_str(&metadata).map_err(|error| format!("cargo metadata: {error}"))?;
        let files: Vec<&str> = changed.lines().filter(|line| !line.is_empty()).collect();
        Ok(Self::of(&files, &packages, process::root()))
    }

    fn of(files: &[&str], packages: &[Package], root: &Path) -> Self {
        let mut own = BTreeSet::new();
        for file in files {
            let path = root.join(file);
            let owner = packages
                .iter()
                .filter(|package| path.starts_with(package.folder()))
                .max_by_key(|package| package.folder().as_os_str().len());
            match owner {
                Some(package) => drop(own.insert(package.name.clone())),
                // The manifest of the workspace affects all packages; a page affects those that compile it or compare with it.
                None if file.starts_with("Cargo.") || file.starts_with(".cargo/") => {
                    own.extend(packages.iter().map(|package| package.name.clone()));
                }
                None if file.ends_with(".md") => {
                    own.extend(["scphd-documents", "scphd-sim", "scphd-tests", "scphd-view"].map(str::to_owned));
                }
                None => {}
            }
        }
        let mut all = own.clone();
        while let Some(package) = packages.iter().find(|package| {
            let depends = |dependency: &Dependency| {
                let path = dependency.path.as_deref();
                packages.iter().any(|other| Some(other.folder()) == path && all.contains(&other.name))
            };
            !all.contains(&package.name) && package.dependencies.iter().any(depends)
        }) {
            all.insert(package.name.clone());
        }
        Self { own, all, files: files.iter().map(|file| (*file).to_owned()).collect() }
    }

    /// Whether a step of the quick run may be affected.
    fn touches(&self, step: &str) -> bool {
        let of_core = self.all.contains("scphd");
        let folder = match step {
            "c" => "bindings/capi/",
            "wheel" => "bindings/python/",
            "board" => "firmware/",
            "examples" => "docs/",
            _ => return false,
        };
        of_core || self.files.iter().any(|file| file.starts_with(folder))
    }
}

/// The steps that may be affected by changes since the last commit.
pub fn steps() -> Result<Vec<&'static Step>, String> {
    let change = Change::read()?;
    Ok(STEPS.iter().chain(quick::STEPS.iter().filter(|step| change.touches(step.name))).collect())
}

fn test() -> Result<Outcome, Stop> {
    let Change { own, all, .. } = Change::read()?;
    // All tests of changed packages and of packages with tests of whole runs; of other packages, the tests of the library or,
    // without a library, of the program.
    let whole = |name: &&String| own.contains(*name) || unit::WHOLE_RUNS.contains(&name.as_str());
    let (whole, rest): (Vec<&String>, Vec<&String>) = all.iter().partition(whole);
    let (programs, libraries): (Vec<&String>, Vec<&String>) = rest.into_iter().partition(|name| *name == "scphd-sim");
    for (packages, targets) in [(whole, &[][..]), (libraries, &["--lib"][..]), (programs, &["--bins"][..])] {
        if !packages.is_empty() {
            let mut cargo = process::cargo();
            cargo.args(["test", "--no-fail-fast"]).args(packages.into_iter().flat_map(|name| ["--package", name]));
            process::run(cargo.args(targets))?;
        }
    }
    let names = own.into_iter().collect::<Vec<_>>().join(", ");
    Ok(Outcome::Passed(if names.is_empty() { "no package was changed".into() } else { names }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, folder: &str, needs: &[&str]) -> Package {
        let dependencies = needs.iter().map(|path| Dependency { path: Some(format!("/top/{path}").into()) }).collect();
        Package { name: name.into(), manifest_path: format!("/top/{folder}/Cargo.toml").into(), dependencies }
    }

    fn of(files: &[&str]) -> (Vec<String>, Vec<String>, Change) {
        let packages = [
            package("scphd", "core", &[]),
            package("scphd-stream", "onboard/stream", &["core"]),
            package("scphd-sim", "host-sim", &["core", "onboard/stream"]),
            package("scphd-tests", "tests", &["host-sim"]),
            package("scphd-digest", "tests/digest", &["host-sim"]),
            package("scphd-ros", "host-sim/ros", &[]),
        ];
        let change = Change::of(files, &packages, Path::new("/top"));
        (change.own.iter().cloned().collect(), change.all.iter().cloned().collect(), change)
    }

    #[test]
    fn packages_that_depend_on_a_changed_one_are_affected() {
        let (own, all, change) = of(&["onboard/stream/src/lib.rs"]);
        assert_eq!(own, ["scphd-stream"]);
        assert_eq!(all, ["scphd-digest", "scphd-sim", "scphd-stream", "scphd-tests"]);
        assert!(!change.touches("c") && !change.touches("wheel"));
        let (own, all, change) = of(&["core/src/lib.rs"]);
        assert_eq!((own.len(), all.len()), (1, 5));
        assert!(["c", "wheel", "board", "examples"].iter().all(|step| change.touches(step)));
    }

    #[test]
    fn a_file_belongs_to_the_innermost_package_and_a_page_to_its_readers() {
        assert_eq!(of(&["tests/digest/digest.rs"]).0, ["scphd-digest"]);
        assert_eq!(of(&["README.md"]).0, ["scphd-documents", "scphd-sim", "scphd-tests", "scphd-view"]);
        assert_eq!(of(&["Cargo.lock"]).0.len(), 6);
        assert!(of(&["bindings/capi/src/lib.rs"]).2.touches("c") && of(&["bindings/capi/src/lib.rs"]).0.is_empty());
        assert!(of(&[]).1.is_empty());
    }
}
