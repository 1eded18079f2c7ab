//! SAFETY.md: every test that it names exists, and its list of items of Rust's `core` that the library uses is correct.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn safety() -> String {
    fs::read_to_string(root().join("SAFETY.md")).unwrap()
}

/// The texts between backquotes.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

#[test]
fn every_named_test_exists() {
    let text = safety();
    let mut named = 0;
    for (file, test) in quoted(&text).filter_map(|word| word.split_once(".rs::")) {
        let path = root().join(format!("{file}.rs"));
        let source = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let at = source.find(&format!("fn {test}(")).unwrap_or_else(|| panic!("no {test} in {file}.rs"));
        // Attributes of a test are directly before it.
        let before: Vec<&str> = source[..at].lines().rev().take(4).collect();
        assert!(before.iter().any(|line| line.trim() == "#[test]"), "{test} in {file}.rs is no test");
        named += 1;
    }
    assert!(named >= 20, "{named}");
}

/// Collects the sources of the library, without its tests.
fn sources(folder: &Path, into: &mut Vec<String>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_stem().unwrap().to_str().unwrap();
        if name.ends_with("tests") || ["testing", "properties", "words"].contains(&name) {
            continue;
        }
        if path.is_dir() {
            sources(&path, into);
        } else {
            let source = fs::read_to_string(&path).unwrap();
            let library = source.split("#[cfg(test)]\nmod tests {").next().unwrap();
            let code = library.lines().filter(|line| !line.trim_start().starts_with("//"));
            into.push(code.collect::<Vec<_>>().join("\n"));
        }
    }
}

/// Collects the paths into `core` of a source, with braces expanded; if `fmt` is imported as a whole, the items used from it.
fn items_of(source: &str, into: &mut BTreeSet<String>) {
    let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    for (at, _) in source.match_indices("core::") {
        if source[..at].ends_with(is_path) {
            continue;
        }
        let path: String = source[at..].chars().take_while(|&c| is_path(c)).collect();
        match path.strip_suffix("::") {
            Some(before) if source[at + path.len()..].starts_with('{') => {
                let inside = source[at + path.len() + 1..].split('}').next().unwrap();
                into.extend(inside.split(',').map(|item| format!("{before}::{}", item.trim())));
            }
            // The rest of the path is written by a macro.
            _ if path == "core::" => (),
            _ => _ = into.insert(path.trim_end_matches(':').to_owned()),
        }
    }
    let from_fmt = ["Arguments", "Debug", "Display", "Formatter", "Result", "Write"];
    let used = |item: &&&str| source.contains(&format!("fmt::{item}"));
    into.extend(from_fmt.iter().filter(used).map(|item| format!("core::fmt::{item}")));
}

#[test]
fn the_list_of_items_of_core_is_correct() {
    let (mut all, mut items) = (Vec::new(), BTreeSet::new());
    sources(&root().join("core/src"), &mut all);
    all.iter().for_each(|source| items_of(source, &mut items));
    let expected = items.into_iter().collect::<Vec<_>>().join("\n");
    let text = safety();
    let listed = text.split("```text\n").nth(1).and_then(|rest| rest.split("\n```").next()).unwrap_or("");
    assert!(listed == expected, "SAFETY.md should list:\n{expected}");
}
