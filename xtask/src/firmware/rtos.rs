//! The images with an operating system: odometry preempts the filter during scans, and the final state must be that of the host.

use super::board::{Board, EMULATED};
use super::rig::{PLANAR, Precision};
use super::streams::{self, Source};
use super::{emulator, image, output};
use crate::outcome::{Outcome, Stop};
use crate::toolchain;
use std::path::Path;

/// The workspace of these images.
const FOLDER: &str = "firmware/rtos";
/// The operating systems, which are also the names of the images.
const RTIC: &str = "rtic";
const EMBASSY: &str = "embassy";
const DRIVE: Source<'_> = Source { what: "survey", scans: 200, rig: PLANAR };
/// A feature by which the vehicle is too fast for the processor.
const TOO_FAST: &str = "too-fast";
/// Greatest latency of an odometry interrupt while the filter runs, ticks of 40 ns: 1 µs.
const WAIT_TICKS: u64 = 25;

/// The command `rtos`.
pub fn step() -> Result<Outcome, Stop> {
    emulator::prepare()?;
    toolchain::find()?;
    check()?;
    Ok(Outcome::Passed("equal digests with scans interrupted, nothing lost or late; what is too fast is told".into()))
}

/// Runs the images on boards with known interrupts; checks that do not depend on the board use the first one only.
pub fn check() -> Result<(), String> {
    let stream = streams::make(DRIVE, Precision::F32)?;
    let host = streams::on_host(&stream, PLANAR, Precision::F32)?;
    let last = host.scans.last().ok_or("nothing to compare")?;
    let [m7, m4f, ..] = &EMULATED;
    for (system, board) in [(RTIC, m7), (RTIC, m4f), (EMBASSY, m7)] {
        let end = run(board, system, &[], &stream)?;
        holds(&end, &last.digest, host.scans.len())
            .map_err(|what| format!("{system} on {}: {what}: {end}", board.name))?;
    }
    let end = run(m7, RTIC, &[TOO_FAST], &stream)?;
    tells(&end, &last.digest).map_err(|what| format!("{RTIC}, {TOO_FAST}: {what}: {end}"))
}

/// Runs an image. Returns its last line.
fn run(board: &Board, system: &str, features: &[&str], stream: &Path) -> Result<String, String> {
    let image = image::build_in(board, FOLDER, system, features)?;
    let text = emulator::run(board, &image, stream)?;
    text.lines().last().map(str::to_owned).ok_or_else(|| format!("{system} on {} said nothing", board.name))
}

fn count(end: &str, name: &str) -> Result<u64, String> {
    output::number(end, name).ok_or_else(|| format!("no {name}"))
}

/// Checks a drive that the processor can follow: the state of the host, nothing lost or late, and odometry has preempted scans,
/// including their longest stage.
fn holds(end: &str, digest: &str, scans: usize) -> Result<(), String> {
    for name in ["late", "lost_odometry", "lost_scans", "refused", "pins_refused"] {
        if count(end, name)? > 0 {
            return Err(name.into());
        }
    }
    if count(end, "scans")? != scans as u64 || output::word(end, "digest") != Some(digest) {
        return Err(format!("{scans} scans on the host, digest {digest}"));
    }
    for stage in ["preempted", "update"] {
        if count(end, stage)? == 0 {
            return Err(format!("{stage}: never interrupted"));
        }
    }
    match count(end, "waited_ticks")? {
        ticks if ticks > WAIT_TICKS => Err(format!("odometry has waited for {ticks} ticks")),
        _ => Ok(()),
    }
}

/// Checks a drive that it cannot follow: the image must report lost and late inputs.
fn tells(end: &str, digest: &str) -> Result<(), String> {
    for name in ["late", "lost_odometry", "lost_scans"] {
        if count(end, name)? == 0 {
            return Err(format!("it says nothing of {name}"));
        }
    }
    if output::word(end, "digest") == Some(digest) { Err("the host's digest, with inputs lost".into()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "scans 200 late 0 lost_odometry 0 lost_scans 0 refused 0 preempted 5 predict 0 weigh 3 resample 0 update 2 \
                        reduce 0 waited_ticks 2 deepest 2 pins_refused 0 digest 00ff stack 9";

    #[test]
    fn all_requirements_are_checked() {
        assert_eq!(holds(GOOD, "00ff", 200), Ok(()));
        for (good, bad) in [
            ("late 0", "late 1"),
            ("lost_odometry 0", "lost_odometry 1"),
            ("lost_scans 0", "lost_scans 1"),
            ("refused 0 preempted", "refused 1 preempted"),
            ("pins_refused 0", "pins_refused 1"),
            ("scans 200", "scans 199"),
            ("00ff", "00fe"),
            ("preempted 5", "preempted 0"),
            ("update 2", "update 0"),
            ("waited_ticks 2", "waited_ticks 200"),
            ("late 0", ""),
        ] {
            let end = GOOD.replacen(good, bad, 1);
            assert!(end != GOOD && holds(&end, "00ff", 200).is_err(), "{bad}");
        }
    }

    #[test]
    fn unreported_losses_are_an_error() {
        let lossy = GOOD
            .replace("late 0", "late 9")
            .replace("lost_odometry 0", "lost_odometry 7")
            .replace("lost_scans 0", "lost_scans 3");
        assert_eq!(tells(&lossy, "1234"), Ok(()));
        assert!(tells(&lossy, "00ff").is_err() && tells(GOOD, "1234").is_err());
    }
}
