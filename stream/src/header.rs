//! The head of a stream: everything a filter has to be told before the first record.

use crate::bytes::{Bytes, CRC};
use crate::reader::StreamError;

/// The first bytes of every stream.
pub(crate) const MAGIC: [u8; 8] = *b"SCPHDLOG";
/// The version this code reads and writes.
pub(crate) const VERSION: u16 = 1;
/// A count that was not known when the head was written, as in a flight that was still going on.
pub const UNKNOWN: u32 = u32::MAX;

/// Number of the numbers of a head.
const COUNT: usize = 42;
/// Bytes before the numbers: magic, version, length, choices, counts, seed.
const FRONT: usize = 52;
/// Bytes of the whole head, its check included.
pub(crate) const LENGTH: usize = FRONT + 8 * COUNT + 4;

/// The number type of the records' payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    /// Four bytes.
    F32,
    /// Eight bytes.
    F64,
}

impl Scalar {
    /// Bytes of one number.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// The motion model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vehicle {
    /// Speed of the encoder's wheel and steering angle (5.25–5.27).
    Ackermann,
    /// Speed and turn rate, Euler step.
    Unicycle,
    /// Speed and turn rate, exact arc.
    UnicycleArc,
}

/// The particle likelihood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Likelihood {
    /// Single cluster (4.52).
    SingleCluster,
    /// RB-PHD with the empty map.
    RbEmpty,
    /// RB-PHD with a single feature.
    RbSingle,
}

/// Where poses are drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Proposal {
    /// The odometry alone.
    Blind,
    /// Odometry and scan.
    Informed,
}

/// How components are merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reduction {
    /// Vo & Ma 2006, table II.
    Greedy,
    /// By Runnalls' cost.
    Runnalls,
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

macro_rules! header {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Everything a filter has to be told before the first record: models, tuning, start. All numbers are in double
        /// precision, whatever the payload: the filter rounds them as it would round settings from anywhere else.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct Header {
            /// The number type of the payload.
            pub scalar: Scalar,
            /// The motion model.
            pub vehicle: Vehicle,
            /// The particle likelihood.
            pub likelihood: Likelihood,
            /// How components are merged.
            pub reduction: Reduction,
            /// Where poses are drawn from.
            pub proposal: Proposal,
            /// Which components are the estimated static features.
            pub extraction: Extraction,
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
            $($(#[$doc])* pub $name: f64,)*
        }

        impl Header {
            /// The numbers of the head in their order in the stream.
            fn numbers(&self) -> [f64; COUNT] {
                [$(self.$name,)*]
            }

            /// The same, for changing.
            fn numbers_mut(&mut self) -> [&mut f64; COUNT] {
                [$(&mut self.$name,)*]
            }

            /// A head with every number zero, one particle, one sample, single cluster, greedy merging, blind proposal, the heaviest
            /// extracted and unknown counts.
            pub const EMPTY: Self = Self {
                scalar: Scalar::F64,
                vehicle: Vehicle::Ackermann,
                likelihood: Likelihood::SingleCluster,
                reduction: Reduction::Greedy,
                proposal: Proposal::Blind,
                extraction: Extraction::Heaviest,
                scans: UNKNOWN,
                predictions: UNKNOWN,
                most_measurements: UNKNOWN,
                particles: 1,
                samples: 1,
                max_components: UNKNOWN,
                seed: 0,
                $($name: 0.0,)*
            };
        }
    };
}

header! {
    /// Pose at the start: x, m.
    start_x_m,
    /// Pose at the start: y, m.
    start_y_m,
    /// Pose at the start: heading, rad.
    start_heading_rad,
    /// Wheelbase L, m; this and the next three are 0 for a unicycle.
    wheelbase_m,
    /// Lateral offset H of the wheel encoder from the centreline, m.
    encoder_offset_m,
    /// Forward offset a of the sensor from the rear axle, m.
    sensor_forward_m,
    /// Leftward offset b of the sensor from the centreline, m.
    sensor_left_m,
    /// Standard deviation of the speed, m/s.
    speed_sigma_mps,
    /// Standard deviation of the speed as a share of it.
    speed_sigma_ratio,
    /// Standard deviation of the second control: steering angle, rad, or turn rate, rad/s.
    turn_sigma,
    /// Standard deviation of the second control as a share of it.
    turn_sigma_ratio,
    /// How long an odometry error lasts, s.
    noise_interval_s,
    /// Standard deviation of the range, m.
    range_sigma_m,
    /// Standard deviation of the bearing, rad.
    bearing_sigma_rad,
    /// Least range, m.
    range_min_m,
    /// Greatest range, m.
    range_max_m,
    /// Half width of the soft edges in range, m.
    range_edge_m,
    /// Middle of the bearing window, rad.
    bearing_center_rad,
    /// Half width of the bearing window, rad; π and above is a full circle.
    bearing_half_width_rad,
    /// Half width of the soft edges in bearing, rad.
    bearing_edge_rad,
    /// p_D at range zero.
    detection_near,
    /// p_D at the greatest range.
    detection_far,
    /// λ, false measurements a scan.
    clutter_per_scan,
    /// w_b, 1/(m·rad).
    birth_intensity,
    /// Resample below this N_eff / N.
    resample_threshold,
    /// Drop components below this weight.
    prune_weight,
    /// A component is confirmed where it is better known than from this many measurements.
    confirming_detections,
    /// Forget components that leave the view lighter than this and not confirmed.
    unconfirmed_weight,
    /// Misses take a confirmed component no further down than to this weight.
    confirmed_weight,
    /// Merge components within this squared Mahalanobis distance.
    merge_distance,
    /// Merge by Runnalls' cost up to this bound.
    merge_cost,
    /// Least weight of an estimated feature.
    extraction_weight,
    /// Linearisations of the informed proposal; a whole number.
    proposal_rounds,
    /// Share of the informed proposal's covariance that is drawn.
    proposal_drawn,
    /// Least share of a measurement with which a component steers the informed proposal.
    proposal_least_share,
    /// w_m, birth intensity of moving features, 1/(m·rad); 0 for none.
    moving_birth_intensity,
    /// Standard deviation of each coordinate of a new feature's velocity, m/s.
    velocity_sigma_mps,
    /// q, spectral density of the acceleration, m²/s³.
    acceleration_psd,
    /// τ, mean lifetime, s.
    lifetime_s,
    /// Forget moving components whose position has a greater standard deviation, m.
    spread_max_m,
    /// Least weight of an estimated moving feature.
    moving_extraction_weight,
    /// Time from one scan to the next, s; the median where it varies.
    scan_interval_s,
}

impl Header {
    /// The bytes of the head.
    #[must_use]
    pub fn encode(&self) -> [u8; LENGTH] {
        let mut bytes = [0; LENGTH];
        let choices = [
            self.scalar.bytes() as u8,
            match self.vehicle {
                Vehicle::Ackermann => 0,
                Vehicle::Unicycle => 1,
                Vehicle::UnicycleArc => 2,
            },
            match self.likelihood {
                Likelihood::SingleCluster => 0,
                Likelihood::RbEmpty => 1,
                Likelihood::RbSingle => 2,
            },
            match self.reduction {
                Reduction::Greedy => 0,
                Reduction::Runnalls => 1,
            },
            match self.proposal {
                Proposal::Blind => 0,
                Proposal::Informed => 1,
            },
            match self.extraction {
                Extraction::Heaviest => 0,
                Extraction::Peaks => 1,
                Extraction::Confirmed => 2,
            },
            0,
            0,
        ];
        let counts =
            [self.scans, self.predictions, self.most_measurements, self.particles, self.samples, self.max_components];
        let front = MAGIC
            .into_iter()
            .chain(VERSION.to_le_bytes())
            .chain((LENGTH as u16).to_le_bytes())
            .chain(choices)
            .chain(counts.into_iter().flat_map(u32::to_le_bytes))
            .chain(self.seed.to_le_bytes());
        let numbers = self.numbers().into_iter().flat_map(f64::to_le_bytes);
        bytes.iter_mut().zip(front.chain(numbers)).for_each(|(slot, byte)| *slot = byte);
        let (content, check) = bytes.split_at_mut(LENGTH - 4);
        check.copy_from_slice(&CRC.checksum(content).to_le_bytes());
        bytes
    }

    /// Takes the head off the front of `bytes`.
    pub(crate) fn decode(bytes: &mut Bytes<'_>) -> Result<Self, StreamError> {
        let whole = bytes.0;
        if bytes.array().ok_or(StreamError::Truncated)? != MAGIC {
            return Err(StreamError::NotAStream);
        }
        let version = bytes.u16().ok_or(StreamError::Truncated)?;
        if version != VERSION {
            return Err(StreamError::Version { found: version });
        }
        let length = usize::from(bytes.u16().ok_or(StreamError::Truncated)?);
        if length != LENGTH {
            return Err(StreamError::Header);
        }
        let content = whole.get(..LENGTH - 4).ok_or(StreamError::Truncated)?;
        let header = Self::fields(bytes).ok_or(StreamError::Header);
        let check = bytes.u32().ok_or(StreamError::Truncated)?;
        if check != CRC.checksum(content) {
            return Err(StreamError::HeaderDamaged);
        }
        header
    }

    /// What follows version and length; consumes all of it, known choices or not.
    fn fields(bytes: &mut Bytes<'_>) -> Option<Self> {
        let [scalar, vehicle, likelihood, reduction, proposal, extraction, 0, 0] = bytes.array()? else { return None };
        let mut header = Self::EMPTY;
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
        for number in header.numbers_mut() {
            *number = bytes.f64()?;
        }
        header.scalar = match scalar {
            4 => Scalar::F32,
            8 => Scalar::F64,
            _ => return None,
        };
        header.vehicle = match vehicle {
            0 => Vehicle::Ackermann,
            1 => Vehicle::Unicycle,
            2 => Vehicle::UnicycleArc,
            _ => return None,
        };
        header.likelihood = match likelihood {
            0 => Likelihood::SingleCluster,
            1 => Likelihood::RbEmpty,
            2 => Likelihood::RbSingle,
            _ => return None,
        };
        header.reduction = match reduction {
            0 => Reduction::Greedy,
            1 => Reduction::Runnalls,
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
        Some(header)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A head in which no two numbers are the same.
    fn numbered() -> Header {
        let mut header = Header {
            scalar: Scalar::F32,
            vehicle: Vehicle::UnicycleArc,
            likelihood: Likelihood::RbSingle,
            reduction: Reduction::Runnalls,
            proposal: Proposal::Informed,
            extraction: Extraction::Peaks,
            scans: 1,
            predictions: 2,
            most_measurements: 3,
            particles: 4,
            samples: 5,
            max_components: 6,
            seed: 0x0102_0304_0506_0708,
            ..Header::EMPTY
        };
        for (index, number) in header.numbers_mut().into_iter().enumerate() {
            *number = 100.5 + index as f64;
        }
        header
    }

    #[test]
    fn what_is_written_is_read() {
        let header = numbered();
        let bytes = header.encode();
        assert_eq!(Header::decode(&mut Bytes(&bytes)), Ok(header));
        assert_eq!((header.start_x_m, header.scan_interval_s), (100.5, 141.5));
    }

    /// The places of the documented layout, by hand.
    #[test]
    fn the_layout_is_the_documented_one() {
        let bytes = numbered().encode();
        assert_eq!(bytes.len(), 392);
        assert_eq!(&bytes[..12], b"SCPHDLOG\x01\x00\x88\x01");
        assert_eq!(bytes[12..20], [4, 2, 2, 1, 1, 1, 0, 0]);
        assert_eq!(bytes[20..24], [1, 0, 0, 0]);
        assert_eq!(bytes[40..44], [6, 0, 0, 0]);
        assert_eq!(bytes[44..52], [8, 7, 6, 5, 4, 3, 2, 1]);
        assert_eq!(bytes[52..60], 100.5_f64.to_le_bytes());
        assert_eq!(bytes[380..388], 141.5_f64.to_le_bytes());
    }

    #[test]
    fn every_damage_to_the_head_is_seen() {
        let good = numbered().encode();
        for place in 0..good.len() {
            let mut bytes = good;
            bytes[place] ^= 0x10;
            assert!(Header::decode(&mut Bytes(&bytes)).is_err(), "byte {place}");
            assert!(Header::decode(&mut Bytes(&good[..place])).is_err(), "cut at {place}");
        }
    }

    #[test]
    fn other_versions_and_other_files_are_told_apart() {
        let mut bytes = numbered().encode();
        bytes[8] = 2;
        assert_eq!(Header::decode(&mut Bytes(&bytes)), Err(StreamError::Version { found: 2 }));
        bytes[0] = b'X';
        assert_eq!(Header::decode(&mut Bytes(&bytes)), Err(StreamError::NotAStream));
        assert_eq!(Header::decode(&mut Bytes(b"SCPHD")), Err(StreamError::Truncated));
    }
}
