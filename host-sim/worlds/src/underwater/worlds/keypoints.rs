//! Simulation of the stereo keypoints of a world, frame by frame.

use super::misbehaviour::Misbehaviour;
use super::plan::Plan;
use super::way::Vehicle;
use crate::scenario::worlds::{Spells, stream};
use crate::underwater::stereo::Projections;
use nalgebra::{Matrix3, Vector3};
use scphd_log::noise::Noise;

/// Duration of an interval in which a feature is not detected, s.
const SPELL_S: f64 = 3.0;
/// Share of outliers among the keypoints, and their noise in standard deviations.
const OUTLIER_SHARE: f64 = 0.02;
const OUTLIER_SIGMAS: f64 = 4.0;
/// Persistent false matches: number of new ones a second, and duration, s.
const STANDING_PER_SECOND: f64 = 0.15;
const STANDING_S: f64 = 3.0;

/// A persistent false match at a fixed position in the map.
#[derive(Debug, Clone, Copy)]
struct Ghost {
    place: Vector3<f64>,
    until_s: f64,
}

pub(super) struct Matcher<'a> {
    plan: &'a Plan,
    projections: Projections,
    misbehaviour: Misbehaviour,
    missed: Spells,
    ghosts: Vec<Ghost>,
    last_s: Option<f64>,
    detection: Noise,
    far_off: Noise,
    standing: Noise,
    clutter: Noise,
}

impl<'a> Matcher<'a> {
    pub fn new(plan: &'a Plan, misbehaviour: Misbehaviour, seed: u64) -> Self {
        let [detection, spells, far_off, standing, clutter] = [41, 42, 43, 44, 45].map(|purpose| stream(seed, purpose));
        Self {
            plan,
            projections: plan.optics.projections(),
            misbehaviour,
            missed: Spells::new(plan.features.len(), spells),
            ghosts: Vec::new(),
            last_s: None,
            detection,
            far_off,
            standing,
            clutter,
        }
    }

    /// (u_l, v_l, u_r, v_r) of all pairs of the matcher at this state, in random order.
    pub fn frame(&mut self, t_s: f64, vehicle: &Vehicle) -> Vec<[f64; 4]> {
        let plan = self.plan;
        let passed_s = self.last_s.map_or(0.0, |last_s| t_s - last_s);
        self.last_s = Some(t_s);
        self.missed.begin(t_s, passed_s, self.misbehaviour.hidden_spells.then_some(SPELL_S));
        let turned = vehicle.rotation();
        self.raise_ghosts(t_s, passed_s, vehicle, &turned);
        let mut pairs = Vec::new();
        for (index, feature) in plan.features.iter().enumerate() {
            let from = feature.position - vehicle.position;
            let behind = self.misbehaviour.occlusion && from.dot(&feature.normal) > 0.0;
            let detection =
                if self.misbehaviour.uneven_detection { feature.detectability } else { plan.detection_probability };
            let detected = self.detection.happens(detection) && !behind && !self.missed.holds(index, t_s);
            let measured = self.measured(&turned.tr_mul(&from));
            pairs.extend(measured.filter(|_| detected));
        }
        for ghost in self.ghosts.clone() {
            pairs.extend(self.measured(&turned.tr_mul(&(ghost.place - vehicle.position))));
        }
        for _ in 0..self.clutter.poisson(plan.clutter_per_scan) {
            pairs.push(self.anything());
        }
        self.clutter.shuffle(&mut pairs);
        pairs
    }

    /// Adds persistent false matches in the view of the left camera, at any depth.
    fn raise_ghosts(&mut self, t_s: f64, passed_s: f64, vehicle: &Vehicle, turned: &Matrix3<f64>) {
        self.ghosts.retain(|ghost| ghost.until_s > t_s);
        let optics = &self.plan.optics;
        for _ in 0..self.standing.poisson(STANDING_PER_SECOND * passed_s) {
            let [u, v] = optics.size_px.map(|size| self.standing.between(0.0, size));
            let depth = self.standing.between(optics.depth_m[0], optics.depth_m[1]);
            let left = &self.projections[0];
            let ray = depth * Vector3::new(u, v, 1.0) - left.column(3);
            // The calibration times a rotation: it is invertible.
            let Some(inverse) = left.fixed_view::<3, 3>(0, 0).try_inverse() else { continue };
            if self.misbehaviour.standing_clutter {
                let place = vehicle.position + turned * (inverse * ray);
                self.ghosts.push(Ghost { place, until_s: t_s + STANDING_S });
            }
        }
    }

    /// A uniform false pair.
    fn anything(&mut self) -> [f64; 4] {
        let (optics, noise) = (&self.plan.optics, &mut self.clutter);
        let [u, v] = optics.size_px.map(|size| noise.between(0.0, size));
        let [least, greatest] = optics.disparities_px();
        let row = v + noise.between(-optics.row_tolerance_px, optics.row_tolerance_px);
        [u, v, u - noise.between(least, greatest), row]
    }

    /// The measurement of a point in the vehicle's frame; `None` out of view. Uses the same number of random numbers in both
    /// cases.
    fn measured(&mut self, point: &Vector3<f64>) -> Option<[f64; 4]> {
        let far_off = self.far_off.happens(OUTLIER_SHARE) && self.misbehaviour.outliers;
        let sigma = self.plan.pixel_sigma * if far_off { OUTLIER_SIGMAS } else { 1.0 };
        let noise = [(); 4].map(|()| sigma * self.detection.normal());
        let true_pair = self.plan.optics.pair(&self.projections, point)?;
        let measured: [f64; 4] = std::array::from_fn(|k| true_pair[k] + noise[k]);
        // The matcher does not accept a greater row difference.
        ((measured[1] - measured[3]).abs() <= self.plan.optics.row_tolerance_px).then_some(measured)
    }
}
