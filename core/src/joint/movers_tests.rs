//! Moving-object tracks of a joint map, against closed forms.

use super::associations::{Association, AssociationRow};
use super::data_association::marginals;
use super::landmark::Landmark;
use super::movers::{MOVES, Movers};
use crate::tests::linear::{Drift, Everywhere, Offset, linear_sensing};
use crate::*;
use nalgebra::{Matrix2, Matrix4, SMatrix, Vector2, Vector4};
use std::boxed::Box;

type Pose64 = PlanarPose<f64>;
type State<const N: usize, const L: usize> = JointState<Pose64, Vector2<f64>, N, L, 32>;
type Moved<'s, M> = JointSlam<'s, M, Vector2<f64>, NoArchive, Tracked<'s, Pose64>>;

const MOVING: MovingConfig<f64> = MovingConfig {
    velocity_sigma_mps: 1.5,
    motion: ConstantVelocity { acceleration_psd: 0.3, lifetime_s: 50.0 },
    spread_max_m: 20.0,
    extraction_weight: 0.5,
};
const R: [f64; 2] = [0.09, 0.16];

type LinearSensing = Sensing<Offset, Everywhere, UniformClutter<f64>>;

/// Linear models with this p_D, clutter, and birth intensities of static features and of tracks.
fn linear(detection: f64, clutter: f64, of_static: f64, of_moving: f64) -> Detector<LinearSensing> {
    let sensing = linear_sensing(R, detection, clutter);
    Detector::new(sensing, Births { of_static, of_moving }).unwrap()
}

/// The prediction of a track over a time.
fn advanced(x: Vector4<f64>, p: Matrix4<f64>, dt: f64) -> (Vector4<f64>, Matrix4<f64>) {
    let (mut f, mut q) = (Matrix4::identity(), Matrix4::zeros());
    for axis in 0..2 {
        f[(axis, axis + 2)] = dt;
        q[(axis, axis)] = dt * dt * dt / 3.0;
        (q[(axis, axis + 2)], q[(axis + 2, axis)]) = (dt * dt / 2.0, dt * dt / 2.0);
        q[(axis + 2, axis + 2)] = dt;
    }
    (f * x, f * p * f.transpose() + q * MOVING.motion.acceleration_psd)
}

/// A new track at a position.
fn newborn(at: Vector2<f64>) -> (Vector4<f64>, Matrix4<f64>) {
    let velocity = MOVING.velocity_sigma_mps * MOVING.velocity_sigma_mps;
    (Vector4::new(at.x, at.y, 0.0, 0.0), Matrix4::from_diagonal(&Vector4::new(R[0], R[1], velocity, velocity)))
}

const H: SMatrix<f64, 2, 4> =
    SMatrix::from_array_storage(nalgebra::ArrayStorage([[1.0, 0.0], [0.0, 1.0], [0.0; 2], [0.0; 2]]));

#[test]
fn one_track_is_the_kalman_filter_with_exact_or_noisy_odometry() {
    for sigmas in [[0.0, 0.0], [0.5, 0.2]] {
        let detector = linear(1.0 - 1e-15, 1e-60, 0.0, 1e-16);
        let (mut state, mut movers) =
            (Box::new(State::<2, { joint_numbers(3, 2, 2) }>::new()), JointMovers::<_, 4>::new());
        let config = JointConfig { gate: 400.0, ..JointConfig::default() };
        let slam = JointSlam::new(Drift { sigmas }, config, &mut *state).unwrap();
        let mut slam = slam.with_movers(&mut movers, MOVING).unwrap();
        slam.reset(PlanarPose::new(1.0, -2.0, 0.3)).unwrap();
        let (mut draws, mut at, mut velocity) = (Noise::seeded(4), Vector2::new(7.0, 3.0), Vector2::new(0.5, -0.4));
        let mut vehicle = Vector2::new(1.0, -2.0);
        let mut known: Option<(Vector4<f64>, Matrix4<f64>)> = None;
        for step in 0..60 {
            let dt = 0.2 + 0.1 * f64::from(step % 3);
            // In two steps, because odometry is more frequent than scans.
            for _ in 0..2 {
                slam.predict(&Vector2::new(0.7, 0.1), dt / 2.0).unwrap();
            }
            vehicle += Vector2::new(0.7, 0.1) * dt;
            velocity += Vector2::new(draws.normal::<f64>(), draws.normal()) * (0.3 * dt).sqrt();
            at += velocity * dt;
            // The error of the odometry is added to the noise of the measurement, relative to the pose of the last
            // scan.
            let slip = |sigma: f64| sigma * dt.sqrt();
            let noise = [(R[0] + slip(sigmas[0]).powi(2)).sqrt(), (R[1] + slip(sigmas[1]).powi(2)).sqrt()];
            let z = at - vehicle + Vector2::new(noise[0] * draws.normal::<f64>(), noise[1] * draws.normal::<f64>());
            let report = slam.scan(&detector, &[z]).unwrap();
            assert_eq!((report.movers, report.features, report.births), (1, 0, 0), "{step}");
            let (x, p) = match known {
                None => newborn(vehicle + z),
                Some((x, p)) => {
                    let (x, p) = advanced(x, p, dt);
                    let r = Matrix2::new(noise[0] * noise[0], 0.0, 0.0, noise[1] * noise[1]);
                    let s = H * p * H.transpose() + r;
                    let gain = p * H.transpose() * s.try_inverse().unwrap();
                    (x + gain * (z + vehicle - H * x), p - gain * s * gain.transpose())
                }
            };
            known = Some((x, p));
            let mover = slam.moving().next().unwrap();
            assert!((mover.mean - x).norm() < 1e-9, "{step}: {} {x}", mover.mean);
            assert!((mover.covariance.to_matrix() - p).norm() < 1e-9, "{step}");
            assert!(mover.ln_weight.abs() < 1e-9, "{step}: {}", mover.ln_weight);
        }
        // Between scans, the track is predicted to the present.
        let (x, p) = known.unwrap();
        slam.predict(&Vector2::zeros(), 0.4).unwrap();
        let (mover, (x, p)) = (slam.moving().next().unwrap(), advanced(x, p, 0.4));
        assert!((mover.mean - x).norm() < 1e-9 && (mover.covariance.to_matrix() - p).norm() < 1e-9);
        // The track has not corrected the pose of the vehicle.
        let pose = slam.estimate_pose().unwrap();
        assert!((pose.mean.x_m - vehicle.x).abs() < 1e-9 && (pose.mean.y_m - vehicle.y).abs() < 1e-9);
    }
}

/// The existence probability of the static feature and that of the track of a single birth: (v, w).
fn kinds<M: Motion<Pose = Pose64>>(slam: &Moved<'_, M>) -> (f64, f64) {
    let of_static =
        slam.memory.landmarks.iter().take(slam.memory.header.len).map(|landmark| landmark.existence.total());
    (of_static.sum(), slam.movers.kept().iter().map(|mover| mover.weight()).sum())
}

fn density(off: Vector2<f64>, s: Matrix2<f64>) -> f64 {
    (-0.5 * (off.transpose() * s.try_inverse().unwrap() * off).x).exp()
        / (core::f64::consts::TAU * s.determinant().sqrt())
}

#[test]
fn the_static_and_the_moving_hypothesis_follow_bayes() {
    let (clutter, births, p) = (2e-3, [4e-3, 3e-3], 0.8);
    let detector = linear(p, clutter, births[0], births[1]);
    let (mut state, mut movers) = (Box::new(State::<4, { joint_numbers(3, 2, 4) }>::new()), JointMovers::<_, 8>::new());
    let config = JointConfig { persistence: Persistence::FOR_EVER, ..JointConfig::default() };
    let slam = JointSlam::new(Drift { sigmas: [0.0; 2] }, config, &mut *state).unwrap();
    let mut slam = slam.with_movers(&mut movers, MOVING).unwrap();
    slam.reset(PlanarPose::ZERO).unwrap();
    let first = Vector2::new(3.0, 4.0);
    let lambda = clutter + births[0] + births[1];
    slam.scan(&detector, &[first]).unwrap();
    let (mut v, mut w) = (births[0] / lambda, births[1] / lambda);
    let statistics = |slam: &Moved<'_, Drift>, v: f64, w: f64| {
        let (ours_v, ours_w) = kinds(slam);
        assert!((ours_v - v).abs() < 1e-12 && (ours_w - w).abs() < 1e-12, "{ours_v} {v}, {ours_w} {w}");
    };
    statistics(&slam, v, w);
    // A second later, 0.8 m away: the object has moved, or it is static and the noise was large, or this measurement is
    // clutter.
    let dt = 1.0;
    slam.predict(&Vector2::zeros(), dt).unwrap();
    w *= (-dt / MOVING.motion.lifetime_s).exp();
    let off = Vector2::new(0.5, 0.6);
    let report = slam.scan(&detector, &[first + off]).unwrap();
    let r = Matrix2::new(R[0], 0.0, 0.0, R[1]);
    let (x, mover) = newborn(first);
    let (_, mover) = advanced(x, mover, dt);
    let (stands, moves) = (p * v * density(off, r * 2.0), p * w * density(off, H * mover * H.transpose() + r));
    let missed = 1.0 - p * (v + w);
    let all = stands + moves + missed * lambda;
    assert!((report.ln_evidence - all.ln()).abs() < 1e-12, "{} {}", report.ln_evidence, all.ln());
    let no_feature_probability = missed * lambda / all;
    assert!(no_feature_probability < 0.3, "{no_feature_probability}: a birth would be counted too");
    let after = |detected: f64, before: f64| (detected + (1.0 - p) * before * lambda) / all;
    (v, w) = (after(stands, v), after(moves, w));
    statistics(&slam, v, w);
    // The track is one Gaussian for both outcomes, detected and missed.
    let gain = mover * H.transpose() * (H * mover * H.transpose() + r).try_inverse().unwrap();
    let probability = moves / (moves + (1.0 - p) * w_before(births[1] / lambda, dt) * lambda);
    let mean = Vector4::new(first.x, first.y, 0.0, 0.0) + gain * off * probability;
    let seen = mover - gain * H * mover;
    let spread = (gain * off) * (gain * off).transpose() * (probability * (1.0 - probability));
    let covariance = seen * probability + mover * (1.0 - probability) + spread;
    let ours = slam.movers.kept()[0].component;
    assert!((ours.mean - mean).norm() < 1e-12, "{} {mean}", ours.mean);
    assert!((ours.covariance.to_matrix() - covariance).norm() < 1e-12);
    // A miss.
    slam.scan(&detector, &[]).unwrap();
    let missed = 1.0 - p * (v + w);
    statistics(&slam, v * (1.0 - p) / missed, w * (1.0 - p) / missed);
}

fn w_before(w: f64, dt: f64) -> f64 {
    w * (-dt / MOVING.motion.lifetime_s).exp()
}

/// A track and the static feature of the same object are associated with measurements as one feature, whose odds are
/// the sum of theirs.
#[test]
fn a_static_feature_and_its_track_have_one_origin() {
    let (of_static, of_moving, other) = ([5.0_f64, 0.3], [2.0_f64, 4.0], [0.7_f64, 3.0]);
    let mut table = [AssociationRow::ZERO; 2];
    let mut landmarks = [Landmark::<Vector2<f64>>::ZERO; 2];
    let mut movers = JointMovers::<Pose64, 2>::new();
    let mut tracked = movers.tracked(MOVING);
    let mut tracks = tracked.tracks().unwrap();
    tracks.put(Component::ZERO);
    tracks.kept_mut()[0].static_index = 0;
    for (z, row) in table.iter_mut().enumerate() {
        row.start(0.0);
        let associations = [(0, of_static[z]), (MOVES, of_moving[z]), (1, other[z])];
        associations.into_iter().for_each(|(who, odds)| row.associate(Association::new(who, odds.ln())));
    }
    let ln_evidence = marginals::<f64, Pose64, _>(&mut landmarks, &mut table, &mut tracked, 0.0);
    let mut alone = [AssociationRow::ZERO; 2];
    let mut two = [Landmark::<Vector2<f64>>::ZERO; 2];
    for (z, row) in alone.iter_mut().enumerate() {
        row.start(0.0);
        let associations = [(0, of_static[z] + of_moving[z]), (1, other[z])];
        associations.into_iter().for_each(|(who, odds)| row.associate(Association::new(who, odds.ln())));
    }
    let expected = marginals::<f64, Pose64, _>(&mut two, &mut alone, &mut NoMovers, 0.0);
    assert!((ln_evidence - expected).abs() < 1e-12, "{ln_evidence} {expected}");
    for z in 0..2 {
        let probability = |row: &AssociationRow<f64>, who: u16| {
            row.associations()
                .iter()
                .find(|association| association.feature == who)
                .map_or(0.0, |association| association.probability)
        };
        let all = of_static[z] + of_moving[z];
        let one = probability(&alone[z], 0);
        assert!((probability(&table[z], 0) - one * of_static[z] / all).abs() < 1e-12);
        assert!((probability(&table[z], MOVES) - one * of_moving[z] / all).abs() < 1e-12);
        assert!((probability(&table[z], 1) - probability(&alone[z], 1)).abs() < 1e-12);
        assert!((table[z].no_feature_probability - alone[z].no_feature_probability).abs() < 1e-12);
    }
}

#[test]
fn invalid_configurations_are_refused() {
    let mut movers = JointMovers::<Pose64, 2>::new();
    for (field, config) in [
        ("moving.velocity_sigma_mps", MovingConfig { velocity_sigma_mps: 0.0, ..MOVING }),
        ("moving.spread_max_m", MovingConfig { spread_max_m: f64::NAN, ..MOVING }),
    ] {
        let mut state = Box::new(State::<2, { joint_numbers(3, 2, 2) }>::new());
        let slam = JointSlam::new(Drift { sigmas: [0.0; 2] }, JointConfig::default(), &mut *state).unwrap();
        match slam.with_movers(&mut movers, config).map(drop) {
            Err(SetupError::Config(error)) => assert_eq!(error.field, field),
            other => panic!("{other:?}"),
        }
    }
}
