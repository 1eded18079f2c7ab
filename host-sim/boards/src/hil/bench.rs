//! Sends a stream, waits for the answer to every scan, and repeats lost records.

use super::line::Line;
use super::trouble::{Rates, Trouble};
use scphd_link::{Answer, FrameKind, Gaps, Received, Receiver, Report, SendError, Sender, Standing, Token, line_bytes};
use scphd_stream::{Kind, pieces};
use std::io;
use std::ops::RangeInclusive;
use std::time::{Duration, Instant};
use thiserror::Error;

/// Greatest size of a record, bytes: a map of a hundred features.
const RECORD: usize = 8192;
/// Greatest size of an answer's frame, bytes.
const ANSWER: usize = 512;

/// Timeout and number of repetitions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Time after which the host asks whether something was lost.
    pub answer_within: Duration,
    /// Greatest number of queries and repetitions for a scan.
    pub repeats: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self { answer_within: Duration::from_secs(1), repeats: 100 }
    }
}

/// A scan with the answer of the target.
#[derive(Debug, Clone, Copy)]
pub struct Scanned<K: Kind> {
    /// Its index.
    pub scan: usize,
    pub answer: Answer<K>,
    /// Time from the first transmission of the scan's frame to the answer.
    pub round_trip: Duration,
    /// Number of queries and repetitions.
    pub repeats: u32,
}

#[derive(Debug, Clone, Copy)]
pub struct Outcome<K: Kind> {
    /// The last answer, to the end of the stream.
    pub last: Answer<K>,
    pub frames: u32,
    /// Number of repeated records and of queries among them.
    pub repeats: u32,
    /// Numbers of accepted and rejected answers at this end.
    pub answers: Report,
}

/// Why a stream was not sent to its end.
#[derive(Debug, Error)]
pub enum HilError {
    #[error("the line to the target: {0}")]
    Line(#[from] io::Error),
    /// There is no answer, or a wrong one.
    #[error("no answer from the target to frame {number} after {repeats} repeats")]
    NoAnswer { number: u32, repeats: u32 },
    #[error(
        "the target cannot set its filter up as the stream says: too little room, another filter, another version or another kind of vehicle"
    )]
    NotSetUp,
    /// A record is too long.
    #[error("record {number} is too long for a frame")]
    TooLong { number: u32 },
    /// The stream is invalid.
    #[error("the stream is damaged or has no end")]
    Stream,
}

/// The token of a request, and its answer.
type Answered<K> = (Option<Token>, Answer<K>);

/// The host's end of the link to a target.
pub struct Bench {
    line: Line,
    limits: Limits,
    sender: Sender<{ line_bytes(RECORD) }>,
    receiver: Receiver<ANSWER>,
    token: Token,
    there: Trouble,
    back: Trouble,
    /// The received part of an answer.
    coming: Vec<u8>,
    /// The bytes from the line after simulated faults, the next byte last.
    arrived: Vec<u8>,
    frames: u32,
    repeats: u32,
}

impl Bench {
    /// A bench at this line, with simulated faults at these rates; the session number must be different each time.
    pub fn new(line: Line, session: u16, limits: Limits, rates: Rates, seed: u64) -> Self {
        Self {
            line,
            limits,
            sender: Sender::new(session),
            receiver: Receiver::within(Gaps::Passed, session),
            token: Token::MIN,
            there: Trouble::new(rates, seed),
            back: Trouble::new(rates, seed ^ 1 << 63),
            coming: Vec::new(),
            arrived: Vec::new(),
            frames: 0,
            repeats: 0,
        }
    }

    /// Sends a stream to its end; `on` is called for every answered scan.
    pub fn run<K: Kind>(&mut self, stream: &[u8], mut on: impl FnMut(&Scanned<K>)) -> Result<Outcome<K>, HilError> {
        let pieces: Vec<&[u8]> = pieces::<K>(stream).collect();
        let begun = self.deliver::<K>(&pieces, 0..=0)?;
        if begun.answer.standing == Standing::NotSetUp {
            return Err(HilError::NotSetUp);
        }
        let (mut first, mut scans) = (1, 0);
        while first < pieces.len() {
            // All records up to the next scan, or to the end.
            let is_last = |piece: &&[u8]| matches!(piece.first(), Some(&SCAN | &END));
            let last = first + pieces[first..].iter().position(is_last).ok_or(HilError::Stream)?;
            let delivered = self.deliver::<K>(&pieces, first..=last)?;
            if pieces[last].first() == Some(&END) {
                let (frames, repeats, answers) = (self.frames, self.repeats, self.receiver.report());
                return Ok(Outcome { last: delivered.answer, frames, repeats, answers });
            }
            on(&Scanned { scan: scans, ..delivered });
            scans += 1;
            first = last + 1;
        }
        Err(HilError::Stream)
    }

    /// Sends records until the last of them is accepted.
    fn deliver<K: Kind>(&mut self, pieces: &[&[u8]], numbers: RangeInclusive<usize>) -> Result<Scanned<K>, HilError> {
        let last = *numbers.end();
        let number = u32::try_from(last).map_err(|_| HilError::Stream)?;
        let begun = self.send(pieces, numbers)?;
        let (mut repeats, mut until) = (0, Instant::now() + self.limits.answer_within);
        loop {
            let answered = self.answer::<K>(until)?;
            let missing = match answered {
                Some((_, answer)) if answer.accepted == number => {
                    self.repeats += repeats;
                    return Ok(Scanned { scan: 0, answer, round_trip: begun.elapsed(), repeats });
                }
                // Everything sent before this token has arrived or was lost.
                Some((Some(token), answer)) if token == self.token => Some(answer.accepted as usize + 1),
                // A late answer to an earlier request.
                Some((Some(_), _)) => continue,
                // A damaged record arrived, or no answer.
                Some((None, _)) | None => None,
            };
            repeats += 1;
            if repeats > self.limits.repeats {
                return Err(HilError::NoAnswer { number, repeats: self.limits.repeats });
            }
            match missing {
                Some(first) => drop(self.send(pieces, first.min(last)..=last)?),
                // There are no answers before a session is open.
                None if last == 0 => drop(self.send(pieces, 0..=0)?),
                None => self.ask()?,
            }
            until = Instant::now() + self.limits.answer_within;
        }
    }

    /// Sends records, the last of them with a token. Returns the time of its transmission.
    fn send(&mut self, pieces: &[&[u8]], numbers: RangeInclusive<usize>) -> Result<Instant, HilError> {
        let last = *numbers.end();
        let mut begun = Instant::now();
        for place in numbers {
            let token = (place == last).then(|| self.next_token());
            let number = u32::try_from(place).map_err(|_| HilError::Stream)?;
            let mut frame = Frame::default();
            self.sender.again(&mut frame, number, pieces[place], token).map_err(|error| of_send(error, number))?;
            begun = Instant::now();
            self.put(&frame.0)?;
        }
        Ok(begun)
    }

    fn ask(&mut self) -> Result<(), HilError> {
        let (token, mut frame) = (self.next_token(), Frame::default());
        self.sender.ask(&mut frame, token).map_err(|error| of_send(error, 0))?;
        self.put(&frame.0)
    }

    fn next_token(&mut self) -> Token {
        self.token = self.token.checked_add(1).unwrap_or(Token::MIN);
        self.token
    }

    /// Sends a frame, with simulated faults.
    fn put(&mut self, frame: &[u8]) -> Result<(), HilError> {
        self.frames += 1;
        let mut sent = Ok(());
        let line = &mut self.line;
        self.there.pass(frame, |bytes| {
            if sent.is_ok() {
                sent = line.send(bytes);
            }
        });
        Ok(sent?)
    }

    /// The next answer with its token; `None` if none arrives in time.
    fn answer<K: Kind>(&mut self, until: Instant) -> Result<Option<Answered<K>>, HilError> {
        loop {
            while let Some(byte) = self.arrived.pop() {
                if let Some(Received::Frame { frame, .. }) = self.receiver.take(byte)
                    && frame.kind == FrameKind::Answer
                    && let Some(answer) = Answer::decode(frame.content)
                {
                    return Ok(Some((frame.token, answer)));
                }
            }
            let Some(byte) = self.line.byte(until)? else { return Ok(None) };
            self.coming.push(byte);
            // Frames are delimited by zeros.
            if byte == 0 && self.coming.len() > 1 {
                let (coming, arrived) = (std::mem::take(&mut self.coming), &mut self.arrived);
                self.back.pass(&coming, |bytes| drop(arrived.splice(0..0, bytes.iter().rev().copied())));
            }
        }
    }
}

/// Types of records, which are their first bytes.
const SCAN: u8 = 2;
const END: u8 = 3;

fn of_send(error: SendError<std::convert::Infallible>, number: u32) -> HilError {
    match error {
        SendError::Line(never) => match never {},
        _ => HilError::TooLong { number },
    }
}

/// A frame to be sent.
#[derive(Default)]
struct Frame(Vec<u8>);

impl embedded_io::ErrorType for Frame {
    type Error = std::convert::Infallible;
}

impl embedded_io::Write for Frame {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}

impl std::fmt::Debug for Bench {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bench").field("limits", &self.limits).field("frames", &self.frames).finish_non_exhaustive()
    }
}
