//! Imports between the files of a crate, read from their text.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A module: its path from the root of the crate.
pub type Module = Vec<String>;
/// The modules that each module imports.
pub type Imports = BTreeMap<Module, BTreeSet<Module>>;

/// The files of a crate without tests; if there is a library, without the programs beside it.
pub fn sources(source: &Path) -> BTreeMap<Module, String> {
    let mut modules = BTreeMap::new();
    folder(source, &[], &mut modules);
    modules
}

fn folder(root: &Path, at: &[String], into: &mut BTreeMap<Module, String>) {
    for entry in fs::read_dir(root).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let within = [at, std::slice::from_ref(&stem)].concat();
        let is_program = at.is_empty() && (stem == "bin" || stem == "main" && root.join("lib.rs").exists());
        if stem == "tests" || is_program {
            continue;
        }
        if path.is_dir() {
            folder(&path, &within, into);
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            let of_the_folder = stem == "mod" || at.is_empty() && (stem == "lib" || stem == "main");
            let module = if of_the_folder { at.to_vec() } else { within };
            into.insert(module, without_tests(&fs::read_to_string(&path).unwrap()));
        }
    }
}

/// A file without its code for tests: single items, and everything from the module of tests on.
fn without_tests(text: &str) -> String {
    let mut rest = text;
    let mut kept = String::new();
    while let Some(at) = ["#[cfg(test)]", "#[cfg(all(test"].iter().filter_map(|mark| rest.find(mark)).min() {
        kept.push_str(&rest[..at]);
        let Some(end) = rest[at..].find([';', '{']) else { return kept };
        let is_block = rest.as_bytes()[at + end] == b'{' && !rest[at..at + end].contains("use ");
        if is_block && rest[at..at + end].contains("mod ") {
            return kept;
        }
        // A `use` tree has its own braces, and ends after them.
        let end = if is_block { end } else { rest[at..].find(';').unwrap_or(end) };
        rest = &rest[at + end + 1..];
    }
    kept + rest
}

/// The `use` declarations of a file, each with whether it is public, and the rest of the file without comments.
fn declarations(text: &str) -> (Vec<(bool, String)>, String) {
    let code = text.lines().map(|line| line.split("//").next().unwrap_or_default().trim());
    let code = code.collect::<Vec<_>>().join(" ");
    let (mut found, mut rest) = (Vec::new(), String::new());
    for statement in code.split_inclusive(';') {
        let words = ["pub use ", "pub(crate) use ", "pub(super) use ", "use "];
        let begins = |at: usize| at == 0 || statement.as_bytes()[at - 1] == b' ';
        let word = words.into_iter().find_map(|word| Some((word, statement.rfind(word).filter(|&at| begins(at))?)));
        let Some((word, at)) = word.filter(|_| statement.ends_with(';')) else {
            // The declaration of a module is not a use of it.
            let file = statement.rfind("mod ").filter(|&at| !statement[at + 4..].contains([' ', '{']));
            rest.push_str(&statement[..file.unwrap_or(statement.len())]);
            continue;
        };
        rest.push_str(&statement[..at]);
        found.push((word != "use ", statement[at + word.len()..].trim_end_matches(';').trim().to_owned()));
    }
    (found, rest)
}

/// Splits a `use` tree into single paths, each with its local name.
fn paths(tree: &str, before: &[String], into: &mut Vec<(Vec<String>, String)>) {
    let tree = tree.trim();
    if let Some(inner) = tree.strip_prefix('{').and_then(|rest| rest.strip_suffix('}')) {
        let (mut depth, mut start) = (0, 0);
        for (at, letter) in inner.char_indices().chain([(inner.len(), ',')]) {
            match letter {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    if !inner[start..at].trim().is_empty() {
                        paths(&inner[start..at], before, into);
                    }
                    start = at + 1;
                }
                _ => (),
            }
        }
    } else if let Some((first, rest)) = tree.split_once("::") {
        paths(rest, &[before, &[first.trim().to_owned()]].concat(), into);
    } else {
        let (name, here) = tree.split_once(" as ").unwrap_or((tree, tree));
        into.push(([before, &[name.trim().to_owned()]].concat(), here.trim().to_owned()));
    }
}

/// An import path in `module`, relative to the root of the crate.
fn from_root(module: &[String], path: &[String]) -> Vec<String> {
    match path[0].as_str() {
        "crate" => path[1..].to_vec(),
        "super" => [&module[..module.len().saturating_sub(1)], &path[1..]].concat(),
        "self" => [module, &path[1..]].concat(),
        _ => [module, path].concat(),
    }
}

/// The module that defines an item, after following public imports.
fn origin(
    path: &[String],
    modules: &BTreeMap<Module, String>,
    handed_on: &BTreeSet<(Module, Vec<String>)>,
) -> Option<Module> {
    if modules.contains_key(path) {
        return Some(path.to_vec());
    }
    let (name, parent) = path.split_last()?;
    if !modules.contains_key(parent) {
        return None;
    }
    let of_parent = handed_on.iter().filter(|(by, _)| by == parent).map(|(_, to)| to);
    for to in of_parent.filter(|to| to.as_slice() != path) {
        let (last, above) = to.split_last()?;
        let target = if last == name {
            to.clone()
        } else if last == "*" {
            [above, std::slice::from_ref(name)].concat()
        } else {
            continue;
        };
        match origin(&target, modules, handed_on) {
            // A glob import counts only if the module defines the name.
            Some(found) if last != "*" || defines(&modules[&found], name) => return Some(found),
            _ => (),
        }
    }
    Some(parent.to_vec())
}

fn defines(text: &str, name: &str) -> bool {
    ["struct", "enum", "trait", "type", "fn", "const"].iter().any(|kind| text.contains(&format!("{kind} {name}")))
}

/// Imports, including paths that are used without a `use` declaration.
pub fn imports(modules: &BTreeMap<Module, String>) -> Imports {
    let mut handed_on = BTreeSet::new();
    let mut named: BTreeMap<&Module, Vec<Vec<String>>> = BTreeMap::new();
    for (module, text) in modules {
        let (declared, rest) = declarations(text);
        let words: BTreeSet<&str> = rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
        let own = named.entry(module).or_default();
        for (public, tree) in declared {
            let mut all = Vec::new();
            paths(&tree, &[], &mut all);
            for (path, here) in &all {
                let path = from_root(module, path);
                if public {
                    handed_on.insert((module.clone(), path.clone()));
                }
                // A public import that the file itself does not use is not a dependency.
                if !public || words.contains(here.as_str()) {
                    own.push(path);
                }
            }
        }
        for start in ["crate::", "super::"] {
            for (at, _) in rest.match_indices(start).filter(|&(at, _)| !rest[..at].ends_with([':', '$'])) {
                let named_here = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
                let end = rest[at..].find(|c| !named_here(c)).unwrap_or(rest.len() - at);
                let path = rest[at..at + end].split("::").filter(|part| !part.is_empty()).map(str::to_owned);
                own.push(from_root(module, &path.collect::<Vec<_>>()));
            }
        }
    }
    let mut imports = Imports::new();
    for (module, all) in named.into_iter().filter(|(module, _)| !module.is_empty()) {
        // For the path of a method, the part up to its type.
        let of = |path: &Vec<String>| (1..=path.len()).rev().find_map(|len| origin(&path[..len], modules, &handed_on));
        let from = all.iter().filter_map(of);
        let from = from.filter(|from| from != module && !from.is_empty());
        imports.entry(module.clone()).or_default().extend(from);
    }
    imports
}

/// Finds a circle of modules.
pub fn circle(imports: &Imports) -> Option<Vec<&Module>> {
    fn go<'i>(
        at: &'i Module,
        imports: &'i Imports,
        way: &mut Vec<&'i Module>,
        done: &mut BTreeSet<&'i Module>,
    ) -> bool {
        if let Some(first) = way.iter().position(|passed| *passed == at) {
            way.drain(..first);
            return true;
        }
        if !done.insert(at) {
            return false;
        }
        way.push(at);
        if imports.get(at).into_iter().flatten().any(|next| go(next, imports, way, done)) {
            return true;
        }
        way.pop();
        false
    }
    let mut done = BTreeSet::new();
    imports.keys().find_map(|start| {
        let mut way = Vec::new();
        go(start, imports, &mut way, &mut done).then_some(way)
    })
}
