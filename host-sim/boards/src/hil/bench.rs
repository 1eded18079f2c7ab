//! Sends a stream, waits for the answer to every scan, and sends again what was lost.

use super::line::Line;
use super::trouble::{Rates, Trouble};
use scphd_link::{Answer, FrameKind, Gaps, Received, Receiver, Report, SendError, Sender, Standing, Token, line_bytes};
use scphd_stream::{Kind, pieces};
use std::io;
use std::ops::RangeInclusive;
use std::time::{Duration, Instant};
use thiserror::Error;

/// Bytes of a record, at most: a map of a hundred features.
const RECORD: usize = 8192;
/// Bytes of an answer's frame, at most.
const ANSWER: usize = 512;

/// How long and how often.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Until it asks whether something was lost.
    pub answer_within: Duration,
    /// Times that it asks or sends again for one scan, at most.
    pub repeats: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self { answer_within: Duration::from_secs(1), repeats: 100 }
    }
}

/// A scan that the target has answered.
#[derive(Debug, Clone, Copy)]
pub struct Scanned<K: Kind> {
    /// Its place, counted from 0.
    pub scan: usize,
    /// What the target says.
    pub answer: Answer<K>,
    /// From the frame of the scan, sent for the first time, to the answer.
    pub round_trip: Duration,
    /// Times that it was asked for or sent again.
    pub repeats: u32,
}

/// How all of it went.
#[derive(Debug, Clone, Copy)]
pub struct Outcome<K: Kind> {
    /// The last answer, to the end of the stream.
    pub last: Answer<K>,
    /// Frames that were sent.
    pub frames: u32,
    /// Of them, records sent again, and frames that ask.
    pub repeats: u32,
    /// What this end has taken and refused of the answers.
    pub answers: Report,
}

/// Why a stream did not come to its end.
#[derive(Debug, Error)]
pub enum HilError {
    /// The line.
    #[error("the line to the target: {0}")]
    Line(#[from] io::Error),
    /// Nothing came, or not what was asked for.
    #[error("no answer from the target to frame {number} after {repeats} repeats")]
    NoAnswer {
        /// The frame.
        number: u32,
        /// How often it was asked.
        repeats: u32,
    },
    /// The filter of the target.
    #[error(
        "the target cannot set its filter up as the stream says: too little room, another version or another kind of vehicle"
    )]
    NotSetUp,
    /// A record.
    #[error("record {number} is too long for a frame")]
    TooLong {
        /// The record.
        number: u32,
    },
    /// The stream.
    #[error("the stream is damaged or has no end")]
    Stream,
}

/// What is answered, and the answer.
type Answered<K> = (Option<Token>, Answer<K>);

/// The host's end of a bench.
pub struct Bench {
    line: Line,
    limits: Limits,
    sender: Sender<{ line_bytes(RECORD) }>,
    receiver: Receiver<ANSWER>,
    token: Token,
    there: Trouble,
    back: Trouble,
    /// Of an answer, what has come.
    coming: Vec<u8>,
    /// What the bad line has let through, the next byte last.
    arrived: Vec<u8>,
    frames: u32,
    repeats: u32,
}

impl Bench {
    /// A bench at this line, made worse at these rates; the session is to be another one each time.
    #[must_use]
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

    /// Sends a stream to its end; every scan that is answered is handed on.
    ///
    /// # Errors
    /// The target does not answer, or cannot set up such a filter.
    pub fn run<K: Kind>(&mut self, stream: &[u8], mut on: impl FnMut(&Scanned<K>)) -> Result<Outcome<K>, HilError> {
        let pieces: Vec<&[u8]> = pieces::<K>(stream).collect();
        let begun = self.deliver::<K>(&pieces, 0..=0)?;
        if begun.answer.standing == Standing::NotSetUp {
            return Err(HilError::NotSetUp);
        }
        let (mut first, mut scans) = (1, 0);
        while first < pieces.len() {
            // All up to the next scan, or to the end.
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
                // All that was sent before this token has arrived or never will.
                Some((Some(token), answer)) if token == self.token => Some(answer.accepted as usize + 1),
                // Late, from something that was asked before.
                Some((Some(_), _)) => continue,
                // Something that arrived was damaged; or nothing comes.
                Some((None, _)) | None => None,
            };
            repeats += 1;
            if repeats > self.limits.repeats {
                return Err(HilError::NoAnswer { number, repeats: self.limits.repeats });
            }
            match missing {
                Some(first) => drop(self.send(pieces, first.min(last)..=last)?),
                // Nobody answers before a session is open.
                None if last == 0 => drop(self.send(pieces, 0..=0)?),
                None => self.ask()?,
            }
            until = Instant::now() + self.limits.answer_within;
        }
    }

    /// Sends records, the last of them with a token; when that was.
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

    /// Puts a frame on the line, or what the line makes of it.
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

    /// The next answer, and what to; `None` where none comes in time.
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
            // A frame has a zero on either side.
            if byte == 0 && self.coming.len() > 1 {
                let (coming, arrived) = (std::mem::take(&mut self.coming), &mut self.arrived);
                self.back.pass(&coming, |bytes| drop(arrived.splice(0..0, bytes.iter().rev().copied())));
            }
        }
    }
}

/// Kinds of record, the first byte of each.
const SCAN: u8 = 2;
const END: u8 = 3;

fn of_send(error: SendError<std::convert::Infallible>, number: u32) -> HilError {
    match error {
        SendError::Line(never) => match never {},
        _ => HilError::TooLong { number },
    }
}

/// A frame on its way to the line.
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
