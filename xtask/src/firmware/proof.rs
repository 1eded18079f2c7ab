//! The step `proof`: what is linked holds no panic and no allocator, fits the reference board, and the checks that say
//! so fail where they should.

use super::board::{Board, EMULATED, REFERENCE};
use super::guide;
use super::hil;
use super::image::{self, Extra, Image};
use super::precision::Precision;
use super::rig::{BLACK_BOXES, JOINT, PLANAR, UNDERWATER};
use crate::noalloc;
use crate::outcome::{Outcome, Stop};
use crate::toolchain;

/// The image whose panic handler calls a function that does not exist.
pub const PROOF: &str = "proof";
/// That function.
const NO_FUNCTION: &str = "undefined symbol: a_panic_is_reachable";
/// Gives that function an address, so that an image with a panic can be looked at.
const WITH_PANICS: &str = "-Clink-arg=--defsym=a_panic_is_reachable=0";

/// The reference board with less RAM than the filter needs.
const TOO_SMALL: Board = Board { name: "too-small", ..REFERENCE };

/// The step.
pub fn step() -> Outcome {
    prove().into()
}

fn prove() -> Result<Outcome, Stop> {
    let toolchain = toolchain::find()?;
    // The code for these is the same for every board with a processor of this kind.
    let others = [(&REFERENCE, UNDERWATER, Precision::F32), (&REFERENCE, JOINT, Precision::F32)];
    let boards = EMULATED.iter().chain([&REFERENCE]);
    let plane = boards.flat_map(|board| Precision::ALL.map(|precision| (board, PLANAR, precision)));
    for (board, rig, precision) in plane.chain(others) {
        let features = &rig.proof_features(precision)[..];
        let image = image::build(&toolchain, board, PROOF, &Extra { features, flags: &[] })
            .map_err(|error| format!("a panic is reachable, or the image does not fit {}: {error}", board.name))?;
        has_no_allocator(&image)?;
    }
    for features in BLACK_BOXES {
        let image = image::build(&toolchain, &REFERENCE, PROOF, &Extra { features, flags: &[] })
            .map_err(|error| format!("with {features:?} a panic is reachable, or the image does not fit: {error}"))?;
        has_no_allocator(&image)?;
    }
    let images =
        [(PLANAR, Precision::F32), (PLANAR, Precision::F64), (JOINT, Precision::F32), (UNDERWATER, Precision::F32)];
    for (rig, precision) in images {
        let name = rig.image(precision);
        let image = image::build_replay(&toolchain, &REFERENCE, rig, precision)?;
        has_no_allocator(&image)?;
        println!("{name} fits {}: {:?}", REFERENCE.name, image.sizes()?);
    }
    for features in [&[][..], &["joint"]] {
        let image = image::build(&toolchain, &REFERENCE, hil::IMAGE, &Extra { features, flags: &[] })
            .map_err(|error| format!("{} with {features:?}: {error}", hil::IMAGE))?;
        has_no_allocator(&image)?;
        println!("{} with {features:?} fits {}: {:?}", hil::IMAGE, REFERENCE.name, image.sizes()?);
    }
    guide::build(&toolchain)?;
    let planted = |feature| Extra { features: feature, flags: &[] };
    for (board, extra, complaint) in [
        (&REFERENCE, planted(&["planted-panic"]), NO_FUNCTION),
        (&REFERENCE, planted(&["planted-heap"]), NO_FUNCTION),
        (&TOO_SMALL, planted(&[]), "will not fit in region 'RAM'"),
    ] {
        image::must_not_link(&toolchain, board, PROOF, &extra, complaint)?;
    }
    let heap = Extra { features: &["planted-heap"], flags: &[WITH_PANICS] };
    match allocator_symbol(&image::build(&toolchain, &REFERENCE, PROOF, &heap)?)? {
        Some(symbol) => println!("the planted heap shows as {symbol}"),
        None => return Err("the check for an allocator does not see a planted heap".into()),
    }
    Ok(Outcome::Passed("no panic, no allocator, fits the reference board; each check fails where it should".into()))
}

fn has_no_allocator(image: &Image) -> Result<(), String> {
    match allocator_symbol(image)? {
        Some(symbol) => Err(format!("{} has the allocator's {symbol}", image.path.display())),
        None => Ok(()),
    }
}

fn allocator_symbol(image: &Image) -> Result<Option<String>, String> {
    image.symbol_with(&noalloc::SYMBOLS)
}
