//! Replays a stream on the desk: `scphd-replay f32|f64|joint-f32|joint-f64 FILE [SCANS]` prints the digest after every scan, with the
//! same words as the firmware.

use scphd::Real;
use scphd_stream::planar::{Planar, PlanarJoint};
use scphd_stream::underwater::Underwater;
use scphd_stream::{Aboard, Monitor, Numbers, Reader, ScanCost, Seen, StreamError, replay};
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Instant;

/// Stack of the thread that replays, bytes: an unoptimised build makes the memory on the stack before it moves to the
/// heap, more than once.
const STACK_BYTES: usize = 64 << 20;

/// Prints every scan; its clock counts nanoseconds.
struct Printer<W> {
    out: W,
    started: Instant,
    failed: Option<io::Error>,
}

impl<W: Write> Monitor for Printer<W> {
    fn start(&mut self) {
        self.started = Instant::now();
    }

    fn elapsed(&mut self) -> u64 {
        self.started.elapsed().as_nanos() as u64
    }

    fn scanned(&mut self, cost: &ScanCost, seen: &Seen, digest: u64) {
        let line = writeln!(
            self.out,
            "scan {} measurements {} predictions {} in_view {} maps {} pages {} health {:04x} digest {digest:016x}",
            cost.scan,
            cost.measurements,
            cost.predictions,
            seen.in_view,
            seen.maps_updated,
            seen.pages_used,
            seen.health
        );
        self.failed = self.failed.take().or(line.err());
    }
}

/// Whatever vehicle the stream is of.
fn run<T: Real>(bytes: &[u8], scans: u32) -> Result<(), String>
where
    Planar: Aboard<T, Kind = Planar>,
    Underwater: Aboard<T, Kind = Underwater>,
{
    match Reader::<Planar>::open(bytes) {
        Err(StreamError::Vehicle { .. }) => run_kind::<Underwater, T>(bytes, scans),
        _ => run_kind::<Planar, T>(bytes, scans),
    }
}

fn run_kind<K: Aboard<T>, T: Real>(bytes: &[u8], scans: u32) -> Result<(), String> {
    let header = *Reader::<K::Kind>::open(bytes).map_err(|error| error.to_string())?.header();
    let mut memory = Box::new(K::MEMORY);
    let mut printer = Printer { out: io::stdout().lock(), started: Instant::now(), failed: None };
    let line = writeln!(printer.out, "stream scan_interval_s {}", header.scan_interval_s);
    printer.failed = line.err();
    let totals = replay::<K, T>(bytes, &mut memory, scans, &mut printer).map_err(|error| error.to_string())?;
    let mut pose = String::new();
    totals.pose.put(&mut |coordinate| pose += &format!(" {coordinate}"));
    let end = writeln!(printer.out, "end scans {} pose{pose} features {}", totals.scans, totals.features);
    match printer.failed.or(end.err()) {
        Some(error) => Err(format!("cannot write to stdout: {error}")),
        None => Ok(()),
    }
}

fn execute() -> Result<(), String> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (precision, path, scans) = match &words[..] {
        [precision, path] => (precision, path, u32::MAX),
        [precision, path, scans] => {
            (precision, path, scans.parse().map_err(|_| format!("`{scans}` is no number of scans"))?)
        }
        _ => return Err("usage: scphd-replay f32|f64|joint-f32|joint-f64 FILE [SCANS]".into()),
    };
    let bytes = std::fs::read(path).map_err(|error| format!("{path}: {error}"))?;
    let work: fn(&[u8], u32) -> Result<(), String> = match precision.as_str() {
        "f32" => run::<f32>,
        "f64" => run::<f64>,
        "joint-f32" => run_kind::<PlanarJoint, f32>,
        "joint-f64" => run_kind::<PlanarJoint, f64>,
        other => return Err(format!("`{other}` is none of f32, f64, joint-f32, joint-f64")),
    };
    let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn(move || work(&bytes, scans));
    let thread = thread.map_err(|error| format!("cannot start a thread: {error}"))?;
    thread.join().unwrap_or_else(|_| Err("the replay panicked".into()))
}

fn main() -> ExitCode {
    match execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}
