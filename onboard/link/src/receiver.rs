//! Receives frames from a line.

use crate::frame::{Frame, Token};
use crate::order::{Gaps, Order};
use crate::report::{Refused, Report};
use cobs::{DecodeResult, DecoderState};
use core::fmt;
use embedded_io::Read;

/// State of the bytes since the last zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Span {
    /// No bytes.
    Empty,
    /// The beginning of a frame.
    Open,
    /// A frame, complete up to its zero.
    Whole,
    /// More bytes than the buffer has room for.
    TooLong,
    /// A zero at a wrong position of the byte stuffing.
    Broken,
}

/// A received frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Received<'a> {
    /// The next frame in order, or a request.
    Frame {
        /// The frame.
        frame: Frame<'a>,
        /// Number of frames missing before it.
        lost: u32,
    },
    /// A refused frame.
    Refused {
        /// The reason.
        why: Refused,
        /// The token if an answer is requested; unknown for a damaged frame.
        token: Option<Token>,
    },
}

/// Receives frames from a line, in a buffer for one frame of at most `BYTES` bytes without byte stuffing: its content and
/// [`OVERHEAD`](crate::OVERHEAD).
///
/// Every zero ends a frame, so that damage affects only the frames in which it is. The work for a byte is bounded; for the last
/// byte of a frame it includes the checksum.
pub struct Receiver<const BYTES: usize> {
    buffer: [u8; BYTES],
    len: usize,
    stuffing: DecoderState,
    span: Span,
    order: Order,
    report: Report,
}

impl<const BYTES: usize> Receiver<BYTES> {
    /// A receiver that waits for a session to be opened by the other side.
    #[must_use]
    pub const fn new(gaps: Gaps) -> Self {
        Self::with(Order::new(gaps))
    }

    /// A receiver for a session that this side opens.
    #[must_use]
    pub const fn within(gaps: Gaps, session: u16) -> Self {
        Self::with(Order::within(gaps, session))
    }

    const fn with(order: Order) -> Self {
        let stuffing = DecoderState::Idle;
        Self { buffer: [0; BYTES], len: 0, stuffing, span: Span::Empty, order, report: Report::NONE }
    }

    /// The counts of accepted and refused frames.
    #[must_use]
    pub fn report(&self) -> Report {
        self.report
    }

    /// The number of the last accepted frame of this session.
    #[must_use]
    pub fn last(&self) -> Option<u32> {
        self.order.last()
    }

    /// Its treatment of gaps.
    #[must_use]
    pub fn gaps(&self) -> Gaps {
        self.order.gaps
    }

    /// Waits for the next frame, valid or not; `None` if the line ends. The line is read byte by byte: a line with expensive
    /// reads needs a buffer.
    ///
    /// # Errors
    /// The errors of the line.
    pub fn receive<L: Read>(&mut self, line: &mut L) -> Result<Option<Received<'_>>, L::Error> {
        loop {
            let mut byte = [0];
            if line.read(&mut byte)? == 0 {
                return Ok(None);
            }
            let [byte] = byte;
            if self.ends(byte) {
                return Ok(Some(self.judge()));
            }
        }
    }

    /// Adds a byte. Returns the frame that it completes, if any.
    pub fn take(&mut self, byte: u8) -> Option<Received<'_>> {
        if self.ends(byte) { Some(self.judge()) } else { None }
    }

    /// Adds a byte. Returns whether it ends a frame.
    fn ends(&mut self, byte: u8) -> bool {
        match self.stuffing.feed(byte) {
            Ok(DecodeResult::NoData) => {}
            Ok(DecodeResult::DataStart) => (self.len, self.span) = (0, Span::Open),
            Ok(DecodeResult::DataContinue(content)) => match self.buffer.get_mut(self.len) {
                Some(slot) => {
                    *slot = content;
                    self.len += 1;
                }
                None => self.span = Span::TooLong,
            },
            Ok(DecodeResult::DataComplete) => {
                if self.span == Span::Open {
                    self.span = Span::Whole;
                }
            }
            Err(_) => self.span = Span::Broken,
        }
        byte == 0 && self.span != Span::Empty
    }

    /// The frame before the zero that was just added.
    fn judge(&mut self) -> Received<'_> {
        let span = core::mem::replace(&mut self.span, Span::Empty);
        let bytes = self.buffer.get(..self.len).unwrap_or(&[]);
        let (token, judged) = match span {
            Span::Whole => match Frame::decode(bytes) {
                Ok(frame) => (frame.token, self.order.take(&frame).map(|lost| (frame, lost))),
                Err(why) => (None, Err(why)),
            },
            Span::TooLong => (None, Err(Refused::TooLong)),
            Span::Empty | Span::Open | Span::Broken => (None, Err(Refused::Damaged)),
        };
        match judged {
            Ok((frame, lost)) => {
                if frame.kind != crate::FrameKind::Ask {
                    self.report.accepted = self.report.accepted.saturating_add(1);
                }
                self.report.lost = self.report.lost.saturating_add(lost);
                Received::Frame { frame, lost }
            }
            Err(why) => {
                self.report.count(why);
                Received::Refused { why, token }
            }
        }
    }
}

impl<const BYTES: usize> fmt::Debug for Receiver<BYTES> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { len, span, order, report, .. } = self;
        f.debug_struct("Receiver")
            .field("len", len)
            .field("span", span)
            .field("order", order)
            .field("report", report)
            .finish_non_exhaustive()
    }
}
