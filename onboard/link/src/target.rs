//! The vehicle's side of a test bench.

use crate::answer::{Answer, Cost, Standing, Unit};
use crate::frame::{FrameKind, Token};
use crate::order::Gaps;
use crate::receiver::{Received, Receiver};
use crate::report::Refused;
use crate::sender::{SendError, Sender};
use embedded_io::{Read, Write};
use scphd::Real;
use scphd_stream::{Aboard, Filter, Header, Kind, Monitor, Piece, Piecewise, Record, ScanCost, StreamError};

/// Maximum number of bytes of an answer.
const ANSWER: usize = 256;

/// Passes the records from a line to a filter, and sends answers. The capacity for a record is `IN` bytes less
/// [`OVERHEAD`](crate::OVERHEAD); that for an answer on the line is `OUT` bytes.
///
/// It answers every frame with a token; if gaps are refused, also damaged frames, which may have had one. Inputs that the filter
/// refuses are counted and otherwise ignored, as on a vehicle.
#[derive(Debug)]
pub struct Target<const IN: usize, const OUT: usize> {
    receiver: Receiver<IN>,
    sender: Sender<OUT>,
}

/// The filter, and the state of its stream.
struct Session<K: Kind, F> {
    filter: Option<F>,
    reader: Option<Piecewise>,
    answer: Answer<K>,
    cost: ScanCost,
}

/// A session that the other side has opened: the stream if its head can be read, and the token if an answer is requested.
struct Opened<K: Kind> {
    stream: Option<(Header<K>, Piecewise)>,
    token: Option<Token>,
}

impl<const IN: usize, const OUT: usize> Target<IN, OUT> {
    /// A target with this treatment of gaps.
    #[must_use]
    pub const fn new(gaps: Gaps) -> Self {
        Self { receiver: Receiver::new(gaps), sender: Sender::new(0) }
    }

    /// Serves all sessions that the other side opens, one after the other, until the line ends.
    ///
    /// The monitor measures the time in this unit, and is called after every scan, as in a replay; it is not asked whether to
    /// continue after a refused input.
    ///
    /// # Errors
    /// The errors of the line.
    pub fn serve<A: Aboard<T>, T: Real, L: Read + Write>(
        &mut self,
        line: &mut L,
        memory: &mut A::Memory,
        unit: Unit,
        monitor: &mut impl Monitor,
    ) -> Result<(), SendError<<L as embedded_io::ErrorType>::Error>> {
        const {
            assert!(Answer::<A::Kind>::LENGTH <= ANSWER);
            assert!(crate::line_bytes(Answer::<A::Kind>::LENGTH) <= OUT, "an answer does not fit `OUT`");
        }
        let Some(mut opened) = self.wait::<A::Kind, L>(line)? else { return Ok(()) };
        // Each session is a new run of the filter in the same memory.
        while let Some(next) = self.session::<A, T, L>(line, memory, unit, monitor, opened)? {
            opened = next;
        }
        Ok(())
    }

    /// Waits for a session; `None` if the line ends.
    fn wait<K: Kind, L: Read + Write>(
        &mut self,
        line: &mut L,
    ) -> Result<Option<Opened<K>>, SendError<<L as embedded_io::ErrorType>::Error>> {
        loop {
            match self.receiver.receive(line).map_err(SendError::Line)? {
                None => return Ok(None),
                Some(Received::Frame { frame, .. }) if frame.kind == FrameKind::Head => {
                    self.sender.begin(frame.session);
                    let stream = Piecewise::open(frame.content).ok();
                    return Ok(Some(Opened { stream, token: frame.token }));
                }
                Some(_) => {}
            }
        }
    }

    /// Serves one session, until the next one is opened.
    fn session<A: Aboard<T>, T: Real, L: Read + Write>(
        &mut self,
        line: &mut L,
        memory: &mut A::Memory,
        unit: Unit,
        monitor: &mut impl Monitor,
        opened: Opened<A::Kind>,
    ) -> Result<Option<Opened<A::Kind>>, SendError<<L as embedded_io::ErrorType>::Error>> {
        let (header, reader) = opened.stream.unzip();
        let filter = header.and_then(|header| A::start(&header, memory).ok());
        let standing = if filter.is_some() { Standing::Running } else { Standing::NotSetUp };
        let mut answer = Answer::none(standing, unit);
        if let Some(filter) = &filter {
            answer.digest = filter.digest();
            (answer.pose, answer.covariance) = filter.estimate_pose();
        }
        let mut session = Session { filter, reader, answer, cost: NO_COST };
        let gaps = self.receiver.gaps();
        if opened.token.is_some() {
            self.answer(line, &mut session.answer, opened.token)?;
        }
        loop {
            let (token, is_wanted) = match self.receiver.receive(line).map_err(SendError::Line)? {
                None => return Ok(None),
                Some(Received::Frame { frame, .. }) => match frame.kind {
                    FrameKind::Head => {
                        self.sender.begin(frame.session);
                        let stream = Piecewise::open(frame.content).ok();
                        return Ok(Some(Opened { stream, token: frame.token }));
                    }
                    FrameKind::Record => {
                        session.take(frame.content, gaps, monitor);
                        (frame.token, frame.token.is_some())
                    }
                    FrameKind::Ask => (frame.token, true),
                    FrameKind::Answer => (None, false),
                },
                // Frames of other sessions are not answered.
                Some(Received::Refused { why: Refused::Foreign, .. }) => (None, false),
                Some(Received::Refused { why: Refused::Damaged | Refused::TooLong, .. }) => {
                    (None, gaps == Gaps::Refused)
                }
                Some(Received::Refused { token, .. }) => (token, token.is_some()),
            };
            if is_wanted {
                self.answer(line, &mut session.answer, token)?;
            }
        }
    }

    fn answer<K: Kind, L: Write>(
        &mut self,
        line: &mut L,
        answer: &mut Answer<K>,
        token: Option<Token>,
    ) -> Result<(), SendError<L::Error>> {
        answer.accepted = self.receiver.last().unwrap_or(0);
        answer.report = self.receiver.report();
        let mut bytes = [0; ANSWER];
        let bytes = bytes.get_mut(..Answer::<K>::LENGTH).and_then(|room| answer.encode(room)).unwrap_or(&[]);
        self.sender.answer(line, bytes, token)
    }
}

/// The cost before the first prediction.
const NO_COST: ScanCost =
    ScanCost { scan: 0, measurements: 0, predictions: 0, predict: 0, predict_worst: 0, update: 0, estimate: 0 };

impl<K: Kind, F: Filter<K>> Session<K, F> {
    /// Passes a record to the filter.
    fn take(&mut self, bytes: &[u8], gaps: Gaps, monitor: &mut impl Monitor) {
        let (Some(filter), Some(reader)) = (&mut self.filter, &mut self.reader) else { return };
        let piece: Result<Piece<'_, K>, StreamError> = match gaps {
            Gaps::Refused => reader.read(bytes),
            Gaps::Passed => reader.read_behind_gap(bytes),
        };
        let answer = &mut self.answer;
        let is_taken = match piece {
            Ok(Piece::End) => {
                answer.standing = Standing::Ended;
                true
            }
            // Snapshots are for readers that begin there.
            Ok(Piece::Slice) => true,
            Ok(Piece::Record(Record::Head(head))) if head.mark().is_some() => true,
            Ok(Piece::Record(Record::Predict(input))) => {
                monitor.start();
                let moved = filter.predict(&input);
                let elapsed = monitor.elapsed();
                let cost = &mut self.cost;
                cost.predictions = cost.predictions.saturating_add(1);
                cost.predict = cost.predict.saturating_add(elapsed);
                cost.predict_worst = cost.predict_worst.max(elapsed);
                moved.is_ok()
            }
            Ok(Piece::Record(Record::Scan(measurements))) => {
                let scan = filter.receive(measurements);
                let cost = &mut self.cost;
                cost.measurements = scan.measurements() as u32;
                monitor.start();
                let seen = filter.scan_with(scan, &mut monitor.probe());
                cost.update = monitor.elapsed();
                monitor.start();
                let (_, features) = filter.estimate();
                (answer.pose, answer.covariance) = filter.estimate_pose();
                cost.estimate = monitor.elapsed();
                answer.digest = filter.digest();
                answer.features = features as u32;
                answer.scans = answer.scans.saturating_add(1);
                let short = |cost: u64| u32::try_from(cost).unwrap_or(u32::MAX);
                let [predict, update, estimate] = [cost.predict, cost.update, cost.estimate].map(short);
                answer.cost = Cost { predict, update, estimate };
                if let Ok(seen) = &seen {
                    answer.health = seen.health;
                    monitor.scanned(cost, seen, answer.digest);
                }
                *cost = ScanCost { scan: cost.scan.saturating_add(1), ..NO_COST };
                seen.is_ok()
            }
            Ok(Piece::Record(record)) => filter.take(&record).is_ok(),
            Err(_) => false,
        };
        answer.refused = answer.refused.saturating_add(u32::from(!is_taken));
    }
}
