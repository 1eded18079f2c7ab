//! A log of an underwater vehicle in memory: instruments, camera and truth.

use crate::dimensions::Underwater;
use crate::log::{Scan, TruePose};

/// A rectified stereo camera fixed to the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Projection matrices of the left and the right camera: from the vehicle's frame (x ahead, y to the left, z upwards, m) to
    /// homogeneous pixels.
    pub projections: [[[f64; 4]; 3]; 2],
    /// Width and height of the images, px.
    pub size_px: [f64; 2],
    /// Independent standard deviations of (u_l, v_l, u_r, v_r), px.
    pub pixel_sigmas: [f64; 4],
    /// Standard deviations of the errors that the columns and the rows of both images have in common, px.
    pub common_sigmas: [f64; 2],
    /// Depths between which keypoints are matched, m.
    pub depth_m: [f64; 2],
    /// Focal length times baseline, px·m: depth times disparity.
    pub focal_baseline: f64,
    /// Greatest row difference of a pair that the matcher accepts, px.
    pub row_tolerance_px: f64,
}

/// Readings of the vehicle's instruments at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instruments {
    pub t_s: f64,
    /// Roll, rad, by the inertial unit.
    pub roll_rad: f64,
    /// Pitch, rad, by the inertial unit.
    pub pitch_rad: f64,
    /// Yaw, rad, by the inertial unit's compass; used by dead reckoning.
    pub yaw_rad: f64,
    /// Yaw rate until the next row, rad/s, by the inertial unit's gyroscope.
    pub yaw_rate_radps: f64,
    /// Its standard deviation, rad/s, if it is not constant.
    pub yaw_rate_sigma_radps: Option<f64>,
    /// Velocity along the vehicle's axes, m/s, by the Doppler log, if it has a measurement.
    pub velocity_mps: Option<[f64; 3]>,
    /// z, m, by the pressure sensor, if there is one.
    pub z_m: Option<f64>,
}

/// A true feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Landmark {
    pub position: [f64; 3],
    /// Probability of detection in view.
    pub detectability: f64,
}

/// Noise of the instruments, as far as the log states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nominal {
    /// Standard deviation of each velocity of the Doppler log, m/s.
    pub velocity_sigma_mps: f64,
    /// Random walk of each velocity of the vehicle, (m/s)/√s.
    pub velocity_walk_mps_rts: f64,
    pub z_sigma_m: f64,
    /// Standard deviation of the gyroscope's yaw rate, rad/s.
    pub yaw_rate_sigma_radps: f64,
    /// Standard deviation of the angular acceleration about the vertical, rad/s².
    pub yaw_acceleration_sigma_radps2: f64,
    pub detection_probability: f64,
    pub clutter_per_scan: f64,
}

impl Nominal {
    /// The noise of a log that states only that of the Doppler log (m/s), the pressure sensor (m) and the gyroscope (rad/s); the
    /// rest are defaults. The velocity of the vehicle changes as fast as it is measured, like that of a hand-held rig.
    pub const fn of_instruments(velocity_sigma_mps: f64, z_sigma_m: f64, yaw_rate_sigma_radps: f64) -> Self {
        Self {
            velocity_sigma_mps,
            velocity_walk_mps_rts: 1.0,
            z_sigma_m,
            yaw_rate_sigma_radps,
            yaw_acceleration_sigma_radps2: 10.0,
            detection_probability: 0.85,
            clutter_per_scan: 0.5,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    pub name: String,
    pub camera: Camera,
    pub nominal: Nominal,
    /// Position (m) and yaw (rad) at the first row of the instruments.
    pub start: ([f64; 3], f64),
    /// Whether the log is simulated, so that its nominal noise is exact.
    pub simulated: bool,
    /// Readings of the instruments, in order of time.
    pub instruments: Vec<Instruments>,
    /// Pairs of images in order of time, possibly without keypoints.
    pub scans: Vec<Scan<Underwater>>,
    /// True trajectory in order of time; empty if unknown.
    pub truth: Vec<TruePose<Underwater>>,
    /// True features; empty if unknown.
    pub landmarks: Vec<Landmark>,
}

impl Log {
    /// Features that are detected at least every other time, which a map should have.
    pub fn stable(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.landmarks.iter().filter(|landmark| landmark.is_stable()).map(|landmark| landmark.position)
    }
}

impl Landmark {
    /// Whether it is detected at least every other time.
    pub fn is_stable(&self) -> bool {
        self.detectability >= 0.5
    }
}
