//! Queries apt and dpkg, without root.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::closure::Archive;
use super::package::Package;
use crate::process;

/// Time limit for the lists, which have about 10 MB.
const LISTS_LIMIT: Duration = Duration::from_secs(300);
/// Time limit for a download; the largest bundle has 150 MB.
const DOWNLOAD_LIMIT: Duration = Duration::from_secs(1200);
/// Lists of this age are fetched again.
const LISTS_AGE: Duration = Duration::from_secs(6 * 3600);

/// Fails if apt or dpkg is missing; the network is not tested.
pub fn present() -> Result<(), String> {
    let missing = ["apt-get", "apt-cache", "dpkg-query", "dpkg-deb"]
        .into_iter()
        .find(|program| process::read(process::command(program).arg("--version")).is_err());
    missing.map_or(Ok(()), |program| Err(format!("there is no {program}")))
}

/// The packages that are installed.
pub fn installed() -> Result<Vec<Package>, String> {
    let mut query = process::command("dpkg-query");
    let format = "-f=Status: ${db:Status-Abbrev}\\nPackage: ${Package}\\nVersion: ${Version}\\n\
                  Source: ${source:Package} (${source:Version})\\nProvides: ${Provides}\\n\\n";
    Ok(parse_installed(&process::read(query.args(["-W", format]))?))
}

fn parse_installed(text: &str) -> Vec<Package> {
    let whole = ["Status: ii", "Status: hi"];
    let is_whole = |stanza: &&str| whole.iter().any(|status| stanza.trim_start().starts_with(status));
    text.split("\n\n").filter(is_whole).flat_map(Package::parse_all).collect()
}

/// apt, with package lists of this project or those of the system.
pub struct Apt {
    /// Folder of this project's lists; `None`: those of the system.
    own_lists: Option<PathBuf>,
    /// Folder for apt's caches.
    cache: PathBuf,
    offered: HashMap<String, Vec<Package>>,
}

impl Apt {
    pub fn with_own_lists(cache: &Path) -> Self {
        Self { own_lists: Some(cache.join("lists")), cache: cache.join("apt"), offered: HashMap::new() }
    }

    pub fn with_system_lists(cache: &Path) -> Self {
        Self { own_lists: None, cache: cache.join("apt-system"), offered: HashMap::new() }
    }

    /// Its name in messages.
    pub fn lists(&self) -> &'static str {
        if self.own_lists.is_some() { "with lists fetched now" } else { "with the system's lists" }
    }

    /// Creates its folders, and fetches its own lists.
    pub fn prepare(&mut self) -> Result<(), String> {
        let make = |path: &Path| fs::create_dir_all(path).map_err(|error| format!("{}: {error}", path.display()));
        make(&self.cache.join("archives/partial"))?;
        let Some(lists) = &self.own_lists else { return Ok(()) };
        make(&lists.join("partial"))?;
        let stamp = lists.with_extension("fetched");
        let age = fs::metadata(&stamp).and_then(|data| data.modified()).ok().and_then(|time| time.elapsed().ok());
        if age.is_some_and(|age| age < LISTS_AGE) {
            return Ok(());
        }
        println!("setting up: apt's lists, in {}", lists.display());
        // Only the packages, without further indices.
        let arguments =
            ["-o", "Acquire::Languages=none", "-o", "Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false"];
        process::run_for(self.command("apt-get").arg("-qq").args(arguments).args(NETWORK).arg("update"), LISTS_LIMIT)?;
        fs::write(&stamp, "").map_err(|error| format!("{}: {error}", stamp.display()))
    }

    /// Downloads packages to a folder.
    pub fn download(&self, packages: &[Package], folder: &Path) -> Result<(), String> {
        let mut get = self.command("apt-get");
        get.current_dir(folder).arg("-qq").args(NETWORK).arg("download");
        get.args(packages.iter().map(|package| format!("{}={}", package.name, package.version)));
        process::run_for(&mut get, DOWNLOAD_LIMIT)
    }

    fn command(&self, program: &str) -> Command {
        let mut command = process::command(program);
        command.env("LC_ALL", "C").env("DEBIAN_FRONTEND", "noninteractive");
        // If apt is run by root, the user that it switches to may not have access to the folders.
        command.args(["-o", "APT::Sandbox::User=root", "-o"]).arg(format!("Dir::Cache={}", self.cache.display()));
        // Container images disable these caches, which make repeated queries fast.
        command.args(["-o", "Dir::Cache::pkgcache=pkgcache.bin", "-o", "Dir::Cache::srcpkgcache=srcpkgcache.bin"]);
        if let Some(lists) = &self.own_lists {
            command.arg("-o").arg(format!("Dir::State::Lists={}", lists.display()));
        }
        command
    }
}

/// Network limits of apt.
pub const NETWORK: [&str; 6] =
    ["-o", "Acquire::Retries=1", "-o", "Acquire::http::Timeout=30", "-o", "Acquire::https::Timeout=30"];

impl Archive for Apt {
    fn offers(&mut self, name: &str) -> Result<Vec<Package>, String> {
        if let Some(known) = self.offered.get(name) {
            return Ok(known.clone());
        }
        let show = |arguments: &[&str]| {
            // It fails for an unknown name, which is not an error here.
            let shown = process::read(self.command("apt-cache").arg("show").args(arguments).arg(name));
            Package::parse_all(&shown.unwrap_or_default())
        };
        let all = [show(&["--no-all-versions"]), show(&[])].concat();
        let offers: Vec<Package> =
            all.into_iter().filter(|package| package.name == name && package.downloadable).collect();
        self.offered.insert(name.to_owned(), offers.clone());
        Ok(offers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_completely_installed_packages_count() {
        let text = "Status: ii \nPackage: here\nVersion: 1\nSource: there (2)\nProvides: \n\n\
                    Status: rc \nPackage: removed\nVersion: 1\nSource: removed (1)\nProvides: \n\n\
                    Status: hi \nPackage: held\nVersion: 1\nSource: held (1)\nProvides: x (= 3)\n\n";
        let found = parse_installed(text);
        assert_eq!(found.iter().map(|package| package.name.as_str()).collect::<Vec<_>>(), ["here", "held"]);
        assert_eq!(found[0].source, ("there".to_owned(), "2".to_owned()));
        assert_eq!(found[1].provides.len(), 1);
    }
}
