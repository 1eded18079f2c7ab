//! The step `firmware`: after every scan the boards are in the same state as the host, bit for bit.

use super::board::{EMULATED, TARGETS};
use super::emulator;
use super::image::{self, Extra};
use super::output::{self, Replay};
use super::streams::{self, Precision, Source};
use crate::steps::Outcome;
use crate::toolchain::{self, Toolchain};

/// Scans of logs and scenarios; double precision takes ten times as long where it has to be emulated.
const SCANS: usize = 200;
/// Scenarios that are always there.
const SCENARIOS: [Source<'_>; 1] = [Source { what: "survey", scans: SCANS }];

/// Host profiles: without optimisation and with all of it.
const PROFILES: [&str; 2] = ["dev", "release"];

/// The step.
pub fn step() -> Outcome {
    match compare() {
        Ok(note) => Outcome::Passed(note),
        Err(reason) => Outcome::Failed(reason),
    }
}

fn compare() -> Result<String, String> {
    emulator::prepare()?;
    let toolchain = toolchain::find(&TARGETS)?;
    let (mut failures, mut compared) = (Vec::new(), 0);
    failures.extend(driven_by_a_timer(&toolchain)?);
    for precision in Precision::ALL {
        let mut images = Vec::new();
        for board in &EMULATED {
            images.push((board, image::build(&toolchain, board, &image_name(precision), &Extra::default())?));
        }
        for source in SCENARIOS {
            let stream = streams::make(source, precision)?;
            let mut replays: Vec<(&str, Replay)> = Vec::new();
            for profile in PROFILES {
                replays.push((profile, streams::on_host(&stream, precision, profile)?));
            }
            for (board, image) in &images {
                let lines = emulator::run(board, image, &stream)?;
                replays.push((board.name, Replay::parse(&lines)?));
            }
            let (first, rest) = replays.split_first().ok_or("nothing to compare")?;
            if first.1.scans.is_empty() {
                return Err(format!("no scan of {}", source.what));
            }
            for (name, replay) in rest {
                if let Some(difference) = first.1.first_difference(replay) {
                    failures.push(format!("{} {} on {name}: {difference}", source.what, precision.name()));
                }
                compared += replay.scans.len();
            }
            println!("{} {}: {} scans compared on {}", source.what, precision.name(), first.1.scans.len(), rest.len());
        }
    }
    if failures.is_empty() { Ok(format!("{compared} digests equal")) } else { Err(failures.join("; ")) }
}

/// The loop that a timer drives ends in the state that the host's ends in, without a scan late or an input lost.
fn driven_by_a_timer(toolchain: &Toolchain) -> Result<Option<String>, String> {
    let [board, ..] = &EMULATED;
    let stream = streams::make(SCENARIOS[0], Precision::F32)?;
    let host = streams::on_host(&stream, Precision::F32, "release")?;
    let image = image::build(toolchain, board, "vehicle-loop", &Extra::default())?;
    let run = Replay::parse(&emulator::run(board, &image, &stream)?)?;
    let (Some(last), Some(end)) = (host.scans.last(), &run.end) else { return Err("nothing to compare".into()) };
    let expected = [("late", "0"), ("lost", "0"), ("digest", last.digest.as_str())];
    let holds = expected.iter().all(|(name, value)| output::word(end, name) == Some(value));
    Ok((!holds).then(|| format!("the timer-driven loop ended with {end}, not with {expected:?}")))
}

/// The image that replays in this precision.
pub fn image_name(precision: Precision) -> String {
    format!("replay-{}", precision.name())
}
