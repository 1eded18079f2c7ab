//! Hardware in the loop: the image `hil` in QEMU communicates with `scphd-sim hil` over its serial port.

use super::board::FIRST;
use super::{emulator, image, streams};
use crate::outcome::{Outcome, Stop};
use crate::{process, toolchain};
use std::net::TcpListener;
use std::time::Duration;

/// The image. It links only if no panic is reachable.
pub const IMAGE: &str = "hil";
/// Time limit of a stream.
const LIMIT: Duration = Duration::from_secs(900);
/// Number of scans in the step `firmware`: over a good line, and over a faulty one with its error rates.
const GOOD: &str = "--scans 40";
const BAD: &str = "--scans 12 --timeout-ms 300 --lose 0.01 --double 0.02 --late 0.02 --flip 0.0005";

/// The command `hil`: the whole scenario.
pub fn step() -> Result<Outcome, Stop> {
    emulator::prepare()?;
    toolchain::find()?;
    with_target(|port| stream(port, []))?;
    Ok(Outcome::Passed("every digest equal".into()))
}

/// Some scans over a good line; then, with the same target, over one that loses, duplicates, delays and damages frames.
pub fn check() -> Result<(), String> {
    with_target(|port| {
        stream(port, GOOD.split(' '))?;
        stream(port, BAD.split(' '))
    })
}

/// Lets the simulator stream the scenario of section 5.3.1 to the target at a port.
fn stream<'a>(port: u16, more: impl IntoIterator<Item = &'a str>) -> Result<(), String> {
    let mut simulator = streams::simulator()?;
    simulator.args(["hil", "thesis-dynamic"]);
    simulator.args(["--particles", "32", "--samples", "2", "--port", &format!("tcp:127.0.0.1:{port}")]);
    process::run_for(simulator.args(more), LIMIT)
}

/// Runs the image while `work` uses its serial port.
fn with_target(work: impl FnOnce(u16) -> Result<(), String>) -> Result<(), String> {
    let image = image::build(FIRST, IMAGE, &[])?;
    let port = free_port()?;
    let mut qemu = emulator::qemu()?.command();
    qemu.args(["-machine", FIRST.name, "-nographic", "-monitor", "none", "-icount", "shift=0"]);
    qemu.args(["-serial", &format!("tcp:127.0.0.1:{port},server=on,wait=on"), "-kernel"]).arg(&image.path);
    println!("{IMAGE} in QEMU, its serial port at tcp:127.0.0.1:{port}");
    let mut running = process::Running(qemu.spawn().map_err(|error| format!("QEMU: {error}"))?);
    let done = work(port);
    match running.0.try_wait() {
        Ok(Some(status)) => Err(format!("the target has ended ({status}): {done:?}")),
        _ => done,
    }
}

/// A port that is not in use.
fn free_port() -> Result<u16, String> {
    let port = TcpListener::bind(("127.0.0.1", 0)).and_then(|listener| listener.local_addr());
    port.map(|address| address.port()).map_err(|error| format!("no free port: {error}"))
}
