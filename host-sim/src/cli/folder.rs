//! Log folders that commands write.

use super::failure::{Failure, notice};
use scphd_log::log::Log;
use scphd_log::log_folder;
use std::fs;
use std::io;
use std::path::Path;
use std::process;

/// Writes the folder under a temporary name and renames it when it is complete.
pub fn export(log: &Log, dir: &Path) -> Result<(), Failure> {
    let cannot = |error: io::Error| Failure::input(format_args!("cannot write {}: {error}", dir.display()));
    let empty = match fs::read_dir(dir) {
        Ok(mut entries) => entries.next().is_none(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => false,
        Err(error) => return Err(cannot(error)),
    };
    if dir.exists() && !empty {
        return Err(Failure::input(format_args!("{} is not empty", dir.display())));
    }
    let name =
        dir.file_name().ok_or_else(|| Failure::input(format_args!("{}: not the name of a folder", dir.display())))?;
    let hidden = dir.with_file_name(format!(".{}.{}.tmp", name.to_string_lossy(), process::id()));
    let moved = log_folder::write(log, &hidden).and_then(|()| {
        if empty {
            fs::remove_dir(dir)?;
        }
        fs::rename(&hidden, dir)
    });
    if let Err(error) = moved {
        // The first error is reported; there may be no folder to remove.
        let _ = fs::remove_dir_all(&hidden);
        return Err(cannot(error));
    }
    notice(format_args!("{} is in {}", log.name, dir.display()));
    Ok(())
}
