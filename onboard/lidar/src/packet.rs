//! One packet of the lidar: twelve points, as 47 bytes.

use crc::{Algorithm, Crc};

/// Number of bytes of a packet.
const LENGTH: usize = 47;
/// Number of points of a packet.
const POINTS: usize = 12;
/// Its first bytes: the mark, then the type of packet (upper three bits) with twelve points (lower five).
pub(crate) const HEADER: [u8; 2] = [0x54, 0x2c];
/// Number of bytes of a point.
const POINT_LENGTH: usize = 3;
/// Hundredths of a degree in a revolution.
pub(crate) const FULL_CIRCLE: u32 = 36_000;
/// Greatest span of a packet, hundredths of a degree: above that of the fastest motor with the lowest rate of points.
const WIDEST: u32 = 6_000;

/// The table of 256 numbers in the manual is that of x⁸+x⁶+x³+x²+1, most significant bit first, with initial value zero.
const CHECK: Crc<u8> = Crc::<u8>::new(&Algorithm {
    width: 8,
    poly: 0x4d,
    init: 0,
    refin: false,
    refout: false,
    xorout: 0,
    check: 0xc3,
    residue: 0,
});

/// One of the twelve readings of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reading {
    /// Distance, mm; 0 without a return.
    pub range_mm: u16,
    /// Intensity of the return; about 200 for white paper at 6 m, according to the manual.
    pub intensity: u8,
}

/// A reading and its direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Point {
    /// Direction clockwise from the arrow on the housing, hundredths of a degree, below 36 000.
    pub angle_cdeg: u16,
    /// The reading.
    pub reading: Reading,
}

/// A packet of the lidar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet {
    /// Rotation speed, degrees/s: 3 600 at 10 Hz.
    pub speed_degps: u16,
    /// Angle of the first reading, hundredths of a degree, clockwise.
    pub start_cdeg: u16,
    /// The readings, with a constant angle between them.
    pub readings: [Reading; POINTS],
    /// Angle of the last reading, hundredths of a degree, clockwise.
    pub end_cdeg: u16,
    /// Time of the lidar's clock, ms; it wraps at 30 000.
    pub time_ms: u16,
}

/// Errors of reading a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PacketError {
    /// The bytes do not begin with a packet header.
    #[error("the bytes do not begin with a packet header")]
    Header,
    /// The checksum is wrong: bytes were changed on the line.
    #[error("the packet is damaged")]
    Check,
    /// The checksum is right, but an angle is invalid, or the readings span more than 60°.
    #[error("the packet has invalid angles")]
    Angles,
}

impl Packet {
    /// Number of bytes of a packet.
    pub const LENGTH: usize = LENGTH;
    /// Number of readings of a packet.
    pub const POINTS: usize = POINTS;

    /// Reads a packet.
    ///
    /// # Errors
    /// The bytes are not a packet.
    pub fn parse(bytes: &[u8; LENGTH]) -> Result<Self, PacketError> {
        let [first, second, s0, s1, a0, a1, points @ .., e0, e1, t0, t1, check] = bytes;
        if [*first, *second] != HEADER {
            return Err(PacketError::Header);
        }
        let covered = bytes.split_last().map_or(&[][..], |(_, covered)| covered);
        if CHECK.checksum(covered) != *check {
            return Err(PacketError::Check);
        }
        let mut readings = [Reading::default(); POINTS];
        for (reading, bytes) in readings.iter_mut().zip(points.chunks_exact(POINT_LENGTH)) {
            if let [low, high, intensity] = *bytes {
                *reading = Reading { range_mm: u16::from_le_bytes([low, high]), intensity };
            }
        }
        let packet = Self {
            speed_degps: u16::from_le_bytes([*s0, *s1]),
            start_cdeg: u16::from_le_bytes([*a0, *a1]),
            readings,
            end_cdeg: u16::from_le_bytes([*e0, *e1]),
            time_ms: u16::from_le_bytes([*t0, *t1]),
        };
        let are_angles = [packet.start_cdeg, packet.end_cdeg].into_iter().all(|angle| u32::from(angle) < FULL_CIRCLE);
        let is_sent = are_angles && packet.span_cdeg() <= WIDEST;
        if is_sent { Ok(packet) } else { Err(PacketError::Angles) }
    }

    /// The packet as the lidar sends it: for simulators and tests.
    pub fn to_bytes(&self) -> [u8; LENGTH] {
        let mut bytes = [0; LENGTH];
        let numbers = [self.speed_degps, self.start_cdeg].into_iter().flat_map(u16::to_le_bytes);
        let readings = self.readings.iter().flat_map(|reading| {
            let [low, high] = reading.range_mm.to_le_bytes();
            [low, high, reading.intensity]
        });
        let last = [self.end_cdeg, self.time_ms].into_iter().flat_map(u16::to_le_bytes);
        let all = HEADER.into_iter().chain(numbers).chain(readings).chain(last);
        bytes.iter_mut().zip(all).for_each(|(slot, byte)| *slot = byte);
        if let Some((check, covered)) = bytes.split_last_mut() {
            *check = CHECK.checksum(covered);
        }
        bytes
    }

    /// Angle from the first reading to the last, hundredths of a degree.
    fn span_cdeg(&self) -> u32 {
        (u32::from(self.end_cdeg) + FULL_CIRCLE - u32::from(self.start_cdeg) % FULL_CIRCLE) % FULL_CIRCLE
    }

    /// Angle between readings, hundredths of a degree.
    pub fn step_cdeg(&self) -> f32 {
        self.span_cdeg() as f32 / (POINTS - 1) as f32
    }

    /// The readings with their directions, in the order of time.
    pub fn points(&self) -> impl Iterator<Item = Point> + '_ {
        let (start, span) = (u32::from(self.start_cdeg), self.span_cdeg());
        (0..).zip(&self.readings).map(move |(k, &reading)| {
            // Rounded to the nearest hundredth.
            let within = (2 * k * span + (POINTS as u32 - 1)) / (2 * (POINTS as u32 - 1));
            Point { angle_cdeg: ((start + within) % FULL_CIRCLE) as u16, reading }
        })
    }
}
