//! What the joint filter knows, and how its places are filled and freed.

use super::mover::Mover;
use nalgebra::{DMatrix, DVector};

/// One feature, but for where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feature {
    /// Names it.
    pub label: u32,
    /// v, the probability that it is there and in sight.
    pub in_sight: f64,
    /// h, the probability that it is there and hidden.
    pub hidden: f64,
    /// g = 1 − v − h, the probability that it is not there, or moves.
    pub absent: f64,
    /// How often it was detected.
    pub detections: f64,
}

impl Feature {
    /// The probability that it is there.
    pub fn total(&self) -> f64 {
        self.in_sight + self.hidden
    }
}

/// A Gaussian over a pose and features, in the order of their places.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// The pose, with what is taken as given behind its uncertain coordinates.
    pub pose: Vec<f64>,
    /// Where every feature is, m.
    pub places: Vec<Vec<f64>>,
    /// P: the uncertain coordinates of the pose, then those of every feature.
    pub covariance: DMatrix<f64>,
    /// Whether every feature is there.
    pub features: Vec<Feature>,
    /// What may move.
    pub movers: Vec<Mover>,
    /// What the noise of the odometry has added to the covariance of the pose since the last scan.
    pub process_noise: DMatrix<f64>,
    /// Time since the last scan, s.
    pub waited_s: f64,
    /// The next feature's label.
    pub next_label: u32,
}

impl State {
    /// At a pose with so many uncertain coordinates, certain of it, without a feature.
    pub fn new(pose: Vec<f64>, uncertain: usize) -> Self {
        let covariance = DMatrix::zeros(uncertain, uncertain);
        let process_noise = covariance.clone();
        let (places, features, movers) = (Vec::new(), Vec::new(), Vec::new());
        Self { pose, places, covariance, features, movers, process_noise, waited_s: 0.0, next_label: 0 }
    }

    /// The first coordinate of a feature, or how many there are before and in so many.
    pub(super) fn first(&self, feature: usize) -> usize {
        let each = self.places.first().map_or(0, Vec::len);
        self.covariance.nrows() - each * (self.places.len() - feature)
    }

    /// Coordinates of the pose that are uncertain.
    pub(super) fn uncertain(&self) -> usize {
        self.first(0)
    }

    /// Moves everything.
    pub(super) fn inject_correction(&mut self, by: &DVector<f64>) {
        let uncertain = self.uncertain();
        self.pose.iter_mut().zip(by.iter()).take(uncertain).for_each(|(coordinate, by)| *coordinate += by);
        let coordinates = self.places.iter_mut().flatten();
        coordinates.zip(by.iter().skip(uncertain)).for_each(|(coordinate, by)| *coordinate += by);
    }

    /// Drops a feature; the last one takes its place.
    pub(super) fn drop_feature(&mut self, place: usize) {
        let (behind, each) = (self.covariance.nrows(), self.places[place].len());
        let (gap, last) = (self.first(place), behind - each);
        let from = |index: usize| if (gap..gap + each).contains(&index) { last + index - gap } else { index };
        self.covariance = DMatrix::from_fn(last, last, |row, column| self.covariance[(from(row), from(column))]);
        self.places.swap_remove(place);
        self.features.swap_remove(place);
    }
}
