//! Reads a stream record by record.

use crate::bytes::Bytes;
use crate::error::StreamError;
use crate::head::Head;
use crate::header::Header;
use crate::kind::Kind;
use crate::record::{END, Raw, Record, Records, SLICE};
use crate::scalar::Scalar;

/// Reads a stream whose records arrive one by one, over a link or from a queue. Stores no bytes of previous records.
///
/// ```
/// use scphd_stream::planar::{Odometry, Planar};
/// use scphd_stream::{Header, Piece, Piecewise, Record, Writer, pieces};
///
/// let mut log = Vec::new();
/// let mut writer = Writer::start(&Header::<Planar>::EMPTY, |bytes: &[u8]| Ok::<(), ()>(log.extend_from_slice(bytes)))?;
/// writer.predict(&Odometry { control: [1.0, 0.1, 0.0], dt_s: 0.05 })?;
/// writer.end()?;
/// let mut pieces = pieces::<Planar>(&log);
/// let (_, mut reader) = Piecewise::open::<Planar>(pieces.next().unwrap()).unwrap();
/// assert!(matches!(reader.read::<Planar>(pieces.next().unwrap()), Ok(Piece::Record(Record::Predict(_)))));
/// assert!(matches!(reader.read::<Planar>(pieces.next().unwrap()), Ok(Piece::End)));
/// assert_eq!(pieces.next(), None);
/// # Ok::<(), ()>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Piecewise {
    scalar: Scalar,
    /// The checksum of the last record or head.
    check: u32,
    /// Number of records read.
    index: u32,
}

/// A record, or another part of a stream.
#[derive(Debug, Clone)]
pub enum Piece<'a, K: Kind> {
    /// A record.
    Record(Record<'a, K>),
    /// A slice of a snapshot.
    Slice,
    /// The end of the stream.
    End,
}

impl Piecewise {
    /// Reads the head at the beginning of a stream.
    ///
    /// # Errors
    /// The bytes are not a head, or one that this code cannot read.
    pub fn open<K: Kind>(head: &[u8]) -> Result<(Header<K>, Self), StreamError> {
        let head = Head::take(&mut Bytes(head))?;
        Ok((head.decode(), Self { scalar: head.scalar, check: head.check, index: 0 }))
    }

    /// Reads the record after the last one.
    ///
    /// # Errors
    /// The record is incomplete, damaged or unknown, or a record before it is missing. The reader stays before it.
    pub fn read<'a, K: Kind>(&mut self, bytes: &'a [u8]) -> Result<Piece<'a, K>, StreamError> {
        self.read_behind(bytes, Some(self.check))
    }

    /// Reads a record, before which records may be missing. Damage is not detected: the caller must have checked the bytes.
    ///
    /// # Errors
    /// The record is incomplete or unknown.
    pub fn read_behind_gap<'a, K: Kind>(&mut self, bytes: &'a [u8]) -> Result<Piece<'a, K>, StreamError> {
        self.read_behind(bytes, None)
    }

    fn read_behind<'a, K: Kind>(&mut self, bytes: &'a [u8], before: Option<u32>) -> Result<Piece<'a, K>, StreamError> {
        let mut at = Records::behind(self.check, self.scalar, Bytes(bytes));
        at.index = self.index;
        let (raw, rest) = at.next_behind::<K>(before)?;
        if !rest.rest.0.is_empty() {
            return Err(StreamError::Record { index: self.index });
        }
        let piece = match raw {
            Raw::Record { kind: END, .. } => Piece::End,
            Raw::Record { kind: SLICE, .. } => Piece::Slice,
            _ => Piece::Record(at.meaning(raw)?),
        };
        (self.check, self.index) = (rest.check, rest.index);
        Ok(piece)
    }
}

/// The pieces of a stream: its head, every record, and its end. Stops before the first that cannot be read.
pub fn pieces<K: Kind>(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut behind = Bytes(bytes);
    let head = Head::<K>::take(&mut behind).ok();
    let mut rest = head.map(|head| Records::behind(head.check, head.scalar, behind));
    head.and_then(|_| bytes.get(..Header::<K>::LENGTH)).into_iter().chain(core::iter::from_fn(move || {
        let records = rest.take()?;
        let (raw, behind) = records.next::<K>().ok()?;
        let piece = records.rest.0.get(..records.rest.0.len() - behind.rest.0.len());
        rest = (!matches!(raw, Raw::Record { kind: END, .. })).then_some(behind);
        piece
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::{Odometry, Planar};
    use crate::{Part, Writer};
    use std::vec::Vec;

    const MOVED: Odometry = Odometry { control: [1.5, -0.25, 0.0], dt_s: 0.5 };

    fn stream() -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = Writer::start(&Header::<Planar>::EMPTY, |piece: &[u8]| {
            bytes.extend_from_slice(piece);
            Ok::<(), ()>(())
        })
        .unwrap();
        writer.predict(&MOVED).unwrap();
        writer.scan(&[[3.0, 0.5]]).unwrap();
        writer.snapshot(&[Part::Filter], 7).unwrap();
        writer.slice(Part::Filter, b"state").unwrap();
        writer.end().unwrap();
        bytes.extend([0xff; 9]);
        bytes
    }

    #[test]
    fn pieces_are_the_stream_cut_into_records() {
        let bytes = stream();
        let pieces: Vec<&[u8]> = pieces::<Planar>(&bytes).collect();
        assert_eq!(pieces.len(), 6);
        assert_eq!(pieces.concat(), bytes[..bytes.len() - 9]);
    }

    #[test]
    fn other_bytes_have_no_pieces() {
        assert_eq!(pieces::<Planar>(b"SCPHDLOG").count(), 0);
        let bytes = stream();
        // The head and the prediction are complete.
        assert_eq!(pieces::<Planar>(&bytes[..Header::<Planar>::LENGTH + 40]).count(), 2);
    }

    #[test]
    fn a_record_out_of_order_is_refused_unless_gaps_are_allowed() {
        let bytes = stream();
        let pieces: Vec<&[u8]> = pieces::<Planar>(&bytes).collect();
        let (_, mut reader) = Piecewise::open::<Planar>(pieces[0]).unwrap();
        let damaged = StreamError::RecordDamaged { index: 0 };
        assert_eq!(reader.read::<Planar>(pieces[2]).unwrap_err(), damaged);
        assert_eq!(reader.read::<Planar>(pieces[3]).unwrap_err(), damaged);
        let scan = reader.clone().read_behind_gap::<Planar>(pieces[2]).unwrap();
        assert!(matches!(scan, Piece::Record(Record::Scan(measurements)) if measurements.len() == 1));
        let read: Vec<Piece<'_, Planar>> = pieces[1..].iter().map(|piece| reader.read(piece).unwrap()).collect();
        let [Piece::Record(first), Piece::Record(_), Piece::Record(Record::Head(_)), Piece::Slice, Piece::End] =
            &read[..]
        else {
            panic!("{read:?}");
        };
        assert!(matches!(first, Record::Predict(moved) if *moved == MOVED));
    }

    #[test]
    fn a_record_with_bytes_behind_it_is_refused() {
        let bytes = stream();
        let pieces: Vec<&[u8]> = pieces::<Planar>(&bytes).collect();
        let (_, mut reader) = Piecewise::open::<Planar>(pieces[0]).unwrap();
        let two = [pieces[1], pieces[2]].concat();
        assert_eq!(reader.read::<Planar>(&two).unwrap_err(), StreamError::Record { index: 0 });
        assert!(reader.read::<Planar>(pieces[1]).is_ok());
    }
}
