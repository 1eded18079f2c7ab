//! Dependencies of modules: in the library every folder depends only on those before it, and in no crate files import in a circle.

mod imports;

use imports::{Imports, Module, circle, imports, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The folders of `core/src`, each after those that it may depend on. Tests are not listed.
const ROOMS: [&str; 12] = [
    "numerics",
    "map",
    "models",
    "report",
    "settings",
    "detection",
    "particles",
    "snapshot",
    "navigation",
    "filter",
    "joint",
    "locate",
];

/// The folders of the crates, each with the minimum number of imports that must be recognised.
const CRATES: [(&str, usize); 30] = [
    ("core", 900),
    ("onboard/stream", 120),
    ("onboard/sequencer", 10),
    ("onboard/store", 5),
    ("onboard/link", 5),
    ("onboard/lidar", 6),
    ("onboard/mavlink", 12),
    ("onboard/vehicle", 20),
    ("host-sim", 40),
    ("host-sim/boards", 5),
    ("host-sim/check", 30),
    ("host-sim/exchange", 40),
    ("host-sim/filters", 60),
    ("host-sim/log", 20),
    ("host-sim/reference", 60),
    ("host-sim/ros", 20),
    ("host-sim/run", 40),
    ("host-sim/score", 10),
    ("host-sim/view", 50),
    ("host-sim/worlds", 40),
    ("xtask", 170),
    ("bindings/capi", 60),
    ("bindings/python", 25),
    ("tests/benches", 3),
    ("bindings/web", 12),
    ("gpu/kernels", 10),
    ("gpu/host", 15),
    ("gpu/ptx", 15),
    ("firmware", 4),
    ("firmware/rtos", 4),
];

fn of(folder: &str) -> Imports {
    imports(&sources(&root().join(folder).join("src")))
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[test]
fn no_file_imports_in_a_circle() {
    for (folder, least) in CRATES {
        let imports = of(folder);
        let count: usize = imports.values().map(BTreeSet::len).sum();
        assert!(count >= least, "{folder}: only {count} imports were understood");
        assert_eq!(circle(&imports), None, "{folder}");
    }
}

#[test]
fn every_folder_of_the_library_depends_on_those_before_it_alone() {
    let place = |module: &Module| ROOMS.iter().position(|room| *room == module[0]);
    for (module, from) in of("core") {
        let Some(own) = place(&module) else { continue };
        for other in from {
            assert!(
                place(&other).is_some_and(|place| place <= own),
                "{} imports {}",
                module.join("/"),
                other.join("/")
            );
        }
    }
}

#[test]
fn a_circle_is_found() {
    let module = |name: &str| vec![name.to_owned()];
    let text = |other: &str| format!("use crate::{other}::{{A, B}};\n");
    let mut modules = BTreeMap::from([(Vec::new(), String::new())]);
    modules.extend([("a", "b"), ("b", "c"), ("c", "d"), ("d", "c")].map(|(own, other)| (module(own), text(other))));
    let found = imports(&modules);
    assert_eq!(circle(&found).map(|way| way.len()), Some(2));
}

#[test]
fn the_root_of_the_library_has_few_names() {
    let root = std::fs::read_to_string(root().join("core/src/lib.rs")).unwrap();
    // Items of modules inline in `lib.rs` are indented; others are at the root. The two macros are not counted.
    let names: usize = root
        .lines()
        .filter_map(|line| line.strip_prefix("pub use ").map(|path| path.split(',').count()))
        .chain(root.lines().filter(|line| line.starts_with("pub mod ")).map(|_| 1))
        .sum();
    assert!((20..=28).contains(&names), "{names} names at the root");
}
