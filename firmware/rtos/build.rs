//! Gives the linker the memory map of the board in the environment variable `SCPHD_BOARD`, one of `../memory/`, and the names of
//! the board's interrupts.

use std::path::PathBuf;
use std::{env, fs};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let here = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let board = env::var("SCPHD_BOARD").unwrap_or_else(|_| "mps2-an500".into());
    let map = here.join("../memory").join(board).with_extension("x");
    let out = PathBuf::from(env::var("OUT_DIR")?);
    for (from, to) in [(map, "memory.x"), (here.join("device.x"), "device.x")] {
        let text = fs::read_to_string(&from).map_err(|error| format!("{}: {error}", from.display()))?;
        fs::write(out.join(to), text)?;
        println!("cargo:rerun-if-changed={}", from.display());
    }
    println!("cargo:rerun-if-env-changed=SCPHD_BOARD");
    println!("cargo:rustc-link-search={}", out.display());
    // The sections need not be aligned to pages, because there are none.
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    Ok(())
}
