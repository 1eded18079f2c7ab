//! EKF SLAM, the filter that a user would try first: one Gaussian over the pose and every landmark, with all their
//! covariances, and nearest-neighbour association. A yardstick: it shares nothing with the filter of this project but the log.
//!
//! Noise is what the log states. Where a log does not say that it is simulated, the sensor's standard deviations are taken
//! half as large again, as a user does who does not trust a data sheet; where odometry noise is not stated, it is 10 % and a
//! little (`odometry`).

pub mod association;
mod covariance;
mod filter;
mod labels;
mod odometry;
#[cfg(test)]
mod tests;

pub use association::Association;
pub use filter::Ekf;
