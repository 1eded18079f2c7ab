//! Gives the linker the memory map of the board in the environment variable `SCPHD_BOARD`, one of `memory/`; by default that of
//! the reference board, `memory.x` at the top of the repository.

use std::path::PathBuf;
use std::{env, fs};

/// Images that use defmt.
const LOGGING: [&str; 9] = [
    "black-box", "flips", "replay-f32", "replay-f64", "replay-joint-f32", "replay-underwater-f32",
    "replay-underwater-joint-f32", "robot", "vehicle-loop",
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let here = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let map = match env::var("SCPHD_BOARD") {
        Ok(board) => here.join("memory").join(board).with_extension("x"),
        Err(_) => here.join("../memory.x"),
    };
    let text = fs::read_to_string(&map).map_err(|error| format!("{}: {error}", map.display()))?;
    let out = PathBuf::from(env::var("OUT_DIR")?);
    fs::write(out.join("memory.x"), text)?;
    println!("cargo:rerun-if-env-changed=SCPHD_BOARD");
    println!("cargo:rerun-if-changed={}", map.display());
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    // The sections need not be aligned to pages, because there are none.
    println!("cargo:rustc-link-arg-bins=--nmagic");
    for image in LOGGING {
        println!("cargo:rustc-link-arg-bin={image}=-Tdefmt.x");
    }
    Ok(())
}
