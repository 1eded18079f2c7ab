//! Runs programs of Debian packages from a folder of this project: the packages are downloaded and unpacked, not installed. This
//! needs no root and does not change the system.

mod apt;
mod closure;
mod package;
mod tree;

use std::fs;
use std::path::{Path, PathBuf};

use crate::process;
pub use apt::{NETWORK, present as can_fetch};
pub use tree::Tree;

/// Packages for a purpose.
#[derive(Debug, Clone, Copy)]
pub struct Bundle {
    /// Name of the folder to which they are unpacked.
    pub name: &'static str,
    /// Alternative sets of packages; the first set that is completely available is used.
    pub packages: &'static [&'static [&'static str]],
    /// Oldest suitable version of the first package.
    pub oldest: &'static str,
}

/// Folders for unpacked packages, in order of preference: in the user's cache, because checkouts are often deleted; otherwise in
/// the build folder.
fn places() -> impl Iterator<Item = PathBuf> {
    let home = || std::env::var_os("HOME").filter(|home| !home.is_empty()).map(|home| Path::new(&home).join(".cache"));
    let user = std::env::var_os("XDG_CACHE_HOME").filter(|cache| !cache.is_empty()).map(PathBuf::from).or_else(home);
    user.map(|cache| cache.join("scphd")).into_iter().chain([process::own_target_dir("cache")])
}

/// The preferred folder for unpacked packages.
pub fn cache() -> PathBuf {
    places().next().unwrap_or_else(|| process::own_target_dir("cache"))
}

fn is_writable(folder: &Path) -> bool {
    let probe = folder.join(format!(".probe-{}", std::process::id()));
    fs::write(&probe, "").and_then(|()| fs::remove_file(&probe)).is_ok()
}

/// The tree that was unpacked before.
pub fn unpacked(bundle: &Bundle) -> Option<Tree> {
    places().find_map(|place| Tree::at(&place.join(bundle.name)))
}

/// Downloads and unpacks the packages of a bundle, with dependencies that are not installed.
pub fn fetch(bundle: &Bundle) -> Result<Tree, String> {
    apt::present()?;
    let cache = places()
        .find(|place| fs::create_dir_all(place).is_ok() && is_writable(place))
        .ok_or_else(|| format!("{}: cannot be written to", cache().display()))?;
    // An existing tree was tried and does not run, because the system has changed.
    let old = cache.join(bundle.name);
    if old.exists() {
        fs::remove_dir_all(&old).map_err(|error| format!("{}: {error}", old.display()))?;
    }
    let installed = apt::installed()?;
    let mut reasons = Vec::new();
    // Lists that are fetched now come first: those of the system may name packages that the archive has replaced, but can be
    // sufficient without a network.
    for mut archive in [apt::Apt::with_own_lists(&cache), apt::Apt::with_system_lists(&cache)] {
        match archive.prepare().and_then(|()| unpack(bundle, &installed, &mut archive, &cache)) {
            Ok(tree) => return Ok(tree),
            Err(reason) => reasons.push(format!("{}: {reason}", archive.lists())),
        }
    }
    Err(reasons.join("; "))
}

fn unpack(
    bundle: &Bundle,
    installed: &[package::Package],
    archive: &mut apt::Apt,
    cache: &Path,
) -> Result<Tree, String> {
    let mut reasons = Vec::new();
    for packages in bundle.packages {
        match resolve(bundle, packages, installed, archive) {
            Ok(chosen) => {
                println!("setting up: {} from {} packages, in {}", bundle.name, chosen.len(), cache.display());
                return tree::make(&cache.join(bundle.name), &chosen, archive);
            }
            Err(reason) => reasons.push(reason),
        }
    }
    Err(reasons.join("; "))
}

fn resolve(
    bundle: &Bundle,
    packages: &[&str],
    installed: &[package::Package],
    archive: &mut apt::Apt,
) -> Result<Vec<package::Package>, String> {
    let chosen = closure::closure(packages, installed, archive)?;
    match chosen.first() {
        Some(first) if deb_version::compare_versions(&first.version, bundle.oldest).is_lt() => {
            Err(format!("{} is offered in version {}, older than {}", first.name, first.version, bundle.oldest))
        }
        _ => Ok(chosen),
    }
}
