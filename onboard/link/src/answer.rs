//! The status report that the target sends.

use crate::report::Report;
use scphd_stream::{Kind, Numbers};

/// State of the filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Standing {
    /// It runs.
    Running,
    /// The stream has ended.
    Ended,
    /// The filter cannot be constructed from the head, or the head cannot be read.
    NotSetUp,
}

/// Unit of the costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unit {
    /// Cycles of the processor.
    Cycles,
    /// Instructions, counted by an emulator.
    Instructions,
    /// Nanoseconds.
    Nanoseconds,
}

/// Cost of the last scan, and of the predictions since the previous one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cost {
    /// Cost of all these predictions.
    pub predict: u32,
    /// Cost of the scan.
    pub update: u32,
    /// Cost of the estimates of pose and map.
    pub estimate: u32,
}

impl Cost {
    /// The sum.
    #[must_use]
    pub fn total(&self) -> u64 {
        u64::from(self.predict) + u64::from(self.update) + u64::from(self.estimate)
    }
}

/// Status of the target after the last scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer<K: Kind> {
    /// State of the filter.
    pub standing: Standing,
    /// Unit of the cost.
    pub unit: Unit,
    /// Health flags of the last scan, as bits.
    pub health: u16,
    /// The number of the last record that the link accepted.
    pub accepted: u32,
    /// Number of scans.
    pub scans: u32,
    /// Number of records that the filter refused or that could not be read.
    pub refused: u32,
    /// Number of estimated features.
    pub features: u32,
    /// Cost of the last scan.
    pub cost: Cost,
    /// Counts of the accepted and refused frames.
    pub report: Report,
    /// Digest of the state.
    pub digest: u64,
    /// The estimated pose.
    pub pose: K::Pose,
    /// The lower triangle of its covariance, row after row.
    pub covariance: K::Covariance,
}

impl<K: Kind> Answer<K> {
    /// Number of its bytes.
    pub const LENGTH: usize =
        4 + 4 * (4 + 3 + Report::COUNTS) + 8 + 8 * (<K::Pose as Numbers>::COUNT + <K::Covariance as Numbers>::COUNT);

    /// The status before the first scan.
    pub(crate) const fn none(standing: Standing, unit: Unit) -> Self {
        Self {
            standing,
            unit,
            health: 0,
            accepted: 0,
            scans: 0,
            refused: 0,
            features: 0,
            cost: Cost { predict: 0, update: 0, estimate: 0 },
            report: Report::NONE,
            digest: 0,
            pose: K::Pose::ZERO,
            covariance: K::Covariance::ZERO,
        }
    }

    /// Encodes it into a buffer of [`LENGTH`](Self::LENGTH) bytes; `None` for another length.
    pub(crate) fn encode<'b>(&self, into: &'b mut [u8]) -> Option<&'b [u8]> {
        let mut slots = into.iter_mut();
        let mut is_room = true;
        let mut put = |bytes: &[u8]| {
            for &byte in bytes {
                match slots.next() {
                    Some(slot) => *slot = byte,
                    None => is_room = false,
                }
            }
        };
        put(&[self.standing as u8, self.unit as u8]);
        put(&self.health.to_le_bytes());
        let Cost { predict, update, estimate } = self.cost;
        for count in [self.accepted, self.scans, self.refused, self.features, predict, update, estimate] {
            put(&count.to_le_bytes());
        }
        self.report.counts().iter().for_each(|count| put(&count.to_le_bytes()));
        put(&self.digest.to_le_bytes());
        self.pose.put(&mut |number| put(&number.to_le_bytes()));
        self.covariance.put(&mut |number| put(&number.to_le_bytes()));
        let is_full = slots.next().is_none();
        (is_room && is_full).then_some(into)
    }

    /// Decodes the content of a frame of this type; `None` if it is invalid, or of another type of vehicle.
    #[must_use]
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.len() != Self::LENGTH {
            return None;
        }
        let (&[standing, unit, h0, h1], mut rest) = bytes.split_first_chunk()?;
        let mut word = || {
            let (word, behind) = rest.split_first_chunk()?;
            rest = behind;
            Some(u32::from_le_bytes(*word))
        };
        let [accepted, scans, refused, features] = [word()?, word()?, word()?, word()?];
        let cost = Cost { predict: word()?, update: word()?, estimate: word()? };
        let mut counts = [0; Report::COUNTS];
        for count in &mut counts {
            *count = word()?;
        }
        let mut long = || {
            let (long, behind) = rest.split_first_chunk()?;
            rest = behind;
            Some(u64::from_le_bytes(*long))
        };
        let digest = long()?;
        let pose = K::Pose::take(&mut || long().map(f64::from_bits))?;
        let covariance = K::Covariance::take(&mut || long().map(f64::from_bits))?;
        Some(Self {
            standing: match standing {
                0 => Standing::Running,
                1 => Standing::Ended,
                2 => Standing::NotSetUp,
                _ => return None,
            },
            unit: match unit {
                0 => Unit::Cycles,
                1 => Unit::Instructions,
                2 => Unit::Nanoseconds,
                _ => return None,
            },
            health: u16::from_le_bytes([h0, h1]),
            accepted,
            scans,
            refused,
            features,
            cost,
            report: Report::of(counts),
            digest,
            pose,
            covariance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_stream::planar::Planar;
    use scphd_stream::underwater::Underwater;
    use std::vec;

    #[test]
    fn an_answer_is_decoded_as_it_was_encoded() {
        let answer = Answer::<Planar> {
            standing: Standing::Ended,
            unit: Unit::Nanoseconds,
            health: 0x8001,
            accepted: 1,
            scans: 2,
            refused: 3,
            features: 4,
            cost: Cost { predict: 5, update: u32::MAX, estimate: 7 },
            report: Report::of([1, 2, 3, 4, 5, 6, 7, 8, 9]),
            digest: 0x0123_4567_89ab_cdef,
            pose: [1.5, -2.5, f64::MIN_POSITIVE],
            covariance: [1.0, 2.0, 3.0, 4.0, 5.0, f64::INFINITY],
        };
        assert_eq!(answer.cost.total(), u64::from(u32::MAX) + 12);
        let mut bytes = [0; Answer::<Planar>::LENGTH];
        assert_eq!(bytes.len(), 148);
        let encoded = answer.encode(&mut bytes).unwrap();
        assert_eq!(Answer::decode(encoded), Some(answer));
        assert_eq!(Answer::<Planar>::decode(&encoded[1..]), None);
        assert_eq!(Answer::<Underwater>::decode(encoded), None);
        for place in [0, 1] {
            let mut damaged = bytes;
            damaged[place] = 3;
            assert_eq!(Answer::<Planar>::decode(&damaged), None);
        }
        for room in [0, 147, 149] {
            assert!(answer.encode(&mut vec![0; room]).is_none());
        }
    }
}
