//! Output of results: every file that the program writes goes through [`write()`].
//!
//! A regular file is replaced completely or not at all: the bytes go to a file beside it, which is renamed when it is complete.
//! A link to one remains, and its target is replaced. FIFOs and devices are written through.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The path that stands for the standard output.
pub const STDOUT: &str = "-";

/// Writes `bytes` to `path`.
///
/// # Errors
///
/// Errors of the file system, or a refusal with its reason. Existing files are not changed in either case.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if is_stdout(path) {
        let mut stdout = io::stdout().lock();
        return stdout.write_all(bytes).and_then(|()| stdout.flush());
    }
    let path = destination(path)?;
    let there = fs::metadata(&path).ok();
    if there.as_ref().is_some_and(|there| !there.is_file()) {
        return fs::OpenOptions::new().write(true).open(path)?.write_all(bytes);
    }
    let mut beside = tempfile::Builder::new();
    #[cfg(unix)]
    beside.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = beside.tempfile_in(folder(&path))?;
    file.write_all(bytes)?;
    if let Some(there) = there {
        file.as_file().set_permissions(there.permissions())?;
    }
    // Stored before the rename, of which the same is not certain.
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}

/// Whether `path` can be written to, as far as this can be checked without writing.
///
/// # Errors
///
/// The reason why [`write()`] would refuse it.
pub fn check(path: &Path) -> io::Result<()> {
    if is_stdout(path) { Ok(()) } else { destination(path).map(drop) }
}

pub fn is_stdout(path: &Path) -> bool {
    path == Path::new(STDOUT) || path == Path::new("/dev/stdout")
}

/// The file to write: of a link to a regular file its target.
fn destination(path: &Path) -> io::Result<PathBuf> {
    let refused = |why: &str| Err(io::Error::other(why));
    if fs::symlink_metadata(path).is_err() {
        let folder = folder(path);
        return if folder.is_dir() { Ok(path.to_owned()) } else { refused(&format!("no folder {}", folder.display())) };
    }
    match fs::metadata(path) {
        Err(_) => refused("is a link that leads nowhere"),
        Ok(there) if there.is_dir() => refused("is a folder"),
        // Also for the superuser, for whom the system does not check it.
        Ok(there) if there.permissions().readonly() => refused("is read-only"),
        Ok(there) if there.is_file() => fs::canonicalize(path),
        Ok(_) => Ok(path.to_owned()),
    }
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_shared_data::Folder;
    use std::fs::Permissions;
    use std::process;

    #[test]
    fn the_old_file_is_replaced_and_no_other_file_remains() {
        let folder = Folder::new("sink");
        let path = folder.0.join("a.txt");
        write(&path, b"old and longer").unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(folder.names(), ["a.txt"]);
    }

    #[test]
    fn a_refusal_has_its_reason_and_changes_nothing() {
        let folder = Folder::new("sink-refused");
        let taken = folder.0.join("taken");
        fs::create_dir(&taken).unwrap();
        let guarded = folder.0.join("guarded");
        fs::write(&guarded, "kept").unwrap();
        let mut permissions = fs::metadata(&guarded).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&guarded, permissions).unwrap();
        for (path, why) in [(&taken, "is a folder"), (&guarded, "read-only"), (&PathBuf::from("/"), "is a folder")] {
            let refusals = [check(path), write(path, b"x")].map(|refusal| refusal.unwrap_err().to_string());
            assert!(refusals.iter().all(|refusal| refusal.contains(why)), "{refusals:?}");
        }
        assert!(check(&folder.0.join("no/file")).unwrap_err().to_string().contains("no folder"));
        assert!(write(&folder.0.join("no/file"), b"x").is_err());
        assert_eq!(fs::read(&guarded).unwrap(), b"kept");
        assert_eq!(folder.names(), ["guarded", "taken"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_remain_and_their_targets_are_replaced() {
        use std::os::unix::fs::{PermissionsExt, symlink};

        let folder = Folder::new("sink-links");
        let at = |name: &str| folder.0.join(name);
        fs::create_dir(at("far")).unwrap();
        fs::write(at("far/file"), "old").unwrap();
        fs::set_permissions(at("far/file"), Permissions::from_mode(0o640)).unwrap();
        symlink("far/file", at("near")).unwrap();
        symlink("near", at("twice")).unwrap();
        symlink("far", at("folder")).unwrap();
        symlink("gone", at("nowhere")).unwrap();
        symlink("round", at("round")).unwrap();
        for (link, bytes) in [("near", "one"), ("twice", "two"), ("folder/file", "three")] {
            check(&at(link)).unwrap();
            write(&at(link), bytes.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(at("far/file")).unwrap(), bytes);
        }
        assert_eq!(fs::read_link(at("near")).unwrap(), Path::new("far/file"));
        assert_eq!(fs::read_link(at("twice")).unwrap(), Path::new("near"));
        assert_eq!(fs::metadata(at("far/file")).unwrap().permissions().mode() & 0o777, 0o640);
        for refused in ["nowhere", "round", "folder"] {
            assert!(check(&at(refused)).is_err() && write(&at(refused), b"x").is_err(), "{refused}");
        }
        assert_eq!(fs::read_link(at("nowhere")).unwrap(), Path::new("gone"));
        fs::set_permissions(at("far/file"), Permissions::from_mode(0o440)).unwrap();
        assert!(write(&at("near"), b"x").unwrap_err().to_string().contains("read-only"));
        assert_eq!(fs::read_to_string(at("far/file")).unwrap(), "three");
        assert_eq!(folder.names(), ["far", "folder", "near", "nowhere", "round", "twice"]);
        assert_eq!(fs::read_dir(at("far")).unwrap().count(), 1);
    }

    /// Whether `mkfifo` or `mknod` with these arguments succeeded; the system may not permit it.
    #[cfg(unix)]
    fn made(program: &str, path: &Path, more: &[&str]) -> bool {
        let mut command = process::Command::new(program);
        let status = command.arg(path).args(more).stderr(process::Stdio::null()).status();
        status.is_ok_and(|status| status.success())
    }

    #[cfg(unix)]
    #[test]
    fn a_fifo_gets_the_bytes_and_remains() {
        use std::os::unix::fs::FileTypeExt;

        let folder = Folder::new("sink-fifo");
        let path = folder.0.join("fifo");
        assert!(made("mkfifo", &path, &[]));
        // The check does not open the FIFO: closing it again would end the data for a reader.
        check(&path).unwrap();
        let reader = {
            let path = path.clone();
            std::thread::spawn(move || fs::read(path).unwrap())
        };
        write(&path, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(fs::symlink_metadata(&path).unwrap().file_type().is_fifo());
        assert_eq!(folder.names(), ["fifo"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_through_and_remains() {
        use std::os::unix::fs::{FileTypeExt, symlink};

        let folder = Folder::new("sink-device");
        // An own device if the system permits it (only for the superuser), so that a failure does no harm; it discards
        // everything. Otherwise that of the system, which only the superuser could replace.
        let own = folder.0.join("null");
        let root = made("mknod", &own, &["c", "1", "3"]);
        let device = if root { own } else { PathBuf::from("/dev/null") };
        let link = folder.0.join("link");
        symlink(&device, &link).unwrap();
        for path in [&device, &link] {
            check(path).unwrap();
            write(path, b"gone").unwrap();
        }
        assert!(fs::symlink_metadata(&device).unwrap().file_type().is_char_device());
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }

    #[test]
    fn a_dash_means_the_standard_output() {
        assert!(is_stdout(Path::new(STDOUT)) && !is_stdout(Path::new("./-")));
        check(Path::new(STDOUT)).unwrap();
        write(Path::new(STDOUT), b"").unwrap();
    }
}
