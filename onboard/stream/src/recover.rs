//! The replay of an incomplete black box.

use crate::find::find_whole_snapshot;
use crate::reader::Reader;
use crate::replay::{Monitor, ReplayError, Totals, run};
use crate::{Aboard, Kind};
use scphd::Real;

/// Results of the replay of a black box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recovered<K: Kind> {
    /// Number of replayed scans, and the pose and the number of features after the last.
    pub totals: Totals<K>,
    /// Number of times that the replay continued at the next snapshot, or began with one because the beginning is missing.
    pub gaps: u32,
    /// Whether the stream is complete up to its end.
    pub ended: bool,
}

/// Replays all usable parts of the stream in `bytes`: from the beginning, or from the first complete snapshot if the beginning is
/// missing, and after damaged or missing records from the next complete snapshot.
///
/// # Errors
/// There is no start point for a replay, or the filter refuses a record and the monitor does not continue.
pub fn recover<A: Aboard<T>, T: Real>(
    bytes: &[u8],
    memory: &mut A::Memory,
    monitor: &mut impl Monitor,
) -> Result<Recovered<A::Kind>, ReplayError> {
    let mut recovered = Recovered { totals: Totals::NONE, gaps: 0, ended: false };
    let mut place = 0;
    loop {
        let (error, damaged) = match Reader::<A::Kind>::open(bytes.get(place..).unwrap_or(&[])) {
            Err(error) => (ReplayError::Stream(error), place),
            Ok(mut reader) => match run::<A, T>(&mut reader, memory, u32::MAX, monitor, &mut recovered.totals) {
                Ok(()) => return Ok(Recovered { ended: true, ..recovered }),
                Err(error @ ReplayError::Step { .. }) => return Err(error),
                Err(error) => (error, bytes.len().saturating_sub(reader.left())),
            },
        };
        match find_whole_snapshot::<A::Kind>(bytes, damaged.max(place.saturating_add(1))) {
            Some(next) => (place, recovered.gaps) = (next, recovered.gaps.saturating_add(1)),
            None if recovered.totals.scans > 0 => return Ok(recovered),
            None => return Err(error),
        }
    }
}
