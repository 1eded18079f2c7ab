//! The share of an image that belongs to the library.

use super::image::Image;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind, SymbolSection};
use std::collections::BTreeMap;

/// The crates of the filter and of its computations.
const CRATES: [&str; 7] = ["scphd", "libm", "nalgebra", "simba", "num_traits", "rand_core", "rand_xoshiro"];

impl Image {
    /// Code and constants of the library and of the crates that it computes with, bytes: the sizes of all functions and constants
    /// with the name of one of these crates in theirs. Code that is inlined into functions of the image cannot be distinguished,
    /// and is not counted.
    pub fn library_flash(&self) -> Result<u64, String> {
        let file = self.file()?;
        let mut sizes = BTreeMap::new();
        for symbol in file.symbols() {
            let SymbolSection::Section(section) = symbol.section() else { continue };
            let kind = file.section_by_index(section).map_err(|error| error.to_string())?.kind();
            let in_flash = matches!(kind, SectionKind::Text | SectionKind::ReadOnlyData | SectionKind::Data);
            if in_flash && matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data) {
                let name = symbol.name().map_err(|error| error.to_string())?;
                if is_of_library(&format!("{:#}", rustc_demangle::demangle(name))) {
                    // Functions with the same code have the same address.
                    sizes.insert(symbol.address(), symbol.size());
                }
            }
        }
        let total = sizes.values().sum();
        if total > 0 { Ok(total) } else { Err(format!("{} has no symbol of the library", self.path.display())) }
    }
}

/// Whether a path in the name begins with one of the crates.
fn is_of_library(name: &str) -> bool {
    let paths = name.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
    paths.filter_map(|path| path.split_once("::")).any(|(first, _)| CRATES.contains(&first))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_tell_crates() {
        assert!(is_of_library("scphd::update::Update<T,_,_>::one"));
        assert!(is_of_library("<scphd::models::Window<T> as scphd::models::FieldOfView<T>>::bounds"));
        assert!(is_of_library("libm::math::exp::exp"));
        assert!(!is_of_library("scphd_stream::reader::Reader::read"));
        assert!(!is_of_library("compiler_builtins::mem::memcpy"));
        assert!(!is_of_library("main"));
    }
}
