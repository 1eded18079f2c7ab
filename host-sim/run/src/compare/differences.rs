//! Differences between filter and reference.

use serde::Serialize;

/// Reason for refusing a log with fixes.
pub(super) const NO_FIXES: &str = "the reference takes no fixes of the pose";

/// Largest differences between filter and reference, relative unless the name has a unit.
/// `docs/results.md` defines the keys.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Differences {
    pub scans: usize,
    pub predicted_position_m: f64,
    pub predicted_heading_rad: f64,
    pub waited_s: f64,
    pub ln_likelihood: f64,
    pub particle_weight: f64,
    pub component_weight: f64,
    pub mean: f64,
    pub covariance: f64,
    pub mass: f64,
    pub estimated_position_m: f64,
    pub estimated_heading_rad: f64,
    pub other_survivors: usize,
    pub components: usize,
    pub moving_components: usize,
    pub unmatched: usize,
    pub unmatched_mass: f64,
    pub capacity_events: usize,
}

impl Differences {
    /// The greater value of every field; counts are added.
    pub(super) fn merge(&mut self, other: &Self) {
        let larger = |into: &mut f64, value: f64| *into = larger(*into, value);
        larger(&mut self.predicted_position_m, other.predicted_position_m);
        larger(&mut self.predicted_heading_rad, other.predicted_heading_rad);
        larger(&mut self.waited_s, other.waited_s);
        larger(&mut self.ln_likelihood, other.ln_likelihood);
        larger(&mut self.particle_weight, other.particle_weight);
        larger(&mut self.component_weight, other.component_weight);
        larger(&mut self.mean, other.mean);
        larger(&mut self.covariance, other.covariance);
        larger(&mut self.mass, other.mass);
        larger(&mut self.estimated_position_m, other.estimated_position_m);
        larger(&mut self.estimated_heading_rad, other.estimated_heading_rad);
        larger(&mut self.unmatched_mass, other.unmatched_mass);
        self.scans += other.scans;
        self.other_survivors += other.other_survivors;
        self.components += other.components;
        self.moving_components += other.moving_components;
        self.unmatched += other.unmatched;
        self.capacity_events += other.capacity_events;
    }
}

/// A comparison over a whole log.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison<D = Differences> {
    /// One row a scan.
    pub scans: Vec<D>,
    /// The largest differences of all scans.
    pub overall: D,
}

pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    a.iter().map(|x| x.powi(2)).sum::<f64>().sqrt()
}

/// The greater of two differences; NaN is the greatest.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

pub(super) fn relative(a: f64, b: f64) -> f64 {
    let scale = a.abs().max(b.abs());
    if a == b { 0.0 } else { (a - b).abs() / scale }
}
