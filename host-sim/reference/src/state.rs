//! The state of the filter: particles with their maps, and the candidates of the next scan. `N` is the number of coordinates of a
//! static feature, `V` that of a moving one.

use super::gaussian::Component;

/// One particle of the parent process (5.7) with its daughter process (5.8).
#[derive(Debug, Clone, PartialEq)]
pub struct Particle<P = [f64; 3], const N: usize = 2, const V: usize = 4> {
    /// Pose; in the plane x m, y m, heading rad.
    pub pose: P,
    /// ln ζ.
    pub ln_weight: f64,
    /// The static part of the map, in no particular order.
    pub map: Vec<Component<N>>,
    /// The moving part, at the time of the last scan, in no particular order.
    pub moving: Vec<Component<V>>,
}

/// A predicted pose that is to be weighed (5.12, 5.13).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate<P = [f64; 3]> {
    /// Pose; in the plane x m, y m, heading rad.
    pub pose: P,
    /// ln ζ.
    pub ln_weight: f64,
}

/// The complete state. That of another filter can be converted to it.
#[derive(Debug, Clone, PartialEq)]
pub struct State<P = [f64; 3], const N: usize = 2, const V: usize = 4> {
    /// The N particles after the last scan.
    pub particles: Vec<Particle<P, N, V>>,
    /// The N·M candidates since the first prediction after the last scan; `None` before it.
    /// Candidate `c` descends from particle `c / M`, whose map it shares.
    pub candidates: Option<Vec<Candidate<P>>>,
    /// Sum of dt of the predictions since the last scan, s: the moving parts are predicted by it later.
    pub waited_s: f64,
    /// Index of the particle whose map is the estimate.
    pub heaviest: usize,
}

impl<P: Copy, const N: usize, const V: usize> State<P, N, V> {
    /// `particles` equal particles at one pose, with empty maps.
    pub fn new(particles: usize, pose: P) -> Self {
        let particle = Particle { pose, ln_weight: -(particles as f64).ln(), map: Vec::new(), moving: Vec::new() };
        Self { particles: vec![particle; particles], candidates: None, waited_s: 0.0, heaviest: 0 }
    }

    /// The candidates that the next scan weighs or, without a prediction since the last scan, the particles.
    pub fn current(&self) -> Vec<Candidate<P>> {
        match &self.candidates {
            Some(candidates) => candidates.clone(),
            None => self
                .particles
                .iter()
                .map(|particle| Candidate { pose: particle.pose, ln_weight: particle.ln_weight })
                .collect(),
        }
    }

    /// M of the present candidates: the number for each particle.
    ///
    /// # Panics
    ///
    /// If there are no particles, or their number does not divide that of the candidates.
    pub fn samples(&self) -> usize {
        let candidates = self.candidates.as_ref().map_or(self.particles.len(), Vec::len);
        assert!(!self.particles.is_empty(), "a state has particles");
        assert!(
            candidates.is_multiple_of(self.particles.len()),
            "{candidates} candidates of {} particles",
            self.particles.len()
        );
        candidates / self.particles.len()
    }
}
