//! Messages in bytes as they come.

use crate::bytes::Reader;
use crate::clock::TimeSync;
use crate::frame::{CHECK, FRAME, HEAD, MARK, Outgoing, SIGNATURE, check};
use crate::pose::Odometry;
use crate::satellite::Satellite;
use crate::target::Target;

/// A message that has come.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
#[expect(clippy::large_enum_variant, reason = "there is no heap to put it on")]
pub enum Incoming {
    /// ODOMETRY.
    Odometry(Odometry),
    /// LANDING_TARGET.
    Target(Target),
    /// GPS_RAW_INT.
    Satellite(Satellite),
    /// TIMESYNC.
    TimeSync(TimeSync),
}

/// A message and who sent it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Received {
    /// The vehicle's number.
    pub system: u8,
    /// The component's number.
    pub component: u8,
    /// What it says.
    pub message: Incoming,
}

/// What has come so far. Every byte is of a frame that was counted, or skipped, or still waits for the rest of its frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Report {
    /// Messages that were read.
    pub messages: u32,
    /// Frames of messages that are not read here.
    pub others: u32,
    /// Messages in a frame of reference that is none of ours, without a position, or with a number where there can be none.
    pub unusable: u32,
    /// Frames whose check was wrong: damaged, or no frames at all.
    pub damaged: u32,
    /// Bytes of no frame. Those of MAVLink 1 are among them, and messages that are not read here until one after them is.
    pub skipped: u32,
}

/// Finds messages of MAVLink 2. Signatures are passed over, and not checked.
#[derive(Debug)]
pub struct Receiver {
    held: [u8; FRAME],
    len: usize,
    /// Whether the first byte held comes right after a frame.
    follows: bool,
    report: Report,
}

/// What the bytes are that are held.
#[expect(clippy::large_enum_variant, reason = "there is no heap to put it on")]
enum Held {
    /// The begin of a frame, or nothing.
    Part,
    /// A frame of so many bytes, and what it says.
    Message(usize, Received),
    /// A frame of so many bytes that says nothing to us.
    Other(usize),
    Unusable(usize),
    /// The first byte is not the begin of a frame.
    None,
    Damaged,
}

impl Receiver {
    /// A receiver that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        let report = Report { messages: 0, others: 0, unusable: 0, damaged: 0, skipped: 0 };
        Self { held: [0; FRAME], len: 0, follows: true, report }
    }

    /// Takes bytes until a message is whole; `None` where they are all taken.
    pub fn read(&mut self, bytes: &mut &[u8]) -> Option<Received> {
        loop {
            match self.look() {
                Held::Part => {
                    let (&byte, rest) = bytes.split_first()?;
                    *bytes = rest;
                    // A frame is never longer than the room for it.
                    if let Some(slot) = self.held.get_mut(self.len) {
                        *slot = byte;
                        self.len += 1;
                    }
                }
                Held::Message(len, received) => {
                    self.drop(len);
                    count(&mut self.report.messages, 1);
                    return Some(received);
                }
                Held::Other(len) => {
                    self.drop(len);
                    count(&mut self.report.others, 1);
                }
                Held::Unusable(len) => {
                    self.drop(len);
                    count(&mut self.report.unusable, 1);
                }
                Held::None => self.skip(),
                Held::Damaged => {
                    count(&mut self.report.damaged, 1);
                    self.skip();
                }
            }
        }
    }

    /// What has come so far.
    #[must_use]
    pub fn report(&self) -> Report {
        self.report
    }

    /// Bytes that wait for the rest of their frame.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.len
    }

    fn look(&self) -> Held {
        let held = self.held.get(..self.len).unwrap_or(&[]);
        let [mark, len, flags, ..] = *held else {
            return if held.first().is_some_and(|mark| *mark != MARK) { Held::None } else { Held::Part };
        };
        // A flag that is not known stands for a frame that cannot be read.
        if mark != MARK || flags > 1 {
            return Held::None;
        }
        let end = HEAD + usize::from(len);
        let whole = end + CHECK + if flags == 1 { SIGNATURE } else { 0 };
        let (Some(covered), Some(&[.., c0, c1]), Some(payload)) =
            (held.get(1..end), held.get(..end + CHECK), held.get(HEAD..end))
        else {
            return Held::Part;
        };
        let [_, _, _, _, system, component, n0, n1, n2, ..] = *covered else { return Held::None };
        let number = u32::from_le_bytes([n0, n1, n2, 0]);
        // The check of a message that is not known here cannot be made: it may be a frame where one is due, and nowhere else.
        let Some((_, extra)) = KNOWN.into_iter().find(|(known, _)| *known == number) else {
            return if !self.follows {
                Held::None
            } else if held.len() < whole {
                Held::Part
            } else {
                Held::Other(whole)
            };
        };
        if check(covered, extra) != u16::from_le_bytes([c0, c1]) {
            return Held::Damaged;
        }
        if held.len() < whole {
            return Held::Part;
        }
        let payload = Reader(payload);
        let message = match number {
            Odometry::NUMBER => Odometry::read(payload).map(Incoming::Odometry),
            TARGET => Target::read(payload).map(Incoming::Target),
            SATELLITE => Satellite::read(payload).map(Incoming::Satellite),
            _ => Some(Incoming::TimeSync(TimeSync::read(payload))),
        };
        message.map_or(Held::Unusable(whole), |message| Held::Message(whole, Received { system, component, message }))
    }

    fn drop(&mut self, bytes: usize) {
        self.follows = true;
        if let Some(held) = self.held.get_mut(..self.len) {
            held.copy_within(bytes.min(held.len()).., 0);
        }
        self.len = self.len.saturating_sub(bytes);
    }

    /// Leaves out the first byte, and what follows up to where a frame may begin.
    fn skip(&mut self) {
        let held = self.held.get(..self.len).unwrap_or(&[]);
        let next = held.iter().skip(1).position(|byte| *byte == MARK).map_or(self.len, |at| at + 1);
        self.drop(next);
        self.follows = false;
        count(&mut self.report.skipped, next as u32);
    }
}

const TARGET: u32 = 149;
const SATELLITE: u32 = 24;
/// The messages that are read, each with the byte of its check that stands for its fields.
const KNOWN: [(u32, u8); 4] =
    [(Odometry::NUMBER, Odometry::EXTRA), (TARGET, 200), (SATELLITE, 24), (TimeSync::NUMBER, TimeSync::EXTRA)];

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}

fn count(counter: &mut u32, by: u32) {
    *counter = counter.saturating_add(by);
}
