//! `scphd-sim hil`.

use super::args::HilArgs;
use super::failure::{Failure, is_quiet, print};
use super::source::{Found, OfKind};
use scphd_boards::hil::{Bench, HilError, Limits, Line, Outcome, Rates, Scanned, expected};
use scphd_boards::stream;
use scphd_link::{Answer, Report, Unit};
use scphd_log::dimensions::Planar;
use scphd_log::log::Log;
use scphd_log::truth;
use scphd_stream::Scalar;
use scphd_stream::planar;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Sums over the scans for the summary.
#[derive(Default)]
struct Sums {
    scans: usize,
    differing: Vec<usize>,
    round_trips: Vec<Duration>,
    /// Cost of the scans: sum and maximum.
    cost: u64,
    cost_worst: u64,
    squared_error_m2: f64,
    known: usize,
}

/// Streams to the target, prints every scan and the summary.
pub fn hil(args: &HilArgs) -> Result<(), Failure> {
    let OfKind::Planar(source) = Found::find(&args.source, args.scenario_seed.scenario_seed)? else {
        return Err(Failure::input("hil is for vehicles in the plane"));
    };
    let seed = args.seed.seed;
    let log = source.log(seed)?;
    // Images on boards have no tracks and one hypothesis, unless they are asked for.
    let settings = source.tuned_alike(&log, &args.tuning, &[args.filter.choice()])?;
    let scans = args.scans.unwrap_or(usize::MAX);
    let stream =
        stream::write(&log, &settings, args.filter.recorded(), seed, Scalar::F32, scans).map_err(Failure::input)?;
    let digests = expected(&stream.bytes)
        .map_err(|why| Failure::input(format_args!("a target has room for 32 particles of 2 samples: {why}")))?;
    let HilArgs { lose, flip, double, late, .. } = *args;
    let limits = Limits { answer_within: Duration::from_millis(args.timeout_ms.into()), repeats: args.repeats };
    let line = Line::open(&args.port).map_err(|error| Failure::input(format_args!("--port: {error}")))?;
    let rates = Rates { lose, flip, double, late };
    let mut bench = Bench::new(line, another_session(), limits, rates, args.line_seed);
    let mut sums = Sums::default();
    let mut printed = Ok(());
    if !is_quiet() {
        print(" scan  error, m  sigma, m  digest            equal  round trip, ms  repeats")?;
    }
    let outcome = bench.run::<planar::Planar>(&stream.bytes, |scanned| {
        let is_equal = digests.get(scanned.scan).copied().flatten() == Some(scanned.answer.digest);
        let error_m = error_m(&log, scanned);
        sums.add(scanned, is_equal, error_m);
        if printed.is_ok() && !is_quiet() {
            printed = print(&row(scanned, is_equal, error_m));
        }
    });
    printed?;
    let outcome = outcome.map_err(|error| match error {
        HilError::NotSetUp | HilError::Stream | HilError::TooLong { .. } => Failure::input(error),
        error => Failure::Internal(error.to_string()),
    })?;
    if !is_quiet() {
        print(&sums.told(args, &outcome))?;
    }
    match sums.differing[..] {
        [] if sums.scans == digests.len() => Ok(()),
        [] => Err(Failure::Internal(format!("{} scans of {} were answered", sums.scans, digests.len()))),
        [first, ..] => {
            let many = sums.differing.len();
            Err(Failure::Internal(format!("{many} digests differ from the host's, that of scan {first} first")))
        }
    }
}

/// A session number that differs from that of other runs.
fn another_session() -> u16 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    // From microseconds: the sessions of a target are seconds apart or more.
    (now.as_micros() % 65_521) as u16
}

/// Distance of the estimated position from the true one, m.
fn error_m(log: &Log, scanned: &Scanned<planar::Planar>) -> Option<f64> {
    let [x, y, _] = scanned.answer.pose;
    let true_pose = truth::at::<Planar>(&log.truth, log.scans.get(scanned.scan)?.t_s)?;
    let [true_x, true_y] = true_pose.position;
    Some((x - true_x).hypot(y - true_y))
}

fn row(scanned: &Scanned<planar::Planar>, is_equal: bool, error_m: Option<f64>) -> String {
    let Scanned { scan, answer, round_trip, repeats } = scanned;
    let [xx, _, yy, ..] = answer.covariance;
    let error = error_m.map_or_else(String::new, |error| format!("{error:.3}"));
    let equal = if is_equal { "yes" } else { "NO" };
    let [sigma, ms] = [(xx + yy).sqrt(), milliseconds(*round_trip)];
    format!("{scan:5}  {error:>8}  {sigma:8.3}  {:016x}  {equal:5}  {ms:14.1}  {repeats:7}", answer.digest)
}

fn milliseconds(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

impl Sums {
    fn add(&mut self, scanned: &Scanned<planar::Planar>, is_equal: bool, error_m: Option<f64>) {
        self.scans += 1;
        if !is_equal {
            self.differing.push(scanned.scan);
        }
        self.round_trips.push(scanned.round_trip);
        let cost = scanned.answer.cost.total();
        self.cost += cost;
        self.cost_worst = self.cost_worst.max(cost);
        if let Some(error_m) = error_m {
            self.known += 1;
            self.squared_error_m2 += error_m * error_m;
        }
    }

    fn told(&mut self, args: &HilArgs, outcome: &Outcome<planar::Planar>) -> String {
        self.round_trips.sort_unstable();
        let at = |share: f64| {
            let place = (share * self.round_trips.len().saturating_sub(1) as f64) as usize;
            self.round_trips.get(place).map_or(f64::NAN, |&time| milliseconds(time))
        };
        let in_time = self.round_trips.iter().filter(|time| time.as_secs_f64() * args.hz <= 1.0).count();
        let Outcome { last, frames, repeats, answers } = outcome;
        let mut lines = vec![format!(
            "{} scans, {} digests equal, {} different; position RMSE {:.3} m; {} records refused by the filter",
            self.scans,
            self.scans - self.differing.len(),
            self.differing.len(),
            (self.squared_error_m2 / self.known as f64).sqrt(),
            last.refused,
        )];
        lines.push(format!(
            "round trip, ms: median {:.1}, 95 % {:.1}, worst {:.1}; {in_time} within the {:.1} of {} Hz",
            at(0.5),
            at(0.95),
            at(1.0),
            1e3 / args.hz,
            args.hz,
        ));
        lines.push(self.margin(args, last));
        lines.push(format!("frames: {frames} sent, {repeats} of them repeats"));
        lines.push(format!("the target has {}", counts(&last.report)));
        lines.push(format!("the host has {}", counts(answers)));
        lines.join("\n")
    }

    /// The margin of the time between two scans.
    fn margin(&self, args: &HilArgs, last: &Answer<planar::Planar>) -> String {
        let (unit, per_second) = match last.unit {
            Unit::Cycles => ("cycles", 1e6 * args.core_mhz),
            Unit::Instructions => ("instructions", 1e6 * args.core_mhz),
            Unit::Nanoseconds => ("ns", 1e9),
        };
        let there = per_second / args.hz;
        let left = |cost: f64| 100.0 * (1.0 - cost / there);
        let [mean, worst] = [self.cost as f64 / self.scans.max(1) as f64, self.cost_worst as f64];
        let of = match last.unit {
            Unit::Cycles => format!(" of {there:.0} at {} MHz", args.core_mhz),
            Unit::Instructions => format!(" of {there:.0}, one a cycle at {} MHz", args.core_mhz),
            Unit::Nanoseconds => format!(" of {there:.0}"),
        };
        format!(
            "cost of a scan with its predictions and estimates: mean {mean:.0}, worst {worst:.0} {unit}{of}: margin at {} Hz \
             {:.0} %, worst {:.0} %",
            args.hz,
            left(mean),
            left(worst)
        )
    }
}

fn counts(report: &Report) -> String {
    let Report { accepted, damaged, too_long, unknown, foreign, doubled, late, ahead, lost } = report;
    let refused = [
        (damaged, "damaged"),
        (too_long, "too long"),
        (unknown, "unknown"),
        (foreign, "of another session"),
        (doubled, "doubled"),
        (late, "late"),
        (ahead, "ahead of a missing one"),
    ];
    let refused: Vec<String> =
        refused.iter().filter(|(count, _)| **count > 0).map(|(count, what)| format!("{count} {what}")).collect();
    let refused = if refused.is_empty() { "none".into() } else { refused.join(", ") };
    format!("accepted {accepted}, refused {refused}, missed {lost}")
}
