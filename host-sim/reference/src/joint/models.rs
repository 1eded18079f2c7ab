//! The models of a vehicle and its sensor for the joint filter.

use nalgebra::{DMatrix, DVector};

/// The prediction of a pose, and its derivatives.
#[derive(Debug, Clone)]
pub struct Moved {
    pub pose: Vec<f64>,
    /// F = ∂f/∂x.
    pub transition: DMatrix<f64>,
    /// Q, the covariance by the noise of the control.
    pub noise: DMatrix<f64>,
}

/// The prediction for a feature.
#[derive(Debug, Clone)]
pub struct Expected {
    /// ẑ = h(m, x).
    pub measurement: DVector<f64>,
    /// Hx = ∂h/∂x.
    pub by_pose: DMatrix<f64>,
    /// Hm = ∂h/∂m.
    pub by_feature: DMatrix<f64>,
    /// p_D, 0 out of view.
    pub detection: f64,
}

/// The feature of a measurement.
#[derive(Debug, Clone)]
pub struct Inverse {
    /// m = h⁻¹(z, x), m.
    pub feature: DVector<f64>,
    /// H* = ∂m/∂z.
    pub by_measurement: DMatrix<f64>,
}

/// A vehicle and its sensor. A pose begins with the uncertain coordinates: position, heading, and possibly others; known
/// coordinates follow.
pub trait Models {
    type Control;

    /// K, number of uncertain coordinates of a pose.
    const POSE: usize;
    /// D, number of coordinates of a feature, and index of the heading in the pose.
    const FEATURE: usize;

    /// The pose after a control over `dt` seconds.
    fn moved(&self, pose: &[f64], control: &Self::Control, dt: f64) -> Moved;

    /// The prediction for a feature; `None` if it cannot be measured.
    fn expected(&self, pose: &[f64], feature: &[f64]) -> Option<Expected>;

    /// The feature of a measurement; `None` if it has no inverse.
    fn inverse(&self, pose: &[f64], measurement: &[f64]) -> Option<Inverse>;

    /// z ⊖ ẑ.
    fn innovation(&self, measurement: &[f64], expected: &DVector<f64>) -> DVector<f64>;

    /// R of the sensor; its number of rows is that of the coordinates of a measurement.
    fn noise(&self) -> DMatrix<f64>;

    /// R of a measurement with this prediction, if it is another one.
    fn noise_at(&self, _expected: &[f64]) -> DMatrix<f64> {
        self.noise()
    }

    /// Whether the measured object is in front of the feature with the prediction `expected`.
    fn occludes(&self, measurement: &[f64], expected: &DVector<f64>) -> bool;

    /// κ.
    fn clutter_intensity(&self) -> f64;
}
