//! A replay under which bits of the filter's memory flip, and what a vehicle does against it: the same on a board and on a desk.

use crate::kind::Kind;
use crate::onboard::{Aboard, Filter, Refusal};
use crate::reader::Reader;
use crate::record::Record;
use crate::replay::{Monitor, ReplayError, start};
use scphd::diagnostics::{Scrubbed, Scrubber};
use scphd::errors::Flaw;
use scphd::numerics::Noise;

/// Scans before the first bit flips.
const WARM: u32 = 60;
/// Scans of a round.
const SCANS: u32 = 10;
/// Bits that flip before every scan.
const FLIPS: u32 = 16;
/// Parts that are scrubbed after every scan.
const PARTS: usize = 8;
/// Seeds of the image `flips`, for a mixture of few particles and for a joint map: of 40 two with which every kind of repair comes about, going
/// back to a snapshot too.
pub const FLIP_SEEDS: [u64; 2] = [5, 3];

/// A filter whose memory can fail.
pub trait Failing<K: Kind>: Filter<K> {
    /// Flips one bit of its state.
    fn flip_bit(&mut self, draws: &mut Noise);

    /// Looks over so many parts of its state, and mends them.
    ///
    /// # Errors
    /// What cannot be mended.
    fn scrub(&mut self, scrubber: &mut Scrubber, parts: usize) -> Result<Scrubbed, Flaw>;

    /// Writes a snapshot into `bytes`; how long it is, and nothing where the state is damaged or there is no room.
    fn save_into(&mut self, bytes: &mut [u8]) -> Option<usize>;

    /// Goes on from a snapshot.
    ///
    /// # Errors
    /// It is none of this filter.
    fn restore_from(&mut self, bytes: &[u8]) -> Result<(), Refusal>;
}

/// What ten scans under flips have come to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Round {
    /// Place of the round, counted from 0.
    pub round: u32,
    /// Bits that have flipped.
    pub flips: u32,
    /// Scrubbings that have found something and mended it.
    pub mended: u32,
    /// Particles isolated by them.
    pub isolated: u32,
    /// Steps, scrubbings and snapshots that were refused, upon which the filter went back to the last snapshot.
    pub refused: u32,
    /// The longest scan, in whatever the monitor's clock counts.
    pub worst: u64,
    /// Hash of the state after all of it was scrubbed.
    pub digest: u64,
}

/// Replays the stream in `bytes`, with flips drawn from `seed`. From the 61st scan on sixteen bits flip before every scan, before its predictions or after them. Eight parts
/// of the state are scrubbed after every scan, and all of it after ten; a snapshot follows, in `room`. Where scrubbing cannot mend, or the
/// filter refuses, it goes back to the last snapshot, and over the predictions since.
///
/// # Errors
/// The stream is damaged, the filter refuses what comes before the first flip, or a snapshot cannot be used.
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

/// A filter under flips, and its last snapshot.
struct Run<'b, 'a, F, K: Kind> {
    filter: F,
    draws: Noise,
    scrubber: Scrubber,
    round: Round,
    scans: u32,
    room: &'b mut [u8],
    /// Bytes of the snapshot.
    len: usize,
    /// What comes after it.
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

    /// Bits that flip, the predictions up to a scan, and the scan; whether there was one.
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

    /// Keeps the state as it is now; whether it is sound.
    fn save(&mut self, now: &Reader<'a, K>) -> bool {
        let saved = self.filter.save_into(self.room);
        if let Some(len) = saved {
            (self.len, self.kept) = (len, now.clone());
        }
        saved.is_some()
    }

    /// Goes back to the snapshot, and from there over the predictions up to where the stream is now.
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
