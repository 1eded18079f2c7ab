//! Writes a stream, on the desk or in flight.

use crate::bytes::CRC;
use crate::reader::{END, PREDICT, SCAN};
use crate::{Header, Scalar};

/// Writes a stream piece by piece into whatever takes bytes: a file, a flash chip, a link.
///
/// ```
/// use scphd_stream::{Header, Reader, Record, Writer};
///
/// let mut log = Vec::new();
/// let mut writer = Writer::start(&Header::EMPTY, |bytes: &[u8]| Ok::<(), ()>(log.extend_from_slice(bytes)))?;
/// writer.predict([1.0, 0.1], 0.05)?;
/// writer.scan(&[[4.0, 0.5]])?;
/// writer.end()?;
/// let mut reader = Reader::open(&log).unwrap();
/// assert!(matches!(reader.read(), Ok(Some(Record::Predict { control: [1.0, 0.1], dt_s: 0.05 }))));
/// # Ok::<(), ()>(())
/// ```
#[derive(Debug)]
pub struct Writer<F> {
    sink: F,
    scalar: Scalar,
}

impl<E, F: FnMut(&[u8]) -> Result<(), E>> Writer<F> {
    /// Writes the head.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn start(header: &Header, mut sink: F) -> Result<Self, E> {
        sink(&header.encode())?;
        Ok(Self { sink, scalar: header.scalar })
    }

    /// Records a prediction: speed (m/s), steering angle (rad) or turn rate (rad/s), and their duration, s.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn predict(&mut self, control: [f64; 2], dt_s: f64) -> Result<(), E> {
        let [first, second] = control;
        self.record(PREDICT, 1, [first, second, dt_s])
    }

    /// Records a scan: range (m) and bearing (rad) of every measurement. Measurements beyond the 65535th are left out.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn scan(&mut self, measurements: &[[f64; 2]]) -> Result<(), E> {
        let count = u16::try_from(measurements.len()).unwrap_or(u16::MAX);
        self.record(SCAN, count, measurements.iter().take(usize::from(count)).copied().flatten())
    }

    /// Marks the end; without it a reader takes the stream for cut off.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn end(mut self) -> Result<(), E> {
        self.record(END, 0, [])
    }

    fn record(&mut self, kind: u8, count: u16, numbers: impl IntoIterator<Item = f64>) -> Result<(), E> {
        let Self { sink, scalar } = self;
        let mut check = CRC.digest();
        let mut put = |bytes: &[u8]| {
            check.update(bytes);
            sink(bytes)
        };
        let [low, high] = count.to_le_bytes();
        put(&[kind, 0, low, high])?;
        for number in numbers {
            match scalar {
                Scalar::F32 => put(&(number as f32).to_le_bytes())?,
                Scalar::F64 => put(&number.to_le_bytes())?,
            }
        }
        sink(&check.finalize().to_le_bytes())
    }
}
