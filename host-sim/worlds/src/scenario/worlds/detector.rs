//! Simulation of the detections in a world, scan by scan.

use super::misbehaviour::Misbehaviour;
use super::plan::Plan;
use super::spells::Spells;
use super::stream::stream;
use libm::{asin, atan2, cos, sin};
use scphd_log::angle::wrap;
use scphd_log::noise::Noise;

/// Radius of a landmark relative to the size of the world.
const RADIUS_SHARE: f64 = 0.012;
/// Duration of an interval in which a landmark is not detected, s.
const SPELL_S: f64 = 2.0;
/// Share of outliers among the detections, and their noise in standard deviations.
const OUTLIER_SHARE: f64 = 0.02;
const OUTLIER_SIGMAS: f64 = 3.0;
/// Persistent false detections: number of new ones a second, and duration, s.
const STANDING_PER_SECOND: f64 = 0.15;
const STANDING_S: f64 = 3.0;

/// A persistent false detection.
#[derive(Debug, Clone, Copy)]
struct Ghost {
    place: [f64; 2],
    until_s: f64,
}

pub(super) struct Detector<'a> {
    plan: &'a Plan,
    misbehaviour: Misbehaviour,
    hidden: Spells,
    ghosts: Vec<Ghost>,
    last_s: Option<f64>,
    detection: Noise,
    far_off: Noise,
    standing: Noise,
    clutter: Noise,
    moving: Noise,
}

impl<'a> Detector<'a> {
    pub fn new(plan: &'a Plan, misbehaviour: Misbehaviour, seed: u64) -> Self {
        Self {
            plan,
            misbehaviour,
            hidden: Spells::new(plan.landmarks.len(), stream(seed, 7)),
            ghosts: Vec::new(),
            last_s: None,
            detection: stream(seed, 6),
            far_off: stream(seed, 8),
            standing: stream(seed, 9),
            clutter: stream(seed, 10),
            moving: stream(seed, 13),
        }
    }

    /// Range and bearing of the detections of a vehicle at `pose`, each with the label of its landmark, or −1, in random order.
    pub fn scan(&mut self, t_s: f64, pose: [f64; 3]) -> Vec<([f64; 2], i64)> {
        let pose = self.plan.sensor.mounting.seat(pose);
        let passed_s = self.last_s.map_or(0.0, |last_s| t_s - last_s);
        self.last_s = Some(t_s);
        self.hidden.begin(t_s, passed_s, self.misbehaviour.hidden_spells.then_some(SPELL_S));
        self.raise_ghosts(t_s, passed_s, pose);
        let mut detections = Vec::new();
        for (label, &landmark) in self.plan.landmarks.iter().enumerate() {
            let hidden = self.hidden.holds(label, t_s) || self.is_behind_another(pose, label);
            let detected = self.detection.happens(self.plan.detection_probability);
            let measured = self.measure(pose, landmark);
            if let Some(measured) = measured.filter(|_| detected && !hidden) {
                detections.push((measured, label as i64));
            }
        }
        for ghost in self.ghosts.clone() {
            if let Some(measured) = self.measure(pose, ghost.place) {
                detections.push((measured, -1));
            }
        }
        for _ in 0..self.clutter.poisson(self.plan.clutter_per_scan) {
            detections.push((self.anywhere(), -1));
        }
        self.clutter.shuffle(&mut detections);
        // Among the others, which are the same without moving objects.
        for mover in &self.plan.movers {
            let detected = self.moving.happens(self.plan.detection_probability);
            let noise = [self.moving.normal(), self.moving.normal()];
            let index = self.moving.between(0.0, (detections.len() + 1) as f64) as usize;
            if let Some(measured) = self.with_noise(pose, mover.at(t_s), 1.0, noise).filter(|_| detected) {
                detections.insert(index, (measured, -1));
            }
        }
        detections
    }

    fn raise_ghosts(&mut self, t_s: f64, passed_s: f64, pose: [f64; 3]) {
        self.ghosts.retain(|ghost| ghost.until_s > t_s);
        for _ in 0..self.standing.poisson(STANDING_PER_SECOND * passed_s) {
            let sensor = self.plan.sensor;
            let range = self.standing.between(sensor.range_min_m, sensor.range_max_m);
            let angle = pose[2] + self.standing.between(sensor.bearing_min_rad, sensor.bearing_max_rad);
            let place = [pose[0] + range * cos(angle), pose[1] + range * sin(angle)];
            if self.misbehaviour.standing_clutter {
                self.ghosts.push(Ghost { place, until_s: t_s + STANDING_S });
            }
        }
    }

    /// A uniform false measurement.
    fn anywhere(&mut self) -> [f64; 2] {
        let sensor = self.plan.sensor;
        let range = self.clutter.between(sensor.range_min_m, sensor.range_max_m);
        [range, self.clutter.between(sensor.bearing_min_rad, sensor.bearing_max_rad)]
    }

    /// Whether a nearer landmark occludes this one.
    fn is_behind_another(&self, [x, y, _]: [f64; 3], label: usize) -> bool {
        let radius = RADIUS_SHARE * self.plan.extent_m;
        let polar = |place: [f64; 2]| {
            let (dx, dy) = (place[0] - x, place[1] - y);
            (dx.hypot(dy), atan2(dy, dx))
        };
        let (range, bearing) = polar(self.plan.landmarks[label]);
        let hides = |&other: &[f64; 2]| {
            let (other_range, other_bearing) = polar(other);
            other_range < range && wrap(other_bearing - bearing).abs() < asin((radius / other_range).min(1.0))
        };
        self.misbehaviour.occlusion && self.plan.landmarks.iter().any(hides)
    }

    /// The measurement of a position; `None` out of view. Uses the same number of random numbers in both cases.
    fn measure(&mut self, pose: [f64; 3], place: [f64; 2]) -> Option<[f64; 2]> {
        let far_off = self.far_off.happens(OUTLIER_SHARE) && self.misbehaviour.outliers;
        let sigmas = if far_off { OUTLIER_SIGMAS } else { 1.0 };
        let noise = [self.detection.normal(), self.detection.normal()];
        self.with_noise(pose, place, sigmas, noise)
    }

    /// The measurement of a position with this noise, multiplied by `sigmas` standard deviations; `None` out of view.
    fn with_noise(&self, [x, y, heading]: [f64; 3], place: [f64; 2], sigmas: f64, noise: [f64; 2]) -> Option<[f64; 2]> {
        let (plan, sensor) = (self.plan, self.plan.sensor);
        let (dx, dy) = (place[0] - x, place[1] - y);
        let (range, bearing) = ((dx * dx + dy * dy).sqrt(), wrap(atan2(dy, dx) - heading));
        let seen = (sensor.range_min_m..=sensor.range_max_m).contains(&range)
            && (sensor.bearing_min_rad..=sensor.bearing_max_rad).contains(&bearing);
        seen.then(|| {
            [
                (range + sigmas * plan.range_sigma_m * noise[0]).abs(),
                wrap(bearing + sigmas * plan.bearing_sigma_rad * noise[1]),
            ]
        })
    }
}
