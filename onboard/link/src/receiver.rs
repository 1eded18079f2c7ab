//! Takes frames out of what a line brings.

use crate::frame::{Frame, Token};
use crate::order::{Gaps, Order};
use crate::report::{Refused, Report};
use cobs::{DecodeResult, DecoderState};
use core::fmt;
use embedded_io::Read;

/// What stands between the last zero and here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Span {
    /// Nothing yet.
    Empty,
    /// The beginning of a frame.
    Open,
    /// A frame, up to its zero.
    Whole,
    /// More than there is room for.
    TooLong,
    /// A zero where the stuffing has none.
    Broken,
}

/// What came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Received<'a> {
    /// A frame whose turn it is, or one that asks.
    Frame {
        /// The frame.
        frame: Frame<'a>,
        /// How many numbers are missing before it.
        lost: u32,
    },
    /// One that is refused.
    Refused {
        /// Why.
        why: Refused,
        /// Whether an answer is wanted to it all the same; nobody knows of a damaged one.
        token: Option<Token>,
    },
}

/// Takes frames out of a line, in a buffer that holds one of at most `BYTES` bytes without its stuffing: its content and
/// [`OVERHEAD`](crate::OVERHEAD).
///
/// Every zero ends whatever stands before it, so that damage costs no more than the frames it hits. The work of a byte is bounded; that of
/// a frame's last byte is its check.
pub struct Receiver<const BYTES: usize> {
    buffer: [u8; BYTES],
    len: usize,
    stuffing: DecoderState,
    span: Span,
    order: Order,
    report: Report,
}

impl<const BYTES: usize> Receiver<BYTES> {
    /// A receiver that waits for a session to be opened.
    #[must_use]
    pub const fn new(gaps: Gaps) -> Self {
        Self::with(Order::new(gaps))
    }

    /// A receiver at the end that opens this session itself.
    #[must_use]
    pub const fn within(gaps: Gaps, session: u16) -> Self {
        Self::with(Order::within(gaps, session))
    }

    const fn with(order: Order) -> Self {
        let stuffing = DecoderState::Idle;
        Self { buffer: [0; BYTES], len: 0, stuffing, span: Span::Empty, order, report: Report::NONE }
    }

    /// What it has taken and refused.
    #[must_use]
    pub fn report(&self) -> Report {
        self.report
    }

    /// The number of the frame that was taken last in this session.
    #[must_use]
    pub fn last(&self) -> Option<u32> {
        self.order.last()
    }

    /// What it does with gaps.
    #[must_use]
    pub fn gaps(&self) -> Gaps {
        self.order.gaps
    }

    /// Waits for the next frame, whatever is wrong with it; `None` where the line ends. The line is read byte by byte: one whose reads
    /// are dear needs a buffer.
    ///
    /// # Errors
    /// Those of the line.
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

    /// Takes a byte of the line; what came, where it is the last one of it.
    pub fn take(&mut self, byte: u8) -> Option<Received<'_>> {
        if self.ends(byte) { Some(self.judge()) } else { None }
    }

    /// Takes a byte; whether it ends something.
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

    /// What stands before the zero that was just taken.
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
