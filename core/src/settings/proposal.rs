//! Where samples are drawn from.

use crate::Real;

/// Where a particle's samples are drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Proposal<T> {
    /// From the transition density, by every prediction (5.12).
    #[default]
    Blind,
    /// From a Gaussian that the scan has been taken into, by every scan.
    Informed(Informed<T>),
}

/// Parameters of the informed proposal.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Informed<T> {
    /// Linearisations at most, 1 to 16. Associations are decided anew in each, from the pose of the one before; one that moves the pose by no
    /// more than 0.3 standard deviations of what it finds is the last.
    pub rounds: usize,
    /// Share of the Gaussian's covariance that the samples are drawn with; what is left stays with the particle, and is added to
    /// what the next motion brings. 1: samples of the posterior; 0: its mean, without drawing.
    pub sampled_fraction: T,
    /// A component speaks for a measurement if its responsibility for it, the share of it that it explains, is at least this.
    pub min_responsibility: T,
}

impl<T: Real> Default for Informed<T> {
    fn default() -> Self {
        Self { rounds: 3, sampled_fraction: T::ONE, min_responsibility: T::from_f64(0.01) }
    }
}
