//! Runs of filters over logs, once for every kind of vehicle: sessions, comparisons with the reference, tuning, and Monte Carlo studies.

pub mod compare;
pub mod film;
pub mod map_truth;
pub mod monte_carlo;
pub mod session;
pub mod tally;
pub mod tune;
