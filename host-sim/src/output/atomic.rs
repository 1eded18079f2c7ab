//! Whole files or none: write beside the target, then rename.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

/// Distinguishes the temporary files of threads that write into one folder.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// Replaces `path` by `bytes`: a reader sees the old file or the new one, never a part.
///
/// The bytes go to a hidden temporary file of the same folder, which is renamed when it is complete and
/// removed when anything fails. The folder must exist.
///
/// # Errors
///
/// Whatever the file system says; `InvalidInput` where `path` does not end in a file name.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "not the name of a file"))?;
    let serial = NEXT.fetch_add(1, Ordering::Relaxed);
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}-{serial}.tmp", process::id()));
    let temporary = path.with_file_name(hidden);

    let written = fill(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        // The first error is the one worth telling; there may be nothing to remove.
        let _ = fs::remove_file(&temporary);
    }
    written
}

/// Creates `path` with `bytes` and waits until they are stored, so that the rename never outruns them.
fn fill(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::path::PathBuf;

    /// A fresh folder that goes with its owner.
    pub(crate) struct Folder(pub(crate) PathBuf);

    impl Folder {
        pub(crate) fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("scphd-sim-{name}-{}", process::id()));
            let _ = fs::remove_dir_all(&path);
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        /// Names in the folder, sorted.
        pub(crate) fn names(&self) -> Vec<String> {
            let mut names: Vec<String> =
                fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn replaces_the_old_file_and_leaves_nothing_beside_it() {
        let folder = Folder::new("atomic");
        let path = folder.0.join("a.txt");
        write(&path, b"old and longer").unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(folder.names(), ["a.txt"]);
    }

    #[test]
    fn a_failed_rename_leaves_nothing() {
        let folder = Folder::new("atomic-fail");
        let path = folder.0.join("taken");
        fs::create_dir(&path).unwrap();
        assert!(write(&path, b"x").is_err());
        assert_eq!(folder.names(), ["taken"]);
        assert!(write(Path::new("/"), b"x").is_err());
    }
}
