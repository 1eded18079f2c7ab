//! The simulated sensor: detections of landmarks and walkers in range, with misses and false measurements.

use crate::world::{World, distance_m};
use nalgebra::Vector2;
use scphd::Real;
use scphd::numerics::{Noise, wrap};

/// Maximum number of measurements in a scan.
pub const MEASUREMENTS: usize = 96;
/// Range, m.
pub(crate) const RANGE_M: f32 = 22.0;
/// Standard deviations of range, m, and bearing, rad.
pub(crate) const SIGMAS: [f32; 2] = [0.2, 0.015];

/// Clutter and detection probability of the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surroundings {
    /// Mean number of false measurements in a scan, 0 to 30.
    pub clutter: f32,
    /// p_D, 0.05 to 0.99.
    pub detection: f32,
}

impl Surroundings {
    /// The values that the filter assumes by default.
    pub const USUAL: Self = Self { clutter: 5.0, detection: 0.9 };

    /// Clamps to the ranges of sensor and filter; not-a-number is replaced by the default.
    #[must_use]
    pub fn bounded(self) -> Self {
        let within = |x: f32, usual: f32, low, high| if x.is_finite() { x.clamp(low, high) } else { usual };
        Self {
            clutter: within(self.clutter, Self::USUAL.clutter, 0.0, 30.0),
            detection: within(self.detection, Self::USUAL.detection, 0.05, 0.99),
        }
    }
}

/// The true source of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// False measurement.
    Clutter,
    /// Landmark.
    Landmark,
    /// Walker.
    Walker,
}

/// A scan: range (m) and bearing (rad) of each measurement. The sources are for display only; the filter does not use them.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    measurements: [Vector2<f32>; MEASUREMENTS],
    sources: [Source; MEASUREMENTS],
    count: usize,
}

impl Scan {
    /// A scan without measurements.
    pub const EMPTY: Self = Self {
        measurements: [Vector2::new(0.0, 0.0); MEASUREMENTS],
        sources: [Source::Clutter; MEASUREMENTS],
        count: 0,
    };

    /// The measurements.
    #[must_use]
    pub fn measurements(&self) -> &[Vector2<f32>] {
        self.measurements.get(..self.count).unwrap_or(&[])
    }

    /// The source of each measurement.
    pub(crate) fn sources(&self) -> impl Iterator<Item = Source> {
        self.sources.iter().take(self.count).copied()
    }

    fn push(&mut self, measurement: Vector2<f32>, source: Source) {
        let slots = self.measurements.iter_mut().zip(&mut self.sources);
        if let Some((slot, of)) = slots.into_iter().nth(self.count) {
            (*slot, *of) = (measurement, source);
            self.count += 1;
        }
    }

    /// Makes a scan of the present world.
    pub(crate) fn take(&mut self, world: &mut World, around: Surroundings) {
        self.count = 0;
        let World { landmarks, walkers, pose, draws, .. } = world;
        let landmarks = landmarks.iter().map(|place| (*place, Source::Landmark));
        let walkers = walkers.iter().map(|walker| (walker.place, Source::Walker));
        for (place, source) in landmarks.chain(walkers) {
            let range = distance_m(place, [pose.x_m, pose.y_m]);
            if range > RANGE_M || draws.uniform::<f32>() >= around.detection {
                continue;
            }
            let bearing = Real::atan2(place[1] - pose.y_m, place[0] - pose.x_m) - pose.heading_rad;
            let [range_off, bearing_off] = SIGMAS.map(|sigma| sigma * draws.normal::<f32>());
            self.push(Vector2::new((range + range_off).abs(), wrap(bearing + bearing_off)), source);
        }
        for _ in 0..poisson(around.clutter, draws) {
            let bearing = f32::PI * (2.0 * draws.uniform::<f32>() - 1.0);
            self.push(Vector2::new(RANGE_M * draws.uniform::<f32>(), bearing), Source::Clutter);
        }
    }
}

/// A Poisson number with this mean, at most [`MEASUREMENTS`]: uniform numbers are multiplied until their product is below e^−mean
/// (Knuth, *The Art of Computer Programming*, volume 2, 3.4.1).
fn poisson(mean: f32, draws: &mut Noise) -> usize {
    let least = Real::exp(-mean);
    let mut product = draws.uniform::<f32>();
    let mut count = 0;
    while product > least && count < MEASUREMENTS {
        product *= draws.uniform::<f32>();
        count += 1;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn false_measurements_are_poisson() {
        let mut draws = Noise::seeded(1);
        for mean in [0.0, 0.5, 5.0, 30.0] {
            let numbers: Vec<f64> = (0..4000).map(|_| poisson(mean, &mut draws) as f64).collect();
            let of_all = numbers.iter().sum::<f64>() / 4000.0;
            let variance = numbers.iter().map(|number| (number - of_all).powi(2)).sum::<f64>() / 4000.0;
            // Five standard deviations of the mean of 4000 numbers.
            let slack = 5.0 * (f64::from(mean) / 4000.0).sqrt() + 1e-12;
            assert!((of_all - f64::from(mean)).abs() < slack, "{mean}: {of_all}");
            assert!((variance - f64::from(mean)).abs() < 0.15 * f64::from(mean) + 1e-12, "{mean}: {variance}");
        }
    }

    #[test]
    fn the_share_of_missed_landmarks_is_the_stated_one() {
        let mut world = World::of_seed(1);
        let mut scan = Scan::EMPTY;
        let near = world.landmarks.iter().filter(|place| distance_m(**place, [0.0; 2]) <= RANGE_M).count();
        let mut seen = 0;
        for _ in 0..1000 {
            scan.take(&mut world, Surroundings { clutter: 3.0, detection: 0.7 });
            seen += scan.sources().filter(|source| *source == Source::Landmark).count();
        }
        let share = seen as f64 / (1000 * near) as f64;
        assert!(near > 5 && (share - 0.7).abs() < 0.02, "{share} of {near}");
    }

    #[test]
    fn a_scan_never_exceeds_its_capacity() {
        let mut scan = Scan::EMPTY;
        (0..2 * MEASUREMENTS).for_each(|_| scan.push(Vector2::new(1.0, 0.0), Source::Clutter));
        assert_eq!(scan.measurements().len(), MEASUREMENTS);
    }

    #[test]
    fn values_beyond_the_sliders_are_clamped() {
        let wild = Surroundings { clutter: 1e9, detection: -1.0 }.bounded();
        assert_eq!(wild, Surroundings { clutter: 30.0, detection: 0.05 });
        assert_eq!(Surroundings { clutter: f32::NAN, detection: f32::INFINITY }.bounded(), Surroundings::USUAL);
    }
}
