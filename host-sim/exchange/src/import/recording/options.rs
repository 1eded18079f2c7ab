//! What is asked for.

/// Which time of a message counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Clock {
    /// That of its header.
    #[default]
    Header,
    /// That at which it was recorded.
    Log,
}

/// What is asked for; topics that are not named are guessed.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The text of a `log.toml`, and where it is from.
    pub head: Option<(String, String)>,
    /// The topic of the odometry.
    pub odometry: Option<String>,
    /// Topics of detections, each with the name of its sensor, which may be empty.
    pub detections: Vec<(String, String)>,
    /// The topic of fixes, or `none`.
    pub fixes: Option<String>,
    /// The topic of the true pose, or `none`.
    pub truth: Option<String>,
    /// Which time counts.
    pub clock: Clock,
    /// Whether what lies before a damage is taken.
    pub partial: bool,
    /// Which part is taken of a recording whose stamps go back, from 1 on.
    pub part: Option<usize>,
    /// Detections whose range, m, is not less are left out.
    pub range_below_m: Option<f64>,
}
