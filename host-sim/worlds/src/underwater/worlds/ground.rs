//! The surfaces with features.

use libm::{cos, sin};
use nalgebra::Vector3;
use scphd_log::noise::Noise;
use std::f64::consts::PI;

/// Share of the features around a structure that are on the floor.
const ON_THE_FLOOR: f64 = 0.25;

/// Waves of the floor, each with its height (m), its wave numbers along x and y (rad/m) and its phase (rad).
type Waves = [(f64, [f64; 2], f64); 3];

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Feature {
    pub position: Vector3<f64>,
    /// Normal of the surface: the feature is not visible from behind.
    pub normal: Vector3<f64>,
    /// Its probability of detection, if these differ between features.
    pub detectability: f64,
}

/// The floor, and a structure on it.
#[derive(Debug, Clone)]
pub(super) struct Ground {
    size_m: f64,
    floor_m: f64,
    waves: Waves,
    /// Radius and height of a structure at the centre, m.
    structure: Option<[f64; 2]>,
}

impl Ground {
    /// A floor with waves of about `rough_m`.
    pub fn relief(size_m: f64, floor_m: f64, rough_m: f64, noise: &mut Noise) -> Self {
        let waves = [(); 3].map(|()| {
            let length = noise.between(0.2, 0.6) * size_m;
            let (angle, phase) = (noise.between(-PI, PI), noise.between(-PI, PI));
            let number = 2.0 * PI / length;
            (rough_m * noise.between(0.2, 0.6), [number * cos(angle), number * sin(angle)], phase)
        });
        Self { size_m, floor_m, waves, structure: None }
    }

    /// A structure at the centre of a nearly flat floor.
    pub fn structure(size_m: f64, floor_m: f64, radius_m: f64, tall_m: f64, noise: &mut Noise) -> Self {
        Self { structure: Some([radius_m, tall_m]), ..Self::relief(size_m, floor_m, 0.02 * size_m, noise) }
    }

    pub fn feature(&self, noise: &mut Noise) -> Feature {
        match self.structure {
            Some([radius_m, tall_m]) if !noise.happens(ON_THE_FLOOR) => {
                let normal = direction(noise.between(-PI, PI));
                let out = normal * radius_m * noise.between(0.85, 1.0);
                let position = out + Vector3::new(0.0, 0.0, self.floor_m + tall_m * noise.uniform());
                Feature { position, normal, detectability: detectability(noise) }
            }
            Some([radius_m, _]) => {
                let out = direction(noise.between(-PI, PI)) * noise.between(radius_m, 0.4 * self.size_m);
                self.on_floor([out.x, out.y], noise)
            }
            None => {
                let half = 0.6 * self.size_m;
                let place = [noise.between(-half, half), noise.between(-half, half)];
                self.on_floor(place, noise)
            }
        }
    }

    fn on_floor(&self, [x, y]: [f64; 2], noise: &mut Noise) -> Feature {
        let wave = |&(size, [kx, ky], phase): &(f64, [f64; 2], f64)| size * sin(kx * x + ky * y + phase);
        let height = self.waves.iter().map(wave).sum::<f64>() + 0.002 * self.size_m * noise.normal();
        let position = Vector3::new(x, y, self.floor_m + height);
        Feature { position, normal: Vector3::z(), detectability: detectability(noise) }
    }
}

/// A probability of detection for a feature: a fifth of the features are seldom detected.
fn detectability(noise: &mut Noise) -> f64 {
    if noise.happens(0.2) { noise.between(0.2, 0.5) } else { noise.between(0.6, 0.98) }
}

/// A direction in the plane, as a vector.
fn direction(angle: f64) -> Vector3<f64> {
    Vector3::new(cos(angle), sin(angle), 0.0)
}
