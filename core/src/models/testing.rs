//! Checks shared by the tests of the models.

use crate::{AuvPose, Matrix, Motion, PlanarPose, Pose, Sensor, Symmetric, Vector};
use nalgebra::{SMatrix, SVector, Vector3, Vector5};

/// Checks that the coordinate `SIFTED_BY` does not wrap: its innovation is the difference, even beyond a full turn.
pub(super) fn check_sifting<S: Sensor<Pose: Pose<Scalar = f64>>>(sensor: &S, measured: &S::Measurement) {
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

/// Compares H with respect to the feature and to the pose of a sensor in space with central differences, relative to the size of
/// either.
pub(super) fn check_in_space<S>(sensor: &S, pose: &AuvPose<f64>, feature: &Vector3<f64>, tolerance: f64)
where
    S: Sensor<Pose = AuvPose<f64>>,
{
    const STEP: f64 = 1e-5;
    let frame = sensor.frame(pose);
    let seen = sensor.expect(&frame, feature).unwrap();
    check_sifting(sensor, &seen.measurement);
    let by_pose = sensor.by_pose(&frame, feature, &seen);
    let slope = |at: &dyn Fn(f64) -> S::Measurement| sensor.innovation(&at(STEP), &at(-STEP)) * (1.0 / (2.0 * STEP));
    for k in 0..3 {
        let difference = slope(&|step| {
            let mut offset = Vector3::zeros();
            offset[k] = step;
            sensor.expect(&frame, &(feature + offset)).unwrap().measurement
        });
        let error = off_by(&difference, |row| seen.jacobian.at(row, k));
        assert!(error < tolerance, "by the feature, column {k}: off by {error} from {difference:?}");
    }
    for k in 0..5 {
        let difference = slope(&|step| {
            let mut by = Vector5::zeros();
            by[k] = step;
            sensor.expect(&sensor.frame(&pose.displaced(&by)), feature).unwrap().measurement
        });
        let error = off_by(&difference, |row| by_pose.at(row, k));
        assert!(error < tolerance, "by the pose, column {k}: off by {error} from {difference:?}");
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
