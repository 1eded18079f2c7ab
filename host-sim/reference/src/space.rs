//! The recursion in space, with an underwater vehicle and stereo pixels (chapter 7): blind proposal, single-cluster likelihood,
//! static features. Algebra, treatment of births, reduction and selection are those of the plane.

use super::algebra::{apply, identity, inverse, minus, plus, product, quadratic, transformed, transpose};
use super::angle::wrap;
use super::config::Config;
use super::draws::Draws;
use super::gaussian::{Component, Density};
use super::log_domain::{log_sum_exp, normalised};
use super::pre_update::{InView, PreUpdate, kalman};
use super::recursion::Recursion;
use super::state::State;
use super::update::{after_scan, born_at, persisting};
use std::array::from_fn;

/// Pose of the vehicle: position (m), yaw (rad), yaw rate (rad/s), with known roll and pitch (rad).
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

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    /// Velocity along the vehicle's axes, m/s.
    pub velocity: [f64; 3],
    pub covariance: [[f64; 3]; 3],
    /// Roll and pitch at the end of the step, rad.
    pub tilt: [f64; 2],
    /// Mean yaw rate during the step with its standard deviation, rad/s.
    pub yaw_rate: Option<[f64; 2]>,
    /// z at the end of the step with its standard deviation, m.
    pub z: Option<[f64; 2]>,
}

/// The filter in space: parameters and models.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Space {
    /// Parameters of the recursion; intensities are per px⁴. Moving features are not supported.
    pub config: Config,
    /// Standard deviation of n_θ, rad/s².
    pub yaw_acceleration_sigma: f64,
    /// Correlation time of the velocity error, s.
    pub velocity_interval_s: f64,
    /// Projection matrices of the left and the right camera; the third row of each begins with a unit vector.
    pub cameras: [[[f64; 4]; 3]; 2],
    /// R, px².
    pub noise: [[f64; 4]; 4],
    /// Greatest squared distance of a pair from the epipolar constraint.
    pub epipolar_gate: f64,
    /// Width and height of the images, and half width of their soft edge, px.
    pub image: [f64; 3],
    /// Least and greatest depth, and half width of their soft edge, m.
    pub depth: [f64; 3],
    /// p_D.
    pub detection: f64,
}

/// Rotation about one axis.
pub(super) fn about(axis: usize, angle: f64) -> [[f64; 3]; 3] {
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
pub(super) fn rotation(pose: &Pose) -> [[f64; 3]; 3] {
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

/// The linear ramp from 0 to 1 around an edge.
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

impl Space {
    /// Pixels of a point in the vehicle's frame, their derivative, and its depth in front of the left camera; `None` behind a
    /// camera.
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

    /// p_D at these pixels and depth.
    pub(super) fn detection_probability(&self, pixels: [f64; 4], depth: f64) -> f64 {
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

    /// The map as seen from a pose: components in view, and the others.
    fn seen(&self, pose: &Pose, map: &[Component<3>], measurements: &[[f64; 4]]) -> PreUpdate<3> {
        let to_body = transpose(&rotation(pose));
        let mut seen = PreUpdate { in_view: Vec::new(), out_of_view: Vec::new() };
        for &prior in map {
            let projected = self.projected(apply(&to_body, minus(prior.mean, pose.position)));
            let detected = projected.map(|(pixels, _, depth)| self.detection_probability(pixels, depth));
            match (projected, detected) {
                (Some((predicted, slope, _)), Some(detection_probability)) if detection_probability > 0.0 => {
                    let (covariance, gain, s) = kalman(&prior, &product(&slope, &to_body), &self.noise);
                    let density = Density::new(&s);
                    let updated = measurements.iter().map(|&z| {
                        let innovation = minus(z, predicted);
                        (plus(prior.mean, apply(&gain, innovation)), density.ln(innovation))
                    });
                    seen.in_view.push(InView::new(prior, detection_probability, covariance, updated.collect()));
                }
                _ => seen.out_of_view.push(prior),
            }
        }
        seen
    }

    /// ln(κ + w_b), the intensity of a measurement without features.
    fn ln_unexplained(&self) -> f64 {
        (self.config.clutter_intensity + self.config.birth_intensity).ln()
    }

    fn ln_eta(&self, in_view: &[InView<3>], measurements: usize) -> Vec<f64> {
        let eta = |z| {
            let terms: Vec<f64> = in_view.iter().map(|j| j.ln_detection(z)).chain([self.ln_unexplained()]).collect();
            log_sum_exp(&terms)
        };
        (0..measurements).map(eta).collect()
    }

    /// The position of the feature of a pair, and its covariance (7.5); `None` if it is not in view.
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

    /// The point in the vehicle's frame that a pair determines, and its derivative: the weighted linear solution, and one
    /// Gauss-Newton step from it.
    pub(super) fn triangulated(&self, measured: [f64; 4]) -> Option<([f64; 3], [[f64; 4]; 3])> {
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

impl Recursion<3, 6> for Space {
    type Pose = Pose;
    type Control = Control;
    /// (u_l, v_l, u_r, v_r), px.
    type Measurement = [f64; 4];

    fn config(&self) -> &Config {
        &self.config
    }

    /// A sample of the transition (7.1).
    fn moved(&self, pose: &Pose, control: &Control, dt: f64, draws: &mut dyn Draws) -> Pose {
        let turned = rotation(pose);
        let step = apply(&turned, control.velocity).map(|v| v * dt);
        let raise = (self.velocity_interval_s / dt).max(1.0);
        let spread = transformed(&turned, &control.covariance).map(|row| row.map(|c| c * dt * dt * raise));
        let (mut mean, mut open) = (plus(pose.position, step), spread);
        if let Some([z, sigma]) = control.z {
            // The position conditioned on a measured third coordinate.
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

    /// Moving features are not supported.
    fn moving_now(&self, _moving: &[Component<6>], _waited_s: f64) -> Vec<Component<6>> {
        Vec::new()
    }

    fn ln_likelihood(
        &self,
        pose: &Pose,
        map: &[Component<3>],
        _moving: &[Component<6>],
        measurements: &[[f64; 4]],
    ) -> f64 {
        let PreUpdate { in_view, .. } = self.seen(pose, map, measurements);
        let expected: f64 = in_view.iter().map(|j| j.detection_probability * j.prior.weight()).sum();
        self.ln_eta(&in_view, measurements.len()).iter().sum::<f64>() - expected
    }

    fn updated_maps(
        &self,
        pose: &Pose,
        map: &[Component<3>],
        _moving: &[Component<6>],
        measurements: &[[f64; 4]],
    ) -> (Vec<Component<3>>, Vec<Component<6>>) {
        let seen = self.seen(pose, map, measurements);
        let ln_eta = self.ln_eta(&seen.in_view, measurements.len());
        let persisting = persisting(&seen, &ln_eta, self.config.remembering, self.config.prune_weight);
        let places = measurements.iter().map(|&measured| self.born(pose, measured));
        let births = born_at(places, &ln_eta, self.ln_unexplained(), self.config.birth_intensity);
        (after_scan(seen.out_of_view, persisting, births, &self.config), Vec::new())
    }

    fn estimated(&self, state: &State<Pose, 3, 6>) -> Pose {
        let candidates = state.current();
        let ln_weights: Vec<f64> = candidates.iter().map(|candidate| candidate.ln_weight).collect();
        let ln_weights = normalised(&ln_weights).expect("some candidate weighs something");
        let mean_of = |value: &dyn Fn(&Pose) -> f64| -> f64 {
            candidates.iter().zip(&ln_weights).map(|(candidate, weight)| weight.exp() * value(&candidate.pose)).sum()
        };
        Pose {
            position: from_fn(|k| mean_of(&|pose| pose.position[k])),
            yaw: mean_of(&|pose| pose.yaw.sin()).atan2(mean_of(&|pose| pose.yaw.cos())),
            yaw_rate: mean_of(&|pose| pose.yaw_rate),
            ..candidates[0].pose
        }
    }
}
