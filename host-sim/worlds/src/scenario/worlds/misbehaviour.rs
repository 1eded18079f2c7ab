//! Errors of real sensors and vehicles beyond white noise.

/// The errors in a world, each with its own switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Misbehaviour {
    /// Landmarks have a width, 1.2 % of the world's size, and occlude others behind them.
    pub occlusion: bool,
    /// A landmark is occluded for 2 s, once in 100 s, by something that is not a landmark.
    pub hidden_spells: bool,
    /// Two detections in a hundred are outliers with three times the noise.
    pub outliers: bool,
    /// The odometry has a scale error of 2 % (standard deviation) for each control.
    pub odometry_scale: bool,
    /// The second control has an offset of 0.004 rad or rad/s (standard deviation).
    pub odometry_offset: bool,
    /// In one row of a hundred the wheels slip, and the reported distance is up to twice the true one.
    pub slip: bool,
    /// False detections persist for 3 s.
    pub standing_clutter: bool,
}

impl Misbehaviour {
    pub const ALL: Self = Self {
        occlusion: true,
        hidden_spells: true,
        outliers: true,
        odometry_scale: true,
        odometry_offset: true,
        slip: true,
        standing_clutter: true,
    };
    pub const NONE: Self = Self {
        occlusion: false,
        hidden_spells: false,
        outliers: false,
        odometry_scale: false,
        odometry_offset: false,
        slip: false,
        standing_clutter: false,
    };
}
