//! Faults of sensors, wheels and clocks.

use scphd::numerics::nalgebra::Vector2;
use scphd::numerics::{Noise, wrap};
use std::f32::consts::PI;

/// A fault that lasts ten seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// No fault, for comparison.
    None,
    /// The lidar repeats its last scan.
    StuckScan,
    /// All ranges are a metre too long.
    RangeBias,
    /// All bearings are wrong by ten degrees.
    BearingBias,
    /// The wheels turn twice as fast as the vehicle moves.
    Slip,
    /// The odometry reports a vehicle at rest.
    StuckOdometry,
    /// The turn rate is 0.2 rad/s too high.
    RateBias,
    /// Ten times as many false measurements.
    Clutter,
    /// One landmark in ten is detected.
    Blind,
    /// There are no scans.
    NoScans,
    /// All time stamps remain the same.
    FrozenClock,
    /// All time stamps are a minute ahead from then on.
    ClockJump,
    /// A quarter of the necessary memory, at all times.
    ShortMemory,
}

impl Fault {
    pub const ALL: [Self; 13] = [
        Self::None,
        Self::StuckScan,
        Self::RangeBias,
        Self::BearingBias,
        Self::Slip,
        Self::StuckOdometry,
        Self::RateBias,
        Self::Clutter,
        Self::Blind,
        Self::NoScans,
        Self::FrozenClock,
        Self::ClockJump,
        Self::ShortMemory,
    ];

    /// The odometry with the fault.
    pub fn odometry(self, [speed, rate]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Slip => [2.0 * speed, rate],
            Self::StuckOdometry => [0.0; 2],
            Self::RateBias => [speed, rate + 0.2],
            _ => [speed, rate],
        }
    }

    /// The scan with the fault; `[clutter, range_m]` are the number of false measurements and the range, m.
    pub fn scan(
        self,
        mut scan: Vec<Vector2<f32>>,
        last: &[Vector2<f32>],
        draws: &mut Noise,
        [clutter, range_m]: [f64; 2],
    ) -> Vec<Vector2<f32>> {
        match self {
            Self::StuckScan => return last.to_vec(),
            Self::RangeBias => scan.iter_mut().for_each(|seen| seen.x += 1.0),
            Self::BearingBias => scan.iter_mut().for_each(|seen| seen.y = wrap(seen.y + 10_f32.to_radians())),
            Self::Clutter => {
                for _ in 0..(9.0 * clutter) as usize {
                    let range = range_m as f32 * draws.uniform::<f32>();
                    scan.push(Vector2::new(range.max(0.1), PI * (2.0 * draws.uniform::<f32>() - 1.0)));
                }
                scan.truncate(crate::MEASUREMENTS);
            }
            _ => (),
        }
        scan
    }
}
