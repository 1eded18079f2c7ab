//! Data of a run for the HTML page and the MCAP file, besides its record.

use scphd::Health;
use scphd_filters::slam::{STAGES, ScanOutcome};
use scphd_log::dimensions::Dimensions;
use scphd_score::record::{MapFeature, MovingFeature};

pub const FRAMES: usize = 400;
pub const PARTICLES: usize = 200;

/// Maps and particles at some scans, and health and times at all scans.
#[derive(Debug, Clone, PartialEq)]
pub struct Film<D: Dimensions> {
    chosen: Vec<usize>,
    pub frames: Vec<Frame<D>>,
    /// Health of every scan.
    pub health: Vec<Health>,
    /// Wall times of the stages of every scan, µs.
    pub stages_us: Vec<Option<[f64; STAGES]>>,
}

/// State of the filter after a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame<D: Dimensions> {
    pub scan: usize,
    pub map: Vec<MapFeature<D>>,
    pub moving: Vec<MovingFeature<D>>,
    pub particles: Vec<(D::Pose, f64)>,
    /// True moving landmarks in view, m; `None` if the log does not have them.
    pub movers: Option<Vec<D::Position>>,
}

impl<D: Dimensions> Film<D> {
    /// Creates the recorder for a run with this number of scans. It has frames of all scans, or of [`FRAMES`] evenly spaced ones,
    /// including the first and the last.
    pub fn of(scans: usize) -> Self {
        let chosen = if scans <= FRAMES {
            (0..scans).collect()
        } else {
            (0..FRAMES).map(|k| k * (scans - 1) / (FRAMES - 1)).collect()
        };
        Self { chosen, frames: Vec::new(), health: Vec::with_capacity(scans), stages_us: Vec::with_capacity(scans) }
    }

    pub fn has(&self, scan: usize) -> bool {
        self.chosen.binary_search(&scan).is_ok()
    }

    /// Number of recorded frames.
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
    fn frames_are_spaced_from_the_first_scan_to_the_last() {
        for scans in [0, 1, 5, FRAMES, FRAMES + 1, 7249] {
            let film: Film<Planar> = Film::of(scans);
            assert_eq!(film.chosen.len(), scans.min(FRAMES));
            assert!(scans == 0 || (film.has(0) && film.has(scans - 1) && !film.has(scans)));
            assert!(film.chosen.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
