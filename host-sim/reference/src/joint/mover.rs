//! Moving-object tracks and their motion model.

use super::models::Expected;
use nalgebra::{DMatrix, DVector};

/// Parameters of moving objects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moving {
    /// w_m.
    pub birth_intensity: f64,
    /// σ_v, standard deviation of each coordinate of a new object's velocity, m/s.
    pub velocity_sigma_mps: f64,
    /// q, spectral density of the acceleration, m²/s³.
    pub acceleration_psd: f64,
    /// τ, mean lifetime, s.
    pub lifetime_s: f64,
    /// Greatest standard deviation of a coordinate of the position, m.
    pub spread_max_m: f64,
    /// Greatest number of tracks.
    pub capacity: usize,
}

/// A moving-object track.
#[derive(Debug, Clone, PartialEq)]
pub struct Mover {
    /// Label, shared with the static feature that it may be instead.
    pub label: u32,
    /// w, the probability that the object exists and moves.
    pub weight: f64,
    /// Position and velocity.
    pub mean: DVector<f64>,
    /// Their covariance relative to the pose of the last scan.
    pub covariance: DMatrix<f64>,
}

impl Mover {
    /// The coordinates of its position.
    pub(super) fn position(&self) -> &[f64] {
        &self.mean.as_slice()[..self.mean.len() / 2]
    }

    pub(crate) fn advance(&mut self, dt: f64, moving: &Moving) {
        let (all, each) = (self.mean.len(), self.mean.len() / 2);
        let of =
            |block: [[f64; 2]; 2]| {
                DMatrix::from_fn(all, all, |row, column| {
                    if row % each == column % each { block[row / each][column / each] } else { 0.0 }
                })
            };
        let f = of([[1.0, dt], [0.0, 1.0]]);
        let cross = dt.powi(2) / 2.0;
        self.mean = &f * &self.mean;
        self.covariance = &f * &self.covariance * f.transpose()
            + of([[dt.powi(3) / 3.0, cross], [cross, dt]]) * moving.acceleration_psd;
        self.weight *= (-dt / moving.lifetime_s).exp();
    }

    /// H with respect to position and velocity.
    pub(super) fn h(&self, expected: &Expected) -> DMatrix<f64> {
        let mut h = DMatrix::zeros(expected.measurement.len(), self.mean.len());
        h.columns_mut(0, expected.by_feature.ncols()).copy_from(&expected.by_feature);
        h
    }
}

/// A predicted measurement of a track: H, and R plus the covariance of the vehicle's motion since the last scan.
pub(super) struct Sight {
    pub(super) expected: Expected,
    pub(super) h: DMatrix<f64>,
    pub(super) noise: DMatrix<f64>,
}

impl Sight {
    /// S.
    pub(super) fn covariance(&self, mover: &Mover) -> DMatrix<f64> {
        &self.h * &mover.covariance * self.h.transpose() + &self.noise
    }
}
