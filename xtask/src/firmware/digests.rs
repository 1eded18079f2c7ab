//! The step `firmware`: after every scan the boards must have the same state as the host, bit for bit.

use super::board::FIRST;
use super::output::{self, Replay, all_equal};
use super::rig::{DIVE, JOINT, JOINT_HYPOTHESES, JOINT_MOVERS, PLANAR, Precision, Rig, UNDERWATER, UNDERWATER_JOINT};
use super::streams::{self, Source};
use super::{emulator, faults, flips, hil, image, rtos};
use crate::outcome::{Outcome, Stop};
use crate::{files, process, toolchain};
use std::path::PathBuf;

/// A scenario without moving features.
const SURVEY: Source<'_> = Source { what: "survey", scans: 200, rig: PLANAR };
/// Scenarios, which are always available: without moving features; all scans of one with moving features; and a dive, each of whose
/// frames takes as long as several scans. With a mixture and with a joint map.
const SCENARIOS: [Source<'_>; 7] = [
    SURVEY,
    Source { what: "survey", scans: 200, rig: JOINT },
    Source { what: "thesis-dynamic", scans: 301, rig: PLANAR },
    Source { what: "thesis-dynamic", scans: 301, rig: JOINT_MOVERS },
    Source { what: "thesis-dynamic", scans: 150, rig: JOINT_HYPOTHESES },
    Source { what: DIVE, scans: 40, rig: UNDERWATER },
    Source { what: DIVE, scans: 40, rig: UNDERWATER_JOINT },
];
const LOG_SCANS: usize = 200;
/// Greatest number of scans in double precision, which boards without such registers emulate in ten times as many instructions, and
/// on the host without optimisation, where a scan takes thirty times as long.
const SLOW_SCANS: usize = 60;
/// Recorded logs, which are not part of this repository.
const LOGS: [&str; 2] = ["victoria_park", "mrclam_ds6_robot2"];

/// Number of scans between snapshots of a black box.
const SNAPSHOT_EVERY: usize = 50;

/// A part of the step. Returns the number of compared scans, or the differences.
type Check<'a> = Box<dyn Fn() -> Result<usize, String> + Sync + 'a>;

pub fn step() -> Result<Outcome, Stop> {
    emulator::prepare()?;
    toolchain::find()?;
    let (logs, missing) = logs();
    let logs = logs.iter().map(|what| Source { what, scans: LOG_SCANS, rig: PLANAR });
    let sources: Vec<Source<'_>> = SCENARIOS.into_iter().chain(logs).collect();
    let named = |what: &str, result: Result<(), String>| match result {
        Ok(()) => Ok(0),
        Err(reason) => Err(format!("{what}: {reason}")),
    };
    // Depends on the clock of the host, so that nothing else runs at the same time.
    let mut results = vec![named("hardware in the loop", hil::check())];
    let sources = &sources[..];
    let mut checks: Vec<Check<'_>> = Vec::new();
    for rig in [PLANAR, JOINT, JOINT_MOVERS, JOINT_HYPOTHESES, UNDERWATER, UNDERWATER_JOINT] {
        for &precision in rig.precisions {
            checks.push(Box::new(move || replays(rig, precision, sources)));
        }
    }
    checks.push(Box::new(faults::check));
    checks.push(Box::new(black_boxes));
    checks.push(Box::new(|| named("with an operating system", rtos::check())));
    checks.push(Box::new(|| named("bits that flip", flips::check())));
    checks.push(Box::new(|| driven_by_a_timer().map(|()| 0)));
    checks.push(Box::new(|| several_sensors().map(|()| 0)));
    // Most checks use one core for most of the time.
    results.extend(process::side_by_side(&checks, |check| Ok(check()))?);
    let (mut failures, mut compared) = (Vec::new(), 0);
    for result in results {
        match result {
            Ok(scans) => compared += scans,
            Err(differences) => failures.push(differences),
        }
    }
    let compared = all_equal(compared, &failures)?;
    let missing: Vec<String> = missing.iter().map(|log| format!("no {log}")).collect();
    Ok(Outcome::without(&missing.join(", "), format!("{compared} digests equal")))
}

/// Compares every board with the host on the sources of a rig, and the host with itself without optimisation.
fn replays(rig: Rig, precision: Precision, sources: &[Source<'_>]) -> Result<usize, String> {
    let (mut compared, mut failures) = (0, Vec::new());
    let mut images = Vec::new();
    for board in rig.boards {
        images.push((board, image::build_replay(board, rig, precision)?));
    }
    let most = if precision == Precision::F64 { SLOW_SCANS } else { usize::MAX };
    for &source in sources.iter().filter(|source| source.rig == rig) {
        let source = Source { scans: source.scans.min(most), ..source };
        let stream = streams::make(source, precision)?;
        let host = streams::on_host(&stream, rig, precision)?;
        if host.scans.is_empty() {
            return Err(format!("no scan of {}", source.what));
        }
        let few = streams::make(Source { scans: source.scans.min(SLOW_SCANS), ..source }, precision)?;
        let (slow, fast) =
            (streams::on_host_unoptimised(&few, rig, precision)?, streams::on_host(&few, rig, precision)?);
        if let Some(difference) = fast.first_difference(&slow) {
            failures.push(format!("{} {} without optimisation: {difference}", source.what, rig.replay(precision)));
        }
        compared += slow.scans.len();
        let replays = emulator::replay(&images, &stream)?;
        for (name, replay) in &replays {
            if let Some(difference) = host.first_difference(replay) {
                failures.push(format!("{} {} on {name}: {difference}", source.what, rig.replay(precision)));
            }
            compared += replay.scans.len();
        }
        println!("{} {}: {} scans compared on {}", source.what, rig.replay(precision), host.scans.len(), replays.len());
    }
    all_equal(compared, &failures)
}

/// The folders of the recorded logs that are present, and those that are missing.
fn logs() -> (Vec<String>, Vec<String>) {
    let data = scphd_shared_data::folder();
    let folders = LOGS.iter().map(|name| data.join(name));
    let (here, missing): (Vec<_>, Vec<_>) = folders.partition(|folder| folder.is_dir());
    let names = |folders: Vec<PathBuf>| folders.iter().map(|folder| folder.display().to_string()).collect();
    (names(here), names(missing))
}

/// Compares the example of a robot on a board with the host.
pub fn robot() -> Result<Outcome, Stop> {
    emulator::prepare()?;
    toolchain::find()?;
    several_sensors()?;
    Ok(Outcome::Passed(FIRST.name.into()))
}

/// The example of a robot with two detectors and fixes must have the same final states on a board and on the host, with the
/// mixture and with the joint map.
fn several_sensors() -> Result<(), String> {
    let mut example = process::cargo();
    // With the optimisation and the features of the tests, which have built most of it.
    example.args(["run", "--quiet", "--profile", "test", "--package", "scphd", "--features", "embedded-hal"]);
    let host = process::read(example.args(["--example", "robot"]))?;
    let image = image::build(FIRST, "robot", &[])?;
    // The image contains its inputs and ignores the stream.
    let nothing = process::own_target_dir("no-stream.bin");
    files::write(&nothing, [0; 8])?;
    let text = emulator::run(FIRST, &image, &nothing)?;
    let end = text.lines().last().unwrap_or_default();
    // The digest of the mixture and, after it, that of the joint map.
    let digests = |text: &str| {
        let first = output::word(text, "digests")?.to_owned();
        Some([output::word(text, &first)?.to_owned(), first])
    };
    if digests(host.trim()).is_some_and(|of_host| digests(end) == Some(of_host)) {
        return Ok(());
    }
    Err(format!("the robot ended with {end} on {}, with {host} on the host", FIRST.name))
}

/// Compares a board's replays of a black box from every snapshot on with the host's replay of all of it, after every scan.
fn black_boxes() -> Result<usize, String> {
    let image = image::build(FIRST, "black-box", &[])?;
    let (mut compared, mut failures) = (0, Vec::new());
    for (what, joint) in [(SURVEY, false), (Source { rig: JOINT, ..SURVEY }, true)] {
        let (all, whole) = streams::black_box(what, SNAPSHOT_EVERY, joint)?;
        for after in (SNAPSHOT_EVERY..what.scans).step_by(SNAPSHOT_EVERY) {
            let left = streams::cut(&all, after)?;
            let replay = Replay::parse(&emulator::run(FIRST, &image, &left)?)?;
            let expected = Replay { scans: whole.scans.iter().skip(after).cloned().collect(), ..Replay::default() };
            if expected.scans.is_empty() {
                return Err(format!("the black box of {} has no scan {after}", what.what));
            }
            compared += replay.scans.len();
            failures.extend(expected.first_difference(&replay).map(|difference| {
                format!("the black box of {} on {} from scan {after} on: {difference}", left.display(), FIRST.name)
            }));
        }
    }
    println!("black boxes: {compared} scans compared on {}", FIRST.name);
    all_equal(compared, &failures)
}

/// The timer-driven loop must have the host's final state, without late scans and lost inputs.
fn driven_by_a_timer() -> Result<(), String> {
    let stream = streams::make(SURVEY, Precision::F32)?;
    let host = streams::on_host(&stream, PLANAR, Precision::F32)?;
    let image = image::build(FIRST, "vehicle-loop", &[])?;
    let run = Replay::parse(&emulator::run(FIRST, &image, &stream)?)?;
    let (Some(last), Some(end)) = (host.scans.last(), &run.end) else { return Err("nothing to compare".into()) };
    let expected = [("late", "0"), ("lost", "0"), ("digest", last.digest.as_str())];
    if expected.iter().all(|(name, value)| output::word(end, name) == Some(value)) {
        return Ok(());
    }
    Err(format!("the timer-driven loop ended with {end}, not with {expected:?}"))
}
