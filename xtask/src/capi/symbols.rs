//! Symbols of the archive's object.

use object::{Object, ObjectSymbol};
use std::collections::BTreeSet;

/// Functions that every C compiler requires.
const IMPORTS: [&str; 4] = ["memcmp", "memcpy", "memmove", "memset"];

/// Fails unless the functions of the header are the only global symbols, and [`IMPORTS`] the only undefined ones: a reachable
/// panic would require a function that nobody defines.
pub fn check(elf: &[u8], functions: &BTreeSet<String>) -> Result<(), String> {
    let file = object::File::parse(elf).map_err(|error| error.to_string())?;
    let (mut offered, mut asked) = (BTreeSet::new(), BTreeSet::new());
    for symbol in file.symbols() {
        let name = symbol.name().map_err(|error| error.to_string())?.to_owned();
        if symbol.is_undefined() && !name.is_empty() {
            asked.insert(name);
        } else if symbol.is_definition() && symbol.is_global() {
            offered.insert(name);
        }
    }
    judge(&offered, &asked, functions)
}

fn judge(offered: &BTreeSet<String>, asked: &BTreeSet<String>, functions: &BTreeSet<String>) -> Result<(), String> {
    if let Some(name) = offered.symmetric_difference(functions).next() {
        return Err(format!("{name} is not in both, the header and the archive"));
    }
    match asked.iter().find(|name| !IMPORTS.contains(&name.as_str())) {
        Some(name) => Err(format!("the archive asks for {name}")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn missing_and_additional_symbols_are_found() {
        let functions = names(&["scphd_start", "scphd_scan"]);
        let check = |offered: &[&str], asked: &[&str]| judge(&names(offered), &names(asked), &functions);
        assert!(check(&["scphd_start", "scphd_scan"], &["memcpy"]).is_ok());
        assert!(check(&["scphd_start", "scphd_scan", "rust_begin_unwind"], &[]).is_err());
        assert!(check(&["scphd_start"], &[]).is_err());
        assert!(check(&["scphd_start", "scphd_scan"], &["scphd_a_panic_is_reachable"]).is_err());
    }
}
