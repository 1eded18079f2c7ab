//! What real instruments and cameras under water do beyond white noise.

/// What is wrong in a world, each with its own switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Misbehaviour {
    /// The gyroscope has a bias of 0.001 rad/s (standard deviation), which wanders by 0.0002 (rad/s)/√s.
    pub gyroscope_bias: bool,
    /// The Doppler log's scale is off by 1 % (standard deviation), for each axis.
    pub velocity_scale: bool,
    /// One velocity in a hundred is off by as much as the vehicle's speed.
    pub velocity_outliers: bool,
    /// The Doppler log loses the bottom once a minute, for 2 to 5 s.
    pub velocity_outages: bool,
    /// Roll and pitch are off by what the data sheet says, but for half a minute at a time.
    pub tilt: bool,
    /// The compass is off by 2° (standard deviation), and iron pulls it by up to 15°.
    pub compass: bool,
    /// A structure hides what is behind it.
    pub occlusion: bool,
    /// Every feature has a probability of detection of its own, a fifth of them a low one.
    pub uneven_detection: bool,
    /// A feature is missed for 3 s, once in 100 s.
    pub hidden_spells: bool,
    /// Two keypoints in a hundred have four times the noise.
    pub outliers: bool,
    /// False matches stand still in the map for 3 s.
    pub standing_clutter: bool,
}

impl Misbehaviour {
    /// Everything.
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
    /// Nothing.
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
