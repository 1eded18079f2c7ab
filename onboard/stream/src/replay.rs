//! The loop that passes a stream to a filter.

use crate::numbers::Numbers;
use crate::{Aboard, Filter, Kind, Reader, Record, Refusal, Seen, StreamError};
use scphd::Real;
use scphd::diagnostics::Probe;

/// Observes a replay: measures times, if it has a clock, and is called after every scan.
pub trait Monitor {
    /// Starts the clock.
    fn start(&mut self) {}
    /// The time since the clock was started, in its unit.
    fn elapsed(&mut self) -> u64 {
        0
    }
    /// The probe for the stages of every scan.
    fn probe(&mut self) -> impl Probe {}
    /// Called after a scan. Its own time is not counted.
    fn scanned(&mut self, cost: &ScanCost, seen: &Seen, digest: u64);
    /// Called at a snapshot after `scans` scans, or when one was restored: whether the digest of the state agrees with it. Only
    /// filters of black boxes call it.
    fn snapshot(&mut self, _scans: u32, _agrees: bool) {}
    /// Called when the filter has refused a record before or with a scan. Returns whether to continue without it, as a vehicle
    /// does.
    fn refused(&mut self, _scan: u32, _refusal: &Refusal) -> bool {
        false
    }
}

/// Cost of a scan and of the predictions before it, in the unit of the monitor's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanCost {
    /// Index of the scan, from 0.
    pub scan: u32,
    /// Number of its measurements.
    pub measurements: u32,
    /// Number of predictions since the previous scan.
    pub predictions: u32,
    /// Cost of all these predictions.
    pub predict: u64,
    /// Cost of the longest of them.
    pub predict_worst: u64,
    /// Cost of the scan.
    pub update: u64,
    /// Cost of the estimates of pose and map.
    pub estimate: u64,
}

impl ScanCost {
    const fn of(scan: u32) -> Self {
        Self { scan, measurements: 0, predictions: 0, predict: 0, predict_worst: 0, update: 0, estimate: 0 }
    }
}

/// Results of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Totals<K: Kind> {
    /// Number of scans.
    pub scans: u32,
    /// The pose after the last scan.
    pub pose: K::Pose,
    /// Number of estimated features after the last scan.
    pub features: usize,
}

impl<K: Kind> Totals<K> {
    /// Before the first scan.
    pub(crate) const NONE: Self = Self { scans: 0, pose: K::Pose::ZERO, features: 0 };
}

/// Errors of a replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReplayError {
    /// The stream cannot be read.
    #[error(transparent)]
    Stream(StreamError),
    /// The filter cannot be constructed from the head.
    #[error("the filter refuses the stream header: {0}")]
    Start(Refusal),
    /// The filter refused a record before or with this scan, counted from 0.
    #[error("scan {scan}: the filter refuses: {refusal}")]
    Step {
        /// The scan.
        scan: u32,
        /// The reason.
        refusal: Refusal,
    },
}

/// Replays the stream in `bytes` with a filter in `memory`, up to `scans` scans. A stream that begins with a snapshot is
/// continued from there.
///
/// # Errors
/// The stream is damaged, or the filter refuses a record.
pub fn replay<A: Aboard<T>, T: Real>(
    bytes: &[u8],
    memory: &mut A::Memory,
    scans: u32,
    monitor: &mut impl Monitor,
) -> Result<Totals<A::Kind>, ReplayError> {
    let mut reader = Reader::<A::Kind>::open(bytes).map_err(ReplayError::Stream)?;
    let mut totals = Totals::NONE;
    run::<A, T>(&mut reader, memory, scans, monitor, &mut totals)?;
    Ok(totals)
}

/// Constructs the filter. Not inlined, so that what is needed only for this is on the stack only here.
#[inline(never)]
pub(crate) fn start<'m, A: Aboard<T>, T: Real>(
    reader: &Reader<'_, A::Kind>,
    memory: &'m mut A::Memory,
) -> Result<A::Filter<'m>, Refusal> {
    A::start(&reader.head, memory)
}

/// Replays the stream from a reader's position behind its head, until `scans` scans in total.
pub(crate) fn run<A: Aboard<T>, T: Real>(
    reader: &mut Reader<'_, A::Kind>,
    memory: &mut A::Memory,
    scans: u32,
    monitor: &mut impl Monitor,
    totals: &mut Totals<A::Kind>,
) -> Result<(), ReplayError> {
    let mut started = start::<A, T>(reader, memory);
    // By reference, because a filter that is moved out takes its place on the stack twice.
    let filter = started.as_mut().map_err(|refusal| ReplayError::Start(*refusal))?;
    let mut first = 0;
    if let Some(snapshot) = reader.snapshot() {
        filter.restore(&snapshot).map_err(ReplayError::Start)?;
        first = snapshot.mark().scans;
        monitor.snapshot(first, filter.digest() == snapshot.mark().digest);
    }
    let mut cost = ScanCost::of(first);
    while totals.scans < scans {
        let outcome = match reader.read().map_err(ReplayError::Stream)? {
            None => break,
            Some(Record::Predict(input)) => {
                monitor.start();
                let moved = filter.predict(&input);
                let elapsed = monitor.elapsed();
                cost.predictions = cost.predictions.saturating_add(1);
                cost.predict = cost.predict.saturating_add(elapsed);
                cost.predict_worst = cost.predict_worst.max(elapsed);
                moved
            }
            Some(Record::Scan(measurements)) => {
                let scan = filter.receive(measurements);
                cost.measurements = scan.measurements() as u32;
                monitor.start();
                let seen = filter.scan_with(scan, &mut monitor.probe());
                cost.update = monitor.elapsed();
                let done = cost;
                totals.scans = totals.scans.saturating_add(1);
                cost = ScanCost::of(cost.scan.saturating_add(1));
                match seen {
                    Ok(seen) => {
                        monitor.start();
                        (totals.pose, totals.features) = filter.estimate();
                        let estimate = monitor.elapsed();
                        monitor.scanned(&ScanCost { estimate, ..done }, &seen, filter.digest());
                        Ok(())
                    }
                    Err(refusal) => {
                        refused(monitor, done.scan, refusal)?;
                        Ok(())
                    }
                }
            }
            Some(record) => match &record {
                Record::Head(head) if head.mark().is_some() => {
                    if A::Filter::BLACK_BOX {
                        let agrees = head.mark().is_some_and(|mark| mark.digest == filter.digest());
                        monitor.snapshot(cost.scan, agrees);
                    }
                    Ok(())
                }
                record => filter.take(record),
            },
        };
        outcome.or_else(|refusal| refused(monitor, cost.scan, refusal))?;
    }
    Ok(())
}

/// Asks the monitor whether to continue after a refusal.
fn refused(monitor: &mut impl Monitor, scan: u32, refusal: Refusal) -> Result<(), ReplayError> {
    if monitor.refused(scan, &refusal) { Ok(()) } else { Err(ReplayError::Step { scan, refusal }) }
}
