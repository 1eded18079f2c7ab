//! The filter.

use super::association::{Association, CLEANING_SCANS, FEWEST_SIGHTS, GATE, NEW, PROBATION_SCANS};
use super::covariance::Covariance;
use super::labels;
use super::odometry::OdometryNoise;
use crate::slam::contract::{PoseAndCovariance, Refusal, ScanOutcome, Slam, no_sensor};
use libm::{atan2, cos, sin};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, RowVector2, SMatrix, Vector2, Vector3};
use scphd::errors::Implausible;
use scphd_log::angle::wrap;
use scphd_log::log::{FixNoise, Log, Mounting, PoseFix, Vehicle};
use scphd_score::record::MapFeature;

/// Factor for the standard deviations of a data sheet, as a cautious user would choose.
const DISTRUST: f64 = 1.5;
/// Step of the central differences of the motion model, in the unit of each variable.
const STEP: f64 = 1e-5;
/// Number of variables of the pose.
const POSE: usize = 3;

/// Data of a landmark besides its variables in the state.
#[derive(Debug, Clone, Copy)]
struct Landmark {
    label: Option<i64>,
    sights: u32,
    born: usize,
}

/// Data of a sensor.
#[derive(Debug, Clone, Copy)]
struct Eye {
    mounting: Mounting,
    /// Variances of range, m², and bearing, rad².
    noise: Vector2<f64>,
    /// Standard deviation of the range divided by the range; adds in quadrature.
    range_sigma_ratio: f64,
}

impl Eye {
    /// R of a measurement with this predicted range, m.
    fn noise_at(&self, range: f64) -> Matrix2<f64> {
        let growing = Vector2::new((self.range_sigma_ratio * range).powi(2), 0.0);
        Matrix2::from_diagonal(&(self.noise + growing))
    }
}

/// EKF SLAM over one log.
#[derive(Debug)]
pub struct Ekf {
    vehicle: Vehicle,
    odometry: OdometryNoise,
    eyes: Vec<Eye>,
    fixes: FixNoise,
    association: Association,
    /// Labels of the detections of every scan, only for static landmarks; used for [`Association::Known`] only.
    labels: Vec<Vec<Option<i64>>>,
    /// State: x m, y m, heading rad, then x and y of every landmark.
    state: Vec<f64>,
    covariance: Covariance,
    landmarks: Vec<Landmark>,
    scans: usize,
}

/// A detection associated with a landmark.
struct Pairing {
    landmark: usize,
    /// ∂h by the pose and by the landmark.
    jacobian: SMatrix<f64, 2, 5>,
    innovation: Vector2<f64>,
    /// S⁻¹.
    information: Matrix2<f64>,
    /// νᵀ S⁻¹ ν.
    distance: f64,
}

impl Ekf {
    /// Starts at the log's initial pose, which is certain, with an empty map.
    pub fn start(log: &Log, association: Association) -> Result<Self, Refusal> {
        let labels = match association {
            Association::NearestNeighbour => Vec::new(),
            Association::Known => labels::of(log).ok_or_else(|| {
                Refusal("the log has no label_landmark or label_subject column to tell the associations from".into())
            })?,
        };
        let trust = if log.simulated { 1.0 } else { DISTRUST };
        let eyes = log.sensors().map(|(_, sensor, nominal)| {
            let noise = Vector2::from(nominal.sigmas(sensor)).map(|sigma| (trust * sigma).powi(2));
            let range_sigma_ratio = trust * nominal.range_sigma_ratio;
            Eye { mounting: sensor.mounting, noise, range_sigma_ratio }
        });
        let FixNoise { position_sigma_m, heading_sigma_rad, .. } = log.fix_noise;
        Ok(Self {
            vehicle: log.vehicle,
            odometry: OdometryNoise::of(log),
            eyes: eyes.collect(),
            fixes: FixNoise {
                position_sigma_m: position_sigma_m.map(|sigma| trust * sigma),
                heading_sigma_rad: heading_sigma_rad.map(|sigma| trust * sigma),
                ..log.fix_noise
            },
            association,
            labels,
            state: log.initial_pose.to_vec(),
            covariance: Covariance::zero(POSE),
            landmarks: Vec::new(),
            scans: 0,
        })
    }

    #[cfg(test)]
    pub(super) fn landmarks(&self) -> usize {
        self.landmarks.len()
    }

    fn pose_mean(&self) -> [f64; POSE] {
        [self.state[0], self.state[1], self.state[2]]
    }

    /// The sensor's pose, and its offset from the vehicle's position, m.
    fn seat(&self, mounting: &Mounting) -> ([f64; POSE], [f64; 2]) {
        let [x, y, _] = self.pose_mean();
        let seat = mounting.seat(self.pose_mean());
        (seat, [seat[0] - x, seat[1] - y])
    }

    /// Innovation of a detection for landmark `landmark`; `None` if S is singular.
    fn pair(&self, eye: &Eye, landmark: usize, detection: [f64; 2]) -> Option<Pairing> {
        let at = POSE + 2 * landmark;
        let ([x, y, heading], [lever_x, lever_y]) = self.seat(&eye.mounting);
        let (dx, dy) = (self.state[at] - x, self.state[at + 1] - y);
        let squared = (dx * dx + dy * dy).max(1e-9);
        let range = squared.sqrt();
        // A rotation of the vehicle moves the sensor on a circle around it.
        let swing = [dx * lever_y - dy * lever_x, -(dx * lever_x + dy * lever_y)];
        #[rustfmt::skip]
        let jacobian = SMatrix::<f64, 2, 5>::new(
            -dx / range, -dy / range, swing[0] / range, dx / range, dy / range,
            dy / squared, -dx / squared, swing[1] / squared - 1.0, -dy / squared, dx / squared,
        );
        let block = self.covariance.block([0, 1, 2, at, at + 1]);
        let noise = eye.noise_at(range);
        let information = (jacobian * block * jacobian.transpose() + noise).try_inverse()?;
        let innovation = Vector2::new(detection[0] - range, wrap(detection[1] - (atan2(dy, dx) - heading)));
        let distance = innovation.dot(&(information * innovation));
        Some(Pairing { landmark, jacobian, innovation, information, distance })
    }

    fn nearest(&self, eye: &Eye, detection: [f64; 2]) -> Option<Pairing> {
        let pairings = (0..self.landmarks.len()).filter_map(|landmark| self.pair(eye, landmark, detection));
        pairings.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// The Kalman update of the whole state by a measurement of these variables.
    fn correct<const N: usize>(
        &mut self,
        variables: [usize; N],
        jacobian: &SMatrix<f64, 2, N>,
        information: &Matrix2<f64>,
        innovation: &Vector2<f64>,
    ) {
        // P Hᵀ and the gain P Hᵀ S⁻¹, row by row.
        let cross: Vec<RowVector2<f64>> = (0..self.covariance.side())
            .map(|row| (jacobian * self.covariance.row(row, variables)).transpose())
            .collect();
        let gain: Vec<RowVector2<f64>> = cross.iter().map(|row| row * information).collect();
        let step: Vec<f64> = gain.iter().map(|gain| (gain * innovation).x).collect();
        self.state.iter_mut().zip(&step).for_each(|(variable, step)| *variable += step);
        self.state[2] = wrap(self.state[2]);
        self.covariance.subtract(&gain, &cross);
        if self.association == Association::Known {
            self.covariance.shear(2, &turned(&step));
        }
    }

    /// Adds a landmark at the position of a detection, with its covariances to the state.
    fn add(&mut self, eye: &Eye, [range, bearing]: [f64; 2], label: Option<i64>) {
        let ([x, y, heading], [lever_x, lever_y]) = self.seat(&eye.mounting);
        let (s, c) = (sin(heading + bearing), cos(heading + bearing));
        let by_pose = Matrix2x3::new(1.0, 0.0, -range * s - lever_y, 0.0, 1.0, range * c + lever_x);
        let by_measurement = Matrix2::new(c, -range * s, s, range * c);
        let old = self.covariance.side();
        let mut covariance = self.covariance.grown(2);
        for column in 0..old {
            let cross = by_pose * self.covariance.row(column, [0, 1, 2]);
            covariance.set(old, column, cross.x);
            covariance.set(old + 1, column, cross.y);
        }
        let noise = eye.noise_at(range);
        let own = by_pose * self.covariance.block([0, 1, 2]) * by_pose.transpose()
            + by_measurement * noise * by_measurement.transpose();
        for (row, column) in [(0, 0), (0, 1), (1, 1)] {
            covariance.set(old + row, old + column, own[(row, column)]);
        }
        self.covariance = covariance;
        self.state.extend([x + range * c, y + range * s]);
        self.landmarks.push(Landmark { label, sights: 1, born: self.scans });
    }

    /// Removes landmarks with too few detections.
    fn drop_clutter(&mut self) {
        let stays =
            |landmark: &Landmark| landmark.sights >= FEWEST_SIGHTS || self.scans - landmark.born <= PROBATION_SCANS;
        let kept: Vec<usize> = (0..self.landmarks.len()).filter(|&k| stays(&self.landmarks[k])).collect();
        if kept.len() == self.landmarks.len() {
            return;
        }
        let places = kept.iter().flat_map(|k| [POSE + 2 * k, POSE + 2 * k + 1]);
        let variables: Vec<usize> = (0..POSE).chain(places).collect();
        self.covariance = self.covariance.keep(&variables);
        self.state = variables.iter().map(|&variable| self.state[variable]).collect();
        self.landmarks = kept.iter().map(|&k| self.landmarks[k]).collect();
    }
}

/// By how much a turn of vehicle and map about the origin moves each variable more after this step than before it, for each radian.
///
/// No measurement of landmarks observes such a turn. In the error coordinates of the invariant filter (Barrau & Bonnabel 2015) it
/// stays unobserved after every step; a plain EKF takes each step for information on the heading.
fn turned(step: &[f64]) -> Vec<f64> {
    let mut by = vec![0.0; step.len()];
    for x in std::iter::once(0).chain((POSE..step.len()).step_by(2)) {
        (by[x], by[x + 1]) = (-step[x + 1], step[x]);
    }
    by
}

fn entries<const N: usize>(matrix: &SMatrix<f64, N, N>) -> [[f64; N]; N] {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}

impl Slam for Ekf {
    fn predict(&mut self, control: [f64; 3], dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        // Implausible odometry is rejected as by the other filters.
        if let Some(what) = self.vehicle.implausible(control, dt_s) {
            return Ok(Some(what));
        }
        let pose = self.pose_mean();
        let step = |pose, control| self.vehicle.step(pose, control, dt_s);
        let slope = |[x, y, h]: [f64; POSE], [x0, y0, h0]: [f64; POSE]| {
            Vector3::new(x - x0, y - y0, wrap(h - h0)) / (2.0 * STEP)
        };
        let nudged = |from: f64, k: usize, at: usize, by: f64| if k == at { from + by } else { from };
        let by_pose = Matrix3::from_columns(&[0, 1, 2].map(|at| {
            let nudge = |by| std::array::from_fn(|k| nudged(pose[k], k, at, by));
            slope(step(nudge(STEP), control), step(nudge(-STEP), control))
        }));
        let by_control = Matrix3::from_columns(&[0, 1, 2].map(|at| {
            let nudge = |by| std::array::from_fn(|k| nudged(control[k], k, at, by));
            slope(step(pose, nudge(STEP)), step(pose, nudge(-STEP)))
        }));
        let variances = Matrix3::from_diagonal(&self.odometry.variances(control, dt_s));
        let moved = step(pose, control);
        self.state[..POSE].copy_from_slice(&moved);
        let before = self.covariance.block([0, 1, 2]);
        let after = by_pose * before * by_pose.transpose() + by_control * variances * by_control.transpose();
        for column in POSE..self.covariance.side() {
            let cross = by_pose * self.covariance.row(column, [0, 1, 2]);
            (0..POSE).for_each(|row| self.covariance.set(row, column, cross[row]));
        }
        for (row, column) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            self.covariance.set(row, column, after[(row, column)]);
        }
        Ok(None)
    }

    fn observe(&mut self, fix: &PoseFix) -> Result<bool, Refusal> {
        let [_, _, heading] = self.pose_mean();
        // A heading is handled as a pair whose second number has no information.
        let (jacobian, innovation, sigmas) = match *fix {
            PoseFix::Position([measured_x, measured_y]) => {
                let antenna = Mounting { forward_m: self.fixes.forward_m, left_m: self.fixes.left_m, yaw_rad: 0.0 };
                let ([seat_x, seat_y, _], [lever_x, lever_y]) = self.seat(&antenna);
                let jacobian = Matrix2x3::new(1.0, 0.0, -lever_y, 0.0, 1.0, lever_x);
                let sigma = self.fixes.position_sigma_m;
                (jacobian, Vector2::new(measured_x - seat_x, measured_y - seat_y), [sigma; 2])
            }
            PoseFix::Heading(measured) => {
                let jacobian = Matrix2x3::new(0.0, 0.0, 1.0, 0.0, 0.0, 0.0);
                (jacobian, Vector2::new(wrap(measured - heading), 0.0), [self.fixes.heading_sigma_rad, Some(1.0)])
            }
        };
        let [Some(first), Some(second)] = sigmas else {
            return Err(Refusal("the log does not state the noise of this fix".into()));
        };
        let noise = Matrix2::new(first * first, 0.0, 0.0, second * second);
        let expected = jacobian * self.covariance.block([0, 1, 2]) * jacobian.transpose() + noise;
        let Some(information) = expected.try_inverse() else { return Ok(false) };
        if !(innovation.dot(&(information * innovation)) <= self.fixes.gate()) {
            return Ok(false);
        }
        self.correct([0, 1, 2], &jacobian, &information, &innovation);
        Ok(true)
    }

    fn relocate(&mut self, pose: &[f64; 3], covariance: &[[f64; 3]; 3]) -> Result<(), Refusal> {
        self.state[..POSE].copy_from_slice(pose);
        for row in 0..POSE {
            // The correlation with the map is removed.
            (0..self.covariance.side()).for_each(|column| self.covariance.set(row, column, 0.0));
        }
        for (row, column) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            self.covariance.set(row, column, covariance[row][column]);
        }
        Ok(())
    }

    fn restart(&mut self, pose: &[f64; 3], covariance: &[[f64; 3]; 3]) -> Result<(), Refusal> {
        self.state.truncate(POSE);
        self.covariance = Covariance::zero(POSE);
        self.landmarks.clear();
        self.relocate(pose, covariance)
    }

    fn scan(&mut self, sensor: usize, detections: &[[f64; 2]]) -> Result<ScanOutcome, Refusal> {
        let eye = *self.eyes.get(sensor).ok_or_else(|| no_sensor(sensor))?;
        let (mut innovation, mut paired) = (0.0, 0_usize);
        for (place, &detection) in detections.iter().enumerate() {
            let (pairing, label) = match self.association {
                Association::NearestNeighbour => (self.nearest(&eye, detection), None),
                Association::Known => {
                    let label = self.labels.get(self.scans).and_then(|labels| *labels.get(place)?);
                    if label.is_none() {
                        continue;
                    }
                    let known = self.landmarks.iter().position(|landmark| landmark.label == label);
                    (known.and_then(|landmark| self.pair(&eye, landmark, detection)), label)
                }
            };
            let known = self.association == Association::Known;
            match pairing {
                Some(pairing) if known || pairing.distance < GATE => {
                    innovation += pairing.distance / 2.0;
                    paired += 1;
                    let Pairing { landmark, jacobian, innovation, information, .. } = &pairing;
                    let at = POSE + 2 * landmark;
                    self.correct([0, 1, 2, at, at + 1], jacobian, information, innovation);
                    self.landmarks[*landmark].sights += 1;
                }
                Some(pairing) if pairing.distance < NEW => {}
                _ => self.add(&eye, detection, label),
            }
        }
        self.scans += 1;
        if self.association == Association::NearestNeighbour && self.scans.is_multiple_of(CLEANING_SCANS) {
            self.drop_clutter();
        }
        let innovation = (paired > 0).then(|| innovation / paired as f64);
        Ok(ScanOutcome { innovation, ..ScanOutcome::SILENT })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance, Refusal> {
        Ok((self.pose_mean(), entries(&self.covariance.block([0, 1, 2]))))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal> {
        let seen = self.landmarks.iter().enumerate().filter(|(_, landmark)| landmark.sights >= FEWEST_SIGHTS);
        let features: Vec<MapFeature> = seen
            .map(|(k, _)| {
                let at = POSE + 2 * k;
                MapFeature {
                    id: k as u32,
                    weight: 1.0,
                    mean: [self.state[at], self.state[at + 1]],
                    covariance: entries(&self.covariance.block([at, at + 1])),
                }
            })
            .collect();
        Ok((features.len() as f64, features))
    }
}
