//! Unsafe code is confined to few files.

use std::fs;
use std::path::Path;

/// The files with unsafe code: memory and pointers of C, and a declaration of a function that nobody defines.
const ALLOWED: [&str; 3] = ["memory.rs", "panic.rs", "pointer.rs"];

#[test]
fn unsafe_code_is_in_few_files() {
    let mut found = Vec::new();
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        // The attribute for the name of a function in C does not count.
        let has = text.lines().any(|line| {
            let code = line.split("//").next().unwrap_or_default().replace("#[unsafe(no_mangle)]", "");
            code.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == "unsafe")
        });
        if has {
            found.push(path.file_name().unwrap().to_str().unwrap().to_owned());
        }
    }
    found.sort_unstable();
    assert_eq!(found, ALLOWED);
}
