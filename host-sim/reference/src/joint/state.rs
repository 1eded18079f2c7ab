//! The state of the joint filter, and the indices of its coordinates.

use super::mover::Mover;
use nalgebra::{DMatrix, DVector};

/// A feature, without its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feature {
    pub label: u32,
    /// v, the probability that it exists and is visible.
    pub in_sight: f64,
    /// h, the probability that it exists and is occluded.
    pub hidden: f64,
    /// g = 1 − v − h, the probability that it does not exist, or moves.
    pub absent: f64,
    /// Expected number of detections.
    pub detections: f64,
}

impl Feature {
    /// The existence probability.
    pub fn total(&self) -> f64 {
        self.in_sight + self.hidden
    }
}

/// A Gaussian over a pose and features, in the order of their indices.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// The pose: the uncertain coordinates, then the known ones.
    pub pose: Vec<f64>,
    /// Position of every feature, m.
    pub places: Vec<Vec<f64>>,
    /// P: the uncertain coordinates of the pose, then those of every feature.
    pub covariance: DMatrix<f64>,
    /// Existence of every feature.
    pub features: Vec<Feature>,
    /// Moving-object tracks.
    pub movers: Vec<Mover>,
    /// Process noise of the odometry in the covariance of the pose since the last scan.
    pub process_noise: DMatrix<f64>,
    /// Time since the last scan, s.
    pub waited_s: f64,
    /// Label of the next feature.
    pub next_label: u32,
}

impl State {
    /// The state at a certain pose with this number of uncertain coordinates, without features.
    pub fn new(pose: Vec<f64>, uncertain: usize) -> Self {
        let covariance = DMatrix::zeros(uncertain, uncertain);
        let process_noise = covariance.clone();
        let (places, features, movers) = (Vec::new(), Vec::new(), Vec::new());
        Self { pose, places, covariance, features, movers, process_noise, waited_s: 0.0, next_label: 0 }
    }

    /// Index of the first coordinate of a feature; for the number of features, the number of all coordinates.
    pub(super) fn first(&self, feature: usize) -> usize {
        let each = self.places.first().map_or(0, Vec::len);
        self.covariance.nrows() - each * (self.places.len() - feature)
    }

    /// Number of uncertain coordinates of the pose.
    pub(super) fn uncertain(&self) -> usize {
        self.first(0)
    }

    /// Applies a correction to all coordinates.
    pub(super) fn inject_correction(&mut self, by: &DVector<f64>) {
        let uncertain = self.uncertain();
        self.pose.iter_mut().zip(by.iter()).take(uncertain).for_each(|(coordinate, by)| *coordinate += by);
        let coordinates = self.places.iter_mut().flatten();
        coordinates.zip(by.iter().skip(uncertain)).for_each(|(coordinate, by)| *coordinate += by);
    }

    /// Removes a feature; the last one moves to its index.
    pub(super) fn drop_feature(&mut self, place: usize) {
        let (behind, each) = (self.covariance.nrows(), self.places[place].len());
        let (gap, last) = (self.first(place), behind - each);
        let from = |index: usize| if (gap..gap + each).contains(&index) { last + index - gap } else { index };
        self.covariance = DMatrix::from_fn(last, last, |row, column| self.covariance[(from(row), from(column))]);
        self.places.swap_remove(place);
        self.features.swap_remove(place);
    }
}
