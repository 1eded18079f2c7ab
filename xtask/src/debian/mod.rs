//! Runs programs of Debian packages from a folder of this project: the packages are downloaded and unpacked, not installed. This
//! needs no root and does not change the system.

mod apt;
mod bundle;
mod tree;

use crate::process;
use std::fs;
use std::path::{Path, PathBuf};

pub use apt::{NETWORK, present as can_fetch};
pub use bundle::Bundle;
pub use tree::Tree;

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

/// The tree that was unpacked before.
pub fn unpacked(bundle: &Bundle) -> Option<Tree> {
    places().find_map(|place| Tree::at(&place.join(bundle.name)))
}

/// Downloads and unpacks the packages of a bundle, with dependencies that are not installed.
pub fn fetch(bundle: &Bundle) -> Result<Tree, String> {
    apt::present()?;
    let partial = format!("{}.partial-{}", bundle.name, std::process::id());
    // A new folder can only be made in a place that can be written to.
    let cache = places()
        .find(|place| fs::create_dir_all(place.join(&partial)).is_ok())
        .ok_or_else(|| format!("{}: cannot be written to", cache().display()))?;
    let (root, partial) = (cache.join(bundle.name), cache.join(partial));
    // An existing tree was tried and does not run, because the system has changed.
    if root.exists() {
        fs::remove_dir_all(&root).map_err(|error| format!("{}: {error}", root.display()))?;
    }
    // Lists that are fetched now come first: those of the system may name packages that the archive has replaced, but can be
    // sufficient without a network.
    let lists = cache.join("lists");
    tree::make(&root, &partial, bundle, Some(&lists)).or_else(|reason| {
        tree::make(&root, &partial, bundle, None)
            .map_err(|other| format!("with lists fetched now: {reason}; with the system's lists: {other}"))
    })
}
