//! Errors of real instruments and cameras under water beyond white noise.

/// The errors in a world, each with its own switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Misbehaviour {
    /// The gyroscope has a bias of 0.001 rad/s (standard deviation) with a random walk of 0.0002 (rad/s)/√s.
    pub gyroscope_bias: bool,
    /// The Doppler log has a scale error of 1 % (standard deviation) for each axis.
    pub velocity_scale: bool,
    /// One velocity in a hundred is an outlier, with an error of the size of the vehicle's speed.
    pub velocity_outliers: bool,
    /// The Doppler log loses the bottom once a minute, for 2 to 5 s.
    pub velocity_outages: bool,
    /// Roll and pitch have errors of the size in the data sheet, with a correlation time of half a minute.
    pub tilt: bool,
    /// The compass has a constant error of 2° (standard deviation), and iron deflects it by up to 15°.
    pub compass: bool,
    /// A structure occludes features behind it.
    pub occlusion: bool,
    /// Every feature has its own probability of detection, which is low for a fifth of them.
    pub uneven_detection: bool,
    /// A feature is not detected for 3 s, once in 100 s.
    pub hidden_spells: bool,
    /// Two keypoints in a hundred are outliers with four times the noise.
    pub outliers: bool,
    /// False matches persist at fixed positions of the map for 3 s.
    pub standing_clutter: bool,
}

impl Misbehaviour {
    pub const ALL: Self = Self {
        gyroscope_bias: true,
        velocity_scale: true,
        velocity_outliers: true,
        velocity_outages: true,
        tilt: true,
        compass: true,
        occlusion: true,
        uneven_detection: true,
        hidden_spells: true,
        outliers: true,
        standing_clutter: true,
    };
    pub const NONE: Self = Self {
        gyroscope_bias: false,
        velocity_scale: false,
        velocity_outliers: false,
        velocity_outages: false,
        tilt: false,
        compass: false,
        occlusion: false,
        uneven_detection: false,
        hidden_spells: false,
        outliers: false,
        standing_clutter: false,
    };
}
