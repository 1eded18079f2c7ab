//! What a page in a browser and an MCAP file need of a run beside its record.

use scphd::Health;
use scphd_filters::slam::{STAGES, ScanOutcome};
use scphd_log::dimensions::Dimensions;
use scphd_score::record::{MapFeature, MovingFeature};

/// Pictures of a film, at most.
pub const FRAMES: usize = 400;
/// Particles of a picture, at most.
pub const PARTICLES: usize = 200;

/// Maps and particles at some scans, health and times at all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Film<D: Dimensions> {
    chosen: Vec<usize>,
    pub frames: Vec<Frame<D>>,
    /// Of every scan.
    pub health: Vec<Health>,
    /// Wall times of the stages of every scan, µs.
    pub stages_us: Vec<Option<[f64; STAGES]>>,
}

/// What the filter knew at a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame<D: Dimensions> {
    /// Its place among the scans.
    pub scan: usize,
    pub map: Vec<MapFeature<D>>,
    pub moving: Vec<MovingFeature<D>>,
    /// Pose and weight.
    pub particles: Vec<(D::Pose, f64)>,
    /// True moving landmarks in view, m; unknown where the log does not tell.
    pub movers: Option<Vec<D::Position>>,
}

impl<D: Dimensions> Film<D> {
    /// Of a run of so many scans: pictures of all, or of [`FRAMES`] that are evenly spread, the first and the last among them.
    #[must_use]
    pub fn of(scans: usize) -> Self {
        let chosen = if scans <= FRAMES {
            (0..scans).collect()
        } else {
            (0..FRAMES).map(|k| k * (scans - 1) / (FRAMES - 1)).collect()
        };
        Self { chosen, frames: Vec::new(), health: Vec::with_capacity(scans), stages_us: Vec::with_capacity(scans) }
    }

    /// Whether a scan has a picture.
    #[must_use]
    pub fn has(&self, scan: usize) -> bool {
        self.chosen.binary_search(&scan).is_ok()
    }

    /// How many pictures it has.
    #[must_use]
    pub fn pictures(&self) -> usize {
        self.frames.len()
    }

    pub(crate) fn scan(&mut self, outcome: &ScanOutcome) {
        self.health.push(outcome.health);
        self.stages_us.push(outcome.stages_us);
    }

    pub(crate) fn add(
        &mut self,
        map: Vec<MapFeature<D>>,
        moving: Vec<MovingFeature<D>>,
        mut particles: Vec<(D::Pose, f64)>,
        movers: Option<Vec<D::Position>>,
    ) {
        particles.sort_by(|a, b| b.1.total_cmp(&a.1));
        particles.truncate(PARTICLES);
        let scan = self.health.len().saturating_sub(1);
        self.frames.push(Frame { scan, map, moving, particles, movers });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_log::dimensions::Planar;

    #[test]
    fn pictures_are_spread_from_the_first_scan_to_the_last() {
        for scans in [0, 1, 5, FRAMES, FRAMES + 1, 7249] {
            let film: Film<Planar> = Film::of(scans);
            assert_eq!(film.chosen.len(), scans.min(FRAMES));
            assert!(scans == 0 || (film.has(0) && film.has(scans - 1) && !film.has(scans)));
            assert!(film.chosen.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
