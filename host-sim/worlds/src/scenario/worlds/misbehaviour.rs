//! Errors of real sensors and vehicles beyond white noise.

crate::switches! {
    /// Landmarks have a width, 1.2 % of the world's size, and occlude others behind them.
    occlusion,
    /// A landmark is occluded for 2 s, once in 100 s, by something that is not a landmark.
    hidden_spells,
    /// Two detections in a hundred are outliers with three times the noise.
    outliers,
    /// The odometry has a scale error of 2 % (standard deviation) for each control.
    odometry_scale,
    /// The second control has an offset of 0.004 rad or rad/s (standard deviation).
    odometry_offset,
    /// In one row of a hundred the wheels slip, and the reported distance is up to twice the true one.
    slip,
    /// False detections persist for 3 s.
    standing_clutter,
}
