//! The step `proof`: the images contain no panic and no allocator and fit the reference board; the checks are themselves checked
//! with images that must fail.

use super::board::{Board, EMULATED, REFERENCE};
use super::image::{self, Image};
use super::rig::{JOINT, JOINT_HYPOTHESES, JOINT_MOVERS, PLANAR, Precision, Rig, UNDERWATER, UNDERWATER_JOINT};
use super::{guide, hil};
use crate::outcome::{Outcome, Stop};
use crate::{process, toolchain};

/// The image whose panic handler calls a function that nobody defines.
pub const PROOF: &str = "proof";
/// The linker's error for that function.
const NO_FUNCTION: &str = "undefined symbol: a_panic_is_reachable";

/// The reference board with less RAM than the filter needs.
const TOO_SMALL: Board = Board { name: "too-small", ..REFERENCE };
/// The reference board with an address of that function, so that an image with a panic can be linked and examined.
const WITH_PANICS: Board =
    Board { flags: &["-Ctarget-cpu=cortex-m7", "-Clink-arg=--defsym=a_panic_is_reachable=0"], ..REFERENCE };

/// A part of the step: builds and examines an image.
type Check<'a> = Box<dyn Fn() -> Result<(), String> + Sync + 'a>;

pub fn step() -> Result<Outcome, Stop> {
    toolchain::find()?;
    let in_single = |rig: Rig| rig.proof_features(Precision::F32);
    // The first emulated board has the processor of the reference board.
    let mut proofs = Vec::from_iter(EMULATED.iter().skip(1).map(|board| (board, in_single(PLANAR))));
    // On one board: the code is the same for all.
    let rigs = [PLANAR, JOINT, JOINT_MOVERS, JOINT_HYPOTHESES, UNDERWATER, UNDERWATER_JOINT];
    proofs.extend(rigs.map(|rig| (&REFERENCE, in_single(rig))));
    proofs.push((&REFERENCE, PLANAR.proof_features(Precision::F64)));
    // The black boxes of the three vehicles, and the crates beside the filters.
    let others = [&["black-box"][..], &["black-box", "joint"], &["black-box", "underwater"], &["sensors"]];
    proofs.extend(others.map(|features| (&REFERENCE, features.to_vec())));
    let mut checks: Vec<Check<'_>> = Vec::new();
    for (board, features) in &proofs {
        checks.push(Box::new(move || proves(board, features)));
    }
    for features in [&[][..], &["joint"]] {
        checks.push(Box::new(move || fits(hil::IMAGE, features)));
    }
    checks.push(Box::new(guide::build));
    for (board, features, complaint) in [
        (&REFERENCE, &["planted-panic"][..], NO_FUNCTION),
        (&REFERENCE, &["planted-heap"], NO_FUNCTION),
        (&TOO_SMALL, &[], "will not fit in region 'RAM'"),
    ] {
        checks.push(Box::new(move || image::must_not_link(board, PROOF, features, complaint)));
    }
    checks.push(Box::new(sees_a_heap));
    process::side_by_side(&checks, |check| check())?;
    Ok(Outcome::Passed("no panic, no allocator, fits the reference board; each check fails where it should".into()))
}

/// Checks that the image with these features contains no panic and no allocator.
fn proves(board: &Board, features: &[&str]) -> Result<(), String> {
    let image = image::build(board, PROOF, features).map_err(|error| {
        format!("with {features:?} a panic is reachable, or the image does not fit {}: {error}", board.name)
    })?;
    has_no_allocator(&image)
}

/// Checks that an image fits the reference board and has no allocator, and prints its size.
fn fits(name: &str, features: &[&str]) -> Result<(), String> {
    let image = image::build(&REFERENCE, name, features);
    let image = image.map_err(|error| format!("{name} with {features:?}: {error}"))?;
    has_no_allocator(&image)?;
    println!("{name} with {features:?} fits {}: {:?}", REFERENCE.name, image.sizes()?);
    Ok(())
}

/// Checks that an allocator would be found.
fn sees_a_heap() -> Result<(), String> {
    let symbol = image::build(&WITH_PANICS, PROOF, &["planted-heap"])?.allocator_symbol()?;
    println!("the planted heap shows as {}", symbol.ok_or("the check for an allocator does not see a planted heap")?);
    Ok(())
}

fn has_no_allocator(image: &Image) -> Result<(), String> {
    match image.allocator_symbol()? {
        Some(symbol) => Err(format!("{} has the allocator's {symbol}", image.path.display())),
        None => Ok(()),
    }
}
