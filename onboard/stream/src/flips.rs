//! A replay with bit flips in the filter's memory, and the countermeasures of a vehicle: the same on a board and on a host.

use crate::kind::Kind;
use crate::onboard::{Aboard, Filter, Refusal};
use crate::reader::Reader;
use crate::record::Record;
use crate::replay::{Monitor, ReplayError, start};
use scphd::diagnostics::{Scrubbed, Scrubber};
use scphd::errors::Flaw;
use scphd::numerics::Noise;

/// Number of scans before the first flip.
const WARM: u32 = 60;
/// Number of scans in a round.
const SCANS: u32 = 10;
/// Number of flips before every scan.
const FLIPS: u32 = 16;
/// Number of parts that are scrubbed after every scan.
const PARTS: usize = 8;
/// Seeds of the firmware image `flips`, for a mixture of few particles and for a joint map: two of 40 with which all types of
/// repair occur, including the restoration of a snapshot.
pub const FLIP_SEEDS: [u64; 2] = [5, 3];

/// A filter with simulated memory faults.
pub trait Failing<K: Kind>: Filter<K> {
    /// Flips one bit of its state.
    fn flip_bit(&mut self, draws: &mut Noise);

    /// Checks this number of parts of its state, and repairs them.
    ///
    /// # Errors
    /// The damage that cannot be repaired.
    fn scrub(&mut self, scrubber: &mut Scrubber, parts: usize) -> Result<Scrubbed, Flaw>;

    /// Writes a snapshot into `bytes`. Returns its length; `None` if the state is damaged or the capacity too small.
    fn save_into(&mut self, bytes: &mut [u8]) -> Option<usize>;

    /// Restores a snapshot.
    ///
    /// # Errors
    /// The bytes are not a snapshot of this filter.
    fn restore_from(&mut self, bytes: &[u8]) -> Result<(), Refusal>;
}

/// Results of ten scans with flips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Round {
    /// Index of the round, from 0.
    pub round: u32,
    /// Number of flips.
    pub flips: u32,
    /// Number of calls of `scrub` that found and repaired damage.
    pub mended: u32,
    /// Number of particles that they isolated.
    pub isolated: u32,
    /// Number of refused steps, scrubbings and snapshots, after each of which the last snapshot was restored.
    pub refused: u32,
    /// The longest scan, in the unit of the monitor's clock.
    pub worst: u64,
    /// Digest of the state after a complete scrubbing.
    pub digest: u64,
}

/// Replays the stream in `bytes`, with flips drawn from `seed`. From the 61st scan on, sixteen bits flip before every scan,
/// either before or after its predictions. Eight parts of the state are scrubbed after every scan, and the whole state after ten;
/// a snapshot in `room` follows. If scrubbing cannot repair the damage, or the filter refuses a step, the last snapshot is
/// restored and the predictions since then are repeated.
///
/// # Errors
/// The stream is damaged, the filter refuses a record before the first flip, or a snapshot cannot be used.
pub fn replay_with_flips<A>(
    bytes: &[u8],
    memory: &mut A::Memory,
    room: &mut [u8],
    seed: u64,
    clock: &mut impl Monitor,
    mut each: impl FnMut(&Round),
) -> Result<(), ReplayError>
where
    A: Aboard<f32>,
    for<'m> A::Filter<'m>: Failing<A::Kind>,
{
    let mut reader = Reader::<A::Kind>::open(bytes).map_err(ReplayError::Stream)?;
    let filter = start::<A, f32>(&reader, memory).map_err(ReplayError::Start)?;
    let (kept, draws) = (reader.clone(), Noise::seeded(seed));
    let mut run =
        Run { filter, draws, scrubber: Scrubber::new(), round: Round::default(), scans: 0, room, len: 0, kept };
    while run.scans < WARM {
        let Some(record) = reader.read().map_err(ReplayError::Stream)? else { return Ok(()) };
        run.scans += u32::from(matches!(record, Record::Scan(_)));
        run.step(&record).map_err(|refusal| run.failed(refusal))?;
    }
    if !run.save(&reader) {
        return Err(run.failed(Refusal::Unusable { why: "the state cannot be saved" }));
    }
    for round in 0..u32::MAX {
        run.round = Round { round, ..Round::default() };
        for _ in 0..SCANS {
            if !run.passage(&mut reader, clock)? {
                return Ok(());
            }
            run.scrub(PARTS, &reader)?;
        }
        run.scrub(usize::MAX, &reader)?;
        if !run.save(&reader) {
            run.go_back(&reader)?;
        }
        run.round.digest = run.filter.digest();
        each(&run.round);
    }
    Ok(())
}

/// A filter with flips, and its last snapshot.
struct Run<'b, 'a, F, K: Kind> {
    filter: F,
    draws: Noise,
    scrubber: Scrubber,
    round: Round,
    scans: u32,
    room: &'b mut [u8],
    /// Number of bytes of the snapshot.
    len: usize,
    /// The records after it.
    kept: Reader<'a, K>,
}

impl<'a, F: Failing<K>, K: Kind> Run<'_, 'a, F, K> {
    fn failed(&self, refusal: Refusal) -> ReplayError {
        ReplayError::Step { scan: self.scans, refusal }
    }

    fn step(&mut self, record: &Record<'a, K>) -> Result<(), Refusal> {
        match record {
            Record::Predict(input) => self.filter.predict(input),
            Record::Scan(measurements) => {
                let scan = self.filter.receive(measurements.clone());
                self.filter.scan(scan).map(|_| ())
            }
            other => self.filter.take(other),
        }
    }

    /// Flips bits, and processes the records up to and including the next scan. Returns whether there was one.
    fn passage(&mut self, reader: &mut Reader<'a, K>, clock: &mut impl Monitor) -> Result<bool, ReplayError> {
        let flips_first = self.draws.uniform::<f32>() < 0.5;
        if flips_first {
            self.flip();
        }
        while let Some(record) = reader.read().map_err(ReplayError::Stream)? {
            let is_scan = matches!(record, Record::Scan(_));
            if is_scan && !flips_first {
                self.flip();
            }
            clock.start();
            let done = self.step(&record);
            let elapsed = clock.elapsed();
            if done.is_err() {
                self.go_back(reader)?;
            }
            if is_scan {
                self.round.worst = self.round.worst.max(elapsed);
                self.scans = self.scans.saturating_add(1);
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn flip(&mut self) {
        for _ in 0..FLIPS {
            self.filter.flip_bit(&mut self.draws);
        }
        self.round.flips += FLIPS;
    }

    fn scrub(&mut self, parts: usize, now: &Reader<'a, K>) -> Result<(), ReplayError> {
        match self.filter.scrub(&mut self.scrubber, parts) {
            Ok(scrubbed) => {
                self.round.mended += u32::from(!scrubbed.is_clean());
                self.round.isolated += scrubbed.isolated as u32;
                Ok(())
            }
            Err(_) => self.go_back(now),
        }
    }

    /// Saves the present state. Returns whether it is valid.
    fn save(&mut self, now: &Reader<'a, K>) -> bool {
        let saved = self.filter.save_into(self.room);
        if let Some(len) = saved {
            (self.len, self.kept) = (len, now.clone());
        }
        saved.is_some()
    }

    /// Restores the snapshot, and repeats the predictions up to the present position of the stream.
    fn go_back(&mut self, now: &Reader<'a, K>) -> Result<(), ReplayError> {
        self.round.refused += 1;
        let snapshot = self.room.get(..self.len).unwrap_or(&[]);
        self.filter.restore_from(snapshot).map_err(|refusal| ReplayError::Step { scan: self.scans, refusal })?;
        let mut since = self.kept.clone();
        while since.left() > now.left() {
            match since.read().map_err(ReplayError::Stream)? {
                Some(Record::Predict(input)) => {
                    self.filter.predict(&input).map_err(|refusal| self.failed(refusal))?;
                }
                Some(_) => (),
                None => break,
            }
        }
        Ok(())
    }
}
