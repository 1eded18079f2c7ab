//! Sends records in frames.

use crate::frame::{Frame, FrameKind, Token};
use core::fmt;
use embedded_io::Write;

/// Errors of sending a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SendError<E> {
    /// The record is too long for the sender's buffer.
    #[error("the record is longer than a frame of the link")]
    TooLong,
    /// All frame numbers of the session are used.
    #[error("all frame numbers of the session are used")]
    SessionFull,
    /// An error of the line.
    #[error("{0}")]
    Line(E),
}

/// Sends the frames of a session, each encoded in a buffer of `BYTES` bytes: [`line_bytes`](crate::line_bytes) of the longest
/// record.
pub struct Sender<const BYTES: usize> {
    buffer: [u8; BYTES],
    session: u16,
    /// The number of the next frame.
    next: u32,
}

impl<const BYTES: usize> Sender<BYTES> {
    /// A sender for this session, whose number must differ from that of the previous session.
    #[must_use]
    pub const fn new(session: u16) -> Self {
        Self { buffer: [0; BYTES], session, next: 0 }
    }

    /// Begins another session.
    pub(crate) fn begin(&mut self, session: u16) {
        (self.session, self.next) = (session, 0);
    }

    /// Opens the session with the head of the stream.
    ///
    /// # Errors
    /// The head is too long, or an error of the line.
    pub fn open<L: Write>(
        &mut self,
        line: &mut L,
        head: &[u8],
        token: Option<Token>,
    ) -> Result<(), SendError<L::Error>> {
        self.begin(self.session);
        self.numbered(line, FrameKind::Head, head, token)
    }

    /// Sends the next record.
    ///
    /// # Errors
    /// The record is too long, all numbers of the session are used, or an error of the line.
    pub fn record<L: Write>(
        &mut self,
        line: &mut L,
        record: &[u8],
        token: Option<Token>,
    ) -> Result<(), SendError<L::Error>> {
        self.numbered(line, FrameKind::Record, record, token)
    }

    /// Sends a record or the head again, with its number in the session.
    ///
    /// # Errors
    /// As for [`record`](Self::record).
    pub fn again<L: Write>(
        &mut self,
        line: &mut L,
        number: u32,
        record: &[u8],
        token: Option<Token>,
    ) -> Result<(), SendError<L::Error>> {
        let kind = if number == 0 { FrameKind::Head } else { FrameKind::Record };
        self.put(line, kind, number, record, token)
    }

    /// Requests an answer.
    ///
    /// # Errors
    /// An error of the line.
    pub fn ask<L: Write>(&mut self, line: &mut L, token: Token) -> Result<(), SendError<L::Error>> {
        self.put(line, FrameKind::Ask, 0, &[], Some(token))
    }

    /// Sends the next answer.
    pub(crate) fn answer<L: Write>(
        &mut self,
        line: &mut L,
        answer: &[u8],
        token: Option<Token>,
    ) -> Result<(), SendError<L::Error>> {
        self.numbered(line, FrameKind::Answer, answer, token)
    }

    fn numbered<L: Write>(
        &mut self,
        line: &mut L,
        kind: FrameKind,
        content: &[u8],
        token: Option<Token>,
    ) -> Result<(), SendError<L::Error>> {
        let number = self.next;
        let next = number.checked_add(1).ok_or(SendError::SessionFull)?;
        self.put(line, kind, number, content, token)?;
        self.next = next;
        Ok(())
    }

    fn put<L: Write>(
        &mut self,
        line: &mut L,
        kind: FrameKind,
        number: u32,
        content: &[u8],
        token: Option<Token>,
    ) -> Result<(), SendError<L::Error>> {
        let frame = Frame { kind, session: self.session, number, token, content };
        let bytes = frame.encode(&mut self.buffer).ok_or(SendError::TooLong)?;
        write_all(line, bytes).and_then(|()| line.flush()).map_err(SendError::Line)
    }
}

/// Writes all bytes. The line's own `write_all` panics if the line accepts nothing; here the rest of the frame is then lost.
fn write_all<L: Write>(line: &mut L, mut bytes: &[u8]) -> Result<(), L::Error> {
    while !bytes.is_empty() {
        let taken = line.write(bytes)?;
        if taken == 0 {
            break;
        }
        bytes = bytes.get(taken..).unwrap_or(&[]);
    }
    Ok(())
}

impl<const BYTES: usize> fmt::Debug for Sender<BYTES> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { session, next, .. } = self;
        f.debug_struct("Sender").field("session", session).field("next", next).finish_non_exhaustive()
    }
}
