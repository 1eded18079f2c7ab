//! The filter.

use super::association::{Association, CLEANING_SCANS, FEWEST_SIGHTS, GATE, NEW, PROBATION_SCANS};
use super::covariance::Covariance;
use super::odometry::OdometryNoise;
use crate::angle::wrap;
use crate::log::{Log, Vehicle};
use crate::record::{MapFeature, MovingFeature};
use crate::slam::{PoseAndCovariance, Refusal, ScanOutcome, Slam};
use libm::{atan2, cos, sin};
use scphd::Health;
use std::collections::BTreeSet;

/// A user who does not trust a data sheet takes its standard deviations this much larger.
const DISTRUST: f64 = 1.5;
/// Standard deviations of range, as a share of the greatest, and bearing, rad, where a log states none.
const RANGE_SIGMA_SHARE: f64 = 0.01;
const BEARING_SIGMA_RAD: f64 = 0.02;
/// Step of the central differences of the motion model, in the unit of each variable.
const STEP: f64 = 1e-5;
/// Variables of the pose.
const POSE: usize = 3;

/// What is kept of a landmark beside its place in the state.
#[derive(Debug, Clone, Copy)]
struct Landmark {
    label: Option<i64>,
    sights: u32,
    born: usize,
}

/// EKF SLAM over one log.
#[derive(Debug)]
pub struct Ekf {
    vehicle: Vehicle,
    odometry: OdometryNoise,
    /// Variances of range, m², and bearing, rad².
    noise: [f64; 2],
    association: Association,
    /// Labels of every scan's detections, those of static landmarks alone; only for [`Association::Known`].
    labels: Vec<Vec<Option<i64>>>,
    /// x m, y m, heading rad, then x and y of every landmark.
    state: Vec<f64>,
    covariance: Covariance,
    landmarks: Vec<Landmark>,
    scans: usize,
}

/// A detection as one landmark explains it.
struct Pairing {
    landmark: usize,
    jacobian: [[f64; 5]; 2],
    innovation: [f64; 2],
    /// S⁻¹.
    information: [[f64; 2]; 2],
    /// νᵀ S⁻¹ ν.
    distance: f64,
}

impl Ekf {
    /// At the log's first pose, which is certain, with an empty map.
    ///
    /// # Errors
    /// The association is to be known and the log has no labels.
    pub fn start(log: &Log, association: Association) -> Result<Self, Refusal> {
        let labels = match association {
            Association::NearestNeighbour => Vec::new(),
            Association::Known => static_labels(log).ok_or_else(|| {
                Refusal("the log has no label_landmark or label_subject column to tell the associations from".into())
            })?,
        };
        let trust = if log.simulated { 1.0 } else { DISTRUST };
        let range = log.nominal.range_sigma_m.unwrap_or(RANGE_SIGMA_SHARE * log.sensor.range_max_m);
        let bearing = log.nominal.bearing_sigma_rad.unwrap_or(BEARING_SIGMA_RAD);
        Ok(Self {
            vehicle: log.vehicle,
            odometry: OdometryNoise::of(log),
            noise: [range, bearing].map(|sigma| (trust * sigma).powi(2)),
            association,
            labels,
            state: log.initial_pose.to_vec(),
            covariance: Covariance::zero(POSE),
            landmarks: Vec::new(),
            scans: 0,
        })
    }

    /// Landmarks in the state.
    #[cfg(test)]
    pub(super) fn landmarks(&self) -> usize {
        self.landmarks.len()
    }

    fn pose_mean(&self) -> [f64; POSE] {
        [self.state[0], self.state[1], self.state[2]]
    }

    /// What landmark `landmark` makes of a detection; `None` where S is singular.
    fn pair(&self, landmark: usize, detection: [f64; 2]) -> Option<Pairing> {
        let at = POSE + 2 * landmark;
        let [x, y, heading] = self.pose_mean();
        let (dx, dy) = (self.state[at] - x, self.state[at + 1] - y);
        let squared = (dx * dx + dy * dy).max(1e-9);
        let range = squared.sqrt();
        let jacobian = [
            [-dx / range, -dy / range, 0.0, dx / range, dy / range],
            [dy / squared, -dx / squared, -1.0, -dy / squared, dx / squared],
        ];
        let block = self.covariance.block([0, 1, 2, at, at + 1]);
        let mut s = [[self.noise[0], 0.0], [0.0, self.noise[1]]];
        for row in 0..2 {
            for column in 0..2 {
                for a in 0..5 {
                    for b in 0..5 {
                        s[row][column] += jacobian[row][a] * block[a][b] * jacobian[column][b];
                    }
                }
            }
        }
        let determinant = s[0][0] * s[1][1] - s[0][1] * s[1][0];
        if !(determinant > 0.0) {
            return None;
        }
        let information =
            [[s[1][1] / determinant, -s[0][1] / determinant], [-s[1][0] / determinant, s[0][0] / determinant]];
        let innovation = [detection[0] - range, wrap(detection[1] - (atan2(dy, dx) - heading))];
        let [u, v] = innovation;
        let distance = u * u * information[0][0]
            + u * v * (information[0][1] + information[1][0])
            + v * v * information[1][1];
        Some(Pairing { landmark, jacobian, innovation, information, distance })
    }

    fn nearest(&self, detection: [f64; 2]) -> Option<Pairing> {
        let pairings = (0..self.landmarks.len()).filter_map(|landmark| self.pair(landmark, detection));
        pairings.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// The Kalman update of the whole state.
    fn correct(&mut self, pairing: &Pairing) {
        let at = POSE + 2 * pairing.landmark;
        let variables = [0, 1, 2, at, at + 1];
        let side = self.covariance.side();
        // P Hᵀ and the gain P Hᵀ S⁻¹.
        let cross: Vec<[f64; 2]> = (0..side)
            .map(|row| {
                let along = |h: &[f64; 5]| {
                    h.iter().zip(variables).map(|(h, variable)| h * self.covariance.get(row, variable)).sum()
                };
                [along(&pairing.jacobian[0]), along(&pairing.jacobian[1])]
            })
            .collect();
        let [[a, b], [c, d]] = pairing.information;
        let gain: Vec<[f64; 2]> = cross.iter().map(|[u, v]| [u * a + v * c, u * b + v * d]).collect();
        for (variable, [u, v]) in self.state.iter_mut().zip(&gain) {
            *variable += u * pairing.innovation[0] + v * pairing.innovation[1];
        }
        self.state[2] = wrap(self.state[2]);
        self.covariance.subtract(&gain, &cross);
        self.landmarks[pairing.landmark].sights += 1;
    }

    /// A new landmark where the detection says, with its covariances to all else.
    fn add(&mut self, [range, bearing]: [f64; 2], label: Option<i64>) {
        let [x, y, heading] = self.pose_mean();
        let (s, c) = (sin(heading + bearing), cos(heading + bearing));
        let by_pose = [[1.0, 0.0, -range * s], [0.0, 1.0, range * c]];
        let by_measurement = [[c, -range * s], [s, range * c]];
        let old = self.covariance.side();
        let mut covariance = self.covariance.grown(2);
        for (row, by_pose) in by_pose.iter().enumerate() {
            for column in 0..old {
                let value = (0..POSE).map(|k| by_pose[k] * self.covariance.get(k, column)).sum();
                covariance.set(old + row, column, value);
            }
        }
        for row in 0..2 {
            for column in row..2 {
                let from_pose: f64 = (0..POSE)
                    .flat_map(|a| (0..POSE).map(move |b| (a, b)))
                    .map(|(a, b)| by_pose[row][a] * self.covariance.get(a, b) * by_pose[column][b])
                    .sum();
                let from_noise: f64 =
                    (0..2).map(|k| by_measurement[row][k] * self.noise[k] * by_measurement[column][k]).sum();
                covariance.set(old + row, old + column, from_pose + from_noise);
            }
        }
        self.covariance = covariance;
        self.state.extend([x + range * c, y + range * s]);
        self.landmarks.push(Landmark { label, sights: 1, born: self.scans });
    }

    /// Drops what was seen but once or twice and not again.
    fn drop_clutter(&mut self) {
        let stays = |landmark: &Landmark| {
            landmark.sights >= FEWEST_SIGHTS || self.scans - landmark.born <= PROBATION_SCANS
        };
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

/// The label of every detection that is of a static landmark; `None` where the log has no labels.
fn static_labels(log: &Log) -> Option<Vec<Vec<Option<i64>>>> {
    let moving: BTreeSet<i64> = log.moving.iter().map(|row| row.subject).collect();
    let known = |label: &i64| *label >= 0 && !moving.contains(label);
    let of_scan = |labels: &[i64]| labels.iter().map(|label| Some(*label).filter(known)).collect();
    let labelled = log.scans.iter().any(|scan| !scan.labels.is_empty());
    labelled.then(|| log.scans.iter().map(|scan| of_scan(&scan.labels)).collect())
}

impl Slam for Ekf {
    fn predict(&mut self, control: [f64; 2], dt_s: f64) -> Result<(), Refusal> {
        let pose = self.pose_mean();
        let step = |pose, control| self.vehicle.step(pose, control, dt_s);
        let slope = |plus: [f64; POSE], minus: [f64; POSE]| {
            [plus[0] - minus[0], plus[1] - minus[1], wrap(plus[2] - minus[2])].map(|change| change / (2.0 * STEP))
        };
        let by_pose: [[f64; POSE]; POSE] = std::array::from_fn(|k| {
            let (mut plus, mut minus) = (pose, pose);
            plus[k] += STEP;
            minus[k] -= STEP;
            slope(step(plus, control), step(minus, control))
        });
        let by_control: [[f64; POSE]; 2] = std::array::from_fn(|k| {
            let (mut plus, mut minus) = (control, control);
            plus[k] += STEP;
            minus[k] -= STEP;
            slope(step(pose, plus), step(pose, minus))
        });
        let variances = self.odometry.variances(control, dt_s);
        let moved = step(pose, control);
        self.state[..POSE].copy_from_slice(&moved);
        let before = self.covariance.block([0, 1, 2]);
        for row in 0..POSE {
            for column in row..POSE {
                let carried: f64 = (0..POSE)
                    .flat_map(|a| (0..POSE).map(move |b| (a, b)))
                    .map(|(a, b)| by_pose[a][row] * before[a][b] * by_pose[b][column])
                    .sum();
                let added: f64 = (0..2).map(|k| by_control[k][row] * variances[k] * by_control[k][column]).sum();
                self.covariance.set(row, column, carried + added);
            }
        }
        for column in POSE..self.covariance.side() {
            let before = [0, 1, 2].map(|k| self.covariance.get(k, column));
            for row in 0..POSE {
                let value = (0..POSE).map(|k| by_pose[k][row] * before[k]).sum();
                self.covariance.set(row, column, value);
            }
        }
        Ok(())
    }

    fn scan(&mut self, detections: &[[f64; 2]]) -> Result<ScanOutcome, Refusal> {
        let (mut innovation, mut paired) = (0.0, 0_usize);
        for (place, &detection) in detections.iter().enumerate() {
            let (pairing, label) = match self.association {
                Association::NearestNeighbour => (self.nearest(detection), None),
                Association::Known => {
                    let label = self.labels.get(self.scans).and_then(|labels| *labels.get(place)?);
                    if label.is_none() {
                        continue;
                    }
                    let known = self.landmarks.iter().position(|landmark| landmark.label == label);
                    (known.and_then(|landmark| self.pair(landmark, detection)), label)
                }
            };
            let known = self.association == Association::Known;
            match pairing {
                Some(pairing) if known || pairing.distance < GATE => {
                    innovation += pairing.distance / 2.0;
                    paired += 1;
                    self.correct(&pairing);
                }
                Some(pairing) if pairing.distance < NEW => {}
                _ => self.add(detection, label),
            }
        }
        self.scans += 1;
        if self.association == Association::NearestNeighbour && self.scans.is_multiple_of(CLEANING_SCANS) {
            self.drop_clutter();
        }
        Ok(ScanOutcome {
            n_eff: 1.0,
            resampled: false,
            ln_evidence: None,
            innovation: (paired > 0).then(|| innovation / paired as f64),
            health: Health::GOOD,
        })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance, Refusal> {
        Ok((self.pose_mean(), self.covariance.block([0, 1, 2])))
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
                    covariance: self.covariance.block([at, at + 1]),
                }
            })
            .collect();
        Ok((features.len() as f64, features))
    }

    fn moving(&mut self) -> Result<Vec<MovingFeature>, Refusal> {
        Ok(Vec::new())
    }

    fn digest(&mut self) -> Option<u64> {
        None
    }

    fn state_bytes(&self) -> Option<u64> {
        None
    }
}
