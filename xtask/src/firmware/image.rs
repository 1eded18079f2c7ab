//! Builds images, and reads their contents.

use super::board::{Board, REFERENCE};
use super::rig::{Precision, Rig};
use super::workbench;
use crate::once::Once;
use crate::{files, noalloc, process, toolchain};
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, elf};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

pub struct Image {
    pub path: PathBuf,
    pub elf: Vec<u8>,
}

/// Flash and RAM of an image, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sizes {
    /// Code, and the vector table.
    pub text: u64,
    /// Constants, and the initial values of variables.
    pub rodata: u64,
    /// Variables.
    pub ram: u64,
}

/// Builds the image that replays the streams of a rig, with its capacities.
pub fn build_replay(board: &Board, rig: Rig, precision: Precision) -> Result<Image, String> {
    build(board, &rig.image(precision), &rig.image_features())
}

/// The workspace of most images.
const FOLDER: &str = "firmware";

/// Builds an image of the firmware for a board, with these features.
pub fn build(board: &Board, name: &str, features: &[&str]) -> Result<Image, String> {
    build_in(board, FOLDER, name, features)
}

/// The images that this run has built: several steps need the same images, and the sources do not change during a run.
static BUILT: Once<PathBuf, ()> = Once::new();

/// Builds an image of a workspace for a board, unless this run has already built it.
pub fn build_in(board: &Board, folder: &str, name: &str, features: &[&str]) -> Result<Image, String> {
    let images = process::own_target_dir(&format!("images-{}", toolchain::find()?.key()));
    fs::create_dir_all(&images).map_err(|error| format!("{}: {error}", images.display()))?;
    let mark = features.iter().map(|feature| format!("-{feature}")).collect::<String>();
    let path = images.join(format!("{}-{name}{mark}.elf", board.name));
    BUILT.get(path.clone(), || {
        workbench::with(|bench| {
            process::run(&mut cargo(board, folder, name, features, bench)?)?;
            // The build for the next board overwrites the image, so that it is moved to the folder of complete images: another
            // step may already run the same image from there.
            let (built, copy) = (bench.join(board.target).join("release").join(name), bench.join("built.elf"));
            let kept = fs::copy(&built, &copy).and_then(|_| fs::rename(&copy, &path));
            kept.map_err(|error| format!("{}: {error}", built.display()))
        })
    })?;
    Image::read(path, board)
}

/// Builds an image that must not link, with an error that contains `complaint`.
pub fn must_not_link(board: &Board, name: &str, features: &[&str], complaint: &str) -> Result<(), String> {
    let built =
        workbench::with(|bench| Ok::<_, String>(process::read(&mut cargo(board, FOLDER, name, features, bench)?)))?;
    match built {
        Err(reason) if reason.contains(complaint) => Ok(()),
        Err(reason) => Err(format!("{name} with {features:?} failed for another reason: {reason}")),
        Ok(_) => Err(format!("{name} for {} linked with {features:?}", board.name)),
    }
}

/// `cargo build` for a board, without a place. `libraries` are built by a toolchain that has none for the target.
pub fn cargo_for(board: &Board, libraries: &str) -> Result<Command, String> {
    let toolchain = toolchain::find()?;
    let mut cargo = toolchain.cargo("build", libraries);
    let mut flags: Vec<String> = board.flags.iter().map(ToString::to_string).collect();
    flags.extend(toolchain.linker(&mut cargo)?);
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
    // The code is the same but for a few bytes, and an image links in half of the time.
    cargo.env("CARGO_PROFILE_RELEASE_DEBUG", "0");
    cargo.args(["--quiet", "--release", "--target", board.target]);
    Ok(cargo)
}

fn cargo(board: &Board, folder: &str, name: &str, features: &[&str], bench: &Path) -> Result<Command, String> {
    let mut cargo = cargo_for(board, if features.is_empty() { "core" } else { "core,alloc" })?;
    cargo.current_dir(process::root().join(folder));
    if board.name == REFERENCE.name {
        cargo.env_remove("SCPHD_BOARD");
    } else {
        cargo.env("SCPHD_BOARD", board.name);
    }
    cargo.args(["--locked", "--bin", name, "--features", &features.join(","), "--target-dir"]).arg(bench);
    Ok(cargo)
}

impl Image {
    pub(super) fn file(&self) -> Result<object::File<'_>, String> {
        object::File::parse(&*self.elf).map_err(|error| format!("{}: {error}", self.path.display()))
    }

    /// Reads the image in a file, which must be for this board.
    fn read(path: PathBuf, board: &Board) -> Result<Self, String> {
        let elf = files::bytes(&path)?;
        let image = Self { path, elf };
        let file = image.file()?;
        let data = file.section_by_name(".data").ok_or_else(|| format!("{} has no .data", image.path.display()))?;
        let address = data.address();
        if address != board.ram {
            let path = image.path.display();
            return Err(format!("{path} has its variables at {address:#x}, not at {:#x}", board.ram));
        }
        Ok(image)
    }

    pub fn sizes(&self) -> Result<Sizes, String> {
        let mut sizes = Sizes { text: 0, rodata: 0, ram: 0 };
        for section in self.file()?.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else { continue };
            // Strings of defmt and debug information are in the file, but not on the board.
            if sh_flags & u64::from(elf::SHF_ALLOC) == 0 {
                continue;
            }
            let (size, name) = (section.size(), section.name().unwrap_or_default());
            match section.kind() {
                SectionKind::UninitializedData => sizes.ram += size,
                SectionKind::Text => sizes.text += size,
                _ if name == ".vector_table" => sizes.text += size,
                _ if name == ".data" => {
                    sizes.ram += size;
                    sizes.rodata += size;
                }
                _ => sizes.rodata += size,
            }
        }
        Ok(sizes)
    }

    /// The first symbol with the name of one of the allocator's in it.
    pub fn allocator_symbol(&self) -> Result<Option<String>, String> {
        let file = self.file()?;
        let mut symbols = file.symbols().filter_map(|symbol| symbol.name().ok());
        Ok(symbols.find(|symbol| noalloc::SYMBOLS.iter().any(|name| symbol.contains(name))).map(str::to_owned))
    }
}
