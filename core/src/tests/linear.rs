//! Linear Gaussian models, for tests against closed forms.

use crate::{
    Bounds, Expected, FieldOfView, Inverse, Linearised, Motion, Noise, PlanarPose, Rates, Sensing, Sensor, Symmetric,
    UniformClutter,
};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};

/// A vehicle displaced by its control, with noise in x and y.
pub(crate) struct Drift {
    /// Standard deviations of the noise of one second in x and y, m.
    pub(crate) sigmas: [f64; 2],
}

impl Motion for Drift {
    type Pose = PlanarPose<f64>;
    type Control = Vector2<f64>;

    fn admits(&self, _: &Vector2<f64>) -> bool {
        true
    }
    fn rates(&self, _: &Vector2<f64>) -> Rates<f64> {
        Rates::NONE
    }
    fn propagate(&self, pose: &PlanarPose<f64>, control: &Vector2<f64>, dt: f64) -> PlanarPose<f64> {
        PlanarPose { x_m: pose.x_m + control.x * dt, y_m: pose.y_m + control.y * dt, ..*pose }
    }
    fn sample(&self, pose: &PlanarPose<f64>, control: &Vector2<f64>, dt: f64, noise: &mut Noise) -> PlanarPose<f64> {
        let moved = self.propagate(pose, control, dt);
        let [x, y] = self.sigmas.map(|sigma| sigma * dt.sqrt() * noise.normal::<f64>());
        PlanarPose { x_m: moved.x_m + x, y_m: moved.y_m + y, ..moved }
    }
    fn linearise(&self, _: &PlanarPose<f64>, _: &Vector2<f64>, dt: f64) -> Linearised<Vector3<f64>> {
        let [x, y] = self.sigmas.map(|sigma| sigma * sigma * dt);
        Linearised { transition: Matrix3::identity(), noise: Symmetric::from_diagonal([x, y, 0.0]) }
    }
}

/// A sensor that measures the position of a feature relative to the vehicle, in map directions.
pub(crate) struct Offset {
    /// R.
    pub(crate) noise: Symmetric<Vector2<f64>>,
}

impl Sensor for Offset {
    type Pose = PlanarPose<f64>;
    type Measurement = Vector2<f64>;
    type Frame = Vector2<f64>;
    const SORTED_BY: usize = 0;
    const SORTED_BY_ANGLE: bool = false;

    fn frame(&self, pose: &PlanarPose<f64>) -> Vector2<f64> {
        Vector2::new(pose.x_m, pose.y_m)
    }
    fn expect(&self, frame: &Vector2<f64>, feature: &Vector2<f64>) -> Option<Expected<Vector2<f64>, Vector2<f64>>> {
        Some(Expected { measurement: feature - frame, jacobian: Matrix2::identity() })
    }
    fn innovation(&self, measured: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        measured - expected
    }
    fn noise(&self) -> &Symmetric<Vector2<f64>> {
        &self.noise
    }
    fn invert(&self, frame: &Vector2<f64>, measured: &Vector2<f64>) -> Option<Inverse<Vector2<f64>, Vector2<f64>>> {
        Some(Inverse { feature: frame + measured, jacobian: Matrix2::identity() })
    }

    fn by_pose(&self, _: &Vector2<f64>, _: &Vector2<f64>, _: &Expected<Vector2<f64>, Vector2<f64>>) -> Matrix2x3<f64> {
        Matrix2x3::new(-1.0, 0.0, 0.0, 0.0, -1.0, 0.0)
    }
}

/// A constant p_D everywhere.
pub(crate) struct Everywhere(pub(crate) f64);

impl FieldOfView<Vector2<f64>, Vector2<f64>, Vector2<f64>> for Everywhere {
    fn detection_probability(&self, _: &Vector2<f64>, _: &Vector2<f64>, _: &Vector2<f64>) -> f64 {
        self.0
    }
    fn bounds(&self, _: &Vector2<f64>) -> Bounds<Vector2<f64>> {
        Bounds::EVERYWHERE
    }
}

/// The linear models with these variances of the noise, probability of detection and clutter intensity.
pub(crate) fn linear_sensing(
    variances: [f64; 2],
    detection: f64,
    clutter: f64,
) -> Sensing<Offset, Everywhere, UniformClutter<f64>> {
    let sensor = Offset { noise: Symmetric::from_diagonal(variances) };
    Sensing { sensor, field_of_view: Everywhere(detection), clutter: UniformClutter::of_scan(clutter, 1.0).unwrap() }
}
