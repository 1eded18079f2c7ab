//! Builds the libraries of a vehicle for a Cortex-M without std and alloc.

use crate::outcome::{Outcome, Stop};
use crate::toolchain::{self, Toolchain};
use crate::{noalloc, process};

/// Cortex-M4F and M7 with an FPU. The target has no std, so that all its crates are no_std.
const TARGET: &str = "thumbv7em-none-eabihf";

/// Filter, sequencer, link, post finder, flight stack messages, and assembled filters. Their dependencies heapless, cobs and
/// embedded-io have a feature `alloc`, which must be off.
const PACKAGES: [&str; 6] = ["scphd", "scphd-sequencer", "scphd-link", "scphd-lidar", "scphd-mavlink", "scphd-vehicle"];

/// The step: builds them without `alloc`, and checks the libraries.
pub fn step() -> Result<Outcome, Stop> {
    let toolchain = toolchain::find()?;
    let dir = process::own_target_dir(&format!("target-{}", toolchain.key()));
    let mut cargo = toolchain.cargo("build", "core");
    if let Toolchain::Active { sysroot } = &toolchain {
        println!("setting up: a sysroot with core and without alloc, in {}", dir.display());
        let core_only = dir.join("core-only");
        noalloc::core_only_sysroot(sysroot, TARGET, &core_only)?;
        // The encoded form allows spaces in paths.
        cargo.env("CARGO_ENCODED_RUSTFLAGS", format!("--sysroot={}", core_only.display()));
    }
    cargo.args(PACKAGES.iter().flat_map(|package| ["-p", package]));
    cargo.args(["--target", TARGET, "--release", "--target-dir"]).arg(&dir);
    process::run(&mut cargo)?;

    for package in PACKAGES {
        let library = dir.join(TARGET).join(format!("release/lib{}.rlib", package.replace('-', "_")));
        noalloc::check_library(&library)?;
        println!("no alloc to link with, and no allocator symbol in {}", library.display());
    }
    Ok(Outcome::Passed(format!("with {}", toolchain.name())))
}
