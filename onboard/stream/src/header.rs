//! The head of a stream: all parameters of a filter.

use crate::bytes::{Bytes, CHECK, CRC, Checked};
use crate::error::StreamError;
use crate::front::{Begins, FRONT, MAGIC, Mark, RETUNED, SNAPSHOT, VERSION};
use crate::kind::Kind;
use crate::numbers::{Numbers, numbers};
use crate::scalar::Scalar;
use scphd::settings::{HypothesesConfig, Persistence, Plausible};
use scphd::{JointConfig, Real};

/// The value of a count that was unknown when the head was written, for example during the flight.
pub const UNKNOWN: u32 = u32::MAX;

/// Proposal density of the poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Proposal {
    /// The transition density.
    Blind,
    /// The Gaussian corrected by the scan.
    Informed,
}

/// Components that are the estimated features.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extraction {
    /// The heaviest.
    Heaviest,
    /// The highest peaks.
    Peaks,
    /// All confirmed components.
    Confirmed,
}

numbers! {
    /// Tuning of the recursion, for static features.
    Recursion {
        /// w_b, 1/(m·rad), or 1/px⁴ for a stereo camera.
        birth_intensity: f64,
        /// Resampling threshold: N_eff / N.
        resample_threshold: f64,
        /// Pruning threshold.
        prune_weight: f64,
        /// A component is confirmed if its covariance is smaller than this number of measurements would give.
        confirming_detections: f64,
        /// Components that leave the view are removed if their weight is below this and they are not confirmed.
        unconfirmed_weight: f64,
        /// Lower limit of the weight of a confirmed component after misses.
        confirmed_weight: f64,
        /// Merging threshold: squared Mahalanobis distance.
        merge_distance: f64,
        /// Minimum weight of an estimated feature.
        extraction_weight: f64,
        /// Number of linearisations of the informed proposal; an integer.
        proposal_rounds: f64,
        /// Fraction of the informed proposal's covariance with which samples are drawn.
        proposal_sampled_fraction: f64,
        /// Minimum association probability with which a measurement corrects the informed proposal.
        proposal_min_responsibility: f64,
        /// Factor on the correlation time of odometry errors in a mixture; 0 counts as 1.
        interval_margin: f64,
    }
}

numbers! {
    /// Tuning of the recursion, for moving features.
    Moving {
        /// w_m, birth intensity of moving features, 1/(m·rad); 0 for none.
        birth_intensity: f64,
        /// Standard deviation of each coordinate of a new feature's velocity, m/s.
        velocity_sigma_mps: f64,
        /// q, spectral density of the acceleration, m²/s³.
        acceleration_psd: f64,
        /// τ, mean lifetime, s.
        lifetime_s: f64,
        /// Moving components are removed if the standard deviation of their position is greater, m.
        spread_max_m: f64,
        /// Minimum weight of an estimated moving feature.
        extraction_weight: f64,
    }
}

numbers! {
    /// Tuning of a joint map.
    Joint {
        /// Minimum probability that a measurement comes from clutter or a new feature for it to become a feature.
        birth_probability_min: f64,
        /// Association gate: squared Mahalanobis distance.
        gate: f64,
        /// Mean time until a visible landmark is occluded, s.
        visible_s: f64,
        /// Mean time until an occluded landmark is visible again, s.
        occluded_s: f64,
        /// Mean time until a landmark is removed, s.
        lifetime_s: f64,
        /// Factor on p_D behind a nearer detection.
        occlusion_factor: f64,
        /// Features are removed if their existence probability is below this.
        least_existence: f64,
        /// The same for features in view that were detected less than twice.
        least_tentative: f64,
        /// Minimum existence probability of an estimated feature.
        extraction_existence: f64,
        /// Features within this squared Mahalanobis distance are merged.
        merge_distance: f64,
        /// Greatest range of all sensors, m, for a filter with an archive.
        archive_reach_m: f64,
        /// Greatest number of hypotheses, for a filter with several; an integer.
        hypotheses: f64,
        /// Hypotheses are joined if their poses are within this many standard deviations.
        joined_sigmas: f64,
        /// A child is dropped if its weight, divided by that of the likeliest, is below this.
        least_ratio: f64,
        /// A hypothesis is dropped if its probability is below this.
        least_share: f64,
    }
}

impl Joint {
    /// The tuning of a joint map without an archive. The limits of the motion are not recorded: the filters of streams have the
    /// default ones.
    #[must_use]
    pub fn of<T: Real>(config: &JointConfig<T>, hypotheses: &HypothesesConfig<T>) -> Self {
        let JointConfig { persistence: Persistence { visible_s, occluded_s, lifetime_s }, .. } = *config;
        let HypothesesConfig { most, joined_sigmas, least_ratio, least_share } = *hypotheses;
        Self {
            birth_probability_min: config.birth_probability_min.to_f64(),
            gate: config.gate.to_f64(),
            visible_s: visible_s.to_f64(),
            occluded_s: occluded_s.to_f64(),
            lifetime_s: lifetime_s.to_f64(),
            occlusion_factor: config.occlusion_factor.to_f64(),
            least_existence: config.least_existence.to_f64(),
            least_tentative: config.least_tentative.to_f64(),
            extraction_existence: config.extraction_existence.to_f64(),
            merge_distance: config.merge_distance.to_f64(),
            archive_reach_m: 0.0,
            hypotheses: most as f64,
            joined_sigmas: joined_sigmas.to_f64(),
            least_ratio: least_ratio.to_f64(),
            least_share: least_share.to_f64(),
        }
    }

    /// The tuning of the joint map.
    pub(crate) fn config<T: Real>(&self) -> JointConfig<T> {
        let real = T::from_f64;
        JointConfig {
            birth_probability_min: real(self.birth_probability_min),
            gate: real(self.gate),
            persistence: Persistence {
                visible_s: real(self.visible_s),
                occluded_s: real(self.occluded_s),
                lifetime_s: real(self.lifetime_s),
            },
            occlusion_factor: real(self.occlusion_factor),
            least_existence: real(self.least_existence),
            least_tentative: real(self.least_tentative),
            extraction_existence: real(self.extraction_existence),
            merge_distance: real(self.merge_distance),
            plausible: Plausible::default(),
        }
    }

    /// The tuning of its hypotheses.
    pub(crate) fn hypotheses<T: Real>(&self) -> HypothesesConfig<T> {
        HypothesesConfig {
            most: self.hypotheses as usize,
            joined_sigmas: T::from_f64(self.joined_sigmas),
            least_ratio: T::from_f64(self.least_ratio),
            least_share: T::from_f64(self.least_share),
        }
    }
}

/// All parameters of a filter: models, tuning and initial pose. All numbers are in double precision, for any payload: the filter
/// rounds them like settings from any other source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header<K: Kind> {
    /// The number type of the payload.
    pub scalar: Scalar,
    /// The motion model.
    pub vehicle: K::Vehicle,
    /// Proposal density of the poses.
    pub proposal: Proposal,
    /// Components that are the estimated static features.
    pub extraction: Extraction,
    /// Whether unexplained births are delayed until the next scan.
    pub births_wait: bool,
    /// Number of scans in the stream, or [`UNKNOWN`].
    pub scans: u32,
    /// Number of predictions in the stream, or [`UNKNOWN`].
    pub predictions: u32,
    /// Maximum number of measurements in a scan, or [`UNKNOWN`].
    pub most_measurements: u32,
    /// N, the number of particles.
    pub particles: u32,
    /// M, the number of samples per particle.
    pub samples: u32,
    /// Maximum number of components in view after reduction.
    pub max_components: u32,
    /// Seed of the filter's random numbers.
    pub seed: u64,
    /// Purpose of this head.
    pub begins: Begins,
    /// Initial pose, vehicle and sensor.
    pub models: K::Models,
    /// Tuning for static features.
    pub recursion: Recursion,
    /// Tuning for moving features.
    pub moving: Moving,
    /// Tuning of the joint map, for a filter that has one.
    pub joint: Joint,
    /// Time between scans, s; the median if it varies.
    pub scan_interval_s: f64,
}

impl<K: Kind> Header<K> {
    /// Number of bytes of the head, including its checksum.
    pub const LENGTH: usize = FRONT
        + 8 * (<K::Models as Numbers>::COUNT + Recursion::COUNT + Moving::COUNT + Joint::COUNT + f64::COUNT)
        + CHECK;

    /// A head with all numbers zero, one particle, one sample, the blind proposal, extraction of the heaviest components, and
    /// unknown counts.
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

    /// Writes the head behind a record with this checksum, 0 for none. Returns the checksum of the head.
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

    /// The number type of the records behind the head at the front of `bytes`, which is decoded completely and must be that of a
    /// start or a snapshot.
    pub(crate) fn scalar_of(bytes: &[u8]) -> Result<Scalar, StreamError> {
        let (Self { begins, scalar, .. }, _) = Self::decode(&mut Bytes(bytes))?;
        if begins == Begins::Retuned { Err(StreamError::NoBeginning) } else { Ok(scalar) }
    }

    /// Takes the head from the front of `bytes`. Returns it with its checksum. Not inlined, so that its stack frame is temporary
    /// and its code exists once.
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
        let mut header = Self { vehicle, ..Self::EMPTY };
        let is_valid = header.read(choices, bytes).is_some();
        let check = bytes.u32().ok_or(StreamError::Truncated)?;
        if check != CRC.checksum(content) {
            return Err(StreamError::HeaderDamaged);
        }
        if is_valid { Ok((header, check)) } else { Err(StreamError::Header) }
    }

    /// Decodes the fields behind the choices, with the meaning of the choices; reads all of them even if a choice is unknown. In
    /// place: a head has more than half a kilobyte, and a copy would lie on the stack.
    fn read(&mut self, choices: [u8; 8], bytes: &mut Bytes<'_>) -> Option<()> {
        for count in [
            &mut self.scans,
            &mut self.predictions,
            &mut self.most_measurements,
            &mut self.particles,
            &mut self.samples,
            &mut self.max_components,
        ] {
            *count = bytes.u32()?;
        }
        self.seed = bytes.u64()?;
        let mark = Mark { scans: bytes.u32()?, parts: bytes.u32()?, digest: bytes.u64()? };
        // The checksum of the previous record is checked by the reader.
        bytes.u32()?;
        let mut number = || bytes.f64();
        self.models = Numbers::take(&mut number)?;
        self.recursion = Numbers::take(&mut number)?;
        self.moving = Numbers::take(&mut number)?;
        self.joint = Numbers::take(&mut number)?;
        self.scan_interval_s = number()?;
        let [scalar, _, 0, 0, proposal, extraction, begins, births_wait] = choices else { return None };
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
        self.proposal = match proposal {
            0 => Proposal::Blind,
            1 => Proposal::Informed,
            _ => return None,
        };
        self.extraction = match extraction {
            0 => Extraction::Heaviest,
            1 => Extraction::Peaks,
            2 => Extraction::Confirmed,
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
    use crate::planar::{Planar, Vehicle};
    use crate::underwater::{Auv, Underwater};
    use std::vec::Vec;

    /// A head in which all numbers differ.
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
    fn a_written_head_is_read() {
        comes_back(planar());
        comes_back(numbered::<Underwater>(Auv));
        assert_eq!((planar().models.start_x_m, planar().scan_interval_s), (100.5, 159.5));
        let underwater = numbered::<Underwater>(Auv);
        assert_eq!((underwater.models.start_m[0], underwater.scan_interval_s), (100.5, 188.5));
    }

    /// The positions of the documented layout.
    #[test]
    fn the_layout_is_the_documented_one() {
        let bytes = encoded(&planar());
        assert_eq!(bytes.len(), 556);
        assert_eq!(&bytes[..12], b"SCPHDLOG\x07\x00\x2c\x02");
        assert_eq!(bytes[12..20], [4, 2, 0, 0, 1, 1, 1, 1]);
        assert_eq!(bytes[20..24], [1, 0, 0, 0]);
        assert_eq!(bytes[40..44], [6, 0, 0, 0]);
        assert_eq!(bytes[44..52], [8, 7, 6, 5, 4, 3, 2, 1]);
        assert_eq!(bytes[52..72], [7, 0, 0, 0, 8, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 10, 0, 0, 0]);
        assert_eq!(bytes[72..80], 100.5_f64.to_le_bytes());
        assert_eq!(bytes[544..552], 159.5_f64.to_le_bytes());
        let head = Head::take::<Planar>(&mut Bytes(&bytes)).unwrap();
        assert_eq!((head.before, head.mark()), (10, Some(Mark { scans: 7, parts: 8, digest: 9 })));
        let bytes = encoded(&numbered::<Underwater>(Auv));
        assert_eq!(bytes.len(), 788);
        assert_eq!(bytes[10..14], [0x14, 0x03, 4, 3]);
        assert_eq!(bytes[72..80], 100.5_f64.to_le_bytes());
        assert_eq!(bytes[776..784], 188.5_f64.to_le_bytes());
    }

    #[test]
    fn all_damage_to_the_head_is_detected() {
        let good = encoded(&planar());
        for place in 0..good.len() {
            let mut bytes = good.clone();
            bytes[place] ^= 0x10;
            assert!(Header::<Planar>::decode(&mut Bytes(&bytes)).is_err(), "byte {place}");
            assert!(Header::<Planar>::decode(&mut Bytes(&good[..place])).is_err(), "cut at {place}");
        }
    }

    #[test]
    fn other_versions_vehicles_and_files_are_distinguished() {
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
