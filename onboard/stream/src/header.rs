//! The decoded head of a stream.

use crate::bytes::{CHECK, Checked};
use crate::front::{Begins, FRONT, MAGIC, Mark, RETUNED, SNAPSHOT, VERSION};
use crate::kind::Kind;
use crate::numbers::Numbers;
use crate::scalar::Scalar;
use scphd::Real;
use scphd_vehicle::{Description, Invalid};

/// The value of a count that was unknown when the head was written, for example during the flight.
pub const UNKNOWN: u32 = u32::MAX;

/// The numbers of a description, in the order of the list of `scphd-vehicle`.
pub type Settings = [f64; Description::<f64>::NUMBERS];

/// The parameters of a filter: a head, decoded or not.
pub trait Parameters<K: Kind> {
    /// Changes the description of a robot to that of the filter, rounded to its numbers. In place, because a description has more
    /// than half a kilobyte.
    ///
    /// # Errors
    /// The first setting whose number is not the index of one of its choices.
    fn describe<T: Real>(&self, description: &mut Description<T>) -> Result<(), Invalid>;

    /// The models that a description does not have.
    fn models(&self) -> K::Models;
}

/// The decoded head: models, tuning and initial pose. All numbers are in double precision, whatever the type in the records: the
/// filter rounds them like settings from any other source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header<K: Kind> {
    /// The number type of the records.
    pub scalar: Scalar,
    /// Number of scans in the stream, or [`UNKNOWN`].
    pub scans: u32,
    /// Number of predictions in the stream, or [`UNKNOWN`].
    pub predictions: u32,
    /// Maximum number of measurements in a scan, or [`UNKNOWN`].
    pub most_measurements: u32,
    /// Purpose of this head.
    pub begins: Begins,
    /// The settings of the description.
    pub settings: Settings,
    /// Models that a description does not have.
    pub models: K::Models,
    /// Time between scans, s; the median if it varies.
    pub scan_interval_s: f64,
}

impl<K: Kind> Parameters<K> for Header<K> {
    fn describe<T: Real>(&self, description: &mut Description<T>) -> Result<(), Invalid> {
        description.take_numbers(self.settings)
    }

    fn models(&self) -> K::Models {
        self.models
    }
}

impl<K: Kind> Header<K> {
    /// Number of bytes of the head, including its checksum.
    pub const LENGTH: usize = FRONT + 8 * (Settings::COUNT + <K::Models as Numbers>::COUNT + f64::COUNT) + CHECK;

    /// A head with all numbers zero, and unknown counts.
    pub const EMPTY: Self = Self {
        scalar: Scalar::F64,
        scans: UNKNOWN,
        predictions: UNKNOWN,
        most_measurements: UNKNOWN,
        begins: Begins::Start,
        settings: Settings::ZERO,
        models: <K::Models as Numbers>::ZERO,
        scan_interval_s: 0.0,
    };

    /// The head of a filter with these settings, and with numbers of this type in the records.
    #[must_use]
    pub fn with<T: Real>(description: &Description<T>, models: K::Models, scalar: Scalar) -> Self {
        Self { scalar, settings: description.numbers(), models, ..Self::EMPTY }
    }

    /// The description of the filter, rounded to the numbers of the filter.
    ///
    /// # Errors
    /// The first setting whose number is not the index of one of its choices.
    pub fn description<T: Real>(&self) -> Result<Description<T>, Invalid> {
        let mut description = Description::robot();
        self.describe(&mut description)?;
        Ok(description)
    }

    /// Writes the head behind a record with this checksum, 0 for none. Returns the checksum of the head.
    pub(crate) fn write<E>(&self, before: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<u32, E> {
        let mut sink = Checked::new(sink);
        sink.put(&MAGIC);
        sink.put(&VERSION.to_le_bytes());
        sink.put(&(Self::LENGTH as u16).to_le_bytes());
        let (begins, mark) = match self.begins {
            Begins::Start => (0, Mark::NONE),
            Begins::Snapshot(mark) => (SNAPSHOT, mark),
            Begins::Retuned => (RETUNED, Mark::NONE),
        };
        sink.put(&[self.scalar.bytes() as u8, K::CODE]);
        sink.put(&begins.to_le_bytes());
        for count in [self.scans, self.predictions, self.most_measurements, mark.scans, mark.parts] {
            sink.put(&count.to_le_bytes());
        }
        sink.put(&mark.digest.to_le_bytes());
        sink.put(&before.to_le_bytes());
        let mut number = |number: f64| sink.put(&number.to_le_bytes());
        self.settings.put(&mut number);
        self.models.put(&mut number);
        self.scan_interval_s.put(&mut number);
        sink.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::Bytes;
    use crate::error::StreamError;
    use crate::head::Head;
    use crate::planar::Planar;
    use crate::underwater::Underwater;
    use std::vec::Vec;

    /// A head in which all numbers differ.
    fn numbered<K: Kind>() -> Header<K> {
        let mut next = 99.5;
        let mut number = || {
            next += 1.0;
            Some(next)
        };
        Header {
            scalar: Scalar::F32,
            scans: 1,
            predictions: 2,
            most_measurements: 3,
            begins: Begins::Snapshot(Mark { scans: 7, parts: 8, digest: 9 }),
            settings: Numbers::take(&mut number).unwrap(),
            models: Numbers::take(&mut number).unwrap(),
            scan_interval_s: number().unwrap(),
        }
    }

    fn encoded<K: Kind>(header: &Header<K>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let Ok(check) = header.write(10, |piece: &[u8]| {
            bytes.extend_from_slice(piece);
            Ok::<(), core::convert::Infallible>(())
        });
        assert!(bytes.ends_with(&check.to_le_bytes()));
        bytes
    }

    fn comes_back<K: Kind>(header: Header<K>) {
        assert_eq!(Head::take(&mut Bytes(&encoded(&header))).map(|head| head.decode()), Ok(header));
    }

    #[test]
    fn a_written_head_is_read() {
        comes_back(numbered::<Planar>());
        comes_back(numbered::<Underwater>());
    }

    /// The positions of the documented layout.
    #[test]
    fn the_layout_is_the_documented_one() {
        let bytes = encoded(&numbered::<Planar>());
        assert_eq!(bytes.len(), 1436);
        assert_eq!(&bytes[..12], b"SCPHDLOG\x09\x00\x9c\x05");
        assert_eq!(bytes[12..20], [4, 0, 1, 0, 1, 0, 0, 0]);
        assert_eq!(bytes[28..48], [7, 0, 0, 0, 8, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 10, 0, 0, 0]);
        assert_eq!(bytes[48..56], 100.5_f64.to_le_bytes());
        assert_eq!(bytes[1424..1432], 272.5_f64.to_le_bytes());
        let head = Head::<Planar>::take(&mut Bytes(&bytes)).unwrap();
        assert_eq!((head.before, head.mark()), (10, Some(Mark { scans: 7, parts: 8, digest: 9 })));
        let bytes = encoded(&numbered::<Underwater>());
        assert_eq!(bytes.len(), 1436 + 8 * 55);
        assert_eq!(bytes[12..14], [4, 3]);
    }

    #[test]
    fn all_damage_to_the_head_is_detected() {
        let good = encoded(&numbered::<Planar>());
        for place in 0..good.len() {
            let mut bytes = good.clone();
            bytes[place] ^= 0x10;
            assert!(Head::<Planar>::take(&mut Bytes(&bytes)).is_err(), "byte {place}");
            assert!(Head::<Planar>::take(&mut Bytes(&good[..place])).is_err(), "cut at {place}");
        }
    }

    #[test]
    fn other_versions_vehicles_and_files_are_distinguished() {
        let decoded = |bytes: &[u8]| Head::<Planar>::take(&mut Bytes(bytes)).map(drop);
        let mut bytes = encoded(&numbered::<Planar>());
        bytes[8] = 8;
        assert_eq!(decoded(&bytes), Err(StreamError::Version { found: 8 }));
        bytes[0] = b'X';
        assert_eq!(decoded(&bytes), Err(StreamError::NotAStream));
        assert_eq!(decoded(b"SCPHD"), Err(StreamError::Truncated));
        assert_eq!(decoded(&encoded(&numbered::<Underwater>())), Err(StreamError::Vehicle { found: 3 }));
        let error = Head::<Underwater>::take(&mut Bytes(&encoded(&numbered::<Planar>()))).map(drop);
        assert_eq!(error, Err(StreamError::Vehicle { found: 0 }));
    }
}
