//! Dependencies of modules: every folder of the library depends only on those before it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The folders of `core/src`, each after those that it may depend on. Tests are not listed.
const ROOMS: [&str; 12] = [
    "numerics", "map", "models", "report", "settings", "detection", "particles", "snapshot", "navigation", "filter",
    "joint", "locate",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src")
}

/// The code of all files of a folder, without tests and comments.
fn code(folder: &Path) -> String {
    let mut text = String::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.file_stem().unwrap().to_str().unwrap().ends_with("tests") {
            continue;
        }
        if path.is_dir() {
            text += &code(&path);
        } else {
            let file = fs::read_to_string(&path).unwrap();
            let lines = file.split("#[cfg(test)]\nmod tests {").next().unwrap().lines();
            lines.for_each(|line| text.extend([line.split("//").next().unwrap(), " "]));
        }
    }
    text
}

/// What a text imports from the root of the crate, also in groups: modules and items.
fn named(text: &str) -> BTreeSet<&str> {
    let mut found = BTreeSet::new();
    // What a module hands on is no dependency of its own.
    let own = text.split(';').filter(|statement| !statement.trim().starts_with("pub use "));
    for path in own.flat_map(|statement| statement.split("crate::").skip(1)) {
        let mut depth = 0;
        for part in path.split_inclusive(['{', '}', ',']) {
            if depth <= 1 {
                found.extend(part.trim().split(|c: char| !(c.is_alphanumeric() || c == '_')).next());
            }
            depth += part.matches('{').count();
            depth = depth.saturating_sub(part.matches('}').count());
            if depth == 0 {
                break;
            }
        }
    }
    found.remove("");
    found
}

/// Whether a folder with this code defines an item.
fn defines(code: &str, item: &str) -> bool {
    let kinds = ["struct", "enum", "trait", "type", "fn", "const"];
    let begins = kinds.iter().flat_map(|kind| [" ", "(crate) ", "(super) "].map(|to| format!("pub{to}{kind} {item}")));
    let ends = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    begins.into_iter().any(|begin| code.split(&begin).skip(1).any(ends))
}

#[test]
fn every_folder_of_the_library_depends_on_those_before_it_alone() {
    let codes = ROOMS.map(|room| code(&root().join(room)));
    let mut understood = 0;
    for (own, text) in codes.iter().enumerate() {
        for name in named(text) {
            let place = ROOMS.iter().position(|room| *room == name);
            let Some(place) = place.or_else(|| codes.iter().position(|code| defines(code, name))) else { continue };
            assert!(place <= own, "{} imports {name} of {}", ROOMS[own], ROOMS[place]);
            understood += 1;
        }
    }
    assert!(understood > 100, "only {understood} imports were understood");
}

#[test]
fn imports_are_found_in_groups() {
    let text = "use crate::{a::{b, c}, d}; pub use crate::h; fn f() -> crate::e::F { crate::G }";
    assert_eq!(named(text), ["G", "a", "d", "e"].into());
}

#[test]
fn the_root_of_the_library_has_few_names() {
    let root = fs::read_to_string(root().join("lib.rs")).unwrap();
    // Items of modules inline in `lib.rs` are indented; others are at the root. The two macros are not counted.
    let names: usize = root
        .lines()
        .filter_map(|line| line.strip_prefix("pub use ").map(|path| path.split(',').count()))
        .chain(root.lines().filter(|line| line.starts_with("pub mod ")).map(|_| 1))
        .sum();
    assert!((20..=28).contains(&names), "{names} names at the root");
}
