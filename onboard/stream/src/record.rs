//! The records of a stream.

use crate::bytes::{Bytes, chained};
use crate::error::StreamError;
use crate::front::MAGIC;
use crate::head::Head;
use crate::kind::{Input, Kind};
use crate::numbers::Numbers;
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// The types of records.
pub(crate) const PREDICT: u8 = 1;
pub(crate) const SCAN: u8 = 2;
pub(crate) const END: u8 = 3;
pub(crate) const FIX: u8 = 4;
pub(crate) const DETECTOR: u8 = 5;
pub(crate) const PLACE: u8 = 7;
pub(crate) const MAP: u8 = 8;
pub(crate) const SLICE: u8 = 9;

/// Flag in the parts of a scan, in addition to its detector: the scan does not change the map.
pub(crate) const LOCALISING: u8 = 0x80;

/// One record.
#[derive(Debug, Clone)]
pub enum Record<'a, K: Kind> {
    /// A prediction.
    Predict(K::Input),
    /// A scan.
    Scan(Measurements<'a, K>),
    /// A measurement of the pose.
    Fix(Shown<'a, K>),
    /// A detector was added, or its models were changed.
    Detector(Which<K>, Later<'a, K::Sensor>),
    /// The pose was set from outside.
    Place(Place<'a, K>),
    /// A map was loaded.
    Map(Features<'a, K>),
    /// The models or the tuning were changed, or a snapshot begins.
    Head(Head<'a, K>),
}

/// The number of a detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Which<K> {
    number: u8,
    kind: PhantomData<K>,
}

impl<K: Kind> Which<K> {
    /// The first detector.
    pub const FIRST: Self = Self { number: 0, kind: PhantomData };

    /// The detector with this number, from 0; `None` if it is not below [`Kind::DETECTORS`].
    #[must_use]
    pub const fn number(number: u8) -> Option<Self> {
        if number < K::DETECTORS { Some(Self { number, kind: PhantomData }) } else { None }
    }

    /// Its number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.number
    }
}

/// A part of a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The filter.
    Filter,
    /// The velocity filter of an underwater vehicle.
    Navigator,
}

impl Part {
    /// Its code, which is also its bit among the parts of a snapshot.
    pub(crate) fn code(self) -> u8 {
        match self {
            Self::Filter => 0,
            Self::Navigator => 16,
        }
    }

    /// Its bit in [`Mark::parts`](crate::Mark::parts).
    #[must_use]
    pub fn bit(self) -> u32 {
        1 << self.code()
    }
}

/// Numbers of a record, decoded on demand.
#[derive(Debug, Clone)]
pub struct Later<'a, N> {
    bytes: &'a [u8],
    numbers: PhantomData<N>,
}

impl<N: Numbers> Later<'_, N> {
    /// Decodes the numbers, whose count the reader has checked.
    #[must_use]
    pub fn get(&self) -> N {
        let mut bytes = Bytes(self.bytes);
        N::take(&mut || bytes.f64()).unwrap_or(N::ZERO)
    }
}

/// A measurement of the pose, decoded on demand.
#[derive(Debug, Clone)]
pub struct Shown<'a, K> {
    parts: u8,
    bytes: &'a [u8],
    kind: PhantomData<K>,
}

impl<K: Kind> Shown<'_, K> {
    /// Decodes the fix; `None` if it is invalid.
    #[must_use]
    pub fn get(&self) -> Option<K::Fix> {
        let mut bytes = Bytes(self.bytes);
        K::Fix::take(self.parts, &mut || bytes.f64())
    }
}

/// A pose set from outside.
#[derive(Debug, Clone)]
pub struct Place<'a, K> {
    /// The operation.
    pub how: How,
    bytes: &'a [u8],
    kind: PhantomData<K>,
}

/// The operation that set a pose from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum How {
    /// A reset: the filter restarts at an exactly known pose, without a map.
    Reset,
    /// A reset to a pose with a covariance.
    ResetWithin,
    /// A relocation in the same map.
    Relocate,
    /// An increase of the covariance; the pose is unchanged.
    Scatter,
}

impl How {
    /// All operations, at the index of their code.
    const ALL: [Self; 4] = [Self::Reset, Self::ResetWithin, Self::Relocate, Self::Scatter];
}

impl<K: Kind> Place<'_, K> {
    /// Decodes all numbers of the pose, its covariance, and the seed of a reset.
    #[must_use]
    pub fn get(&self) -> (K::Full, K::Covariance, u64) {
        let mut bytes = Bytes(self.bytes);
        let pose = K::Full::take(&mut || bytes.f64()).unwrap_or(K::Full::ZERO);
        let covariance = K::Covariance::take(&mut || bytes.f64()).unwrap_or(K::Covariance::ZERO);
        (pose, covariance, bytes.u64().unwrap_or(0))
    }
}

/// The features of a loaded map.
#[derive(Debug, Clone)]
pub struct Features<'a, K> {
    bytes: Bytes<'a>,
    kind: PhantomData<K>,
}

impl<K: Kind> Iterator for Features<'_, K> {
    type Item = K::Feature;

    fn next(&mut self) -> Option<K::Feature> {
        K::Feature::take(&mut || self.bytes.f64())
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let len = self.bytes.0.len() / (8 * K::Feature::COUNT);
        (len, Some(len))
    }
}

impl<K: Kind> ExactSizeIterator for Features<'_, K> {}

/// The measurements of one scan.
#[derive(Debug, Clone)]
pub struct Measurements<'a, K> {
    numbers: Payload<'a>,
    which: Which<K>,
    localising: bool,
}

impl<K: Kind> Measurements<'_, K> {
    /// The detector of the scan.
    #[must_use]
    pub fn detector(&self) -> Which<K> {
        self.which
    }

    /// Whether they update the pose only, by [`scphd::JointSlam::localise`].
    #[must_use]
    pub fn localising(&self) -> bool {
        self.localising
    }
}

impl<K: Kind> Iterator for Measurements<'_, K> {
    type Item = K::Measurement;

    fn next(&mut self) -> Option<K::Measurement> {
        Numbers::take(&mut || self.numbers.next())
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let len = self.numbers.bytes.0.len() / (K::Measurement::COUNT * self.numbers.scalar.bytes());
        (len, Some(len))
    }
}

impl<K: Kind> ExactSizeIterator for Measurements<'_, K> {}

/// The numbers of a record.
#[derive(Debug, Clone)]
struct Payload<'a> {
    bytes: Bytes<'a>,
    scalar: Scalar,
}

impl Payload<'_> {
    fn next(&mut self) -> Option<f64> {
        match self.scalar {
            Scalar::F32 => self.bytes.f32().map(f64::from),
            Scalar::F64 => self.bytes.f64(),
        }
    }
}

/// An encoded record.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Raw<'a, K> {
    /// A head.
    Head(Head<'a, K>),
    /// Any other record.
    Record {
        /// Type, parts and count.
        kind: u8,
        parts: u8,
        count: u16,
        /// The bytes behind them.
        payload: &'a [u8],
    },
}

/// A record, encoded and decoded.
pub(crate) type Both<'a, K> = (Raw<'a, K>, Record<'a, K>);

/// The sequence of records behind a head.
#[derive(Debug, Clone)]
pub(crate) struct Records<'a> {
    pub(crate) rest: Bytes<'a>,
    /// The number type of the payload.
    scalar: Scalar,
    /// The checksum of the previous record or head.
    pub(crate) check: u32,
    /// Index of the next record, from 0.
    pub(crate) index: u32,
}

impl<'a> Records<'a> {
    /// The records behind a head with this checksum.
    pub(crate) fn behind(check: u32, scalar: Scalar, rest: Bytes<'a>) -> Self {
        Self { rest, scalar, check, index: 0 }
    }

    /// The next record, and all records behind it.
    ///
    /// # Errors
    /// The record is incomplete, damaged or unknown, or does not follow the previous one.
    pub(crate) fn next<K: Kind>(&self) -> Result<(Raw<'a, K>, Self), StreamError> {
        self.next_behind::<K>(Some(self.check))
    }

    /// The next record, behind a record with this checksum. With `None` the checksum of the record is not checked, because it
    /// includes that of the previous one.
    ///
    /// # Errors
    /// As for [`next`](Self::next).
    pub(crate) fn next_behind<K: Kind>(&self, before: Option<u32>) -> Result<(Raw<'a, K>, Self), StreamError> {
        let &Self { scalar, index, .. } = self;
        let mut rest = self.rest.clone();
        let whole = rest.0;
        let behind = |rest, check| Self { rest, scalar, check, index: index.saturating_add(1) };
        let damaged = StreamError::RecordDamaged { index };
        let kind = rest.u8().ok_or(StreamError::Truncated)?;
        if [kind] == MAGIC.first_chunk::<1>().copied().unwrap_or_default() {
            let mut rest = Bytes(whole);
            let head = Head::take(&mut rest);
            let head = head.map_err(|why| if why == StreamError::Truncated { why } else { damaged })?;
            return if before.is_none_or(|before| before == head.before) {
                Ok((Raw::Head(head), behind(rest, head.check)))
            } else {
                Err(damaged)
            };
        }
        let parts = rest.u8().ok_or(StreamError::Truncated)?;
        let count = rest.u16().ok_or(StreamError::Truncated)?;
        let length = length::<K>(kind, parts, count, scalar).ok_or(StreamError::Record { index })?;
        let payload = rest.slice(length).ok_or(StreamError::Truncated)?;
        let content = whole.get(..4 + payload.len()).ok_or(StreamError::Truncated)?;
        let check = rest.u32().ok_or(StreamError::Truncated)?;
        if before.is_some_and(|before| check != chained(before, content)) {
            return Err(damaged);
        }
        Ok((Raw::Record { kind, parts, count, payload }, behind(rest, check)))
    }

    /// Decodes a record that is neither the end nor a slice.
    ///
    /// # Errors
    /// It is the end or a slice, or unknown.
    pub(crate) fn meaning<K: Kind>(&self, raw: Raw<'a, K>) -> Result<Record<'a, K>, StreamError> {
        let unknown = StreamError::Record { index: self.index };
        let (kind, parts, bytes) = match raw {
            Raw::Head(head) => return Ok(Record::Head(head)),
            Raw::Record { kind, parts, payload, .. } => (kind, parts, payload),
        };
        let which = Which::number(parts & !LOCALISING).ok_or(unknown);
        Ok(match kind {
            PREDICT => {
                let mut numbers = Payload { bytes: Bytes(bytes), scalar: K::Input::scalar(self.scalar) };
                Record::Predict(Input::take(parts, &mut || numbers.next()).ok_or(StreamError::Truncated)?)
            }
            SCAN => {
                let numbers = Payload { bytes: Bytes(bytes), scalar: self.scalar };
                Record::Scan(Measurements { numbers, which: which?, localising: parts & LOCALISING != 0 })
            }
            FIX => Record::Fix(Shown { parts, bytes, kind: PhantomData }),
            DETECTOR => Record::Detector(which?, Later { bytes, numbers: PhantomData }),
            PLACE => {
                let how = *How::ALL.get(usize::from(parts)).ok_or(unknown)?;
                Record::Place(Place { how, bytes, kind: PhantomData })
            }
            MAP => Record::Map(Features { bytes: Bytes(bytes), kind: PhantomData }),
            _ => return Err(unknown),
        })
    }
}

/// Number of bytes of the payload of a record; `None` if its type is invalid.
fn length<K: Kind>(kind: u8, parts: u8, count: u16, scalar: Scalar) -> Option<usize> {
    let many = usize::from(count);
    let is_one = |number: u8| number < K::DETECTORS;
    match (kind, parts, count) {
        (PREDICT, parts, 1) => Some(K::Input::count(parts)? * K::Input::scalar(scalar).bytes()),
        (SCAN, parts, _) if is_one(parts & !LOCALISING) => Some(K::Measurement::COUNT * many * scalar.bytes()),
        (END, 0, 0) => Some(0),
        (FIX, parts, 1) => Some(8 * K::Fix::count(parts)?),
        (DETECTOR, _, 1) if K::Sensor::COUNT > 0 && is_one(parts) => Some(8 * K::Sensor::COUNT),
        (PLACE, 0..=3, 1) => Some(8 * (K::Full::COUNT + K::Covariance::COUNT) + 8),
        (MAP, 0, _) => Some(8 * K::Feature::COUNT * many),
        (SLICE, 0..=31, _) => Some(many),
        _ => None,
    }
}
