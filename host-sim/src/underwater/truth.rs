//! The part of the true map that a run has had in view.

use super::log::{Log, TruePose};
use super::record::MapFeature;
use crate::score::map_error::MapError;
use nalgebra::{Matrix3, SMatrix, Vector3, Vector4};
use scphd::rotation;

/// Which of the [stable](Log::stable) features have been shown by both images so far.
#[derive(Debug)]
pub struct Seen<'a> {
    log: &'a Log,
    features: Vec<([f64; 3], bool)>,
    cameras: [SMatrix<f64, 3, 4>; 2],
}

impl<'a> Seen<'a> {
    /// None yet.
    #[must_use]
    pub fn new(log: &'a Log) -> Self {
        let camera = |p: [[f64; 4]; 3]| SMatrix::from_fn(|row, column| p[row][column]);
        Self {
            log,
            features: log.stable().map(|position| (position, false)).collect(),
            cameras: log.camera.projections.map(camera),
        }
    }

    /// Looks around from a true pose, with the roll and pitch that the instruments say.
    pub fn look(&mut self, truth: &TruePose) {
        let row = self.log.instruments.partition_point(|row| row.t_s <= truth.t_s);
        let Some(tilt) = row.checked_sub(1).map(|row| &self.log.instruments[row]) else { return };
        let turned: Matrix3<f64> = rotation(tilt.roll_rad, tilt.pitch_rad, truth.yaw_rad);
        let ([width, height], [near, far]) = (self.log.camera.size_px, self.log.camera.depth_m);
        for (feature, seen) in self.features.iter_mut().filter(|(_, seen)| !seen) {
            let point = turned.tr_mul(&(Vector3::from(*feature) - Vector3::from(truth.position)));
            *seen = self.cameras.iter().all(|camera| {
                let pixel = camera * Vector4::new(point.x, point.y, point.z, 1.0);
                let (u, v) = (pixel.x / pixel.z, pixel.y / pixel.z);
                (near..=far).contains(&pixel.z) && (0.0..=width).contains(&u) && (0.0..=height).contains(&v)
            });
        }
    }

    /// The features seen, m.
    #[must_use]
    pub fn features(&self) -> Vec<[f64; 3]> {
        self.features.iter().filter(|(_, seen)| *seen).map(|(feature, _)| *feature).collect()
    }

    /// Distance of an estimated map to them; unknown where the log does not know its features.
    #[must_use]
    pub fn error(&self, map: &[MapFeature]) -> Option<MapError> {
        let estimate: Vec<[f64; 3]> = map.iter().map(|feature| feature.mean).collect();
        (!self.log.landmarks.is_empty()).then(|| MapError::between(&estimate, &self.features()))
    }
}
