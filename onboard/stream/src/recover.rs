//! The loop over what is left of a black box.

use crate::find::find_whole_snapshot;
use crate::reader::Reader;
use crate::replay::{Monitor, ReplayError, Totals, run};
use crate::{Aboard, Kind};
use scphd::Real;

/// What was replayed of a black box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recovered<K: Kind> {
    /// Scans that were replayed, with the pose and the features after the last.
    pub totals: Totals<K>,
    /// How often the replay had to go on from the next snapshot, or to begin with one because the beginning is not there.
    pub gaps: u32,
    /// Whether the stream ends, and is not cut off.
    pub ended: bool,
}

/// Replays what can be replayed of the stream in `bytes`: where its beginning is torn off from the first whole snapshot on, and where
/// something in it is damaged or missing up to there, and then from the next whole snapshot on.
///
/// # Errors
/// There is nothing that a replay can begin with, or the filter refuses something that the monitor does not go on without.
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
