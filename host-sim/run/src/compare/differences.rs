//! How far apart filter and reference are.

use serde::Serialize;

/// Why a log with fixes is refused.
pub(super) const NO_FIXES: &str = "the reference takes no fixes of the pose";

/// Largest differences between filter and reference, relative unless the name carries a unit.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Differences {
    /// Scans compared.
    pub scans: usize,
    /// Position of a candidate after a prediction, m.
    pub predicted_position_m: f64,
    /// Heading of a candidate after a prediction, rad.
    pub predicted_heading_rad: f64,
    /// Time since the last scan after a prediction, s: what moving features are predicted by.
    pub waited_s: f64,
    /// ln L of a candidate, relative to its magnitude or to 1, whichever is larger: where ln L passes through zero, this
    /// is the relative difference of L itself.
    pub ln_likelihood: f64,
    /// Weight of a particle.
    pub particle_weight: f64,
    /// Weight of a component; here and below, of the static and of the moving ones.
    pub component_weight: f64,
    /// Mean of a component: distance over distance from the origin; of a moving one also that of the velocity, likewise.
    pub mean: f64,
    /// Covariance of a component: Frobenius norm of the difference over that of the covariance.
    pub covariance: f64,
    /// N̂ of either part of a map.
    pub mass: f64,
    /// Position of the estimated pose, m.
    pub estimated_position_m: f64,
    /// Heading of the estimated pose, rad.
    pub estimated_heading_rad: f64,
    /// Scans that selected other survivors, or only one of both resampled (the reference's maps are then updated for the
    /// filter's survivors).
    pub other_survivors: usize,
    /// Static components compared.
    pub components: usize,
    /// Moving components compared.
    pub moving_components: usize,
    /// Components of either that have no counterpart: rounding decided otherwise whether to prune or to merge.
    pub unmatched: usize,
    /// Greatest share of the mass of either part of a map in such components.
    pub unmatched_mass: f64,
    /// Scans in which the filter reported a lack of room, and so was not expected to agree.
    pub capacity_events: usize,
}

impl Differences {
    /// The larger of both in every field; counts are added.
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
    /// The largest of all.
    pub overall: D,
}

pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    a.iter().map(|x| x.powi(2)).sum::<f64>().sqrt()
}

/// The larger of two differences; one that is not a number outdoes all.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

pub(super) fn relative(a: f64, b: f64) -> f64 {
    let scale = a.abs().max(b.abs());
    if a == b { 0.0 } else { (a - b).abs() / scale }
}
