//! The rooms of the library: every folder depends on those before it alone, and no file imports in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The folders of `core/src`, each after those that it may depend on. Tests stand aside.
const ROOMS: [&str; 12] = [
    "numerics",
    "map",
    "models",
    "report",
    "settings",
    "sight",
    "particles",
    "snapshot",
    "navigation",
    "filter",
    "joint",
    "locate",
];

/// A module by its path from the root of the crate.
type Module = Vec<String>;
/// What every module imports from which other.
type Imports = BTreeMap<Module, BTreeSet<Module>>;

/// The files of the crate without their tests.
fn sources(folder: &Path, at: &[String], into: &mut BTreeMap<Module, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let within = [at, std::slice::from_ref(&stem)].concat();
        if path.is_dir() {
            if stem != "tests" {
                sources(&path, &within, into);
            }
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let tests = ["#[cfg(test)]", "#[cfg(all(test"].map(|mark| text.find(mark).unwrap_or(text.len()));
        let end = if stem == "lib" { text.len() } else { tests[0].min(tests[1]) };
        let module = if stem == "mod" || stem == "lib" { at.to_vec() } else { within };
        if stem != "tests" {
            into.insert(module, text[..end].to_owned());
        }
    }
}

/// The `use` declarations of a file, each with whether it is handed on.
fn declarations(text: &str) -> Vec<(bool, String)> {
    let code = text.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
    let code = code.collect::<Vec<_>>().join(" ");
    let mut found = Vec::new();
    for statement in code.split(';') {
        for word in ["pub use ", "pub(crate) use ", "use "] {
            let begins = |at: usize| at == 0 || !statement.as_bytes()[at - 1].is_ascii_alphanumeric();
            if let Some(at) = statement.rfind(word).filter(|&at| begins(at)) {
                found.push((word != "use ", statement[at + word.len()..].trim().to_owned()));
                break;
            }
        }
    }
    found
}

/// A tree of imports as its single paths.
fn paths(tree: &str, before: &[String], into: &mut Vec<Vec<String>>) {
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
        let name = tree.split(" as ").next().unwrap().trim().to_owned();
        into.push([before, &[name]].concat());
    }
}

/// A path of an import in `module`, from the root of the crate on.
fn from_root(module: &[String], path: &[String]) -> Vec<String> {
    match path[0].as_str() {
        "crate" => path[1..].to_vec(),
        "super" => [&module[..module.len().saturating_sub(1)], &path[1..]].concat(),
        "self" => [module, &path[1..]].concat(),
        _ => [module, path].concat(),
    }
}

/// Where something comes from in the end: the module that defines it.
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
            // Of a glob only what is really there.
            Some(found) if last != "*" || defines(&modules[&found], name) => return Some(found),
            _ => (),
        }
    }
    Some(parent.to_vec())
}

fn defines(text: &str, name: &str) -> bool {
    ["struct", "enum", "trait", "type", "fn", "const"].iter().any(|kind| text.contains(&format!("{kind} {name}")))
}

/// Imports, and paths named on the spot.
fn imports(modules: &BTreeMap<Module, String>) -> Imports {
    let mut handed_on = BTreeSet::new();
    let mut named: BTreeMap<&Module, Vec<Vec<String>>> = BTreeMap::new();
    for (module, text) in modules {
        for (public, tree) in declarations(text) {
            let mut all = Vec::new();
            paths(&tree, &[], &mut all);
            for path in all.iter().map(|path| from_root(module, path)) {
                if public {
                    handed_on.insert((module.clone(), path.clone()));
                }
                named.entry(module).or_default().push(path);
            }
        }
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//") && !line.contains("use crate"));
        for rest in code.flat_map(|line| line.split("crate::").skip(1)) {
            let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(rest.len());
            let path = rest[..end].split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect();
            named.entry(module).or_default().push(path);
        }
    }
    let mut imports = Imports::new();
    for (module, all) in named.into_iter().filter(|(module, _)| !module.is_empty()) {
        let from = all.iter().filter_map(|path| origin(path, modules, &handed_on));
        let from = from.filter(|from| from != module && !from.is_empty());
        imports.entry(module.clone()).or_default().extend(from);
    }
    imports
}

/// A circle of modules, if there is one.
fn circle(imports: &Imports) -> Option<Vec<&Module>> {
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

fn of_the_crate() -> Imports {
    let mut modules = BTreeMap::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &[], &mut modules);
    assert!(modules.len() > 80, "{} files", modules.len());
    imports(&modules)
}

#[test]
fn no_file_imports_in_a_circle() {
    let imports = of_the_crate();
    let count: usize = imports.values().map(BTreeSet::len).sum();
    assert!(count > 300, "only {count} imports were understood");
    assert_eq!(circle(&imports), None);
}

#[test]
fn every_folder_depends_on_those_before_it_alone() {
    let place = |module: &Module| ROOMS.iter().position(|room| *room == module[0]);
    for (module, from) in of_the_crate() {
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
