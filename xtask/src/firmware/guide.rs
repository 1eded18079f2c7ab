//! Builds the project of `docs/guide/embedding.md` as shown there.

use super::board::REFERENCE;
use super::{image, workbench};
use crate::{files, process};

const CHAPTER: &str = include_str!("../../../docs/guide/embedding.md");
/// Path of the library in the chapter, relative to the project.
const LIBRARY: &str = "../scphd/core";
const FILES: usize = 4;

/// The files of the chapter: the names from its headings, and the code below them.
fn shown(chapter: &str) -> Vec<(&str, &str)> {
    let sections = chapter.split("\n## `").skip(1);
    let file = |section| {
        let (name, rest) = str::split_once(section, '`')?;
        let (_, block) = rest.split_once("\n```")?;
        let (_, code) = block.split_once('\n')?;
        let (code, _) = code.split_once("\n```")?;
        Some((name, code))
    };
    sections.filter_map(file).collect()
}

/// Builds the project for the reference board.
pub fn build() -> Result<(), String> {
    let project = process::own_target_dir("guide");
    let write = |name: &str, text: &str| files::write(&project.join(name), text);
    let read = |name: &str| files::text(&process::root().join(name));
    let shown = shown(CHAPTER);
    if shown.len() != FILES {
        return Err(format!("docs/guide/embedding.md has {} files for {FILES}", shown.len()));
    }
    for (name, code) in shown {
        if name == "Cargo.toml" {
            // The project is in a folder of this workspace, but is not one of its packages.
            let library = process::root().join("core");
            let code = code.replace(LIBRARY, &library.display().to_string());
            write(name, &format!("{code}\n\n[workspace]\n"))?;
        } else {
            write(name, code)?;
        }
    }
    write("memory.x", &read("memory.x")?)?;
    // The lock file of the other images.
    write("Cargo.lock", &read("firmware/Cargo.lock")?)?;
    let mut cargo = image::cargo_for(&REFERENCE, "core")?;
    cargo.current_dir(&project).args(["--offline", "--target-dir"]);
    workbench::with(|bench| process::run(cargo.arg(bench))).map_err(|error| format!("docs/guide/embedding.md: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_chapter_is_found() {
        let names: Vec<_> = shown(CHAPTER).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["Cargo.toml", "build.rs", "src/main.rs", "src/drivers.rs"]);
        assert!(CHAPTER.contains(LIBRARY));
    }
}
