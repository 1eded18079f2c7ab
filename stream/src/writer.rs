//! Writes a stream, on the desk or in flight.

use crate::bytes::Checked;
use crate::kind::{Input, Kind};
use crate::numbers::Numbers;
use crate::reader::{END, PREDICT, SCAN};
use crate::{Header, Scalar};
use core::marker::PhantomData;

/// Writes a stream piece by piece into whatever takes bytes: a file, a flash chip, a link.
///
/// ```
/// use scphd_stream::planar::{Odometry, Planar};
/// use scphd_stream::{Header, Reader, Record, Writer};
///
/// let mut log = Vec::new();
/// let head = Header::<Planar>::EMPTY;
/// let mut writer = Writer::start(&head, |bytes: &[u8]| Ok::<(), ()>(log.extend_from_slice(bytes)))?;
/// let moved = Odometry { control: [1.0, 0.1], dt_s: 0.05 };
/// writer.predict(&moved)?;
/// writer.scan(&[[4.0, 0.5]])?;
/// writer.end()?;
/// let mut reader = Reader::<Planar>::open(&log).unwrap();
/// assert!(matches!(reader.read(), Ok(Some(Record::Predict(input))) if input == moved));
/// # Ok::<(), ()>(())
/// ```
#[derive(Debug)]
pub struct Writer<K, F> {
    sink: F,
    scalar: Scalar,
    kind: PhantomData<K>,
}

impl<K: Kind, E, F: FnMut(&[u8]) -> Result<(), E>> Writer<K, F> {
    /// Writes the head.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn start(header: &Header<K>, mut sink: F) -> Result<Self, E> {
        header.write(&mut sink)?;
        Ok(Self { sink, scalar: header.scalar, kind: PhantomData })
    }

    /// Records a prediction.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn predict(&mut self, input: &K::Input) -> Result<(), E> {
        self.record([PREDICT, input.parts()], 1, K::Input::scalar(self.scalar), |mut number| input.put(&mut number))
    }

    /// Records a scan. Measurements beyond the 65535th are left out.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn scan(&mut self, measurements: &[K::Measurement]) -> Result<(), E> {
        let count = u16::try_from(measurements.len()).unwrap_or(u16::MAX);
        let kept = measurements.iter().take(usize::from(count));
        self.record([SCAN, 0], count, self.scalar, |mut number| {
            kept.for_each(|measurement| measurement.put(&mut number))
        })
    }

    /// Marks the end; without it a reader takes the stream for cut off.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn end(mut self) -> Result<(), E> {
        self.record([END, 0], 0, self.scalar, |_| ())
    }

    fn record(
        &mut self,
        kind: [u8; 2],
        count: u16,
        scalar: Scalar,
        numbers: impl FnOnce(&mut dyn FnMut(f64)),
    ) -> Result<(), E> {
        let mut record = Checked::new(&mut self.sink);
        record.put(&kind);
        record.put(&count.to_le_bytes());
        numbers(&mut |number| match scalar {
            Scalar::F32 => record.put(&(number as f32).to_le_bytes()),
            Scalar::F64 => record.put(&number.to_le_bytes()),
        });
        record.end()
    }
}
