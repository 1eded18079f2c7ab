//! A board with the sensors sends records to the computer of a vehicle, over a line that damages a frame: the computer uses the
//! other frames, and knows which are missing.

use scphd_link::{Gaps, Received, Receiver, Sender, line_bytes};
use scphd_stream::planar::{Odometry, Planar};
use scphd_stream::{Header, Piece, Piecewise, Record, Writer};
use std::cell::RefCell;
use std::convert::Infallible;

/// Maximum number of bytes of a record: 64 measurements in single precision, or the head.
const RECORD: usize = 2048;
const STEPS: usize = 20;

/// The line: on boards, two serial ports.
#[derive(Default)]
struct Line(Vec<u8>);

impl embedded_io::ErrorType for Line {
    type Error = Infallible;
}

impl embedded_io::Write for Line {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// The board with the sensors: sends every record of the writer in a frame.
fn sensors(line: &mut Line) -> Result<(), Box<dyn std::error::Error>> {
    let mut sender = Sender::<{ line_bytes(RECORD) }>::new(1);
    let made = RefCell::new(Vec::with_capacity(RECORD));
    let head = Header::<Planar>::EMPTY; // the models and the tuning of the vehicle
    let mut writer = Writer::start(&head, |piece: &[u8]| {
        made.borrow_mut().extend_from_slice(piece);
        Ok::<(), Infallible>(())
    })?;
    sender.open(line, &made.take(), None)?;
    for step in 0..STEPS {
        writer.predict(&Odometry { control: [1.5, 0.1, 0.0], dt_s: 0.05 })?;
        sender.record(line, &made.take(), None)?;
        writer.scan(&[[4.0 + step as f64, 0.25], [7.0, -0.5]])?;
        sender.record(line, &made.take(), None)?;
    }
    Ok(())
}

/// The computer of the vehicle: receives the inputs of the filter. Returns the numbers of predictions, measurements and missing
/// frames.
fn vehicle(mut line: &[u8]) -> Result<[usize; 3], Box<dyn std::error::Error>> {
    let mut receiver = Receiver::<{ RECORD + scphd_link::OVERHEAD }>::new(Gaps::Passed);
    let (mut stream, mut counts) = (None, [0; 3]);
    while let Some(received) = receiver.receive(&mut line)? {
        let Received::Frame { frame, lost } = received else { continue };
        counts[2] += lost as usize;
        let Some(stream) = &mut stream else {
            let (_header, opened) = Piecewise::open::<Planar>(frame.content)?;
            stream = Some(opened); // and a filter is made of the header
            continue;
        };
        match stream.read_behind_gap::<Planar>(frame.content)? {
            Piece::Record(Record::Predict(_odometry)) => counts[0] += 1, // slam.predict(...)
            Piece::Record(Record::Scan(measurements)) => counts[1] += measurements.len(), // slam.scan(...)
            _ => {}
        }
    }
    println!("{:?}", receiver.report());
    Ok(counts)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut line = Line::default();
    sensors(&mut line)?;
    let damaged = line.0.len() / 2;
    line.0[damaged] ^= 0x10;
    let [predictions, measurements, lost] = vehicle(&line.0)?;
    println!("{predictions} predictions, {measurements} measurements, {lost} frames lost");
    assert_eq!((predictions + measurements / 2, lost), (2 * STEPS - 1, 1));
    Ok(())
}

#[test]
fn one_frame_is_lost_and_reported() {
    main().expect("the example runs");
}
