//! Hardware in the loop: the image `hil` in QEMU answers `scphd-sim hil` over its serial port.

use std::net::TcpListener;
use std::process::Child;
use std::time::Duration;

use super::board::EMULATED;
use super::emulator;
use super::image::{self, Extra};
use super::streams;
use crate::outcome::{Outcome, Stop};
use crate::process;
use crate::toolchain::{self, Toolchain};
use crate::tools::Tool;

/// The image. It links only if no panic can be reached.
pub const IMAGE: &str = "hil";
/// A stream that takes longer has gone wrong.
const LIMIT: Duration = Duration::from_secs(900);
/// Scans of the step `firmware`.
const SCANS: &str = "40";
/// Scans over a bad line, and how bad it is.
const BAD: [&str; 12] = [
    "--scans",
    "12",
    "--timeout-ms",
    "300",
    "--lose",
    "0.01",
    "--double",
    "0.02",
    "--late",
    "0.02",
    "--flip",
    "0.0005",
];

/// The command `hil`: the whole scenario.
pub fn step() -> Outcome {
    let whole = || -> Result<Outcome, Stop> {
        let qemu = emulator::prepare()?;
        let toolchain = toolchain::find()?;
        with_target(&qemu, &toolchain, |port| stream(port, &[]))?;
        Ok(Outcome::Passed("every digest equal".into()))
    };
    whole().into()
}

/// Some scans over a good line, then, to the target that has served these, over one that loses, doubles, delays and damages frames.
pub fn check(qemu: &Tool, toolchain: &Toolchain) -> Result<(), String> {
    with_target(qemu, toolchain, |port| {
        stream(port, &["--scans", SCANS])?;
        stream(port, &BAD)
    })
}

/// Has the simulator stream the scenario of 5.3.1 to the target at a port.
fn stream(port: u16, more: &[&str]) -> Result<(), String> {
    let mut simulator = streams::simulator()?;
    simulator.args(["hil", "thesis-dynamic"]);
    simulator.args(["--particles", "32", "--samples", "2", "--port", &format!("tcp:127.0.0.1:{port}")]);
    process::run_for(simulator.args(more), LIMIT)
}

/// Runs the image while something is done with its serial port.
fn with_target(qemu: &Tool, toolchain: &Toolchain, work: impl FnOnce(u16) -> Result<(), String>) -> Result<(), String> {
    let [board, ..] = &EMULATED;
    let image = image::build(toolchain, board, IMAGE, &Extra::default())?;
    let port = free_port()?;
    let mut emulator = qemu.command();
    emulator.args(["-machine", board.name, "-nographic", "-monitor", "none", "-icount", "shift=0"]);
    emulator.args(["-serial", &format!("tcp:127.0.0.1:{port},server=on,wait=on"), "-kernel"]).arg(&image.path);
    println!("{IMAGE} in QEMU, its serial port at tcp:127.0.0.1:{port}");
    let mut running = Running(emulator.spawn().map_err(|error| format!("QEMU: {error}"))?);
    let done = work(port);
    match running.0.try_wait() {
        Ok(Some(status)) => Err(format!("the target has ended ({status}): {done:?}")),
        _ => done,
    }
}

/// A port that nobody has now.
fn free_port() -> Result<u16, String> {
    let port = TcpListener::bind(("127.0.0.1", 0)).and_then(|listener| listener.local_addr());
    port.map(|address| address.port()).map_err(|error| format!("no free port: {error}"))
}

/// A program that ends with this.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Either call fails only if it has ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
