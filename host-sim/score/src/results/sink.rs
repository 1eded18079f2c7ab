//! Output of results: every file that the program writes goes through [`write()`].
//!
//! A regular file is replaced completely or not at all: the bytes go to a file beside it, which is renamed when it is complete.
//! Anything but a regular file is never replaced:
//!
//! | path | what happens |
//! |---|---|
//! | `-`, or the target of the standard output (also `/dev/stdout`) | written to the standard output |
//! | nothing there | a new file, complete or none |
//! | regular file | replaced by a new one with the same permissions |
//! | link to a regular file | its target is replaced, the link remains |
//! | FIFO, character device, links to them | written through; a FIFO waits for its reader |
//! | folder, block device, broken link, no write permission | refused |
//!
//! Write permission is that of the mode, also for the superuser, for whom the system does not check it.

use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The path that stands for the standard output.
pub const STDOUT: &str = "-";

/// How a path is written.
#[derive(Debug)]
enum Way {
    Stdout,
    /// A file that is not there yet.
    New,
    /// A regular file, without any link in its name, and its permissions.
    Replace(PathBuf, Permissions),
    /// Not a regular file, but one that can be opened and written to.
    Through,
}

/// Writes `bytes` to `path` as in the table above.
///
/// # Errors
///
/// Errors of the file system, or a refusal with its reason. Existing files are not changed in either case.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    match way(path)? {
        Way::Stdout => {
            let mut stdout = io::stdout().lock();
            stdout.write_all(bytes).and_then(|()| stdout.flush())
        }
        Way::New => replace(path, bytes, None),
        Way::Replace(file, permissions) => replace(&file, bytes, Some(permissions)),
        Way::Through => OpenOptions::new().write(true).truncate(true).open(path)?.write_all(bytes),
    }
}

/// Whether `path` can be written to, as far as this can be checked without writing.
///
/// # Errors
///
/// The reason why [`write()`] would refuse it.
pub fn check(path: &Path) -> io::Result<()> {
    if matches!(way(path)?, Way::New) {
        let folder = folder(path);
        if !folder.is_dir() {
            return Err(refused(io::ErrorKind::NotFound, &format!("no folder {}", folder.display())));
        }
    }
    Ok(())
}

pub fn is_stdout(path: &Path) -> bool {
    matches!(way(path), Ok(Way::Stdout))
}

fn way(path: &Path) -> io::Result<Way> {
    if path.as_os_str() == STDOUT {
        return Ok(Way::Stdout);
    }
    if path.file_name().is_none() {
        return Err(refused(io::ErrorKind::InvalidInput, "not the name of a file"));
    }
    let itself = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Way::New),
        other => other?,
    };
    let there = match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Err(refused(io::ErrorKind::NotFound, "is a link that leads nowhere"));
        }
        other => other?,
    };
    if there.is_dir() {
        return Err(refused(io::ErrorKind::IsADirectory, "is a folder"));
    }
    if is_standard_output(&there) {
        return Ok(Way::Stdout);
    }
    if there.permissions().readonly() {
        return Err(refused(io::ErrorKind::PermissionDenied, "is read-only"));
    }
    if is_block_device(&there) {
        return Err(refused(io::ErrorKind::InvalidInput, "is a block device"));
    }
    if !there.is_file() {
        return Ok(Way::Through);
    }
    // The folder may permit a replacement although the file is not writable.
    OpenOptions::new().write(true).open(path)?;
    let file = if itself.is_symlink() { fs::canonicalize(path)? } else { path.to_owned() };
    Ok(Way::Replace(file, there.permissions()))
}

/// Writes a hidden file in the same folder and renames it: a reader sees the old or the new file, never a part. After an error
/// the hidden file is removed.
fn replace(path: &Path, bytes: &[u8], permissions: Option<Permissions>) -> io::Result<()> {
    let mut hidden = tempfile::Builder::new();
    // Less what the user's mask takes away; the crate's own default is a file that nobody else can read.
    #[cfg(unix)]
    hidden.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = hidden.tempfile_in(folder(path))?;
    if let Some(permissions) = permissions {
        file.as_file().set_permissions(permissions)?;
    }
    file.write_all(bytes)?;
    // Stored before the rename, of which the same is not certain.
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}

/// The folder that a file is in.
fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn refused(kind: io::ErrorKind, why: &str) -> io::Error {
    io::Error::new(kind, why)
}

/// Whether it is the file or pipe of the standard output. A terminal or `/dev/null` is written through like any other device,
/// because other output there does no harm.
#[cfg(unix)]
fn is_standard_output(there: &Metadata) -> bool {
    use std::os::fd::AsFd;
    use std::os::unix::fs::{FileTypeExt, MetadataExt};

    if there.file_type().is_char_device() {
        return false;
    }
    let Ok(stdout) = io::stdout().as_fd().try_clone_to_owned() else { return false };
    let stdout = File::from(stdout).metadata();
    stdout.is_ok_and(|stdout| (stdout.dev(), stdout.ino()) == (there.dev(), there.ino()))
}

#[cfg(not(unix))]
fn is_standard_output(_: &Metadata) -> bool {
    false
}

#[cfg(unix)]
fn is_block_device(there: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;

    there.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_block_device(_: &Metadata) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_shared_data::Folder;
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
        for (path, why) in [(&taken, "is a folder"), (&guarded, "read-only"), (&PathBuf::from("/"), "not the name")] {
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
        // A block device is never written to. No device has this number.
        let disk = folder.0.join("disk");
        if made("mknod", &disk, &["b", "240", "77"]) {
            assert!(write(&disk, b"x").unwrap_err().to_string().contains("block device"));
            assert!(fs::symlink_metadata(&disk).unwrap().file_type().is_block_device());
        }
    }

    #[test]
    fn a_dash_means_the_standard_output() {
        assert!(is_stdout(Path::new(STDOUT)) && !is_stdout(Path::new("./-")));
        check(Path::new(STDOUT)).unwrap();
        write(Path::new(STDOUT), b"").unwrap();
    }
}
