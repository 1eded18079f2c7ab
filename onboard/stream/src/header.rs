//! The head of a stream: everything a filter has to be told before the first record.

use crate::bytes::{Bytes, CHECK, CRC, Checked};
use crate::error::StreamError;
use crate::front::{Begins, FRONT, MAGIC, Mark, RETUNED, SNAPSHOT, VERSION};
use crate::kind::Kind;
use crate::numbers::{Numbers, numbers};
use crate::scalar::Scalar;

/// A count that was not known when the head was written, as in a flight that was still going on.
pub const UNKNOWN: u32 = u32::MAX;

/// Where poses are drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Proposal {
    /// The odometry alone.
    Blind,
    /// Odometry and scan.
    Informed,
}

/// Which components are the estimated features.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extraction {
    /// The heaviest.
    Heaviest,
    /// The highest peaks.
    Peaks,
    /// All that are confirmed.
    Confirmed,
}

numbers! {
    /// Numbers of the recursion, for static features.
    Recursion {
        /// w_b, 1/(m·rad), or 1/px⁴ for a stereo camera.
        birth_intensity: f64,
        /// Resample below this N_eff / N.
        resample_threshold: f64,
        /// Drop components below this weight.
        prune_weight: f64,
        /// A component is confirmed where it is better known than from this many measurements.
        confirming_detections: f64,
        /// Forget components that leave the view lighter than this and not confirmed.
        unconfirmed_weight: f64,
        /// Misses take a confirmed component no further down than to this weight.
        confirmed_weight: f64,
        /// Merge components within this squared Mahalanobis distance.
        merge_distance: f64,
        /// Least weight of an estimated feature.
        extraction_weight: f64,
        /// Linearisations of the informed proposal; a whole number.
        proposal_rounds: f64,
        /// Share of the informed proposal's covariance that is drawn.
        proposal_sampled_fraction: f64,
        /// Least share of a measurement with which a component steers the informed proposal.
        proposal_min_responsibility: f64,
        /// By how much longer than the vehicle's own odometry errors those of a mixture are taken to last; 0 counts as 1.
        interval_margin: f64,
    }
}

numbers! {
    /// Numbers of the recursion, for moving features.
    Moving {
        /// w_m, birth intensity of moving features, 1/(m·rad); 0 for none.
        birth_intensity: f64,
        /// Standard deviation of each coordinate of a new feature's velocity, m/s.
        velocity_sigma_mps: f64,
        /// q, spectral density of the acceleration, m²/s³.
        acceleration_psd: f64,
        /// τ, mean lifetime, s.
        lifetime_s: f64,
        /// Forget moving components whose position has a greater standard deviation, m.
        spread_max_m: f64,
        /// Least weight of an estimated moving feature.
        extraction_weight: f64,
    }
}

numbers! {
    /// Numbers of a joint map.
    Joint {
        /// Mean time that a landmark stays in sight before something hides it, s.
        visible_s: f64,
        /// Mean time that it stays hidden, s.
        occluded_s: f64,
        /// Mean time until it is taken away, s.
        lifetime_s: f64,
        /// Share of p_D that is left behind a nearer detection.
        occlusion_factor: f64,
        /// Two features within this squared Mahalanobis distance are one.
        merge_distance: f64,
    }
}

/// Everything a filter has to be told before the first record: models, tuning, start. All numbers are in double
/// precision, whatever the payload: the filter rounds them as it would round settings from anywhere else.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header<K: Kind> {
    /// The number type of the payload.
    pub scalar: Scalar,
    /// The motion model.
    pub vehicle: K::Vehicle,
    /// Where poses are drawn from.
    pub proposal: Proposal,
    /// Which components are the estimated static features.
    pub extraction: Extraction,
    /// Whether births that nothing explains wait for the next scan.
    pub births_wait: bool,
    /// Scans in the stream, or [`UNKNOWN`].
    pub scans: u32,
    /// Predictions in the stream, or [`UNKNOWN`].
    pub predictions: u32,
    /// The most measurements in a scan, or [`UNKNOWN`].
    pub most_measurements: u32,
    /// N.
    pub particles: u32,
    /// M.
    pub samples: u32,
    /// Components kept in view, at most.
    pub max_components: u32,
    /// Seed of the filter's random numbers.
    pub seed: u64,
    /// What stands behind this head.
    pub begins: Begins,
    /// Start, vehicle and sensor.
    pub models: K::Models,
    /// The recursion for static features.
    pub recursion: Recursion,
    /// The recursion for moving features.
    pub moving: Moving,
    /// The joint map, for a filter that has one.
    pub joint: Joint,
    /// Time from one scan to the next, s; the median where it varies.
    pub scan_interval_s: f64,
}

impl<K: Kind> Header<K> {
    /// Bytes of the whole head, its check included.
    pub const LENGTH: usize = FRONT
        + 8 * (<K::Models as Numbers>::COUNT + Recursion::COUNT + Moving::COUNT + Joint::COUNT + f64::COUNT)
        + CHECK;

    /// A head with every number zero, one particle, one sample, blind proposal, the heaviest extracted and unknown
    /// counts.
    pub const EMPTY: Self = Self {
        scalar: Scalar::F64,
        vehicle: K::VEHICLE,
        proposal: Proposal::Blind,
        extraction: Extraction::Heaviest,
        births_wait: false,
        scans: UNKNOWN,
        predictions: UNKNOWN,
        most_measurements: UNKNOWN,
        particles: 1,
        samples: 1,
        max_components: UNKNOWN,
        seed: 0,
        begins: Begins::Start,
        models: <K::Models as Numbers>::ZERO,
        recursion: Recursion::ZERO,
        moving: Moving::ZERO,
        joint: Joint::ZERO,
        scan_interval_s: 0.0,
    };

    /// Writes the head behind a record of this check, 0 for none; the check of the head.
    pub(crate) fn write<E>(&self, before: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<u32, E> {
        let mut sink = Checked::new(sink);
        sink.put(&MAGIC);
        sink.put(&VERSION.to_le_bytes());
        sink.put(&(Self::LENGTH as u16).to_le_bytes());
        sink.put(&[
            self.scalar.bytes() as u8,
            K::code(self.vehicle),
            0,
            0,
            match self.proposal {
                Proposal::Blind => 0,
                Proposal::Informed => 1,
            },
            match self.extraction {
                Extraction::Heaviest => 0,
                Extraction::Peaks => 1,
                Extraction::Confirmed => 2,
            },
            match self.begins {
                Begins::Start => 0,
                Begins::Snapshot(_) => SNAPSHOT,
                Begins::Retuned => RETUNED,
            },
            u8::from(self.births_wait),
        ]);
        for count in
            [self.scans, self.predictions, self.most_measurements, self.particles, self.samples, self.max_components]
        {
            sink.put(&count.to_le_bytes());
        }
        sink.put(&self.seed.to_le_bytes());
        let Mark { scans, parts, digest } = match self.begins {
            Begins::Snapshot(mark) => mark,
            Begins::Start | Begins::Retuned => Mark { scans: 0, parts: 0, digest: 0 },
        };
        sink.put(&scans.to_le_bytes());
        sink.put(&parts.to_le_bytes());
        sink.put(&digest.to_le_bytes());
        sink.put(&before.to_le_bytes());
        let mut number = |number: f64| sink.put(&number.to_le_bytes());
        self.models.put(&mut number);
        self.recursion.put(&mut number);
        self.moving.put(&mut number);
        self.joint.put(&mut number);
        self.scan_interval_s.put(&mut number);
        sink.end()
    }

    /// The number type of the records behind the head at the front of `bytes`, which is read as a whole.
    pub(crate) fn scalar_of(bytes: &[u8]) -> Result<Scalar, StreamError> {
        Self::decode(&mut Bytes(bytes)).map(|(header, _)| header.scalar)
    }

    /// Takes the head off the front of `bytes`; the head, and its check. In a frame of its own, and once in an image.
    #[inline(never)]
    pub(crate) fn decode(bytes: &mut Bytes<'_>) -> Result<(Self, u32), StreamError> {
        let whole = bytes.0;
        if bytes.array().ok_or(StreamError::Truncated)? != MAGIC {
            return Err(StreamError::NotAStream);
        }
        let version = bytes.u16().ok_or(StreamError::Truncated)?;
        if version != VERSION {
            return Err(StreamError::Version { found: version });
        }
        let length = usize::from(bytes.u16().ok_or(StreamError::Truncated)?);
        let choices: [u8; 8] = bytes.array().ok_or(StreamError::Truncated)?;
        // The length of the head depends on the vehicle.
        let [_, code, ..] = choices;
        let vehicle = K::vehicle(code).ok_or(StreamError::Vehicle { found: code })?;
        if length != Self::LENGTH {
            return Err(StreamError::Header);
        }
        let content = whole.get(..Self::LENGTH - CHECK).ok_or(StreamError::Truncated)?;
        let header = Self::fields(vehicle, choices, bytes).ok_or(StreamError::Header);
        let check = bytes.u32().ok_or(StreamError::Truncated)?;
        if check != CRC.checksum(content) {
            return Err(StreamError::HeaderDamaged);
        }
        Ok((header?, check))
    }

    /// What follows the choices, with what they stand for; consumes all of it, known choices or not.
    fn fields(vehicle: K::Vehicle, choices: [u8; 8], bytes: &mut Bytes<'_>) -> Option<Self> {
        let mut header = Self { vehicle, ..Self::EMPTY };
        for count in [
            &mut header.scans,
            &mut header.predictions,
            &mut header.most_measurements,
            &mut header.particles,
            &mut header.samples,
            &mut header.max_components,
        ] {
            *count = bytes.u32()?;
        }
        header.seed = bytes.u64()?;
        let mark = Mark { scans: bytes.u32()?, parts: bytes.u32()?, digest: bytes.u64()? };
        // The check of the record before is the reader's to look at.
        bytes.u32()?;
        let mut number = || bytes.f64();
        header.models = Numbers::take(&mut number)?;
        header.recursion = Numbers::take(&mut number)?;
        header.moving = Numbers::take(&mut number)?;
        header.joint = Numbers::take(&mut number)?;
        header.scan_interval_s = number()?;
        let [scalar, _, 0, 0, proposal, extraction, begins, births_wait] = choices else { return None };
        header.begins = match begins {
            0 => Begins::Start,
            SNAPSHOT => Begins::Snapshot(mark),
            RETUNED => Begins::Retuned,
            _ => return None,
        };
        header.scalar = match scalar {
            4 => Scalar::F32,
            8 => Scalar::F64,
            _ => return None,
        };
        header.proposal = match proposal {
            0 => Proposal::Blind,
            1 => Proposal::Informed,
            _ => return None,
        };
        header.extraction = match extraction {
            0 => Extraction::Heaviest,
            1 => Extraction::Peaks,
            2 => Extraction::Confirmed,
            _ => return None,
        };
        header.births_wait = match births_wait {
            0 => false,
            1 => true,
            _ => return None,
        };
        Some(header)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::head::Head;
    use crate::planar::{Planar, Vehicle};
    use crate::underwater::{Auv, Underwater};
    use std::vec::Vec;

    /// A head in which no two numbers are the same.
    fn numbered<K: Kind>(vehicle: K::Vehicle) -> Header<K> {
        let mut next = 99.5;
        let mut number = || {
            next += 1.0;
            Some(next)
        };
        Header {
            scalar: Scalar::F32,
            vehicle,
            proposal: Proposal::Informed,
            extraction: Extraction::Peaks,
            births_wait: true,
            scans: 1,
            predictions: 2,
            most_measurements: 3,
            particles: 4,
            samples: 5,
            max_components: 6,
            seed: 0x0102_0304_0506_0708,
            begins: Begins::Snapshot(Mark { scans: 7, parts: 8, digest: 9 }),
            models: Numbers::take(&mut number).unwrap(),
            recursion: Numbers::take(&mut number).unwrap(),
            moving: Numbers::take(&mut number).unwrap(),
            joint: Numbers::take(&mut number).unwrap(),
            scan_interval_s: number().unwrap(),
        }
    }

    fn planar() -> Header<Planar> {
        numbered(Vehicle::UnicycleArc)
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
        assert_eq!(Header::decode(&mut Bytes(&encoded(&header))).map(|(header, _)| header), Ok(header));
    }

    #[test]
    fn what_is_written_is_read() {
        comes_back(planar());
        comes_back(numbered::<Underwater>(Auv));
        assert_eq!((planar().models.start_x_m, planar().scan_interval_s), (100.5, 149.5));
        let underwater = numbered::<Underwater>(Auv);
        assert_eq!((underwater.models.start_m[0], underwater.scan_interval_s), (100.5, 178.5));
    }

    /// The places of the documented layout, by hand.
    #[test]
    fn the_layout_is_the_documented_one() {
        let bytes = encoded(&planar());
        assert_eq!(bytes.len(), 476);
        assert_eq!(&bytes[..12], b"SCPHDLOG\x06\x00\xdc\x01");
        assert_eq!(bytes[12..20], [4, 2, 0, 0, 1, 1, 1, 1]);
        assert_eq!(bytes[20..24], [1, 0, 0, 0]);
        assert_eq!(bytes[40..44], [6, 0, 0, 0]);
        assert_eq!(bytes[44..52], [8, 7, 6, 5, 4, 3, 2, 1]);
        assert_eq!(bytes[52..72], [7, 0, 0, 0, 8, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 10, 0, 0, 0]);
        assert_eq!(bytes[72..80], 100.5_f64.to_le_bytes());
        assert_eq!(bytes[464..472], 149.5_f64.to_le_bytes());
        let head = Head::take::<Planar>(&mut Bytes(&bytes)).unwrap();
        assert_eq!((head.before, head.mark()), (10, Some(Mark { scans: 7, parts: 8, digest: 9 })));
        let bytes = encoded(&numbered::<Underwater>(Auv));
        assert_eq!(bytes.len(), 708);
        assert_eq!(bytes[10..14], [0xc4, 0x02, 4, 3]);
        assert_eq!(bytes[72..80], 100.5_f64.to_le_bytes());
        assert_eq!(bytes[696..704], 178.5_f64.to_le_bytes());
    }

    #[test]
    fn every_damage_to_the_head_is_seen() {
        let good = encoded(&planar());
        for place in 0..good.len() {
            let mut bytes = good.clone();
            bytes[place] ^= 0x10;
            assert!(Header::<Planar>::decode(&mut Bytes(&bytes)).is_err(), "byte {place}");
            assert!(Header::<Planar>::decode(&mut Bytes(&good[..place])).is_err(), "cut at {place}");
        }
    }

    #[test]
    fn other_versions_vehicles_and_files_are_told_apart() {
        let decoded = |bytes: &[u8]| Header::<Planar>::decode(&mut Bytes(bytes)).map(drop);
        let mut bytes = encoded(&planar());
        bytes[8] = 1;
        assert_eq!(decoded(&bytes), Err(StreamError::Version { found: 1 }));
        bytes[0] = b'X';
        assert_eq!(decoded(&bytes), Err(StreamError::NotAStream));
        assert_eq!(decoded(b"SCPHD"), Err(StreamError::Truncated));
        assert_eq!(decoded(&encoded(&numbered::<Underwater>(Auv))), Err(StreamError::Vehicle { found: 3 }));
        let error = Header::<Underwater>::decode(&mut Bytes(&encoded(&planar()))).map(drop);
        assert_eq!(error, Err(StreamError::Vehicle { found: 2 }));
    }
}
