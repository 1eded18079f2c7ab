//! Checks shared by the tests of the models.

use crate::{AuvPose, Dim, Locating, Motion, Packed, PlanarPose, Pose, Sensor, Symmetric};
use nalgebra::{SMatrix, SVector, Vector3};

/// That measurements are sifted by a coordinate that is no angle: its innovation is the difference, also past a turn.
pub(super) fn check_sifting<S: Sensor<f64, D, Z>, const D: usize, const Z: usize>(
    sensor: &S,
    measured: &SVector<f64, Z>,
) where
    Dim<D>: Packed,
    Dim<Z>: Packed,
{
    let Some(k) = S::SIFTED_BY else { return };
    assert!(k < Z && k != S::SORTED_BY);
    let expected = measured.add_scalar(-4.0);
    assert_eq!(sensor.innovation(measured, &expected)[k], measured[k] - expected[k]);
}

/// H by the feature and by the pose of a sensor in space against central differences, relative to the size of either.
pub(super) fn check_in_space<S, const Z: usize>(sensor: &S, pose: &AuvPose<f64>, feature: &Vector3<f64>, tolerance: f64)
where
    S: Sensor<f64, 3, Z, Pose = AuvPose<f64>> + Locating<f64, 5, 3, Z>,
    Dim<Z>: Packed,
{
    const STEP: f64 = 1e-5;
    let frame = sensor.frame(pose);
    let seen = sensor.expect(&frame, feature).unwrap();
    check_sifting::<S, 3, Z>(sensor, &seen.measurement);
    let by_pose = sensor.by_pose(&frame, feature, &seen);
    let slope = |at: &dyn Fn(f64) -> SVector<f64, Z>| sensor.innovation(&at(STEP), &at(-STEP)) / (2.0 * STEP);
    for k in 0..3 {
        let difference = slope(&|step| {
            let mut offset = Vector3::zeros();
            offset[k] = step;
            sensor.expect(&frame, &(feature + offset)).unwrap().measurement
        });
        let error = (difference - seen.jacobian.column(k)).norm();
        assert!(error < tolerance, "by the feature, column {k}: off by {error} from {difference}");
    }
    for k in 0..5 {
        let difference = slope(&|step| {
            let mut by = SVector::<f64, 5>::zeros();
            by[k] = step;
            sensor.expect(&sensor.frame(&pose.displaced(&by)), feature).unwrap().measurement
        });
        let error = (difference - by_pose.column(k)).norm();
        assert!(error < tolerance, "by the pose, column {k}: off by {error} from {difference}");
    }
}

/// F and Q of a planar motion model against central differences at one pose and control.
pub(super) fn check_linearised<M: Motion<f64, 3, Pose = PlanarPose<f64>>>(
    motion: &M,
    pose: &PlanarPose<f64>,
    control: [f64; 2],
    as_control: impl Fn([f64; 2]) -> M::Control,
    control_covariance: Symmetric<f64, 2>,
    dt: f64,
) {
    let step = 1e-6;
    let moved = |pose: [f64; 3], control: [f64; 2]| {
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
    let by_control = SMatrix::<f64, 3, 2>::from_columns(&[0, 1].map(|k| {
        slope(&|h| {
            let mut c = control;
            c[k] += h;
            moved(coordinates, c)
        })
    }));
    let noise = control_covariance.congruence(&by_control).to_matrix();
    let error = (noise - linearised.noise.to_matrix()).norm();
    assert!(error < 1e-8, "Q at {pose:?}, {control:?}: off by {error}");
}
