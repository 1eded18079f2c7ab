//! Replays a stream on the host, and prints the digest after every scan in the same format as the firmware.
//!
//! `scphd-replay f32|f64|joint-f32|joint-f64 FILE [SCANS]` replays a stream; `joint-40-f32` has capacity for 40 features,
//! `joint-movers-f32`, `joint-40-movers-f32` and `joint-hypotheses-f32` have moving-object tracks. With `box-` or `box-joint-`
//! before the precision it replays all records of a black box, also if it is incomplete. `scphd-replay list FILE` lists the snapshots of a black box, and
//! `scphd-replay cut FILE SCANS OUT` writes the part from the snapshot after that number of scans on.

use scphd::Real;
use scphd_stream::planar::{
    BlackBox, BlackBoxArchive, BlackBoxCalibrated, BlackBoxHypotheses, BlackBoxJoint, BlackBoxMovers, Planar,
    PlanarHypotheses, PlanarJoint, PlanarJoint40, PlanarJoint40Movers, PlanarJointMovers,
};
use scphd_stream::underwater::{self, Underwater, UnderwaterJoint};
use scphd_stream::{
    Aboard, Kind, Monitor, Numbers, Reader, Refusal, ScanCost, Seen, Snapshot, find_snapshot, find_whole_snapshot,
    recover, replay,
};
use scphd_vehicle::Filter;
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Instant;

/// Stack of the thread that replays, bytes: an unoptimised build constructs the memory on the stack, more than once, before it
/// moves it to the heap.
const STACK_BYTES: usize = 64 << 20;

/// The command line.
const USAGE: &str = "usage: scphd-replay [box-][joint-[40-][movers-]]f32|f64 FILE [SCANS], scphd-replay list FILE, scphd-replay cut FILE SCANS OUT";

/// Replays at most a number of scans of a stream.
type Work = fn(&[u8], u32) -> Result<(), String>;

/// Prints every scan; its clock counts nanoseconds.
struct Printer<W> {
    out: W,
    started: Instant,
    /// Whether to continue after a refused input.
    goes_on: bool,
    /// Number of snapshots that disagree with the state.
    disagreeing: u32,
    failed: Option<io::Error>,
}

impl<W: Write> Printer<W> {
    fn over(out: W, goes_on: bool) -> Self {
        Self { out, started: Instant::now(), goes_on, disagreeing: 0, failed: None }
    }

    fn print(&mut self, line: std::fmt::Arguments<'_>) {
        let line = writeln!(self.out, "{line}");
        self.failed = self.failed.take().or(line.err());
    }
}

impl<W: Write> Monitor for Printer<W> {
    fn start(&mut self) {
        self.started = Instant::now();
    }

    fn elapsed(&mut self) -> u64 {
        self.started.elapsed().as_nanos() as u64
    }

    fn scanned(&mut self, cost: &ScanCost, seen: &Seen, digest: u64) {
        self.print(format_args!(
            "scan {} measurements {} predictions {} in_view {} maps {} pages {} health {:04x} digest {digest:016x}",
            cost.scan,
            cost.measurements,
            cost.predictions,
            seen.in_view,
            seen.maps_updated,
            seen.pages_used,
            seen.health
        ));
    }

    fn snapshot(&mut self, scans: u32, agrees: bool) {
        self.disagreeing += u32::from(!agrees);
        self.print(format_args!("snapshot {scans} agrees {agrees}"));
    }

    fn refused(&mut self, scan: u32, refusal: &Refusal) -> bool {
        if self.goes_on {
            self.print(format_args!("refused {scan}: {refusal}"));
        }
        self.goes_on
    }
}

/// Calls one of the functions, for a stream of a planar or of an underwater vehicle.
fn of_either<R>(bytes: &[u8], planar: impl FnOnce() -> R, underwater: impl FnOnce() -> R) -> R {
    // Without the beginning of a black box, its first snapshot decides.
    let starts = Reader::<Underwater>::open(bytes).is_ok();
    if starts || Reader::<Planar>::open(bytes).is_err() && find_snapshot::<Underwater>(bytes, 0).is_some() {
        underwater()
    } else {
        planar()
    }
}

fn run<T: Real>(bytes: &[u8], scans: u32) -> Result<(), String> {
    of_either(bytes, || run_kind::<Planar, T>(bytes, scans), || run_kind::<Underwater, T>(bytes, scans))
}

fn run_joint<T: Real>(bytes: &[u8], scans: u32) -> Result<(), String> {
    of_either(bytes, || run_kind::<PlanarJoint, T>(bytes, scans), || run_kind::<UnderwaterJoint, T>(bytes, scans))
}

fn run_kind<K: Aboard<T>, T: Real>(bytes: &[u8], scans: u32) -> Result<(), String> {
    let header = Reader::<K::Kind>::open(bytes).map_err(|error| error.to_string())?.header();
    let mut memory = Box::new(K::MEMORY);
    let mut printer = Printer::over(io::stdout().lock(), false);
    printer.print(format_args!("stream scan_interval_s {}", header.scan_interval_s));
    let totals = replay::<K, T>(bytes, &mut memory, scans, &mut printer).map_err(|error| error.to_string())?;
    let mut pose = String::new();
    totals.pose.put(&mut |coordinate| pose += &format!(" {coordinate}"));
    printer.print(format_args!("end scans {} pose{pose} features {}", totals.scans, totals.features));
    done(printer)
}

fn run_box<T: Real>(bytes: &[u8]) -> Result<(), String> {
    of_either(bytes, || run_box_kind::<BlackBox, T>(bytes), || run_box_kind::<underwater::BlackBox, T>(bytes))
}

/// The black box of a joint map in the plane, with the optional parts in its first readable head.
fn run_joint_box<T: Real>(bytes: &[u8]) -> Result<(), String> {
    let from = if Reader::<Planar>::open(bytes).is_ok() { 0 } else { find_snapshot::<Planar>(bytes, 0).unwrap_or(0) };
    let header = Reader::<Planar>::open(&bytes[from..]).map_err(|error| error.to_string())?.header();
    let Filter::Joint(joint) = header.description::<f64>().map_err(|error| error.to_string())?.filter else {
        return run_box_kind::<BlackBoxJoint, T>(bytes);
    };
    if joint.hypotheses.is_some() {
        run_box_kind::<BlackBoxHypotheses, T>(bytes)
    } else if joint.odometry.is_some() {
        run_box_kind::<BlackBoxCalibrated, T>(bytes)
    } else if joint.archive_reach_m.is_some() {
        run_box_kind::<BlackBoxArchive, T>(bytes)
    } else if joint.movers.is_some() {
        run_box_kind::<BlackBoxMovers, T>(bytes)
    } else {
        run_box_kind::<BlackBoxJoint, T>(bytes)
    }
}

/// Replays all available parts of a black box.
fn run_box_kind<K: Aboard<T>, T: Real>(bytes: &[u8]) -> Result<(), String> {
    let mut memory = Box::new(K::MEMORY);
    let mut printer = Printer::over(io::stdout().lock(), true);
    let recovered = recover::<K, T>(bytes, &mut memory, &mut printer).map_err(|error| error.to_string())?;
    let totals = recovered.totals;
    let mut pose = String::new();
    totals.pose.put(&mut |coordinate| pose += &format!(" {coordinate}"));
    printer.print(format_args!(
        "end scans {} pose{pose} features {} gaps {} ended {}",
        totals.scans, totals.features, recovered.gaps, recovered.ended
    ));
    match printer.disagreeing {
        0 => done(printer),
        many => Err(format!("{many} snapshots are of other states than the replay came to")),
    }
}

fn done<W>(printer: Printer<W>) -> Result<(), String> {
    printer.failed.map_or(Ok(()), |error| Err(format!("cannot write to stdout: {error}")))
}

/// The snapshots, with their positions in the stream.
fn snapshots<K: Kind>(bytes: &[u8]) -> impl Iterator<Item = (usize, Snapshot<'_, K>)> {
    let mut from = 0;
    std::iter::from_fn(move || {
        let place = find_snapshot::<K>(bytes, from)?;
        from = place + 1;
        Some((place, Reader::<K>::open(&bytes[place..]).ok()?.snapshot()?))
    })
}

fn list<K: Kind>(bytes: &[u8]) -> Result<(), String> {
    let mut printer = Printer::over(io::stdout().lock(), false);
    for (place, snapshot) in snapshots::<K>(bytes) {
        let (mark, whole) = (snapshot.mark(), snapshot.is_whole());
        printer.print(format_args!("snapshot {} at {place} digest {:016x} whole {whole}", mark.scans, mark.digest));
    }
    done(printer)
}

/// The part of the stream from the snapshot after this number of scans on.
fn cut<K: Kind>(bytes: &[u8], scans: u32) -> Result<&[u8], String> {
    let whole = |place: usize| find_whole_snapshot::<K>(bytes, place) == Some(place);
    let found = snapshots::<K>(bytes).find(|(place, snapshot)| snapshot.mark().scans == scans && whole(*place));
    found.map(|(place, _)| &bytes[place..]).ok_or_else(|| format!("no whole snapshot after {scans} scans"))
}

/// Replays in a thread with a large stack.
fn in_thread(bytes: Vec<u8>, work: impl FnOnce(&[u8]) -> Result<(), String> + Send + 'static) -> Result<(), String> {
    let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn(move || work(&bytes));
    let thread = thread.map_err(|error| format!("cannot start a thread: {error}"))?;
    thread.join().unwrap_or_else(|_| Err("the replay panicked".into()))
}

/// The replay with a filter.
fn work_of(filter: &str) -> Option<Work> {
    // A build with other capacities replays streams of planar vehicles in single precision, and compiles in a fraction of the time.
    if cfg!(any(feature = "few-particles", feature = "small-pools")) {
        return match filter {
            "f32" => Some(run_kind::<Planar, f32>),
            "joint-f32" => Some(run_kind::<PlanarJoint, f32>),
            _ => None,
        };
    }
    Some(match filter {
        "f32" => run::<f32>,
        "f64" => run::<f64>,
        "joint-f32" => run_joint::<f32>,
        "joint-f64" => run_joint::<f64>,
        "joint-40-f32" => run_kind::<PlanarJoint40, f32>,
        "joint-movers-f32" => run_kind::<PlanarJointMovers, f32>,
        "joint-40-movers-f32" => run_kind::<PlanarJoint40Movers, f32>,
        "joint-hypotheses-f32" => run_kind::<PlanarHypotheses, f32>,
        "box-f32" => |bytes, _| run_box::<f32>(bytes),
        "box-f64" => |bytes, _| run_box::<f64>(bytes),
        "box-joint-f32" => |bytes, _| run_joint_box::<f32>(bytes),
        "box-joint-f64" => |bytes, _| run_joint_box::<f64>(bytes),
        _ => return None,
    })
}

fn execute() -> Result<(), String> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let number = |word: &str| word.parse::<u32>().map_err(|_| format!("`{word}` is no number of scans"));
    let read = |path: &str| std::fs::read(path).map_err(|error| format!("{path}: {error}"));
    match words[..] {
        ["list", path] => {
            let bytes = read(path)?;
            of_either(&bytes, || list::<Planar>(&bytes), || list::<Underwater>(&bytes))
        }
        ["cut", path, scans, out] => {
            let (bytes, scans) = (read(path)?, number(scans)?);
            let left = of_either(&bytes, || cut::<Planar>(&bytes, scans), || cut::<Underwater>(&bytes, scans))?;
            std::fs::write(out, left).map_err(|error| format!("{out}: {error}"))
        }
        [filter, path] | [filter, path, _] => {
            let scans = words.get(2).map_or(Ok(u32::MAX), |scans| number(scans))?;
            if words.len() > 2 && filter.starts_with("box-") {
                return Err("a black box is replayed whole".into());
            }
            let work = work_of(filter).ok_or_else(|| format!("`{filter}` is no filter; {USAGE}"))?;
            in_thread(read(path)?, move |bytes| work(bytes, scans))
        }
        _ => Err(USAGE.into()),
    }
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
