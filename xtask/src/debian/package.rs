//! The description of a Debian package: the fields of deb-control(5) that are needed here.

use std::cmp::Ordering;

use deb_version::compare_versions;

/// A version of a package.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Package {
    pub name: String,
    pub version: String,
    /// Its source package, and the version of that.
    pub source: (String, String),
    /// Dependencies: one of each group is needed.
    pub depends: Vec<Vec<Relation>>,
    /// Other packages that it provides.
    pub provides: Vec<Relation>,
    /// Whether an archive offers it; false for an installed package.
    pub downloadable: bool,
}

/// A package with a condition on its version.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Relation {
    pub name: String,
    /// Operator, such as `>=`, and version.
    pub bound: Option<(String, String)>,
}

impl Package {
    /// Reads the output of `apt-cache show`, or the status file of dpkg.
    pub fn parse_all(text: &str) -> Vec<Self> {
        text.split("\n\n").filter_map(Self::parse).collect()
    }

    fn parse(stanza: &str) -> Option<Self> {
        let field = |name: &str| {
            // Continuation lines begin with a space; none of these fields has any.
            let lines = stanza.lines();
            lines.filter_map(|line| line.split_once(':')).find(|(key, _)| *key == name).map(|(_, value)| value.trim())
        };
        let name = field("Package")?.to_owned();
        let version = field("Version")?.to_owned();
        let source = match field("Source").map(|source| source.split_once(' ').unwrap_or((source, ""))) {
            None => (name.clone(), version.clone()),
            Some((source, "")) => (source.to_owned(), version.clone()),
            Some((source, version)) => (source.to_owned(), version.trim_matches(['(', ')']).to_owned()),
        };
        let groups = |field: Option<&str>| -> Vec<Vec<Relation>> {
            let groups = field.unwrap_or_default().split(',').map(str::trim).filter(|group| !group.is_empty());
            groups.map(|group| group.split('|').map(Relation::parse).collect()).collect()
        };
        let depends = [groups(field("Pre-Depends")), groups(field("Depends"))].concat();
        let provides = groups(field("Provides")).concat();
        Some(Self { name, version, source, depends, provides, downloadable: field("Filename").is_some() })
    }

    /// Whether it satisfies a relation.
    pub fn satisfies(&self, relation: &Relation) -> bool {
        if self.name == relation.name {
            return relation.allows(&self.version);
        }
        self.provides.iter().filter(|provided| provided.name == relation.name).any(|provided| match &provided.bound {
            Some((_, version)) => relation.allows(version),
            // A provided name without a version satisfies no condition on the version.
            None => relation.bound.is_none(),
        })
    }
}

impl Relation {
    /// Parses for example `libc6 (>= 2.34)`; the architecture in `python3:any` is ignored.
    fn parse(text: &str) -> Self {
        let (name, bound) = text.trim().split_once('(').unwrap_or((text.trim(), ""));
        let name = name.trim().split(':').next().unwrap_or_default().to_owned();
        let bound = bound.trim_end_matches(')').trim();
        let (operator, version) = bound.split_at(bound.find(|c| !"<>=".contains(c)).unwrap_or(bound.len()));
        let bound = (!operator.is_empty()).then(|| (operator.to_owned(), version.trim().to_owned()));
        Self { name, bound }
    }

    fn allows(&self, found: &str) -> bool {
        let Some((operator, wanted)) = &self.bound else { return true };
        let order = compare_versions(found, wanted);
        match operator.as_str() {
            "<<" => order == Ordering::Less,
            "<=" | "<" => order != Ordering::Greater,
            "=" => order == Ordering::Equal,
            ">=" | ">" => order != Ordering::Less,
            ">>" => order == Ordering::Greater,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHOWN: &str = "Package: qemu-system-arm\nSource: qemu (1:7.2+dfsg-7+deb12u18)\nVersion: 1:7.2+dfsg-7+deb12u18+b3\n\
        Provides: qemu-system-aarch64\nPre-Depends: libc6 (>= 2.34)\n\
        Depends: gcc | clang:any, qemu-system-data (>> 1:7.2+dfsg~)\n\
        Description: an emulator\n of machines: many\nFilename: pool/q.deb\n\n\
        Package: rustc-web\nStatus: install ok installed\nVersion: 1.96.0-1\nProvides: rustc (= 1.96.0-1), c\n\n";

    fn relation(text: &str) -> Relation {
        Relation::parse(text)
    }

    #[test]
    fn fields_are_read() {
        let packages = Package::parse_all(SHOWN);
        let [qemu, rustc] = &packages[..] else { panic!("{packages:?}") };
        assert_eq!(qemu.source, ("qemu".to_owned(), "1:7.2+dfsg-7+deb12u18".to_owned()));
        let names: Vec<Vec<&str>> =
            qemu.depends.iter().map(|group| group.iter().map(|one| one.name.as_str()).collect()).collect();
        assert_eq!(names, [vec!["libc6"], vec!["gcc", "clang"], vec!["qemu-system-data"]]);
        assert_eq!(qemu.depends[2][0].bound, Some((">>".to_owned(), "1:7.2+dfsg~".to_owned())));
        assert!(qemu.downloadable && !rustc.downloadable);
        assert_eq!(rustc.source, ("rustc-web".to_owned(), "1.96.0-1".to_owned()));
    }

    #[test]
    fn relations_depend_on_versions_and_provided_names() {
        let rustc = &Package::parse_all(SHOWN)[1];
        for (text, holds) in [
            ("rustc-web", true),
            ("rustc-web (= 1.96.0-1)", true),
            ("rustc-web (>= 1.97)", false),
            ("rustc-web (<< 1.97~)", true),
            ("rustc (>= 1.89)", true),
            ("rustc (>> 1.96.0-1)", false),
            ("c", true),
            ("c (>= 1)", false),
            ("cargo", false),
        ] {
            assert_eq!(rustc.satisfies(&relation(text)), holds, "{text}");
        }
    }
}
