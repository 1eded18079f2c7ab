//! Checks shared by the tests of the models.

use crate::{Matrix, Motion, Noise, PlanarPose, Pose, PositionOf, Sensor, Symmetric, TangentOf, Vector};
use nalgebra::{SMatrix, SVector, Vector3};

/// Checks that the coordinate `SIFTED_BY` does not wrap: its innovation is the difference, even beyond a full turn.
fn check_sifting<S: Sensor<Pose: Pose<Scalar = f64>>>(sensor: &S, measured: &S::Measurement) {
    let Some(k) = S::SIFTED_BY else { return };
    assert!(k < S::Measurement::DIMENSION && k != S::SORTED_BY);
    let expected = S::Measurement::with(|k| measured.at(k) - 4.0);
    assert_eq!(sensor.innovation(measured, &expected).at(k), measured.at(k) - expected.at(k));
}

/// Distance of a difference quotient from the column of a matrix.
pub(super) fn off_by<Z: Vector<Scalar = f64>>(quotient: &Z, of_matrix: impl Fn(usize) -> f64) -> f64 {
    let off = Z::with(|row| quotient.at(row) - of_matrix(row));
    off.dot(&off).sqrt()
}

/// Compares H with respect to the feature and to the pose of a sensor with central differences.
pub(super) fn check_sensor<S: Sensor<Pose: Pose<Scalar = f64>>>(
    sensor: &S,
    pose: &S::Pose,
    feature: &PositionOf<S::Pose>,
    tolerance: f64,
) {
    const STEP: f64 = 1e-5;
    let frame = sensor.frame(pose);
    let seen = sensor.expect(&frame, feature).unwrap();
    check_sifting(sensor, &seen.measurement);
    let by_pose = sensor.by_pose(&frame, feature, &seen);
    let slope = |at: &dyn Fn(f64) -> S::Measurement| sensor.innovation(&at(STEP), &at(-STEP)) * (1.0 / (2.0 * STEP));
    for k in 0..PositionOf::<S::Pose>::DIMENSION {
        let difference = slope(&|step| {
            let moved = *feature + Vector::with(|of| if of == k { step } else { 0.0 });
            sensor.expect(&frame, &moved).unwrap().measurement
        });
        let error = off_by(&difference, |row| seen.jacobian.at(row, k));
        assert!(error < tolerance, "by the feature, column {k}: off by {error} from {difference:?}");
    }
    for k in 0..TangentOf::<S::Pose>::DIMENSION {
        let difference = slope(&|step| {
            let moved = pose.displaced(&Vector::with(|of| if of == k { step } else { 0.0 }));
            sensor.expect(&sensor.frame(&moved), feature).unwrap().measurement
        });
        let error = off_by(&difference, |row| by_pose.at(row, k));
        assert!(error < tolerance, "by the pose, column {k}: off by {error} from {difference:?}");
    }
}

/// Compares the covariance of samples of a motion with Q, relative to the standard deviations.
pub(super) fn check_samples<M: Motion<Pose: Pose<Scalar = f64>>>(
    motion: &M,
    pose: &M::Pose,
    control: &M::Control,
    dt: f64,
    (runs, tolerance): (u32, f64),
) {
    let (mean, q) = (motion.propagate(pose, control, dt), motion.linearise(pose, control, dt).noise);
    let (mut draws, dimension) = (Noise::seeded(7), TangentOf::<M::Pose>::DIMENSION);
    let mut covariance = [[0.0; 5]; 5];
    for _ in 0..runs {
        let off = motion.sample(pose, control, dt, &mut draws).difference(&mean);
        for (row, column) in (0..dimension).flat_map(|row| (0..=row).map(move |column| (row, column))) {
            covariance[row][column] += off.at(row) * off.at(column) / f64::from(runs);
        }
    }
    for (row, column) in (0..dimension).flat_map(|row| (0..=row).map(move |column| (row, column))) {
        let scale = (q.get(row, row) * q.get(column, column)).sqrt();
        let error = (covariance[row][column] - q.get(row, column)).abs();
        assert!(error < tolerance * scale, "{row} {column}, {dt} s: {covariance:?} {q:?}");
    }
}

/// Compares F and Q of a planar motion model with `N` controls with central differences, at one pose and control.
pub(super) fn check_linearised<M: Motion<Pose = PlanarPose<f64>>, const N: usize>(
    motion: &M,
    pose: &PlanarPose<f64>,
    control: [f64; N],
    as_control: impl Fn([f64; N]) -> M::Control,
    control_covariance: Symmetric<SVector<f64, N>>,
    dt: f64,
) where
    SVector<f64, N>: Vector<Scalar = f64>,
{
    let step = 1e-6;
    let moved = |pose: [f64; 3], control: [f64; N]| {
        motion.propagate(&PlanarPose::new(pose[0], pose[1], pose[2]), &as_control(control), dt)
    };
    let coordinates = [pose.x_m, pose.y_m, pose.heading_rad];
    let slope = |change: &dyn Fn(f64) -> PlanarPose<f64>| -> Vector3<f64> {
        change(step).difference(&change(-step)) / (2.0 * step)
    };
    let linearised = motion.linearise(pose, &as_control(control), dt);
    for k in 0..3 {
        let column = slope(&|h| {
            let mut c = coordinates;
            c[k] += h;
            moved(c, control)
        });
        let error = (column - linearised.transition.column(k)).norm();
        assert!(error < 1e-7, "∂f/∂x, column {k} at {pose:?}, {control:?}: off by {error}");
    }
    let by_control = SMatrix::<f64, 3, N>::from_columns(&core::array::from_fn::<_, N, _>(|k| {
        slope(&|h| {
            let mut c = control;
            c[k] += h;
            moved(coordinates, c)
        })
    }));
    let covariance = SMatrix::<f64, N, N>::from_fn(|row, column| control_covariance.get(row, column));
    let noise = by_control * covariance * by_control.transpose();
    let error = (noise - linearised.noise.to_matrix()).norm();
    assert!(error < 1e-8, "Q at {pose:?}, {control:?}: off by {error}");
}
