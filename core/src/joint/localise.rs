//! Localisation in a map that is not changed.
//!
//! The map has errors, which stay the same from scan to scan. The features therefore remain in the joint Gaussian with
//! their covariances and their cross-covariances with the pose; only their gain is zero (Schmidt 1966). The error of a
//! feature is thus counted once, however often it is measured.

use super::archive::Archive;
use super::associate::{Associated, associate};
use super::associations::detected;
use super::covariance::{Joint, first, symmetric};
use super::filter::JointSlam;
use super::innovation_statistics::{InnovationStatistics, innovation_statistics, is_informative_for_pose};
use super::map_management::{Initiated, initiate};
use super::movers::Movers;
use super::pending::Pending;
use super::report::{JointReport, Tally};
use super::state::Memory;
use crate::numerics::vector::applied;
use crate::report::watch::Recognised;
use crate::{
    Births, Clutter, Detector, Health, Linear, Matrix, MeasurementModel, Motion, Pose, Real, ScanError, Sensor, Serial,
    Vector,
};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, A, V>
{
    /// Updates only the pose with one scan: static features are not corrected, initiated or removed, and their
    /// existence probabilities are unchanged. Use it instead of [`scan`](Self::scan) with a map that was
    /// [loaded](Self::load_map) or is good enough. The covariance of the pose includes the errors of the map, which are
    /// counted once, however often the features are measured. Features in an archive are not used.
    ///
    /// # Errors
    /// As for `scan`; the state is unchanged.
    pub fn localise<X: MeasurementModel<Pose = M::Pose>, R>(
        &mut self,
        detector: &Detector<X, R>,
        measurements: &[X::Measurement],
    ) -> Result<JointReport<T>, ScanError> {
        let models = self.checked(detector, measurements)?;
        let births = &detector.births;
        let Self { config, memory, movers, .. } = self;
        memory.clamp();
        if let Some(mut tracks) = movers.tracks() {
            tracks.advance(memory.header.waited_s, config.least_existence);
        }
        // With a window of 0 no landmark is excluded as weakly determined: no new landmarks are initiated that could be
        // matched with the map later.
        let Associated { in_view, ln_evidence, .. } =
            associate(&models, births, config, memory, movers, measurements, 0);
        let mut tally = Tally::NOTHING;
        for index in 0..memory.header.len {
            let Some(&landmark) = memory.landmarks.get(index).filter(|landmark| landmark.detection > T::ZERO) else {
                continue;
            };
            let detected = detected(memory.association_table, index, measurements);
            let sensor = models.sensor();
            let tells = is_informative_for_pose(sensor, memory.association_table, index, measurements, detected);
            if tells {
                move_pose_by(sensor, memory, index, measurements, config.gate, &mut tally);
            }
            // Existence probabilities do not decrease, because the map is unchanged.
            let seen = Recognised {
                expected: landmark.detection * landmark.existence.visible,
                detected,
                existence_loss: T::ZERO,
            };
            tally.count(memory.header.watch.knows(landmark.label, memory.header.next_label), seen);
        }
        tally.left_out += memory.joint.repair_pose(memory.header.len);
        let (mut merged, mut born) = (0, Initiated::default());
        if let Some(mut tracks) = movers.tracks() {
            tracks.correct(models.sensor(), memory.header, memory.association_table, measurements, None);
            merged = tracks.merge_and_prune(config);
            let births = Births { of_static: T::ZERO, ..*births };
            born = initiate(&models, &births, config, memory, movers, measurements);
        }
        let report =
            tally.report(memory.header, (measurements.len(), models.clutter().per_scan()), X::Measurement::DIMENSION);
        let Initiated { no_birth, lost, .. } = born;
        let (movers, health) = (movers.kept().len(), report.health | Health::COMPONENTS_LOST.when(lost > 0));
        Ok(JointReport { in_view, ln_evidence, merged, no_birth, lost, movers, health, ..report })
    }
}

/// Corrects the pose with the measurements associated with one feature, if the result is valid.
fn move_pose_by<T: Real, S: Sensor<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    index: usize,
    measurements: &[S::Measurement],
    gate: T,
    tally: &mut Tally<T>,
) {
    let Some(statistics) =
        innovation_statistics(sensor, memory, index, measurements, (T::ONE, false), gate, tally, &Serial)
    else {
        return;
    };
    let InnovationStatistics { pose, inverse, step, spread, detected } = statistics;
    let spread = symmetric::<S::Measurement>(&spread);
    if !(spread.is_finite() && step.as_slice().iter().all(|x| x.is_finite())) {
        tally.left_out += 1;
        return;
    }
    let Memory { header, joint, pending, .. } = memory;
    // All are padded with zeros to the dimension of `Z`, the measurement with the most dimensions.
    let learnt = Matrix::with(|row, column| -inverse.at(row, column) * detected);
    let spread = Matrix::with(|row, column| spread.get(row, column));
    let step = Z::with(|z| step.at(z));
    if !(pending.may_push(joint, &(learnt + spread)) && header.may_move::<Z>(&pose, &step)) {
        tally.left_out += 1;
        return;
    }
    joint.correct_pose_block::<Z>(pending, &learnt, &spread, header.len);
    header.pose = header.moved_by::<Z>(&pose, &step);
}

impl<T: Real, P: Pose<Scalar = T>> Joint<'_, P> {
    /// P_xx ← P_xx + (P Hᵀ)_x (L + V) (P Hᵀ)_xᵀ and P_mx ← P_mx + (P Hᵀ)_m L (P Hᵀ)_xᵀ for this number of features,
    /// with L = `learnt`, the decrease by the measurement, and V = `spread`, the uncertainty of the association.
    /// Features are not corrected, so that V is added to the pose alone.
    fn correct_pose_block<Z: Vector<Scalar = T>>(
        &mut self,
        common: &Pending<'_, P, Z>,
        learnt: &Linear<Z, Z>,
        spread: &Linear<Z, Z>,
        features: usize,
    ) {
        let rounding = T::ONE + T::EPSILON * T::from_f64(4.0);
        let pose = common.pose();
        let of_pose = pose.as_ref();
        for (row, of_row) in of_pose.iter().enumerate() {
            let weighed = applied::<Z, Z>(learnt, of_row) + applied::<Z, Z>(spread, of_row);
            for (column, of_column) in of_pose.iter().enumerate().take(row + 1) {
                let statistics = self.get(row, column) + weighed.dot(of_column);
                self.set(row, column, if row == column { statistics * rounding } else { statistics });
            }
        }
        for (feature, rows) in common.features().enumerate().take(features) {
            for (row, of_row) in rows.as_ref().iter().enumerate() {
                let (row, weighed) = (first::<P>(feature) + row, applied::<Z, Z>(learnt, of_row));
                for (column, of_column) in of_pose.iter().enumerate() {
                    self.set(row, column, self.get(row, column) + weighed.dot(of_column));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::tests::linear::{Drift, linear_sensing};
    use crate::*;
    use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
    use std::boxed::Box;
    use std::vec::Vec;

    type Memory = JointState<PlanarPose<f64>, Vector2<f64>, 8, { joint_numbers(3, 2, 8) }, 16>;
    type Map = Vec<Component<Vector2<f64>>>;

    fn surveyed(indices: &[[f64; 2]], sigma: f64) -> Map {
        let of = |(label, &index): (usize, &[f64; 2])| Component {
            label: label as u32,
            mean: Vector2::from(index),
            covariance: Symmetric::from_diagonal([sigma * sigma; 2]),
            ..Component::ZERO
        };
        indices.iter().enumerate().map(of).collect()
    }

    #[test]
    fn with_linear_models_it_is_the_schmidt_kalman_filter() {
        let sensing = linear_sensing([0.09, 0.16], 1.0 - 1e-15, 1e-60);
        let detector = Detector::new(sensing, Births::of_static(1e-16)).unwrap();
        let config = JointConfig { gate: 400.0, ..JointConfig::default() };
        let mut state = Box::new(Memory::new());
        let mut slam = JointSlam::new(Drift { sigmas: [0.5, 0.2] }, config, &mut *state).unwrap();
        let indices = [[300.0, 0.0], [0.0, 400.0], [-500.0, 20.0]];
        let map = surveyed(&indices, 0.7);
        assert_eq!(slam.load_map(&map), Err(LoadMapError::NotStarted));
        let known = Symmetric::from_diagonal([1.0, 2.0, 0.0]);
        slam.reset_within(PlanarPose::new(1.0, -2.0, 0.3), &known).unwrap();
        slam.load_map(&map).unwrap();

        // The same with full matrices; the heading has no effect.
        let r = Matrix2::new(0.09, 0.0, 0.0, 0.16);
        let mut x = SVector::<f64, 2>::new(1.0, -2.0);
        let mut p = SMatrix::<f64, 8, 8>::identity() * 0.49;
        (p[(0, 0)], p[(1, 1)]) = (1.0, 2.0);
        let (mut truth, mut draws) = (Vector2::new(1.5, -1.0), Noise::seeded(4));
        for step in 0..30 {
            let control = Vector2::new(0.7, -0.3);
            slam.predict(&control, 0.5).unwrap();
            truth += control * 0.5 + Vector2::new(0.35 * draws.normal::<f64>(), 0.14 * draws.normal::<f64>());
            x += control * 0.5;
            p[(0, 0)] += 0.125;
            p[(1, 1)] += 0.02;
            let z = indices.map(|index| {
                let noise = Vector2::new(0.3 * draws.normal::<f64>(), 0.4 * draws.normal::<f64>());
                Vector2::from(index) - truth + noise
            });
            slam.localise(&detector, &z).unwrap();
            for (k, index) in indices.iter().enumerate() {
                let mut h = SMatrix::<f64, 2, 8>::zeros();
                for d in 0..2 {
                    (h[(d, d)], h[(d, 2 + 2 * k + d)]) = (-1.0, 1.0);
                }
                let s = h * p * h.transpose() + r;
                let mut gain = p * h.transpose() * s.try_inverse().unwrap();
                gain.fixed_rows_mut::<6>(2).fill(0.0);
                let innovation = z[k] - (Vector2::from(*index) - x);
                x += gain.fixed_rows::<2>(0) * innovation;
                let kept = SMatrix::<f64, 8, 8>::identity() - gain * h;
                p = kept * p * kept.transpose() + gain * r * gain.transpose();
            }
            let pose = slam.estimate_pose().unwrap();
            assert!((pose.mean.x_m - x[0]).abs() < 1e-9 && (pose.mean.y_m - x[1]).abs() < 1e-9, "{step} {pose:?} {x}");
            for (row, column) in [(0, 0), (1, 0), (1, 1)] {
                assert!((pose.covariance.get(row, column) - p[(row, column)]).abs() < 1e-9, "{step}");
            }
        }
        assert_eq!(slam.features().collect::<Map>(), map);
        assert_eq!(slam.audit(), Ok(()));
    }

    /// Forty maps with errors of the given covariance: after a hundred scans of the same eight posts, the error of the
    /// pose agrees with its covariance.
    #[test]
    fn the_error_of_a_surveyed_map_is_counted_once() {
        let window = RangeBearingWindow::full_circle(30.0, 0.9).unwrap();
        let sensing = Sensing::range_bearing([0.1, 0.02], window, 0.1).unwrap();
        let lidar = Detector::new(sensing, Births::of_static(1e-3)).unwrap();
        let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05)).unwrap();
        let exact = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
        let mut squares = 0.0;
        for seed in 0..40 {
            let mut draws = Noise::seeded(seed);
            let posts: [[f64; 2]; 8] = core::array::from_fn(|k| {
                let (sine, cosine) = (0.8 * k as f64).sin_cos();
                [(6.0 + k as f64) * cosine, (6.0 + k as f64) * sine]
            });
            let off = posts.map(|index| index.map(|at| at + 0.3 * draws.normal::<f64>()));
            let mut state = Box::new(Memory::new());
            let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
            let mut truth = PlanarPose::new(3.0, 0.0, 1.5);
            let known = Symmetric::from_diagonal([0.25, 0.25, 0.01]);
            let start = Vector::with(|k| [0.5, 0.5, 0.1][k] * draws.normal::<f64>());
            slam.reset_within(truth.displaced(&start), &known).unwrap();
            slam.load_map(&surveyed(&off, 0.3)).unwrap();
            for _ in 0..100 {
                truth = exact.propagate(&truth, &UnicycleControl { speed_mps: 1.0, rate_radps: 0.3 }, 0.1);
                // White noise of 0.1 m/√s and 0.05 rad/√s: over 0.1 s about three times what the filter assumes.
                let [speed, rate] = [0.1, 0.05].map(|sigma| sigma * draws.normal::<f64>() / 0.1_f64.sqrt());
                slam.predict(&UnicycleControl { speed_mps: 1.0 + speed, rate_radps: 0.3 + rate }, 0.1).unwrap();
                let mut seen = Vec::new();
                for [x, y] in posts {
                    let (dx, dy) = (x - truth.x_m, y - truth.y_m);
                    let noise = [0.1 * draws.normal::<f64>(), 0.02 * draws.normal::<f64>()];
                    if draws.uniform::<f64>() < 0.9 {
                        let bearing = dy.atan2(dx) - truth.heading_rad;
                        seen.push(Vector2::new(dx.hypot(dy) + noise[0], wrap(bearing + noise[1])));
                    }
                }
                slam.localise(&lidar, &seen).unwrap();
            }
            let pose = slam.estimate_pose().unwrap();
            squares += pose.covariance.factor().unwrap().mahalanobis(&truth.difference(&pose.mean)) / 3.0;
        }
        // Mean of 120 squared standard normal numbers: within five standard deviations.
        let nees = squares / 40.0;
        assert!((0.4..1.65).contains(&nees), "{nees}");
    }
}
