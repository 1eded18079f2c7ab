//! Unsafe code occurs only in the listed files.

use std::fs;
use std::path::Path;

/// The files that may contain it: data that is lent to threads, the buffers and launches, entry points of the device, a slot of
/// zeros, and the code that starts threads.
const ALLOWED: [&str; 13] = [
    "host/src/cuda.rs",
    "host/src/device.rs",
    "host/src/emulated.rs",
    "kernels/src/group.rs",
    "kernels/src/joint.rs",
    "kernels/src/kernel.rs",
    "kernels/src/room.rs",
    "kernels/src/select.rs",
    "kernels/src/size.rs",
    "kernels/src/slot.rs",
    "kernels/src/stages.rs",
    "kernels/src/store.rs",
    "kernels/src/tell.rs",
];

#[test]
fn unsafe_code_occurs_only_in_the_allowed_files() {
    let mut found = Vec::new();
    for folder in ["host/src", "kernels/src"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join(folder);
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let text = fs::read_to_string(&path).unwrap();
            let has = text.lines().any(|line| {
                let code = line.split("//").next().unwrap_or_default();
                code.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == "unsafe")
            });
            if has {
                let parts: Vec<_> =
                    path.components().rev().take(3).map(|part| part.as_os_str().to_string_lossy()).collect();
                found.push(format!("{}/{}/{}", parts[2], parts[1], parts[0]));
            }
        }
    }
    found.sort_unstable();
    assert_eq!(found, ALLOWED);
}
