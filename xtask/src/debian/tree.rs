//! A folder with unpacked packages.

use super::apt::Apt;
use super::bundle::Bundle;
use crate::process;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The list of its packages, which is written last.
const LIST: &str = "packages.txt";

/// A folder that replaces the root of a file system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tree {
    root: PathBuf,
}

impl Tree {
    /// The tree in this folder, if it is complete.
    pub fn at(root: &Path) -> Option<Self> {
        root.join(LIST).is_file().then(|| Self { root: root.to_owned() })
    }

    /// The path of the packages' `/path`.
    pub fn path(&self, path: &str) -> PathBuf {
        self.root.join(path)
    }

    /// Name and version of the requested package.
    pub fn what(&self) -> String {
        let list = fs::read_to_string(self.root.join(LIST)).unwrap_or_default();
        list.lines().next().unwrap_or_default().to_owned()
    }

    /// Adds the libraries of the tree to the environment of a command, before those that it already has.
    pub fn equip(&self, command: &mut Command) {
        const VARIABLE: &str = "LD_LIBRARY_PATH";
        let set = command.get_envs().find(|(name, _)| *name == VARIABLE).map(|(_, value)| value.map(OsString::from));
        let before = set.unwrap_or_else(|| std::env::var_os(VARIABLE)).unwrap_or_default();
        let before = std::env::split_paths(&before).filter(|path| !path.as_os_str().is_empty());
        let mut folders = BTreeSet::new();
        for top in ["lib", "usr/lib"] {
            // A missing folder has no libraries.
            let _ = shared_libraries(&self.root.join(top), &mut folders);
        }
        // With a path that cannot be in such a list, no program of the tree could run.
        let all = std::env::join_paths(folders.into_iter().chain(before)).unwrap_or_default();
        command.env(VARIABLE, all);
    }
}

/// Adds all folders with a shared library.
fn shared_libraries(folder: &Path, found: &mut BTreeSet<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.file_type()?.is_dir() {
            shared_libraries(&entry.path(), found)?;
        } else if name.starts_with("lib") && (name.ends_with(".so") || name.contains(".so.")) {
            found.insert(folder.to_owned());
        }
    }
    Ok(())
}

/// Downloads and unpacks a bundle to the new folder `root`, by way of `partial`: it is complete or does not exist afterwards.
/// Package lists are fetched to the folder `lists`; without one, those of the system are used.
pub fn make(root: &Path, partial: &Path, bundle: &Bundle, lists: Option<&Path>) -> Result<Tree, String> {
    let failed = |error| format!("{}: {error}", root.display());
    let made = fill(partial, bundle, lists).and_then(|()| fs::rename(partial, root).map_err(failed));
    // Exists only after a failure, whose reason is returned.
    let _ = fs::remove_dir_all(partial);
    // If another run was faster, its tree is used.
    Tree::at(root).ok_or_else(|| made.err().unwrap_or_default())
}

fn fill(partial: &Path, bundle: &Bundle, lists: Option<&Path>) -> Result<(), String> {
    let failed = |error: io::Error| format!("{}: {error}", partial.display());
    let downloads = partial.join("downloads");
    let apt = Apt::new(&downloads, lists)?;
    if lists.is_some() {
        apt.update()?;
    }
    let packages = apt.download(bundle.packages, bundle.oldest)?;
    for entry in fs::read_dir(&downloads).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_some_and(|extension| extension == "deb") {
            process::read(process::command("dpkg-deb").arg("-x").arg(&path).arg(partial))?;
        }
    }
    fs::remove_dir_all(&downloads).map_err(failed)?;
    fs::write(partial.join(LIST), packages.join("\n")).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("scphd-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn an_incomplete_tree_is_not_used() {
        let root = folder("tree");
        assert_eq!(Tree::at(&root), None);
        fs::write(root.join(LIST), "emulator=7\nlibrary=1").unwrap();
        assert_eq!(Tree::at(&root).unwrap().what(), "emulator=7");
        fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn libraries_are_found_in_all_folders() {
        let root = folder("libraries");
        for file in ["usr/lib/x/libone.so.1", "usr/lib/x/deep/libtwo.so", "lib/libthree.so.3.1", "usr/lib/y/other.so.x"]
        {
            let path = root.join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        let mut command = Command::new("true");
        command.env("LD_LIBRARY_PATH", "/before");
        Tree { root: root.clone() }.equip(&mut command);
        let (_, path) = command.get_envs().next().unwrap();
        let found: Vec<PathBuf> = std::env::split_paths(path.unwrap()).collect();
        let own = ["lib", "usr/lib/x", "usr/lib/x/deep"].map(|name| root.join(name));
        assert_eq!(found, [&own[..], &["/before".into()]].concat());
        fs::remove_dir_all(root).unwrap();
    }
}
