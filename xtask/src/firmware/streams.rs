//! Streams for boards and host, and replays on the host.

use super::output::Replay;
use super::rig::{Precision, Rig};
use crate::once::Once;
use crate::{process, unit};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, OnceLock, PoisonError};

/// The program that replays streams on the host.
const REPLAY: &str = "scphd-replay";

/// The source of a stream.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// A scenario, `worst-case`, or the folder of a log.
    pub what: &'a str,
    /// Number of scans, from the first one on.
    pub scans: usize,
    /// The filter for it.
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
    let text = run(REPLAY, "release", &[], &[replay.as_ref(), path.as_ref()])?;
    Ok((path, Replay::parse(&text)?))
}

/// The part of a black box from the snapshot after this number of scans on.
pub fn cut(black_box: &Path, after: usize) -> Result<PathBuf, String> {
    let left = black_box.with_extension(format!("{after}.scphd"));
    let after = after.to_string();
    run(REPLAY, "release", &[], &["cut".as_ref(), black_box.as_ref(), after.as_ref(), left.as_ref()])?;
    Ok(left)
}

fn write(source: Source<'_>, precision: Precision, suffix: &str, more: &[&str]) -> Result<PathBuf, String> {
    let dir = process::own_target_dir("streams");
    std::fs::create_dir_all(&dir).map_err(|error| format!("{}: {error}", dir.display()))?;
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

/// The simulator from the tests' build, which the step `unit` has made.
pub fn simulator() -> Result<Command, String> {
    static BUILT: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let build = || {
        let mut cargo = process::cargo();
        // Programs are built for the tests of their package. A separate build would have other features.
        cargo.args(["test", "--quiet", "--no-run", "--test", "guide"]).args(unit::PACKAGES);
        process::run(cargo.arg("--target-dir").arg(process::target_dir()))?;
        Ok(process::target_dir().join("debug").join("scphd-sim"))
    };
    BUILT.get_or_init(build).clone().map(process::command)
}

/// Runs a program of the streams' package in this profile and with these features, and returns its output. One runs at a time: builds
/// with different features use the same folder, and must not overwrite a running program.
fn run(program: &str, profile: &str, features: &[&str], arguments: &[&OsStr]) -> Result<String, String> {
    static PLACE: Mutex<()> = Mutex::new(());
    let _place = PLACE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut cargo = process::cargo();
    cargo.args(["run", "--quiet", "--package", "scphd-stream", "--bin", program, "--profile", profile]);
    process::read(cargo.args(["--features", &features.join(","), "--"]).args(arguments))
}

/// The output of a replay with bit flips on the host, with these features.
pub fn flips_on_host(stream: &Path, features: &[&str]) -> Result<String, String> {
    run("scphd-flips", "release", features, &[stream.as_ref()])
}

/// Replays a stream on the host with the capacities of the vehicle, unless this program has already done so.
pub fn on_host(stream: &Path, rig: Rig, precision: Precision) -> Result<Replay, String> {
    on_host_in("release", stream, rig, precision)
}

/// As [`on_host`], in a build of this profile.
pub fn on_host_in(profile: &'static str, stream: &Path, rig: Rig, precision: Precision) -> Result<Replay, String> {
    static REPLAYED: Once<(&str, PathBuf, String, &[&str]), Replay> = Once::new();
    REPLAYED.get((profile, stream.to_owned(), rig.replay(precision), rig.room), || {
        Replay::parse(&run(REPLAY, profile, rig.room, &[rig.replay(precision).as_ref(), stream.as_ref()])?)
    })
}
