//! Options of the import.

/// Which time of a message is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Clock {
    /// The time stamp of its header.
    #[default]
    Header,
    /// The time of recording.
    Log,
}

/// Options; topics that are not named are chosen automatically.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The text of a `log.toml`, and its source.
    pub head: Option<(String, String)>,
    pub odometry: Option<String>,
    /// Topics of detections, each with the name of its sensor, which may be empty.
    pub detections: Vec<(String, String)>,
    /// The topic of fixes, or `none`.
    pub fixes: Option<String>,
    /// The topic of the true pose, or `none`.
    pub truth: Option<String>,
    pub clock: Clock,
    /// Whether the data before a damaged part are imported.
    pub partial: bool,
    /// The piece to import of a recording whose stamps go back, from 1.
    pub part: Option<usize>,
    /// Detections with this range, m, or more are left out.
    pub range_below_m: Option<f64>,
}
