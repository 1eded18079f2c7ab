//! Static landmarks at random positions along a trajectory.

use scphd_log::noise::Noise;

/// Distribution of landmarks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scatter {
    pub count: usize,
    pub seed: u64,
    /// Least and greatest distance from the path of the sensor, m.
    pub from_path_m: (f64, f64),
    /// Least distance between two, m.
    pub apart_m: f64,
    /// Least distance from the tracks of moving landmarks, m.
    pub from_tracks_m: f64,
}

impl Scatter {
    /// The landmarks (m) on both sides of `path`, at a distance from the positions in `tracks`.
    pub fn around(&self, path: &[[f64; 3]], tracks: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut noise = Noise::new(self.seed);
        let (near, far) = self.from_path_m;
        let side = |k: usize| {
            let least = path.iter().map(|pose| pose[k]).fold(f64::INFINITY, f64::min);
            let most = path.iter().map(|pose| pose[k]).fold(f64::NEG_INFINITY, f64::max);
            (least - far, most + far)
        };
        let (width, height) = (side(0), side(1));
        let squared = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
        let mut landmarks: Vec<[f64; 2]> = Vec::with_capacity(self.count);
        while landmarks.len() < self.count {
            let place = [noise.between(width.0, width.1), noise.between(height.0, height.1)];
            let to_path = path.iter().map(|pose| squared(place, [pose[0], pose[1]])).fold(f64::INFINITY, f64::min);
            let apart = |others: &[[f64; 2]], least: f64| others.iter().all(|&o| squared(place, o) >= least * least);
            if apart(&landmarks, self.apart_m)
                && (near * near..=far * far).contains(&to_path)
                && apart(tracks, self.from_tracks_m)
            {
                landmarks.push(place);
            }
        }
        landmarks
    }
}
