//! Finds messages in a stream of bytes.

use crate::bytes::Reader;
use crate::clock::TimeSync;
use crate::frame::{CHECK, FRAME, HEAD, MARK, Outgoing, SIGNATURE, check};
use crate::pose::Odometry;
use crate::satellite::Satellite;
use crate::target::Target;

/// A received message.
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

/// A received message and its sender.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Received {
    /// The system id.
    pub system: u8,
    /// The component id.
    pub component: u8,
    /// The message.
    pub message: Incoming,
}

/// Counts of a receiver. Every byte belongs to a counted frame, was skipped, or waits for the rest of its frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Report {
    /// Number of messages that were read.
    pub messages: u32,
    /// Number of frames with messages that are not supported here.
    pub others: u32,
    /// Number of messages in an unsupported frame of reference, without a position, or with a number that is not finite.
    pub unusable: u32,
    /// Number of frames with a wrong checksum: damaged, or other bytes.
    pub damaged: u32,
    /// Number of bytes that belong to no frame. This includes MAVLink 1; and, after skipped bytes, unsupported messages until the
    /// next supported one.
    pub skipped: u32,
}

/// Finds messages of MAVLink 2. Signatures are skipped, and not checked.
#[derive(Debug)]
pub struct Receiver {
    held: [u8; FRAME],
    len: usize,
    /// Whether the first stored byte is directly behind a frame.
    follows: bool,
    report: Report,
}

/// Classification of the stored bytes.
#[expect(clippy::large_enum_variant, reason = "there is no heap to put it on")]
enum Held {
    /// The beginning of a frame, or no bytes.
    Part,
    /// A frame with this number of bytes, and its message.
    Message(usize, Received),
    /// A frame with this number of bytes, whose message is not supported.
    Other(usize),
    /// A frame with this number of bytes, whose message cannot be used.
    Unusable(usize),
    /// The first byte does not begin a frame.
    None,
    /// A frame with a wrong checksum.
    Damaged,
}

impl Receiver {
    /// A receiver without any bytes.
    pub const fn new() -> Self {
        let report = Report { messages: 0, others: 0, unusable: 0, damaged: 0, skipped: 0 };
        Self { held: [0; FRAME], len: 0, follows: true, report }
    }

    /// Reads bytes until a message is complete; `None` when all are read.
    pub fn read(&mut self, bytes: &mut &[u8]) -> Option<Received> {
        loop {
            match self.parse() {
                Held::Part => {
                    let (&byte, rest) = bytes.split_first()?;
                    *bytes = rest;
                    // A frame is never longer than the buffer.
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

    /// The counts so far.
    pub fn report(&self) -> Report {
        self.report
    }

    /// Number of bytes that wait for the rest of their frame.
    pub fn waiting(&self) -> usize {
        self.len
    }

    fn parse(&self) -> Held {
        let held = self.held.get(..self.len).unwrap_or(&[]);
        let [mark, len, flags, ..] = *held else {
            return if held.first().is_some_and(|mark| *mark != MARK) { Held::None } else { Held::Part };
        };
        // A frame with an unknown flag cannot be read.
        if mark != MARK || flags > 1 {
            return Held::None;
        }
        let [_, _, _, _, _, system, component, n0, n1, n2, ..] = *held else { return Held::Part };
        let end = HEAD + usize::from(len);
        let whole = end + CHECK + if flags == 1 { SIGNATURE } else { 0 };
        let number = u32::from_le_bytes([n0, n1, n2, 0]);
        // The checksum of an unsupported message is unknown: the bytes count as a frame only directly behind another one.
        let Some((_, extra)) = KNOWN.into_iter().find(|(known, _)| *known == number) else {
            return if !self.follows {
                Held::None
            } else if held.len() < whole {
                Held::Part
            } else {
                Held::Other(whole)
            };
        };
        let (Some(covered), Some(&[.., c0, c1]), Some(payload)) =
            (held.get(1..end), held.get(..end + CHECK), held.get(HEAD..end))
        else {
            return Held::Part;
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

    /// Removes the first byte, and the following ones up to the next that may begin a frame.
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
/// The supported messages, each with the byte of its checksum that identifies its fields.
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
