//! Reads a stream record by record.

use crate::bytes::Bytes;
use crate::error::StreamError;
use crate::front::Begins;
use crate::head::Head;
use crate::header::Header;
use crate::kind::Kind;
use crate::record::{Both, END, Raw, Record, Records, SLICE};
use crate::snapshot::Snapshot;
use scphd_vehicle::Setting;

/// The place of the setting of the filter, whose second choice is the joint map.
const FILTER: usize = Setting::FILTER.place();

/// Reads a stream that is completely in memory.
#[derive(Debug, Clone)]
pub struct Reader<'a, K: Kind> {
    pub(crate) head: Head<'a, K>,
    first: Records<'a>,
    rest: Records<'a>,
}

impl<'a, K: Kind> Reader<'a, K> {
    /// Decodes and checks the head. Bytes behind the last record are ignored, so that `bytes` may be a memory region into which a
    /// stream was loaded.
    ///
    /// # Errors
    /// The bytes do not begin with the head of a stream that this code can read.
    pub fn open(bytes: &'a [u8]) -> Result<Self, StreamError> {
        let mut rest = Bytes(bytes);
        let head = Head::<K>::take(&mut rest)?;
        if head.begins == Begins::Retuned {
            return Err(StreamError::NoBeginning);
        }
        let first = Records::behind(head.check, head.scalar, rest);
        Ok(Self { head, rest: first.clone(), first })
    }

    /// The head.
    #[must_use]
    pub fn header(&self) -> Header<K> {
        self.head.decode()
    }

    /// Whether its filter is a joint map.
    #[must_use]
    pub fn is_of_joint_map(&self) -> bool {
        self.head.numbers().nth(FILTER) == Some(1.0)
    }

    /// The snapshot at the beginning of the stream, if any.
    #[must_use]
    pub fn snapshot(&self) -> Option<Snapshot<'a, K>> {
        self.head.mark().map(|mark| Snapshot::behind(mark, self.first.clone()))
    }

    /// Number of bytes from the next record on.
    #[must_use]
    pub fn left(&self) -> usize {
        self.rest.rest.0.len()
    }

    /// The next record; `None` after the last. The slices of snapshots are skipped.
    ///
    /// # Errors
    /// The record is incomplete, damaged or unknown, or a record before it is missing. The reader stays before it.
    pub fn read(&mut self) -> Result<Option<Record<'a, K>>, StreamError> {
        Ok(self.read_both()?.map(|(_, record)| record))
    }

    /// The next record, encoded and decoded.
    pub(crate) fn read_both(&mut self) -> Result<Option<Both<'a, K>>, StreamError> {
        loop {
            let (raw, rest) = self.rest.next::<K>()?;
            match raw {
                // The reader stays before the end, so that further calls give the same result.
                Raw::Record { kind: END, .. } => return Ok(None),
                Raw::Record { kind: SLICE, .. } => self.rest = rest,
                _ => {
                    let record = self.rest.meaning(raw)?;
                    self.rest = rest;
                    return Ok(Some((raw, record)));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Input;
    use crate::planar::{Odometry, Planar};
    use crate::underwater::{Navigation, Underwater};
    use crate::{Scalar, Writer};
    use scphd::models::Reading;
    use scphd::navigation::Instruments;
    use std::vec;
    use std::vec::Vec;

    const MOVED: Odometry = Odometry { control: [1.1, -0.2, 0.3], dt_s: 0.05 };
    const SCAN_OF_TWO: [[f64; 2]; 2] = [[3.3, 0.4], [5.5, -0.6]];
    const PIXELS: [[f64; 4]; 1] = [[401.5, 300.25, 310.75, 299.5]];

    fn written<K: Kind>(scalar: Scalar, inputs: &[K::Input], scans: &[&[K::Measurement]]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let header = Header::<K> { scalar, ..Header::EMPTY };
        let mut writer = Writer::start(&header, |piece: &[u8]| {
            bytes.extend_from_slice(piece);
            Ok::<(), ()>(())
        })
        .unwrap();
        inputs.iter().for_each(|input| writer.predict(input).unwrap());
        scans.iter().for_each(|scan| writer.scan(scan).unwrap());
        writer.end().unwrap();
        bytes
    }

    fn planar(scalar: Scalar) -> Vec<u8> {
        written::<Planar>(scalar, &[MOVED], &[&SCAN_OF_TWO, &[]])
    }

    /// Rows of instruments with both readings, with one of them, with none, and a step without a row.
    fn dive() -> Vec<Navigation> {
        let row = |velocity_mps, z_m| {
            let yaw_rate_radps = Reading { value: 0.3, sigma: 0.02 };
            Some(Instruments { roll_rad: 0.1, pitch_rad: -0.2, yaw_rate_radps, velocity_mps, z_m })
        };
        let velocity = Some([0.4, 0.01, -0.03]);
        let rows = [row(velocity, Some(-2.9)), row(velocity, None), row(None, Some(-3.1)), row(None, None), None];
        rows.into_iter().map(|instruments| Navigation { dt_s: 0.1, instruments }).collect()
    }

    fn underwater(scalar: Scalar) -> Vec<u8> {
        written::<Underwater>(scalar, &dive(), &[&PIXELS, &[]])
    }

    /// Predictions and scans.
    type Records<K> = (Vec<<K as Kind>::Input>, Vec<Vec<<K as Kind>::Measurement>>);

    /// All records of the stream, up to an error or its end.
    fn records<K: Kind>(bytes: &[u8]) -> Result<Records<K>, StreamError> {
        let mut reader = Reader::<K>::open(bytes)?;
        let (mut inputs, mut scans) = (Vec::new(), Vec::new());
        while let Some(record) = reader.read()? {
            match record {
                Record::Predict(input) => inputs.push(input),
                Record::Scan(measurements) => {
                    let len = measurements.len();
                    scans.push(measurements.collect::<Vec<_>>());
                    assert_eq!(scans.last().map(Vec::len), Some(len));
                }
                other => panic!("{other:?}"),
            }
        }
        Ok((inputs, scans))
    }

    #[test]
    fn written_records_are_read() {
        let expected = (vec![MOVED], vec![SCAN_OF_TWO.to_vec(), vec![]]);
        assert_eq!(records::<Planar>(&planar(Scalar::F64)), Ok(expected));
        let round = |x: f64| f64::from(x as f32);
        let moved = Odometry { control: MOVED.control.map(round), dt_s: round(MOVED.dt_s) };
        let expected = (vec![moved], vec![SCAN_OF_TWO.map(|z| z.map(round)).to_vec(), vec![]]);
        assert_eq!(records::<Planar>(&planar(Scalar::F32)), Ok(expected));
        // The instruments are in double precision in both; the pixels are exact in both.
        for scalar in [Scalar::F32, Scalar::F64] {
            assert_eq!(records::<Underwater>(&underwater(scalar)), Ok((dive(), vec![PIXELS.to_vec(), vec![]])));
        }
    }

    #[test]
    fn invalid_parts_are_refused() {
        for (parts, ok) in [(0, true), (1, true), (2, false), (3, true), (4, false), (5, true), (6, false), (7, true)] {
            assert_eq!(Navigation::count(parts).is_some(), ok, "{parts}");
        }
        assert_eq!((Navigation::count(8), Odometry::count(2)), (None, None));
        // A record of an unknown type in an otherwise valid stream.
        let mut bytes = planar(Scalar::F32);
        bytes[Header::<Planar>::LENGTH] = 99;
        assert_eq!(records::<Planar>(&bytes), Err(StreamError::Record { index: 0 }));
    }

    #[test]
    fn bytes_behind_the_end_are_ignored() {
        let mut bytes = planar(Scalar::F32);
        let expected = records::<Planar>(&bytes);
        bytes.extend([0xff; 100]);
        assert_eq!(records::<Planar>(&bytes), expected);
        let mut reader = Reader::<Planar>::open(&bytes).unwrap();
        (0..3).for_each(|_| assert!(reader.read().unwrap().is_some()));
        assert!(reader.read().unwrap().is_none() && reader.read().unwrap().is_none());
    }

    /// A ring buffer may be torn at such a record.
    #[test]
    fn a_change_of_tuning_is_no_beginning() {
        let mut bytes = Vec::new();
        let mut writer = Writer::start(&Header::<Planar>::EMPTY, |piece: &[u8]| {
            bytes.extend_from_slice(piece);
            Ok::<(), ()>(())
        })
        .unwrap();
        writer.retune(&Header::EMPTY).unwrap();
        writer.end().unwrap();
        assert!(Reader::<Planar>::open(&bytes).is_ok());
        let torn = Reader::<Planar>::open(&bytes[Header::<Planar>::LENGTH..]);
        assert_eq!(torn.map(drop), Err(StreamError::NoBeginning));
    }

    fn damage_is_seen<K: Kind>(good: &[u8]) {
        assert!(records::<K>(good).is_ok());
        for place in 0..good.len() {
            assert!(records::<K>(&good[..place]).is_err(), "cut at {place}");
            for bit in 0..8 {
                let mut bytes = good.to_vec();
                bytes[place] ^= 1 << bit;
                assert!(records::<K>(&bytes).is_err(), "bit {bit} of byte {place}");
            }
        }
    }

    #[test]
    fn all_damage_and_truncation_is_detected() {
        for scalar in [Scalar::F32, Scalar::F64] {
            damage_is_seen::<Planar>(&planar(scalar));
            damage_is_seen::<Underwater>(&underwater(scalar));
        }
    }

    #[test]
    fn complete_records_before_a_cut_can_be_read() {
        let bytes = planar(Scalar::F64);
        let mut reader = Reader::<Planar>::open(&bytes[..bytes.len() - 9]).unwrap();
        assert!(reader.read().unwrap().is_some() && reader.read().unwrap().is_some());
        assert_eq!(reader.read().unwrap_err(), StreamError::Truncated);
        assert_eq!(reader.read().unwrap_err(), StreamError::Truncated);
    }
}
