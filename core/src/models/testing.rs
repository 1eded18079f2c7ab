//! Checks shared by the tests of the motion models.

use crate::{Motion, PlanarPose, Pose, Symmetric};
use nalgebra::{SMatrix, Vector3};

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
