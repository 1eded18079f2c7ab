//! Proposal densities.

use crate::Real;

/// Proposal density from which the samples of a particle are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Proposal<T> {
    /// Blind (bootstrap) proposal: every prediction draws from the transition density (5.12).
    #[default]
    Blind,
    /// Informed proposal: every scan draws from a Gaussian that was updated with this scan.
    Informed(Informed<T>),
}

/// Parameters of the informed proposal.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Informed<T> {
    /// Maximum number of linearisations, 1 to 16. Each repeats the data association at the pose of the previous one; iteration
    /// stops when the pose moves by at most 0.3 standard deviations of the result.
    pub rounds: usize,
    /// Fraction of the Gaussian's covariance with which the samples are drawn; the rest remains the covariance of the particle and
    /// is added to that of the next motion. 1: samples of the posterior; 0: its mean, without sampling.
    pub sampled_fraction: T,
    /// Minimum association probability (responsibility) of a component and a measurement for the measurement to correct the pose
    /// through this component.
    pub min_responsibility: T,
}

impl<T: Real> Default for Informed<T> {
    fn default() -> Self {
        Self { rounds: 3, sampled_fraction: T::ONE, min_responsibility: T::from_f64(0.01) }
    }
}
