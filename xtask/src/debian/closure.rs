//! Determines the packages to download, given the installed ones.

use super::package::{Package, Relation};

/// Dependencies that are needed for an installation, but not to run a program from a folder: whoever built this program has a
/// linker and the headers of the C library, and its debugging symbols are only looked for in the system.
const NOT_NEEDED: [&str; 4] = ["gcc", "libc-dev", "binutils", "libc6-dbg"];

/// Belongs to the loader, which must be that of the system.
const C_LIBRARY: &str = "libc6";

/// A source of packages.
pub trait Archive {
    /// The packages with this name that can be downloaded: first the version that apt would install, then others.
    fn offers(&mut self, name: &str) -> Result<Vec<Package>, String>;
}

/// The packages to download for `roots`, including these and their dependencies, without `installed` ones.
pub fn closure(roots: &[&str], installed: &[Package], archive: &mut dyn Archive) -> Result<Vec<Package>, String> {
    let mut chosen: Vec<Package> = Vec::new();
    for root in roots {
        let offers = archive.offers(root)?;
        let package = offers.into_iter().next().ok_or_else(|| format!("no archive that apt knows has {root}"))?;
        if chosen.iter().all(|other| other.name != package.name) {
            chosen.push(package);
        }
    }
    let mut next = 0;
    while let Some(package) = chosen.get(next).cloned() {
        next += 1;
        for group in &package.depends {
            let there = |relation: &Relation| NOT_NEEDED.contains(&relation.name.as_str());
            if group.iter().any(there) || chosen.iter().any(|other| group.iter().any(|one| other.satisfies(one))) {
                continue;
            }
            if let Some(missing) = choose(&package, group, installed, archive)? {
                if missing.name == C_LIBRARY {
                    return Err(format!("{} needs another {C_LIBRARY} than is installed", package.name));
                }
                chosen.push(missing);
            }
        }
    }
    Ok(chosen)
}

/// The package to download for one of the `group`; `None` if one is present.
fn choose(
    package: &Package,
    group: &[Relation],
    installed: &[Package],
    archive: &mut dyn Archive,
) -> Result<Option<Package>, String> {
    // Packages from the same source must have the same version.
    let fits = |other: &Package| other.source.0 != package.source.0 || other.source.1 == package.source.1;
    let has = |other: &Package| fits(other) && group.iter().any(|relation| other.satisfies(relation));
    if installed.iter().any(has) {
        return Ok(None);
    }
    for relation in group {
        let offers = archive.offers(&relation.name)?;
        if let Some(found) = offers.into_iter().find(|offer| fits(offer) && offer.satisfies(relation)) {
            return Ok(Some(found));
        }
    }
    let names: Vec<&str> = group.iter().map(|relation| relation.name.as_str()).collect();
    Err(format!("{} needs {}, which no archive that apt knows has", package.name, names.join(" or ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An archive for tests.
    struct Shelf(Vec<Package>);

    impl Archive for Shelf {
        fn offers(&mut self, name: &str) -> Result<Vec<Package>, String> {
            Ok(self.0.iter().filter(|package| package.name == name).cloned().collect())
        }
    }

    /// A package from `name version: depends` or `name version source: depends`.
    fn package(text: &str) -> Package {
        let (head, depends) = text.split_once(": ").unwrap_or((text, ""));
        let words: Vec<&str> = head.split(' ').collect();
        let source = words.get(2).map(|source| format!("\nSource: {source}")).unwrap_or_default();
        let (name, version) = (words[0], words[1]);
        let stanza = format!("Package: {name}\nVersion: {version}{source}\nDepends: {depends}\nFilename: f");
        Package::parse_all(&stanza).remove(0)
    }

    fn resolve(roots: &[&str], installed: &[&str], offered: &[&str]) -> Result<Vec<String>, String> {
        let installed: Vec<Package> = installed.iter().map(|text| package(text)).collect();
        let mut shelf = Shelf(offered.iter().map(|text| package(text)).collect());
        let chosen = closure(roots, &installed, &mut shelf)?;
        Ok(chosen.into_iter().map(|package| format!("{} {}", package.name, package.version)).collect())
    }

    #[test]
    fn missing_packages_are_fetched_with_their_dependencies_and_installed_ones_are_not() {
        let offered = ["emulator 7: here (>= 1), far", "far 1: farther | other, emulator", "farther 2", "here 1"];
        assert_eq!(resolve(&["emulator"], &["here 1"], &offered).unwrap(), ["emulator 7", "far 1", "farther 2"]);
        assert_eq!(resolve(&["emulator"], &["here 1", "other 1"], &offered).unwrap(), ["emulator 7", "far 1"]);
    }

    #[test]
    fn an_unsuitable_installed_version_is_fetched_too() {
        let offered = ["emulator 7: here (>= 2)", "here 1", "here 2"];
        assert_eq!(resolve(&["emulator"], &["here 1"], &offered).unwrap(), ["emulator 7", "here 2"]);
    }

    /// A newer part is installed, and apt offers it first.
    #[test]
    fn packages_of_one_source_have_one_version() {
        let offered = ["arm 7 qemu: data (>> 6)", "data 10 qemu", "data 7 qemu"];
        assert_eq!(resolve(&["arm"], &["data 10 qemu", "utils 10 qemu"], &offered).unwrap(), ["arm 7", "data 7"]);
    }

    #[test]
    fn a_linker_is_assumed_and_another_c_library_is_refused() {
        let offered = ["rust 1: gcc, libc-dev, clang | gcc", "new 1: libc6 (>= 3)", "libc6 3"];
        assert_eq!(resolve(&["rust"], &[], &offered).unwrap(), ["rust 1"]);
        assert!(resolve(&["new"], &["libc6 2"], &offered).unwrap_err().contains("another libc6"));
    }

    #[test]
    fn unknown_packages_are_named() {
        assert!(resolve(&["ghost"], &[], &[]).unwrap_err().contains("ghost"));
        let message = resolve(&["a"], &[], &["a 1: b (>= 2) | c", "b 1"]).unwrap_err();
        assert!(message.contains("a needs b or c"), "{message}");
    }
}
