//! EKF SLAM, the filter that a user would try first: one Gaussian over the pose and all landmarks, with their covariances, and
//! nearest-neighbour association. It is a baseline, and shares only the log with the filters of this project.
//!
//! The noise is that of the log. Unless the log is simulated, the sensor's standard deviations are increased by half, as a
//! cautious user does with a data sheet; odometry noise that is not stated is 10 % and a small constant (`odometry`).

pub mod association;
mod covariance;
mod filter;
mod labels;
mod odometry;
#[cfg(test)]
mod tests;

pub use association::Association;
pub use filter::Ekf;
