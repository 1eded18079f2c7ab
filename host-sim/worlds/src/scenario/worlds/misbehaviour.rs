//! What real sensors and vehicles do beyond white noise.

/// What is wrong in a world, each with its own switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Misbehaviour {
    /// Landmarks have a width, 1.2 % of the world's, and hide what is behind.
    pub occlusion: bool,
    /// A landmark is hidden by something that is no landmark for 2 s, once in 100 s.
    pub hidden_spells: bool,
    /// Two detections in a hundred have three times the noise.
    pub outliers: bool,
    /// Odometry's scale is off by 2 % (standard deviation), for either control.
    pub odometry_scale: bool,
    /// The second control is off by 0.004 rad or rad/s (standard deviation).
    pub odometry_offset: bool,
    /// In one row of a hundred the wheels slip: they tell of up to twice the way.
    pub slip: bool,
    /// False returns stand still for 3 s.
    pub standing_clutter: bool,
}

impl Misbehaviour {
    /// Everything.
    pub const ALL: Self = Self {
        occlusion: true,
        hidden_spells: true,
        outliers: true,
        odometry_scale: true,
        odometry_offset: true,
        slip: true,
        standing_clutter: true,
    };
    /// Nothing.
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
