//! Lets apt resolve and download packages, without root.

use crate::process;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Time limit for the lists, which have about 10 MB.
const LISTS_LIMIT: Duration = Duration::from_secs(300);
/// Time limit for a download; the largest bundle has 150 MB.
const DOWNLOAD_LIMIT: Duration = Duration::from_secs(1200);

/// Network limits of apt.
pub const NETWORK: [&str; 6] =
    ["-o", "Acquire::Retries=1", "-o", "Acquire::http::Timeout=30", "-o", "Acquire::https::Timeout=30"];

/// Dependencies that are needed for an installation, but not to run a program from a folder: whoever built this program has a
/// linker and the headers of the C library, and its debugging symbols are only looked for in the system.
const NOT_NEEDED: [&str; 4] = ["gcc", "libc-dev", "binutils", "libc6-dbg"];

/// What is asked about an installed package. Its dependencies are not: those that the system lacks are not to be downloaded.
const FIELDS: &str = "-f=Package: ${Package}\\nStatus: install ok ${db:Status-Status}\\nProvides: ${Provides}\\nMulti-Arch: \
    ${Multi-Arch}\\nArchitecture: ${Architecture}\\nVersion: ${Version}\\nSource: ${source:Package}\\n\\n";

/// Fails if apt or dpkg is missing; the network is not tested.
pub fn present() -> Result<(), String> {
    let missing = ["apt-get", "apt-cache", "dpkg", "dpkg-query", "dpkg-deb"]
        .into_iter()
        .find(|program| process::read(process::command(program).arg("--version")).is_err());
    missing.map_or(Ok(()), |program| Err(format!("there is no {program}")))
}

/// apt with folders of its own.
pub struct Apt {
    folder: PathBuf,
    options: Vec<String>,
}

impl Apt {
    /// Keeps its files and what it downloads in `folder`. Without a folder for package `lists`, it has those of the system.
    pub fn new(folder: &Path, lists: Option<&Path>) -> Result<Self, String> {
        let mut options = vec![
            // If apt is run by root, the user that it switches to may not have access to the folders.
            "APT::Sandbox::User=root".into(),
            // Without their dependencies, installed packages look as if they could be upgraded.
            "APT::Get::Upgrade-By-Source-Package=false".into(),
            format!("Dir::Cache={}", folder.display()),
            // Even a simulation writes a log of how apt plans.
            format!("Dir::Log={}", folder.display()),
            format!("Dir::State::status={}", folder.join("status").display()),
        ];
        options.extend(lists.map(|lists| format!("Dir::State::Lists={}", lists.display())));
        let made = [folder, lists.unwrap_or(folder)].iter().try_for_each(fs::create_dir_all);
        made.and_then(|()| fs::write(folder.join("status"), ""))
            .map_err(|error| format!("{}: {error}", folder.display()))?;
        Ok(Self { folder: folder.to_owned(), options })
    }

    /// Fetches the package lists.
    pub fn update(&self) -> Result<(), String> {
        // Only the packages, without further indices.
        let only = ["-o", "Acquire::Languages=none", "-o", "Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false"];
        process::run_for(self.command("apt-get").arg("-qq").args(only).args(NETWORK).arg("update"), LISTS_LIMIT)
            .map_err(|error| format!("apt's lists: {error}"))
    }

    /// Downloads the first set of packages that is available, with dependencies. Returns them as `name=version`, the first
    /// package of the set first.
    pub fn download(&self, sets: &[&[&str]], oldest: &str) -> Result<Vec<String>, String> {
        let installed = process::read(process::command("dpkg-query").args(["-W", FIELDS]))?;
        let mut reasons = Vec::new();
        for names in sets {
            match self.resolve(names, oldest, &installed) {
                Ok(packages) => {
                    println!("setting up: {} from {} packages", names[0], packages.len());
                    let mut get = self.command("apt-get");
                    get.current_dir(&self.folder).arg("-qq").args(NETWORK).arg("download").args(&packages);
                    return process::run_for(&mut get, DOWNLOAD_LIMIT)
                        .map(|()| packages)
                        .map_err(|error| format!("download: {error}"));
                }
                Err(reason) => reasons.push(reason),
            }
        }
        Err(reasons.join("; "))
    }

    /// The packages to download for `names`, if the first one is recent enough.
    fn resolve(&self, names: &[&str], oldest: &str, installed: &str) -> Result<Vec<String>, String> {
        // It fails for an unknown name; apt-get says so below.
        let shown = process::read(self.command("apt-cache").arg("show").args(names)).unwrap_or_default();
        let sources = shown.lines().filter_map(|line| line.strip_prefix("Source: ")?.split(' ').next());
        let anew: Vec<&str> = sources.chain(names.iter().copied()).collect();
        fs::write(self.folder.join("status"), status(installed, &anew)).map_err(|error| format!("status: {error}"))?;
        let mut get = self.command("apt-get");
        get.args(["-q", "-y", "--no-install-recommends", "--simulate", "install"]).args(names);
        let output = get.output().map_err(|error| format!("apt-get: {error}"))?;
        let [said, complaint] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
        if !output.status.success() {
            // Some complaints are on the standard output.
            let lines = said.lines().filter(|line| line.contains(" but ")).chain(complaint.lines());
            return Err(lines.map(str::trim).collect::<Vec<_>>().join("; "));
        }
        let mut packages: Vec<String> = said.lines().filter_map(package).collect();
        packages.sort_by_key(|package| package.split('=').next() != Some(names[0]));
        let version = packages.first().and_then(|first| first.strip_prefix(names[0])?.strip_prefix('='));
        let version = version.ok_or_else(|| format!("apt does not offer {}", names[0]))?;
        process::read(process::command("dpkg").args(["--compare-versions", version, "ge", oldest]))
            .map_err(|_| format!("{} is offered in version {version}, older than {oldest}", names[0]))?;
        Ok(packages)
    }

    fn command(&self, program: &str) -> Command {
        let mut command = process::command(program);
        command.env("LC_ALL", "C").args(self.options.iter().flat_map(|option| ["-o", option]));
        command
    }
}

/// The state of the system for apt. Packages named in `anew`, and those made from a source of this name, are left out: an installed
/// package of a bundle does not run, and what is made from one source is to have one version. What is not needed is said to be
/// installed.
fn status(installed: &str, anew: &[&str]) -> String {
    let left_out = |line: &str| match line.split_once(": ") {
        Some(("Package", name)) => anew.contains(&name) || NOT_NEEDED.contains(&name),
        Some(("Source", name)) => anew.contains(&name),
        _ => false,
    };
    let stanzas = installed.split("\n\n").filter(|stanza| !stanza.lines().any(left_out));
    let lines = stanzas.flat_map(|stanza| stanza.lines().filter(|line| !line.ends_with(": ")).chain([""]));
    // The C library belongs to the loader, which is that of the system: on hold, apt keeps its version.
    let status =
        lines.collect::<Vec<_>>().join("\n").replace("Package: libc6\nStatus: install", "Package: libc6\nStatus: hold");
    let pretend = |name| format!("\nPackage: {name}\nStatus: install ok installed\nArchitecture: all\nVersion: 999\n");
    status + &NOT_NEEDED.map(pretend).concat()
}

/// `name=version` from a line of a simulation, such as `Inst name [1:1] (1:2 Debian:12/stable [all])`.
fn package(line: &str) -> Option<String> {
    let (name, rest) = line.strip_prefix("Inst ")?.split_once(' ')?;
    Some(format!("{name}={}", rest.split_once('(')?.1.split(' ').next()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARCHIVE: &str = "arm 1:7 qemu Depends: data (>> 6), far, gcc (>= 4) | tcc, clang\ndata 7 qemu Section: a\n\
        far 1 far Depends: libc6 (>= 2)\nclang 9 llvm Section: a\nlibc6 3 glibc Section: a\nnew 1 new Depends: libc6 (>= 3)";

    /// Packages of an archive or installed ones, from lines with name, version, source and another field.
    fn stanzas(text: &str) -> String {
        let stanza = |line: &str| {
            let [name, version, source, field] = line.splitn(4, ' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
            let rest = "Provides: \nArchitecture: all\nFilename: ./f\nSize: 1";
            format!("Package: {name}\n{field}\n{rest}\nVersion: {version}\nSource: {source}\n\n")
        };
        text.lines().map(stanza).collect()
    }

    #[test]
    fn apt_chooses_what_is_not_installed_and_says_why_it_cannot() {
        if present().is_err() {
            return;
        }
        let folder = std::env::temp_dir().join(format!("scphd-apt-{}", std::process::id()));
        let source = folder.join("sources.list");
        let mut apt = Apt::new(&folder.join("apt"), Some(&folder.join("lists"))).unwrap();
        apt.options.extend([format!("Dir::Etc::sourcelist={}", source.display()), "Dir::Etc::sourceparts=-".into()]);
        fs::write(folder.join("Packages"), stanzas(ARCHIVE).replace("Provides: \n", "")).unwrap();
        fs::write(source, format!("deb [trusted=yes] file:{} ./\n", folder.display())).unwrap();
        apt.update().unwrap();
        // What is wanted does not count as installed, nor does anything of its source.
        let parts = "arm 1:10 own Status: install ok installed\ndata 10 qemu Status: install ok installed\n\
                     clang 8 llvm Status: install ok installed\nfar 1 far Status: install ok config-files\n";
        for (name, parts, result) in [
            ("arm", "", "arm=1:7 clang=9 data=7 far=1"),
            ("arm", parts, "arm=1:7 data=7 far=1"),
            ("far", "", "far is offered in version 1, older than 1:7"),
            ("new", "", "new : Depends: libc6 (>= 3) but 2 is to be installed"),
            ("ghost", "", "Unable to locate package ghost"),
        ] {
            let installed = format!("{parts}libc6 2 glibc Status: install ok installed");
            let said = apt.resolve(&[name], "1:7", &stanzas(&installed)).map(|mut packages| {
                packages[1..].sort();
                packages.join(" ")
            });
            let said = said.unwrap_or_else(|reason| reason);
            assert!(said.contains(result), "{said}");
        }
        fs::remove_dir_all(folder).unwrap();
    }
}
