//! Random operations on filters, locators, snapshots and streams, determined by a seed, with plausible and hostile numbers: no
//! operation may panic, hang, or leave an invalid state.
//!
//! Operations are grouped in sessions. The seed of a session determines vehicle, scalar, capacities, and the share of hostile
//! numbers. The numbers of an operation are independent of earlier operations, so that a failing session can be reduced by
//! leaving operations out.

pub mod counts;
mod draw;
mod fixes;
mod joint;
mod locator;
mod scans;
mod session;
mod snapshots;
mod streams;
mod tuning;
mod worlds;

use scphd::storage::{Dynamic, MapMemory, NoMoving, Static};
use session::Seeded;
use std::fmt;
use std::panic::{self, AssertUnwindSafe};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use worlds::{Car, Diver, FeatureOf, Listener, Rover, Tracker, World};

pub const SESSION: usize = 250;

/// Greatest duration of an operation and the check after it. Every loop of the library is bounded by capacities, and the longest
/// operations here take about ten milliseconds; an unoptimised build on a busy machine is about a hundred times slower.
const PATIENCE: Duration = Duration::from_secs(20);

/// The tested component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Operations of a `ScPhd`.
    Mixture,
    /// Operations of a `JointSlam`.
    Joint,
    /// Operations of a `Locator`.
    Locator,
    /// Snapshots of every kind: damaged, truncated, concatenated, of other versions and capacities; restored and continued.
    Snapshots,
    /// Streams, damaged and with hostile numbers; replayed.
    Streams,
}

impl Target {
    pub const ALL: [Self; 5] = [Self::Mixture, Self::Joint, Self::Locator, Self::Snapshots, Self::Streams];

    pub fn name(self) -> &'static str {
        match self {
            Self::Mixture => "mixture",
            Self::Joint => "joint",
            Self::Locator => "locator",
            Self::Snapshots => "snapshots",
            Self::Streams => "streams",
        }
    }

    /// Its share of all operations, in thousandths.
    pub fn share(self) -> u64 {
        match self {
            Self::Mixture => 500,
            Self::Joint => 350,
            Self::Locator => 60,
            Self::Snapshots => 80,
            Self::Streams => 10,
        }
    }

    fn session(self, seed: u64) -> (String, Run) {
        match self {
            Self::Mixture => mixture_of(seed),
            Self::Joint => joint::kind_of(seed),
            Self::Locator => locator::kind_of(seed),
            Self::Snapshots => snapshots::kind_of(seed),
            Self::Streams => streams::kind_of(seed),
        }
    }
}

/// The summary of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Done {
    pub operations: u64,
    /// Duration of the longest operation with the check after it.
    pub longest: Duration,
}

/// The operations of a session to run.
pub(crate) struct Operations<'a> {
    /// Indices of the operations, in ascending order.
    pub(crate) indices: &'a [usize],
    /// Whether to print them.
    pub(crate) tell: bool,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Failure {
    /// Index of the operation that failed.
    pub(crate) operation: usize,
    pub(crate) what: String,
}

/// A failed session, with the data to reproduce it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failed {
    pub target: Target,
    pub seed: u64,
    /// Index of the operation, from 0.
    pub operation: usize,
    /// Description of the failure.
    pub what: String,
    /// Indices of operations that reproduce the failure, in order.
    pub operations: Vec<usize>,
}

impl fmt::Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { target, seed, operation, what, operations } = self;
        let name = target.name();
        writeln!(f, "{name}, session {seed}, operation {operation}: {what}")?;
        write!(
            f,
            "again, operation by operation: cargo run --release -p scphd-tests --bin fuzz -- session {name} {seed}"
        )?;
        operations.iter().try_for_each(|operation| write!(f, " {operation}"))
    }
}

/// State for the watchdog: the present operation and its start.
#[derive(Debug)]
pub(crate) struct Watch {
    target: Target,
    start: Instant,
    /// Start of the last operation, ns since the start of the run, and duration of the longest one so far.
    since_ns: AtomicU64,
    longest_ns: AtomicU64,
    seed: AtomicU64,
    operation: AtomicU64,
    /// Number of operations begun.
    begun: AtomicU64,
    done: AtomicBool,
}

impl Watch {
    fn over(target: Target) -> Self {
        let zero = || AtomicU64::new(0);
        let (since_ns, longest_ns, seed, operation, begun) = (zero(), zero(), zero(), zero(), zero());
        let (start, done) = (Instant::now(), AtomicBool::new(false));
        Self { target, start, since_ns, longest_ns, seed, operation, begun, done }
    }

    /// Records the start of an operation, and the end of the previous one.
    pub(crate) fn at(&self, seed: u64, operation: usize) {
        let now = self.start.elapsed().as_nanos() as u64;
        let took = now - self.since_ns.swap(now, Ordering::Relaxed);
        self.longest_ns.fetch_max(took, Ordering::Relaxed);
        self.seed.store(seed, Ordering::Relaxed);
        self.operation.store(operation as u64, Ordering::Relaxed);
        self.begun.fetch_add(1, Ordering::Relaxed);
    }

    /// Ends the process if an operation does not return.
    fn guard(&self) {
        let (mut seen, mut since) = (0, Instant::now());
        while !self.done.load(Ordering::Relaxed) {
            thread::sleep(Duration::from_millis(100));
            let begun = self.begun.load(Ordering::Relaxed);
            if begun != seen {
                (seen, since) = (begun, Instant::now());
            } else if since.elapsed() > PATIENCE {
                let (seed, operation) = (self.seed.load(Ordering::Relaxed), self.operation.load(Ordering::Relaxed));
                let name = self.target.name();
                eprintln!("{name}, session {seed}, operation {operation}: it does not return");
                eprintln!("again: cargo run --release -p scphd-tests --bin fuzz -- session {name} {seed}");
                process::exit(101);
            }
        }
    }
}

/// Runs `operations` operations from `seed` on; calls `progress` with the number of finished ones. Outcomes are
/// [counted](counts::take).
pub fn run(target: Target, operations: u64, seed: u64, progress: &mut dyn FnMut(u64)) -> Result<Done, Box<Failed>> {
    guarded(target, |watch| {
        let mut done = 0;
        for session in 0..operations.div_ceil(SESSION as u64) {
            let seed = seed.wrapping_add(session);
            let indices: Vec<usize> = (0..SESSION.min((operations - done) as usize)).collect();
            if let Err(failure) = attempt(seed, &Operations { indices: &indices, tell: false }, watch) {
                return Err(Box::new(shortened(seed, &indices, failure, watch)));
            }
            done += indices.len() as u64;
            progress(done);
        }
        Ok(Done { operations: done, longest: Duration::from_nanos(watch.longest_ns.load(Ordering::Relaxed)) })
    })
}

/// Repeats a session and prints its operations: all, or those with these indices.
pub fn replay(target: Target, seed: u64, operations: &[usize]) -> Result<(), Box<Failed>> {
    let all: Vec<usize> = (0..SESSION).collect();
    let indices = if operations.is_empty() { &all } else { operations };
    println!("{}", target.session(seed).0);
    guarded(target, |watch| attempt(seed, &Operations { indices, tell: true }, watch)).map_err(|failure| {
        let Failure { operation, what } = failure;
        Box::new(Failed { target, seed, operation, what, operations: indices.to_vec() })
    })
}

fn guarded<R>(target: Target, work: impl FnOnce(&Watch) -> R) -> R {
    let watch = Arc::new(Watch::over(target));
    let guard = thread::spawn({
        let watch = Arc::clone(&watch);
        move || watch.guard()
    });
    let result = work(&watch);
    watch.done.store(true, Ordering::Relaxed);
    let _ = guard.join();
    result
}

/// Removes operations that are not needed for the failure: smaller and smaller groups, down to single operations.
fn shortened(seed: u64, indices: &[usize], failure: Failure, watch: &Watch) -> Failed {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let mut last = failure;
    let mut needed: Vec<usize> = indices.iter().copied().filter(|&index| index <= last.operation).collect();
    let mut part = needed.len().div_ceil(2);
    while part > 0 {
        let mut from = 0;
        while from < needed.len() {
            let without: Vec<usize> = [&needed[..from], &needed[needed.len().min(from + part)..]].concat();
            match attempt(seed, &Operations { indices: &without, tell: false }, watch) {
                Err(failure) if !without.is_empty() => (needed, last) = (without, failure),
                _ => from += part,
            }
        }
        part /= 2;
    }
    panic::set_hook(hook);
    Failed { target: watch.target, seed, operation: last.operation, what: last.what, operations: needed }
}

fn attempt(seed: u64, operations: &Operations<'_>, watch: &Watch) -> Result<(), Failure> {
    let (_, session) = watch.target.session(seed);
    panic::catch_unwind(AssertUnwindSafe(|| session(operations, watch))).unwrap_or_else(|payload| {
        let text = payload.downcast_ref::<String>().cloned();
        let text = text.or_else(|| payload.downcast_ref::<&str>().map(|&text| text.to_owned()));
        let operation = watch.operation.load(Ordering::Relaxed) as usize;
        Err(Failure { operation, what: format!("a panic: {}", text.unwrap_or_default()) })
    })
}

type Run = Box<dyn Fn(&Operations<'_>, &Watch) -> Result<(), Failure>>;

/// A session of this kind and its description.
fn named(kind: &str, seeded: Seeded, run: fn(Seeded, &Operations<'_>, &Watch) -> Result<(), Failure>) -> (String, Run) {
    let hostility = seeded.hostility;
    let run = Box::new(move |operations: &Operations<'_>, watch: &Watch| run(seeded, operations, watch));
    (format!("{kind}; {hostility} of the numbers hostile"), run)
}

fn require(holds: bool, what: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what()) }
}

/// The kinds of sessions: a vehicle, a scalar, and capacities for particles, candidates, measurements, pages, pages of a map,
/// components in an update; with or without moving features.
macro_rules! sessions {
    ($choice:expr; $($world:ident $t:ident:
        $(($n:literal $c:literal $m:literal, $pages:literal $map:literal $view:literal $moving:ident))*;)*) => {{
        let mut kinds: Vec<(String, fn(Seeded, &Operations<'_>, &Watch) -> Result<(), Failure>)> = Vec::new();
        $($(
            kinds.push((
                format!(
                    "{}, {}: {} particles, {} candidates, {} measurements, {} pages, {} a map, {} in an update, {}",
                    <$world<$t> as World>::NAME,
                    stringify!($t), $n, $c, $m, $pages, $map, $view, stringify!($moving),
                ),
                session::run::<$world<$t>, $n, $c, $m,
                    MapMemory<Static<FeatureOf<$world<$t>>>, $n, $pages, $map, $view>,
                    sessions!(@$moving $world $t $n $pages $map $view)>,
            ));
        )*)*
        let (name, run) = kinds.swap_remove($choice % kinds.len());
        (name, run)
    }};
    (@moving $world:ident $t:ident $n:literal $pages:literal $map:literal $view:literal) => {
        MapMemory<Dynamic<FeatureOf<$world<$t>>>, $n, $pages, $map, $view>
    };
    (@still $world:ident $t:ident $n:literal $pages:literal $map:literal $view:literal) => { NoMoving };
}

/// The kind of session of a mixture of a seed. A change of this list gives every recorded seed another session.
fn mixture_of(seed: u64) -> (String, Run) {
    let (seeded, mut draw) = Seeded::of(seed, 0x5eed);
    let (name, run) = sessions!(draw.below(1 << 20);
        Rover f32:
            (1 1 1, 1 1 8 still) (1 1 1, 1 1 8 moving) (2 4 4, 6 3 12 moving) (4 8 8, 24 6 24 moving) (8 16 24, 128 16 128 moving);
        Rover f64:
            (1 1 1, 1 1 8 moving) (3 6 6, 12 4 16 moving) (8 16 24, 128 16 128 moving);
        Car f32: (4 4 12, 16 8 32 still) (8 16 16, 64 16 128 moving);
        Car f64: (4 8 12, 16 8 32 moving);
        Tracker f32: (1 1 4, 4 4 16 still) (2 4 12, 32 16 256 moving);
        Tracker f64: (1 2 12, 32 32 256 moving);
        Diver f32: (1 1 1, 1 1 8 moving) (4 8 12, 48 12 64 moving);
        Diver f64: (2 4 6, 8 4 16 still) (4 8 12, 48 12 64 moving);
        Listener f32: (1 2 2, 2 2 8 moving) (4 8 12, 48 12 64 moving);
        Listener f64: (4 4 12, 48 12 64 still);
    );
    named(&name, seeded, run)
}
