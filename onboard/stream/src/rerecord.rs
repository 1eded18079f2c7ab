//! Records a stream again, with snapshots.

use crate::black_box::Saves;
use crate::record::Record;
use crate::replay::{ReplayError, start};
use crate::{Aboard, Filter, Reader, Refusal, Writer};
use scphd::Real;
use scphd::snapshot::SaveError;

/// Errors of recording a stream again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RerecordError<E> {
    /// The stream cannot be replayed.
    #[error(transparent)]
    Replay(ReplayError),
    /// A snapshot cannot be written, or the sink returned an error.
    #[error(transparent)]
    Save(SaveError<E>),
}

/// Replays the stream in `bytes`, which begins with a start, and writes it again, with a snapshot after every `every` scans.
/// Refused records are kept, because a vehicle records all inputs of its filter, except refused changes of models or tuning. Existing
/// snapshots are left out.
///
/// # Errors
/// The stream is damaged, the filter refuses its head, a snapshot cannot be written, or the sink returned an error.
pub fn rerecord<'m, A, T, E>(
    bytes: &[u8],
    memory: &'m mut A::Memory,
    every: u32,
    sink: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<(), RerecordError<E>>
where
    A: Aboard<T>,
    A::Filter<'m>: Saves<A::Kind>,
    T: Real + 'm,
{
    let of_stream = |error| RerecordError::Replay(ReplayError::Stream(error));
    let of_sink = |error| RerecordError::Save(SaveError::Sink(error));
    let mut reader = Reader::<A::Kind>::open(bytes).map_err(of_stream)?;
    let of_start = |refusal| RerecordError::Replay(ReplayError::Start(refusal));
    let mut filter = start::<A, T>(&reader, memory).map_err(of_start)?;
    let mut log = Writer::start(&reader.header(), sink).map_err(of_sink)?;
    let mut scans = 0_u32;
    while let Some((raw, record)) = reader.read_both().map_err(of_stream)? {
        let is_scan = matches!(record, Record::Scan(_));
        // A refused change of models has no effect, and must not be in the head of a snapshot. Any other refused record has the same
        // effect on this filter as on that of a replay.
        if matches!(record, Record::Head(_) | Record::Detector(..)) {
            let is_snapshot = matches!(record, Record::Head(head) if head.mark().is_some());
            if !is_snapshot && filter.take(&record).is_ok() {
                log.again(&raw, &record).map_err(of_sink)?;
            }
            continue;
        }
        log.again(&raw, &record).map_err(of_sink)?;
        let _: Result<(), Refusal> = match record {
            Record::Predict(input) => filter.predict(&input),
            Record::Scan(measurements) => {
                let scan = filter.receive(measurements);
                filter.scan(scan).map(drop)
            }
            record => filter.take(&record),
        };
        if is_scan {
            scans = scans.saturating_add(1);
            if every > 0 && scans.is_multiple_of(every) {
                filter.save(&mut log).map_err(RerecordError::Save)?;
            }
        }
    }
    log.end().map_err(of_sink)
}
