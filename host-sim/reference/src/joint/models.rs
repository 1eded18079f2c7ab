//! What the joint filter must know of a vehicle and its sensor.

use nalgebra::{DMatrix, DVector};

/// Where a vehicle has come to, and what it depends on.
#[derive(Debug, Clone)]
pub struct Moved {
    /// The pose.
    pub pose: Vec<f64>,
    /// F = ∂f/∂x.
    pub transition: DMatrix<f64>,
    /// Q, what the noise of the control adds.
    pub noise: DMatrix<f64>,
}

/// What is expected of a feature.
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

/// A feature from a measurement.
#[derive(Debug, Clone)]
pub struct Inverse {
    /// m = h⁻¹(z, x), m.
    pub feature: DVector<f64>,
    /// H* = ∂m/∂z.
    pub by_measurement: DMatrix<f64>,
}

/// A vehicle and its sensor. A pose begins with the coordinates that are uncertain: its place, its heading, and whatever else there is;
/// what is taken as given stands behind them.
pub trait Models {
    /// What moves the vehicle.
    type Control;

    /// K, coordinates of a pose that are uncertain.
    const POSE: usize;
    /// D, coordinates of a feature. The heading is the coordinate of the pose behind as many.
    const FEATURE: usize;

    /// The pose after `dt` seconds of a control.
    fn moved(&self, pose: &[f64], control: &Self::Control, dt: f64) -> Moved;

    /// What is expected of a feature; `None` where it cannot be measured at all.
    fn expected(&self, pose: &[f64], feature: &[f64]) -> Option<Expected>;

    /// The feature that a measurement would be of; `None` where it has no inverse.
    fn inverse(&self, pose: &[f64], measurement: &[f64]) -> Option<Inverse>;

    /// z ⊖ ẑ.
    fn innovation(&self, measurement: &[f64], expected: &DVector<f64>) -> DVector<f64>;

    /// R.
    fn noise(&self) -> DMatrix<f64>;

    /// Whether what was measured stands before a feature of which `expected` is expected.
    fn occludes(&self, measurement: &[f64], expected: &DVector<f64>) -> bool;

    /// κ.
    fn clutter_intensity(&self) -> f64;
}
