//! Proof that the core needs no allocator.
//!
//! The core and all its dependencies are compiled in a sysroot without the crate `alloc`. Symbols would not be sufficient: the
//! core is generic, and generic code is not in its library until it is instantiated. In addition, the library is scanned for
//! calls of the allocator's symbols without the crate.

use crate::{files, process};
use std::fs;
use std::path::Path;

/// The libraries of a bare-metal target that the core may use.
const ALLOWED: [&str; 2] = ["libcore-", "libcompiler_builtins-"];

/// Symbols of the allocator; mangled names contain them literally.
pub const SYMBOLS: [&str; 4] = ["__rust_alloc", "__rust_realloc", "__rg_alloc", "__rdl_alloc"];

/// Makes a sysroot in `dir` with `core` and its compiler support, but without `alloc`, from `sysroot`.
///
/// Fails if a crate can still use `alloc` in it, because the check would then be void.
pub fn core_only_sysroot(sysroot: &Path, target: &str, dir: &Path) -> Result<(), String> {
    let libraries = Path::new("lib/rustlib").join(target).join("lib");
    let from = sysroot.join(&libraries);
    let to = dir.join(&libraries);
    let failed = |error: std::io::Error| format!("cannot copy {} to {}: {error}", from.display(), to.display());

    if dir.exists() {
        // After an update of the toolchain the folder has libraries with other hashes, and the compiler refuses duplicates.
        fs::remove_dir_all(dir).map_err(failed)?;
    }
    fs::create_dir_all(&to).map_err(failed)?;
    for entry in fs::read_dir(&from).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        if is_allowed(&name.to_string_lossy()) {
            let (source, copy) = (from.join(&name), to.join(&name));
            // Hard links save 60 MB if both folders are in the same file system.
            fs::hard_link(&source, &copy).or_else(|_| fs::copy(&source, &copy).map(drop)).map_err(failed)?;
        }
    }
    probe(target, dir)
}

/// Whether `sysroot` has `core` for the target; a removed target may leave an empty folder.
pub fn has_core(sysroot: &Path, target: &str) -> bool {
    let libraries = sysroot.join("lib/rustlib").join(target).join("lib");
    fs::read_dir(libraries)
        .is_ok_and(|entries| entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-")))
}

fn is_allowed(file_name: &str) -> bool {
    ALLOWED.iter().any(|prefix| file_name.starts_with(prefix))
}

/// Compiles a crate that needs only `core`, which must work, and one that needs `alloc`, which must fail.
fn probe(target: &str, sysroot: &Path) -> Result<(), String> {
    let compile = |name: &str, text: &str| {
        let source = sysroot.join(name).with_extension("rs");
        files::write(&source, text)?;
        let mut rustc = process::rustc();
        rustc.args(["--crate-type=rlib", "--emit=metadata", "--target", target, "--sysroot"]).arg(sysroot);
        process::read(rustc.arg("--out-dir").arg(sysroot).arg(source))
    };
    compile("needs_core", "#![no_std]\npub use core::mem::size_of;\n")?;
    match compile("needs_alloc", "#![no_std]\nextern crate alloc;\n") {
        Err(complaint) if complaint.contains("can't find crate for `alloc`") => Ok(()),
        Err(complaint) => Err(format!("the probe failed for another reason: {complaint}")),
        Ok(_) => Err("a crate that needs alloc compiled without it".into()),
    }
}

/// Fails if the library at `path` refers to an allocator.
pub fn check_library(path: &Path) -> Result<(), String> {
    let bytes = files::bytes(path)?;
    // Any other file would pass the scan.
    if !bytes.starts_with(b"!<arch>\n") {
        return Err(format!("{} is not a library archive", path.display()));
    }
    match allocator_symbol(&bytes) {
        Some(symbol) => Err(format!("{} refers to {symbol}", path.display())),
        None => Ok(()),
    }
}

/// The first of the allocator's symbols that occurs in `bytes`, which may be object code or LLVM bitcode.
fn allocator_symbol(bytes: &[u8]) -> Option<&'static str> {
    let occurs = |symbol: &&str| bytes.windows(symbol.len()).any(|window| window == symbol.as_bytes());
    SYMBOLS.into_iter().find(|symbol| occurs(symbol))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn allocator_symbols_are_found_at_any_position() {
        assert_eq!(allocator_symbol(b"__rust_alloc"), Some("__rust_alloc"));
        assert_eq!(allocator_symbol(b"\0\x7f_RNvCsfLfy6EI15iL_7___rustc12___rust_alloc\0\0"), Some("__rust_alloc"));
        assert_eq!(allocator_symbol(b"\xff__rust_alloc_zeroed"), Some("__rust_alloc"));
        assert_eq!(allocator_symbol(b"\xff_RNv7___rustc14___rust_realloc\xff"), Some("__rust_realloc"));
        assert_eq!(allocator_symbol(b"x__rg_alloc"), Some("__rg_alloc"));
        assert_eq!(allocator_symbol(b"x__rdl_allocx"), Some("__rdl_alloc"));
    }

    #[test]
    fn other_bytes_are_not_allocator_symbols() {
        assert_eq!(allocator_symbol(b""), None);
        assert_eq!(allocator_symbol(b"__rust_allo"), None);
        assert_eq!(allocator_symbol(b"allocation of a page from the pool, memcpy, __rust_begin_unwind"), None);
    }

    #[test]
    fn only_core_and_its_support_are_allowed() {
        assert!(is_allowed("libcore-0147d103acb464ac.rlib"));
        assert!(is_allowed("libcompiler_builtins-bbc9955573378e8c.rmeta"));
        assert!(!is_allowed("liballoc-71d093c14198c12f.rlib"));
        assert!(!is_allowed("libstd-71d093c14198c12f.rlib"));
    }

    #[test]
    fn a_file_that_is_not_a_library_does_not_pass() {
        assert!(check_library(&process::root().join("Cargo.toml")).is_err());
        assert!(check_library(&process::root().join("no-such-file")).is_err());
    }
}
