//! Streams for boards and host, and replays on the host.

use super::output::Replay;
use super::rig::{Precision, Rig};
use crate::once::Once;
use crate::{process, unit};
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

/// The program that replays streams on the host.
const REPLAY: &str = "scphd-replay";

#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// A scenario, `worst-case`, or the folder of a log.
    pub what: &'a str,
    /// Number of scans, from the first one on.
    pub scans: usize,
    pub rig: Rig,
}

/// The worst case of a joint map, which has its own birth intensity of moving objects.
const WORST_CASE_JOINT: &str = "worst-case-joint";

impl Source<'_> {
    /// Whether its filter has moving-object tracks; `None` if the source decides.
    fn moving(&self) -> Option<&'static str> {
        self.rig.moving.filter(|&moving| self.what != WORST_CASE_JOINT || moving == "off")
    }
}

/// Lets the simulator write a stream.
pub fn make(source: Source<'_>, precision: Precision) -> Result<PathBuf, String> {
    write(source, precision, "", &[])
}

/// Lets the simulator write a black box of a planar vehicle in single precision, and replays it on the host.
pub fn black_box(source: Source<'_>, snapshot_every: usize, joint: bool) -> Result<(PathBuf, Replay), String> {
    let replay = if joint { "box-joint-f32" } else { "box-f32" };
    let arguments = ["--snapshot-every", &snapshot_every.to_string()];
    let path = write(source, Precision::F32, "-box", &arguments)?;
    let text = run(REPLAY, OF_TESTS, &[replay.as_ref(), path.as_ref()])?;
    Ok((path, Replay::parse(&text)?))
}

/// The part of a black box from the snapshot after this number of scans on.
pub fn cut(black_box: &Path, after: usize) -> Result<PathBuf, String> {
    let left = black_box.with_extension(format!("{after}.scphd"));
    let after = after.to_string();
    run(REPLAY, OF_TESTS, &["cut".as_ref(), black_box.as_ref(), after.as_ref(), left.as_ref()])?;
    Ok(left)
}

fn write(source: Source<'_>, precision: Precision, suffix: &str, more: &[&str]) -> Result<PathBuf, String> {
    let dir = process::own_target_dir("streams");
    fs::create_dir_all(&dir).map_err(|error| format!("{}: {error}", dir.display()))?;
    let name = Path::new(source.what).file_name().unwrap_or_default().display();
    let rig = source.rig;
    let path = dir.join(format!("{name}-{}{}-{}{suffix}.scphd", source.scans, rig.mark, precision.name()));
    // Several checks need the same stream, some at the same time.
    static WRITTEN: Once<PathBuf, ()> = Once::new();
    WRITTEN.get(path.clone(), || {
        let mut simulator = simulator()?;
        simulator.args(["stream", source.what]).arg(&path);
        simulator.args(["--scans", &source.scans.to_string(), "--precision", precision.name()]);
        simulator.args(["--particles", &rig.particles.to_string(), "--samples", &rig.samples.to_string()]);
        simulator.args(["--filter", if rig.is_joint() { "joint" } else { "core" }]).args(rig.more);
        simulator.args(rig.settings.map(|settings| ["--settings", settings]).into_iter().flatten());
        simulator.args(source.moving().map(|moving| ["--moving", moving]).into_iter().flatten());
        process::run(simulator.args(more))
    })?;
    Ok(path)
}

/// The optimisation of the tests, and none.
const OPTIMISED: &str = "test";
const UNOPTIMISED: &str = "dev";

/// A build of a program: its profile, and the features of the streams' package.
type Build = (&'static str, &'static [&'static str]);

/// The build of the tests, which the step `unit` has made.
const OF_TESTS: Build = (OPTIMISED, &[]);

pub fn simulator() -> Result<Command, String> {
    program("scphd-sim", OF_TESTS).map(process::command)
}

/// A program of this workspace, which is built once in a run.
fn program(name: &'static str, build: Build) -> Result<PathBuf, String> {
    static BUILT: Once<(&str, Build), PathBuf> = Once::new();
    // All builds put a program at the same place, from where it is kept.
    static PLACE: Mutex<()> = Mutex::new(());
    BUILT.get((name, build), || {
        let _place = PLACE.lock().unwrap_or_else(PoisonError::into_inner);
        let (profile, features) = build;
        let mut cargo = process::cargo();
        if build == OF_TESTS {
            // Programs are built for the tests of their package. A separate build would have other features.
            cargo.args(["test", "--quiet", "--no-run", "--test", "guide", "--test", "crowded"]).args(unit::PACKAGES);
        } else {
            cargo.args(["build", "--quiet", "--package", "scphd-stream", "--bin", name, "--profile", profile]);
            cargo.args(["--features", &features.join(",")]);
        }
        process::run(cargo.arg("--target-dir").arg(process::target_dir()))?;
        let mark = features.iter().map(|feature| format!("-{feature}")).collect::<String>();
        let folder = process::own_target_dir("programs");
        let (built, path) =
            (process::target_dir().join("debug").join(name), folder.join(format!("{name}-{profile}{mark}")));
        let kept = fs::create_dir_all(&folder).and_then(|()| keep(&built, &path));
        kept.map(|()| path).map_err(|error| format!("{}: {error}", built.display()))
    })
}

/// Gives a program a second name, under which it stays when another build takes its place.
fn keep(built: &Path, path: &Path) -> io::Result<()> {
    if path.exists() {
        fs::remove_file(path)?;
    }
    // Not a copy where that can be avoided: a program that has just been written may still be open in a child of another thread.
    fs::hard_link(built, path).or_else(|_| fs::copy(built, path).map(drop))
}

/// Runs a program of the streams' package, and returns its output.
fn run(name: &'static str, build: Build, arguments: &[&OsStr]) -> Result<String, String> {
    process::read(process::command(program(name, build)?).args(arguments))
}

/// The output of a replay with bit flips on the host, with these features.
pub fn flips_on_host(stream: &Path, features: &'static [&str]) -> Result<String, String> {
    run("scphd-flips", (OPTIMISED, features), &[stream.as_ref()])
}

/// Replays a stream on the host with the capacities of the vehicle, unless this program has already done so.
pub fn on_host(stream: &Path, rig: Rig, precision: Precision) -> Result<Replay, String> {
    replayed(OPTIMISED, stream, rig, precision)
}

/// As [`on_host`], without optimisation.
pub fn on_host_unoptimised(stream: &Path, rig: Rig, precision: Precision) -> Result<Replay, String> {
    replayed(UNOPTIMISED, stream, rig, precision)
}

fn replayed(profile: &'static str, stream: &Path, rig: Rig, precision: Precision) -> Result<Replay, String> {
    static REPLAYED: Once<(Build, PathBuf, String), Replay> = Once::new();
    let build = (profile, rig.room);
    REPLAYED.get((build, stream.to_owned(), rig.replay(precision)), || {
        Replay::parse(&run(REPLAY, build, &[rig.replay(precision).as_ref(), stream.as_ref()])?)
    })
}
