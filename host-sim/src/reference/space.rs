//! The recursion in space, with an underwater vehicle and stereo pixels (chapter 7): blind proposal, single-cluster likelihood, static
//! features. Algebra, what becomes of births, reduction and selection are those of the plane.

use super::algebra::{
    apply, difference, identity, inverse, minus, plus, product, quadratic, sum, symmetrised, transformed, transpose,
};
use super::angle::wrap;
use super::draws::Draws;
use super::gaussian::{Component, ln_density};
use super::log_domain::{log_sum_exp, normalised};
use super::resample::{self, Selection};
use super::update::{after_scan, born_at};
use super::{Config, Weighing};
use std::array::from_fn;

/// Where the vehicle is: position (m), yaw (rad), yaw rate (rad/s), with roll and pitch (rad) as given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// x, y, z, m.
    pub position: [f64; 3],
    /// Yaw, rad.
    pub yaw: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Roll, rad.
    pub roll: f64,
    /// Pitch, rad.
    pub pitch: f64,
}

/// What moves the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    /// Velocity along the vehicle's axes, m/s.
    pub velocity: [f64; 3],
    /// Its covariance, m²/s².
    pub covariance: [[f64; 3]; 3],
    /// Roll and pitch at the end of the step, rad.
    pub tilt: [f64; 2],
    /// Mean yaw rate during the step with its standard deviation, rad/s.
    pub yaw_rate: Option<[f64; 2]>,
    /// z at the end of the step with its standard deviation, m.
    pub z: Option<[f64; 2]>,
}

/// A pose with its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The pose.
    pub pose: Pose,
    /// ln ζ.
    pub ln_weight: f64,
}

/// The filter in space: parameters and models.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Space {
    /// Parameters of the recursion; intensities are per px⁴. Moving features are not there.
    pub config: Config,
    /// Standard deviation of n_θ, rad/s².
    pub yaw_acceleration_sigma: f64,
    /// How long an error of the velocity lasts, s.
    pub velocity_interval_s: f64,
    /// Projection matrices of the left and the right camera; the third row of each begins with a unit vector.
    pub cameras: [[[f64; 4]; 3]; 2],
    /// R, px².
    pub noise: [[f64; 4]; 4],
    /// Greatest squared length of what no point explains of a pair.
    pub epipolar_gate: f64,
    /// Width and height of the images, and half width of their soft edge, px.
    pub image: [f64; 3],
    /// Least and greatest depth, and half width of their soft edge, m.
    pub depth: [f64; 3],
    /// p_D.
    pub detection: f64,
}

/// Rotation about one axis.
fn about(axis: usize, angle: f64) -> [[f64; 3]; 3] {
    let (sin, cos) = angle.sin_cos();
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut turned = identity();
    turned[next][next] = cos;
    turned[last][last] = cos;
    turned[next][last] = -sin;
    turned[last][next] = sin;
    turned
}

/// R(φ, ψ, θ).
fn rotation(pose: &Pose) -> [[f64; 3]; 3] {
    product(&product(&about(2, pose.yaw), &about(1, pose.pitch)), &about(0, pose.roll))
}

/// The lower triangular L with L Lᵀ = a (Cholesky).
fn lower_root(a: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut l = [[0.0; 3]; 3];
    for row in 0..3 {
        for column in 0..=row {
            let rest = a[row][column] - (0..column).map(|k| l[row][k] * l[column][k]).sum::<f64>();
            l[row][column] = if row == column { rest.sqrt() } else { rest / l[column][column] };
        }
    }
    l
}

/// The ramp from 0 to 1 around an edge.
fn ramp(inside: f64, edge: f64) -> f64 {
    if inside >= edge {
        return 1.0;
    }
    if inside <= -edge {
        return 0.0;
    }
    let t = (1.0 + inside / edge) / 2.0;
    3.0 * t * t - 2.0 * t * t * t
}

/// A component in view.
struct InView {
    prior: Component<3>,
    detection: f64,
    covariance: [[f64; 3]; 3],
    /// Of every measurement: m⁺, and ln N(z; ẑ, S).
    updated: Vec<([f64; 3], f64)>,
}

impl InView {
    fn ln_detection(&self, z: usize) -> f64 {
        self.detection.ln() + self.prior.ln_weight + self.updated[z].1
    }
}

impl Space {
    /// A sample of the transition (7.1).
    pub fn moved(&self, pose: &Pose, control: &Control, dt: f64, draws: &mut dyn Draws) -> Pose {
        let turned = rotation(pose);
        let step = apply(&turned, control.velocity).map(|v| v * dt);
        let raise = (self.velocity_interval_s / dt).max(1.0);
        let spread = transformed(&turned, &control.covariance).map(|row| row.map(|c| c * dt * dt * raise));
        let (mut mean, mut open) = (plus(pose.position, step), spread);
        if let Some([z, sigma]) = control.z {
            // The position given its third coordinate with an error.
            let gain = from_fn(|k| spread[k][2] / (spread[2][2] + sigma * sigma));
            let off = z - mean[2];
            mean = plus(mean, gain.map(|g| g * off));
            open = from_fn(|row| from_fn(|column| spread[row][column] - gain[row] * spread[2][column]));
        }
        let drawn = from_fn(|_| draws.normal());
        let position = plus(mean, apply(&lower_root(&open), drawn));

        let variance = self.yaw_acceleration_sigma.powi(2);
        let (acceleration, left, share) = match control.yaw_rate {
            Some([rate, sigma]) => {
                let gain = variance * dt * dt / (variance * dt * dt + sigma * sigma);
                (gain * (rate - pose.yaw_rate) / dt, variance * (1.0 - gain), 1.0)
            }
            None => (0.0, variance, 0.5),
        };
        let acceleration = acceleration + left.sqrt() * draws.normal();
        Pose {
            position,
            yaw: wrap(pose.yaw + pose.yaw_rate * dt + share * acceleration * dt * dt),
            yaw_rate: pose.yaw_rate + acceleration * dt,
            roll: control.tilt[0],
            pitch: control.tilt[1],
        }
    }

    /// Pixels of a point of the vehicle's frame, their derivative, and its depth before the left camera; `None` behind a camera.
    fn projected(&self, point: [f64; 3]) -> Option<([f64; 4], [[f64; 3]; 4], f64)> {
        let (mut pixels, mut slope, mut depths) = ([0.0; 4], [[0.0; 3]; 4], [0.0; 2]);
        for (side, camera) in self.cameras.iter().enumerate() {
            let [x, y, depth] = apply(camera, [point[0], point[1], point[2], 1.0]);
            if depth <= 1e-3 {
                return None;
            }
            depths[side] = depth;
            for (k, coordinate) in [x, y].into_iter().enumerate() {
                let pixel = coordinate / depth;
                pixels[2 * side + k] = pixel;
                slope[2 * side + k] = from_fn(|c| (camera[k][c] - pixel * camera[2][c]) / depth);
            }
        }
        Some((pixels, slope, depths[0]))
    }

    /// p_D of what is seen at these pixels and depth.
    fn detection_probability(&self, pixels: [f64; 4], depth: f64) -> f64 {
        let [width, height, edge] = self.image;
        let [near, far, depth_edge] = self.depth;
        let across = |pixel: f64, size: f64| ramp(pixel.min(size - pixel), edge);
        self.detection
            * across(pixels[0], width)
            * across(pixels[1], height)
            * across(pixels[2], width)
            * across(pixels[3], height)
            * ramp((depth - near).min(far - depth), depth_edge)
    }

    /// The map as one pose sees it: what is in view, and what is not.
    fn seen(&self, pose: &Pose, map: &[Component<3>], measurements: &[[f64; 4]]) -> (Vec<InView>, Vec<Component<3>>) {
        let to_body = transpose(&rotation(pose));
        let (mut in_view, mut out_of_view) = (Vec::new(), Vec::new());
        for &prior in map {
            let projected = self.projected(apply(&to_body, minus(prior.mean, pose.position)));
            let detected = projected.map(|(pixels, _, depth)| self.detection_probability(pixels, depth));
            match (projected, detected) {
                (Some((predicted, slope, _)), Some(detection)) if detection > 0.0 => {
                    let h = product(&slope, &to_body);
                    let s = sum(&transformed(&h, &prior.covariance), &self.noise);
                    let gain = product(&product(&prior.covariance, &transpose(&h)), &inverse(&s));
                    let kept = difference(&identity(), &product(&gain, &h));
                    let updated = measurements.iter().map(|&z| {
                        let innovation = minus(z, predicted);
                        (plus(prior.mean, apply(&gain, innovation)), ln_density(innovation, &s))
                    });
                    let covariance = symmetrised(&product(&kept, &prior.covariance));
                    in_view.push(InView { prior, detection, covariance, updated: updated.collect() });
                }
                _ => out_of_view.push(prior),
            }
        }
        (in_view, out_of_view)
    }

    /// ln(κ + w_b): what explains a measurement without any feature.
    fn ln_unexplained(&self) -> f64 {
        (self.config.clutter_intensity + self.config.birth_intensity).ln()
    }

    fn ln_eta(&self, in_view: &[InView], measurements: usize) -> Vec<f64> {
        let eta = |z| {
            let terms: Vec<f64> = in_view.iter().map(|j| j.ln_detection(z)).chain([self.ln_unexplained()]).collect();
            log_sum_exp(&terms)
        };
        (0..measurements).map(eta).collect()
    }

    /// ln L of one pose with its map (4.52).
    pub fn ln_likelihood(&self, pose: &Pose, map: &[Component<3>], measurements: &[[f64; 4]]) -> f64 {
        let (in_view, _) = self.seen(pose, map, measurements);
        let expected: f64 = in_view.iter().map(|j| j.detection * j.prior.weight()).sum();
        self.ln_eta(&in_view, measurements.len()).iter().sum::<f64>() - expected
    }

    /// Weighs candidates, `samples` of every particle, against the measurements.
    pub fn weigh(
        &self,
        candidates: &[Candidate],
        samples: usize,
        maps: &[Vec<Component<3>>],
        measurements: &[[f64; 4]],
    ) -> Weighing {
        let likelihood =
            |(c, candidate): (usize, &Candidate)| self.ln_likelihood(&candidate.pose, &maps[c / samples], measurements);
        let ln_likelihoods: Vec<f64> = candidates.iter().enumerate().map(likelihood).collect();
        let before: Vec<f64> = candidates.iter().map(|candidate| candidate.ln_weight).collect();
        let after: Vec<f64> = before.iter().zip(&ln_likelihoods).map(|(weight, ln_l)| weight + ln_l).collect();
        let updated = normalised(&after);
        let weights_kept = updated.is_none();
        let ln_weights = updated.or_else(|| normalised(&before)).expect("some candidate weighs something");
        Weighing { n_eff: resample::effective_number(&ln_weights), ln_likelihoods, ln_weights, weights_kept }
    }

    /// Selects the candidates that go on.
    pub fn select(&self, weighing: &Weighing, particles: usize, draws: &mut dyn Draws) -> Selection {
        resample::select(&weighing.ln_weights, weighing.n_eff, particles, self.config.resample_threshold, draws)
    }

    /// A map updated by the measurements from one pose, and reduced: components out of view, then the reduced ones, heaviest
    /// first, then the births on unexplained measurements, in the measurements' order, which wait for the next scan.
    pub fn updated(&self, pose: &Pose, map: &[Component<3>], measurements: &[[f64; 4]]) -> Vec<Component<3>> {
        let (in_view, out_of_view) = self.seen(pose, map, measurements);
        let ln_eta = self.ln_eta(&in_view, measurements.len());
        let mut persisting: Vec<Component<3>> = in_view
            .iter()
            .map(|j| Component { ln_weight: j.prior.ln_weight + (-j.detection).ln_1p(), ..j.prior })
            .collect();
        for (z, ln_eta) in ln_eta.iter().enumerate() {
            persisting.extend(in_view.iter().map(|j| Component {
                ln_weight: j.ln_detection(z) - ln_eta,
                mean: j.updated[z].0,
                covariance: j.covariance,
            }));
        }
        let places = measurements.iter().map(|&measured| self.born(pose, measured));
        let births = born_at(places, &ln_eta, self.ln_unexplained(), self.config.birth_intensity);
        after_scan(out_of_view, persisting, births, &self.config)
    }

    /// Where a pair puts a feature, and how surely (7.5); `None` where it puts none in view.
    fn born(&self, pose: &Pose, measured: [f64; 4]) -> Option<([f64; 3], [[f64; 3]; 3])> {
        let (point, by_measurement) = self.triangulated(measured)?;
        let (pixels, _, depth) = self.projected(point)?;
        if self.detection_probability(pixels, depth) <= 0.0 {
            return None;
        }
        let turned = rotation(pose);
        let mean = plus(pose.position, apply(&turned, point));
        Some((mean, transformed(&product(&turned, &by_measurement), &self.noise)))
    }

    /// (Aᵀ R⁻¹ A)⁻¹ Aᵀ R⁻¹.
    fn pseudoinverse(&self, a: &[[f64; 3]; 4]) -> [[f64; 4]; 3] {
        let weighted = product(&transpose(a), &inverse(&self.noise));
        product(&inverse(&product(&weighted, a)), &weighted)
    }

    /// The point of the vehicle's frame that a pair comes from, and its derivative: the weighted linear solution, and one step
    /// of Gauss and Newton from it.
    fn triangulated(&self, measured: [f64; 4]) -> Option<([f64; 3], [[f64; 4]; 3])> {
        let row = |k: usize| {
            let camera = &self.cameras[k / 2];
            let row: [f64; 4] = from_fn(|c| camera[k % 2][c] - measured[k] * camera[2][c]);
            ([row[0], row[1], row[2]], -row[3])
        };
        let (rows, right): ([[f64; 3]; 4], [f64; 4]) = (from_fn(|k| row(k).0), from_fn(|k| row(k).1));
        let start = apply(&self.pseudoinverse(&rows), right);
        let (pixels, slope, _) = self.projected(start)?;
        let point = plus(start, apply(&self.pseudoinverse(&slope), minus(measured, pixels)));
        let (pixels, slope, _) = self.projected(point)?;
        let mismatch = quadratic(&inverse(&self.noise), minus(measured, pixels));
        (mismatch <= self.epipolar_gate).then(|| (point, self.pseudoinverse(&slope)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::algebra::scaled;
    use super::super::tests::CONFIG;
    use super::*;

    const POSE: Pose = Pose { position: [1.0, 2.0, 3.0], yaw: 0.0, yaw_rate: 0.0, roll: 0.0, pitch: 0.0 };
    /// κ + w_b.
    const UNEXPLAINED: f64 = CONFIG.clutter_intensity + CONFIG.birth_intensity;

    /// Cameras that look along z, the right one 0.2 m beside the left one.
    fn space() -> Space {
        let camera =
            |baseline| [[500.0, 0.0, 320.0, -500.0 * baseline], [0.0, 500.0, 240.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        Space {
            config: CONFIG,
            yaw_acceleration_sigma: 0.1,
            velocity_interval_s: 0.0,
            cameras: [camera(0.0), camera(0.2)],
            noise: identity(),
            epipolar_gate: 20.0,
            image: [640.0, 480.0, 10.0],
            depth: [0.5, 20.0, 0.1],
            detection: 0.9,
        }
    }

    /// Pixels of a point of the vehicle's frame.
    fn pair(space: &Space, point: [f64; 3]) -> [f64; 4] {
        space.projected(point).expect("before both cameras").0
    }

    #[test]
    fn births_on_unexplained_pairs_wait_one_scan() {
        let space = space();
        let scan = [[0.0, 0.0, 3.0], [0.001, 0.0, 3.0]].map(|point| pair(&space, point));
        let born = space.updated(&POSE, &[], &scan);
        assert_eq!(born.len(), 2);
        for (birth, x) in born.iter().zip([1.0, 1.001]) {
            assert_eq!(birth.ln_weight, CONFIG.birth_intensity.ln() - UNEXPLAINED.ln());
            assert!((birth.mean[0] - x).abs() < 1e-9);
        }
        assert_eq!(space.updated(&POSE, &born, &[]).len(), 1);
    }

    #[test]
    fn births_on_explained_pairs_are_reduced_at_once() {
        let space = space();
        let scan = [pair(&space, [0.0, 0.0, 3.0])];
        let map = [Component { ln_weight: 0.5f64.ln(), mean: [1.0, 2.0, 6.0], covariance: scaled(1e-4, &identity()) }];
        let (in_view, _) = space.seen(&POSE, &map, &scan);
        let detected = in_view[0].ln_detection(0).exp();
        let updated = space.updated(&POSE, &map, &scan);
        assert_eq!(updated.len(), 1);
        let expected = 0.5 * 0.1 + (detected + CONFIG.birth_intensity) / (detected + UNEXPLAINED);
        assert!((updated[0].weight() - expected).abs() < 1e-13);
    }
}
