//! Measurements of the pose of a planar vehicle.

use crate::Scalar;
use crate::kind::Input;
use crate::numbers::Numbers;
use crate::onboard::Refusal;
use nalgebra::{Vector1, Vector2};
use scphd::Real;
use scphd::models::{BeaconFix, HeadingFix, ModelError, Mounting, PositionFix, RangeBearing};
use scphd_vehicle::Recordable;

/// A measurement of the pose with its noise, in double precision in every stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fix {
    /// A position: [`PositionFix`].
    Position {
        /// x and y, m.
        place_m: [f64; 2],
        /// Standard deviation along both axes, m.
        sigma_m: f64,
        /// Squared Mahalanobis distance beyond which it is an outlier.
        gate: f64,
        /// Position of the antenna ahead and to the left of the pose, m.
        antenna_m: [f64; 2],
    },
    /// A heading: [`HeadingFix`].
    Heading {
        /// Heading, rad.
        heading_rad: f64,
        /// Standard deviation, rad.
        sigma_rad: f64,
        /// As for a position.
        gate: f64,
    },
    /// A beacon: [`BeaconFix`].
    Beacon {
        /// Range, m, and bearing, rad.
        measured: [f64; 2],
        /// Their standard deviations.
        sigmas: [f64; 2],
        /// As for a position.
        gate: f64,
        /// Position of the beacon, m.
        place_m: [f64; 2],
        /// Mounting of the sensor: position ahead and to the left of the pose, m; rotation to the left, rad.
        mounted: [f64; 3],
    },
}

const POSITION: u8 = 1;
const HEADING: u8 = 2;
const BEACON: u8 = 3;

impl Input for Fix {
    fn parts(&self) -> u8 {
        match self {
            Self::Position { .. } => POSITION,
            Self::Heading { .. } => HEADING,
            Self::Beacon { .. } => BEACON,
        }
    }

    fn count(parts: u8) -> Option<usize> {
        match parts {
            POSITION => Some(6),
            HEADING => Some(3),
            BEACON => Some(10),
            _ => None,
        }
    }

    fn scalar(_of_stream: Scalar) -> Scalar {
        Scalar::F64
    }

    fn put(&self, sink: &mut impl FnMut(f64)) {
        match *self {
            Self::Position { place_m: [x, y], sigma_m, gate, antenna_m: [forward, left] } => {
                [x, y, sigma_m, gate, forward, left].put(sink);
            }
            Self::Heading { heading_rad, sigma_rad, gate } => [heading_rad, sigma_rad, gate].put(sink),
            Self::Beacon { measured, sigmas, gate, place_m, mounted } => {
                [measured, sigmas].put(sink);
                gate.put(sink);
                place_m.put(sink);
                mounted.put(sink);
            }
        }
    }

    fn take(parts: u8, source: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        Some(match parts {
            POSITION => {
                let [x, y, sigma_m, gate, forward, left] = Numbers::take(source)?;
                Self::Position { place_m: [x, y], sigma_m, gate, antenna_m: [forward, left] }
            }
            HEADING => {
                let [heading_rad, sigma_rad, gate] = Numbers::take(source)?;
                Self::Heading { heading_rad, sigma_rad, gate }
            }
            _ => Self::Beacon {
                measured: Numbers::take(source)?,
                sigmas: Numbers::take(source)?,
                gate: source()?,
                place_m: Numbers::take(source)?,
                mounted: Numbers::take(source)?,
            },
        })
    }
}

impl Fix {
    /// Passes it to a filter.
    pub(crate) fn shown<T: Real>(&self, filter: &mut impl Recordable<T>) -> Result<(), Refusal> {
        let real = T::from_f64;
        let report = match *self {
            Self::Position { place_m, sigma_m, gate, antenna_m: [forward, left] } => {
                let fix = PositionFix::new(real(sigma_m))?.gated(real(gate))?;
                let fix = if [forward, left] == [0.0; 2] { fix } else { fix.mounted(real(forward), real(left))? };
                filter.observe(fix, &Vector2::from(place_m.map(real)))
            }
            Self::Heading { heading_rad, sigma_rad, gate } => {
                let fix = HeadingFix::new(real(sigma_rad))?.gated(real(gate))?;
                filter.observe(fix, &Vector1::new(real(heading_rad)))
            }
            Self::Beacon { measured, sigmas: [range, bearing], gate, place_m, mounted } => {
                let sensor = RangeBearing::new(real(range), real(bearing))?;
                let place_m = Vector2::from(place_m.map(real));
                let fix = BeaconFix { sensor, mounting: seat(mounted)?, place: place_m, gate: real(gate) };
                filter.observe(fix, &Vector2::from(measured.map(real)))
            }
        };
        report.map(drop).map_err(Refusal::Observe)
    }
}

/// A mounting: position ahead and to the left, m, and rotation to the left, rad; `None` if all are zero.
fn seat<T: Real>(seat: [f64; 3]) -> Result<Option<Mounting<T>>, ModelError> {
    let [forward, left, yaw] = seat.map(T::from_f64);
    (seat != [0.0; 3]).then(|| Mounting::in_plane(forward, left, yaw)).transpose()
}
