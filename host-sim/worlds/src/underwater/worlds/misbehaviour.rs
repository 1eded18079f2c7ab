//! Errors of real instruments and cameras under water beyond white noise.

crate::switches! {
    /// The gyroscope has a bias of 0.001 rad/s (standard deviation) with a random walk of 0.0002 (rad/s)/√s.
    gyroscope_bias,
    /// The Doppler log has a scale error of 1 % (standard deviation) for each axis.
    velocity_scale,
    /// One velocity in a hundred is an outlier, with an error of the size of the vehicle's speed.
    velocity_outliers,
    /// The Doppler log loses the bottom once a minute, for 2 to 5 s.
    velocity_outages,
    /// Roll and pitch have errors of the size in the data sheet, with a correlation time of half a minute.
    tilt,
    /// The compass has a constant error of 2° (standard deviation), and iron deflects it by up to 15°.
    compass,
    /// A structure occludes features behind it.
    occlusion,
    /// Every feature has its own probability of detection, which is low for a fifth of them.
    uneven_detection,
    /// A feature is not detected for 3 s, once in 100 s.
    hidden_spells,
    /// Two keypoints in a hundred are outliers with four times the noise.
    outliers,
    /// False matches persist at fixed positions of the map for 3 s.
    standing_clutter,
}
