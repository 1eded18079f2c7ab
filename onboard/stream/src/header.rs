//! The head of a stream: all parameters of a filter.

use crate::bytes::{Bytes, CHECK, CRC, Checked};
use crate::error::StreamError;
use crate::front::{Begins, FRONT, MAGIC, Mark, RETUNED, SNAPSHOT, VERSION};
use crate::kind::Kind;
use crate::numbers::Numbers;
use crate::scalar::Scalar;
use scphd::Real;
use scphd_vehicle::{Description, Filter, Invalid};

/// The value of a count that was unknown when the head was written, for example during the flight.
pub const UNKNOWN: u32 = u32::MAX;

/// The numbers of a description, in the order of the list of `scphd-vehicle`.
pub type Settings = [f64; Description::<f64>::NUMBERS];

/// All parameters of a filter: models, tuning and initial pose. All numbers are in double precision, for any payload: the filter
/// rounds them like settings from any other source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header<K: Kind> {
    /// The number type of the payload.
    pub scalar: Scalar,
    /// Whether the unexplained births of a mixture are delayed until the next scan.
    pub births_wait: bool,
    /// Number of scans in the stream, or [`UNKNOWN`].
    pub scans: u32,
    /// Number of predictions in the stream, or [`UNKNOWN`].
    pub predictions: u32,
    /// Maximum number of measurements in a scan, or [`UNKNOWN`].
    pub most_measurements: u32,
    /// Seed of the filter's random numbers.
    pub seed: u64,
    /// Purpose of this head.
    pub begins: Begins,
    /// The settings of the description.
    pub settings: Settings,
    /// Models that a description does not have.
    pub models: K::Models,
    /// Time between scans, s; the median if it varies.
    pub scan_interval_s: f64,
}

impl<K: Kind> Header<K> {
    /// Number of bytes of the head, including its checksum.
    pub const LENGTH: usize = FRONT + 8 * (Settings::COUNT + <K::Models as Numbers>::COUNT + f64::COUNT) + CHECK;

    /// A head with all numbers zero, and unknown counts.
    pub const EMPTY: Self = Self {
        scalar: Scalar::F64,
        births_wait: false,
        scans: UNKNOWN,
        predictions: UNKNOWN,
        most_measurements: UNKNOWN,
        seed: 0,
        begins: Begins::Start,
        settings: Settings::ZERO,
        models: <K::Models as Numbers>::ZERO,
        scan_interval_s: 0.0,
    };

    /// A head of zeros, which takes no flash.
    pub(crate) fn zero() -> Self {
        let (scans, predictions, most_measurements, seed, scan_interval_s) = (0, 0, 0, 0, 0.0);
        let (scalar, births_wait, begins) = (Scalar::F32, false, Begins::Start);
        let (settings, models) = (Settings::ZERO, <K::Models as Numbers>::ZERO);
        Self {
            scalar,
            births_wait,
            scans,
            predictions,
            most_measurements,
            seed,
            begins,
            settings,
            models,
            scan_interval_s,
        }
    }

    /// The head of a filter with these settings, and with numbers of this type in the records.
    #[must_use]
    pub fn with<T: Real>(description: &Description<T>, models: K::Models, scalar: Scalar) -> Self {
        let births_wait = matches!(description.filter, Filter::Mixture(config) if config.births_wait);
        let (settings, seed) = (description.numbers(), description.start.seed);
        Self { scalar, births_wait, settings, seed, models, ..Self::EMPTY }
    }

    /// The description of the filter, rounded to the numbers of the filter.
    ///
    /// # Errors
    /// A choice that the setting does not have.
    pub fn description<T: Real>(&self) -> Result<Description<T>, Invalid> {
        let mut description = Description::robot();
        self.describe(&mut description)?;
        Ok(description)
    }

    /// Changes the description of a robot to that of the filter, in place.
    pub(crate) fn describe<T: Real>(&self, description: &mut Description<T>) -> Result<(), Invalid> {
        description.take_numbers(&self.settings)?;
        description.start.seed = self.seed;
        if let Filter::Mixture(config) = &mut description.filter {
            config.births_wait = self.births_wait;
        }
        Ok(())
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
        sink.put(&[self.scalar.bytes() as u8, K::CODE, begins, u8::from(self.births_wait)]);
        for count in [self.scans, self.predictions, self.most_measurements] {
            sink.put(&count.to_le_bytes());
        }
        sink.put(&self.seed.to_le_bytes());
        sink.put(&mark.scans.to_le_bytes());
        sink.put(&mark.parts.to_le_bytes());
        sink.put(&mark.digest.to_le_bytes());
        sink.put(&before.to_le_bytes());
        let mut number = |number: f64| sink.put(&number.to_le_bytes());
        self.settings.put(&mut number);
        self.models.put(&mut number);
        self.scan_interval_s.put(&mut number);
        sink.end()
    }

    /// The number type of the records behind the head at the front of `bytes`, which is decoded completely and must be that of a
    /// start or a snapshot.
    pub(crate) fn scalar_of(bytes: &[u8]) -> Result<Scalar, StreamError> {
        let mut header = Self::zero();
        header.decode(&mut Bytes(bytes))?;
        if header.begins == Begins::Retuned { Err(StreamError::NoBeginning) } else { Ok(header.scalar) }
    }

    /// The head at the front of `bytes`, with its checksum.
    pub(crate) fn decoded(bytes: &mut Bytes<'_>) -> Result<(Self, u32), StreamError> {
        let mut header = Self::zero();
        let check = header.decode(bytes)?;
        Ok((header, check))
    }

    /// Becomes the head at the front of `bytes`. Returns its checksum. In place, because a head has more than a kilobyte, and a
    /// copy would lie on the stack. Not inlined, so that its code exists once.
    #[inline(never)]
    pub(crate) fn decode(&mut self, bytes: &mut Bytes<'_>) -> Result<u32, StreamError> {
        let whole = bytes.0;
        if bytes.array().ok_or(StreamError::Truncated)? != MAGIC {
            return Err(StreamError::NotAStream);
        }
        let version = bytes.u16().ok_or(StreamError::Truncated)?;
        if version != VERSION {
            return Err(StreamError::Version { found: version });
        }
        let length = usize::from(bytes.u16().ok_or(StreamError::Truncated)?);
        let choices: [u8; 4] = bytes.array().ok_or(StreamError::Truncated)?;
        // The length of the head depends on the vehicle.
        let [_, code, ..] = choices;
        if code != K::CODE {
            return Err(StreamError::Vehicle { found: code });
        }
        if length != Self::LENGTH {
            return Err(StreamError::Header);
        }
        let content = whole.get(..Self::LENGTH - CHECK).ok_or(StreamError::Truncated)?;
        let is_valid = self.read(choices, bytes).is_some();
        let check = bytes.u32().ok_or(StreamError::Truncated)?;
        if check != CRC.checksum(content) {
            return Err(StreamError::HeaderDamaged);
        }
        if is_valid { Ok(check) } else { Err(StreamError::Header) }
    }

    /// Decodes the fields behind the choices, with the meaning of the choices; reads all of them even if a choice is unknown.
    fn read(&mut self, choices: [u8; 4], bytes: &mut Bytes<'_>) -> Option<()> {
        for count in [&mut self.scans, &mut self.predictions, &mut self.most_measurements] {
            *count = bytes.u32()?;
        }
        self.seed = bytes.u64()?;
        let mark = Mark { scans: bytes.u32()?, parts: bytes.u32()?, digest: bytes.u64()? };
        // The checksum of the previous record is checked by the reader.
        bytes.u32()?;
        for setting in &mut self.settings {
            *setting = bytes.f64()?;
        }
        self.models = Numbers::take(&mut || bytes.f64())?;
        self.scan_interval_s = bytes.f64()?;
        let [scalar, _, begins, births_wait] = choices;
        self.begins = match begins {
            0 => Begins::Start,
            SNAPSHOT => Begins::Snapshot(mark),
            RETUNED => Begins::Retuned,
            _ => return None,
        };
        self.scalar = match scalar {
            4 => Scalar::F32,
            8 => Scalar::F64,
            _ => return None,
        };
        self.births_wait = match births_wait {
            0 => false,
            1 => true,
            _ => return None,
        };
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
            births_wait: true,
            scans: 1,
            predictions: 2,
            most_measurements: 3,
            seed: 0x0102_0304_0506_0708,
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
        assert_eq!(Header::decoded(&mut Bytes(&encoded(&header))).map(|(header, _)| header), Ok(header));
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
        assert_eq!(&bytes[..12], b"SCPHDLOG\x08\x00\x9c\x05");
        assert_eq!(bytes[12..20], [4, 0, 1, 1, 1, 0, 0, 0]);
        assert_eq!(bytes[28..36], [8, 7, 6, 5, 4, 3, 2, 1]);
        assert_eq!(bytes[36..56], [7, 0, 0, 0, 8, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 10, 0, 0, 0]);
        assert_eq!(bytes[56..64], 100.5_f64.to_le_bytes());
        assert_eq!(bytes[1424..1432], 271.5_f64.to_le_bytes());
        let head = Head::take::<Planar>(&mut Bytes(&bytes)).unwrap();
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
            assert!(Header::<Planar>::decoded(&mut Bytes(&bytes)).is_err(), "byte {place}");
            assert!(Header::<Planar>::decoded(&mut Bytes(&good[..place])).is_err(), "cut at {place}");
        }
    }

    #[test]
    fn other_versions_vehicles_and_files_are_distinguished() {
        let decoded = |bytes: &[u8]| Header::<Planar>::decoded(&mut Bytes(bytes)).map(drop);
        let mut bytes = encoded(&numbered::<Planar>());
        bytes[8] = 7;
        assert_eq!(decoded(&bytes), Err(StreamError::Version { found: 7 }));
        bytes[0] = b'X';
        assert_eq!(decoded(&bytes), Err(StreamError::NotAStream));
        assert_eq!(decoded(b"SCPHD"), Err(StreamError::Truncated));
        assert_eq!(decoded(&encoded(&numbered::<Underwater>())), Err(StreamError::Vehicle { found: 3 }));
        let error = Header::<Underwater>::decoded(&mut Bytes(&encoded(&numbered::<Planar>()))).map(drop);
        assert_eq!(error, Err(StreamError::Vehicle { found: 0 }));
    }
}
