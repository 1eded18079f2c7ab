//! A sensor of one's own: a scanner that tells where reflectors are, ahead (m) and to the left (m) of itself, in a square before it.

use nalgebra::{Matrix2, Matrix2x3, Vector2};
use scphd::models::{Expected, ExpectedOf, FieldOfView, Inverse, InverseOf, PlanarFrame, PlanarPose, Sensor};
use scphd::numerics::{Bounds, Symmetric};

/// What it measures, with noise of this covariance.
#[derive(Debug, Clone, Copy)]
pub struct Scanner(pub Symmetric<Vector2<f32>>);

impl Sensor for Scanner {
    type Pose = PlanarPose<f32>;
    type Measurement = Vector2<f32>;
    type Frame = PlanarFrame<f32>;
    const SORTED_BY: usize = 1;
    const SORTED_BY_ANGLE: bool = false;
    const SIFTED_BY: Option<usize> = Some(0);

    fn frame(&self, pose: &PlanarPose<f32>) -> PlanarFrame<f32> {
        PlanarFrame::of(pose)
    }

    fn expect(&self, frame: &PlanarFrame<f32>, feature: &Vector2<f32>) -> Option<ExpectedOf<Self>> {
        let jacobian = Matrix2::new(frame.cosine, frame.sine, -frame.sine, frame.cosine);
        Some(Expected { measurement: jacobian * (feature - frame.position), jacobian })
    }

    fn innovation(&self, measured: &Vector2<f32>, expected: &Vector2<f32>) -> Vector2<f32> {
        measured - expected
    }

    fn noise(&self) -> &Symmetric<Vector2<f32>> {
        &self.0
    }

    fn invert(&self, frame: &PlanarFrame<f32>, measured: &Vector2<f32>) -> Option<InverseOf<Self>> {
        let jacobian = Matrix2::new(frame.cosine, -frame.sine, frame.sine, frame.cosine);
        Some(Inverse { feature: frame.position + jacobian * measured, jacobian })
    }

    fn by_pose(&self, frame: &PlanarFrame<f32>, feature: &Vector2<f32>, expected: &ExpectedOf<Self>) -> Matrix2x3<f32> {
        frame.by_pose(&expected.jacobian, feature)
    }
}

/// Where it sees: a square before it, of this side, m.
#[derive(Debug, Clone, Copy)]
pub struct Square(pub f32);

impl FieldOfView<PlanarFrame<f32>, Vector2<f32>, Vector2<f32>> for Square {
    fn detection_probability(&self, _: &PlanarFrame<f32>, _: &Vector2<f32>, expected: &Vector2<f32>) -> f32 {
        if (0.0..self.0).contains(&expected.x) && expected.y.abs() < 0.5 * self.0 { 0.9 } else { 0.0 }
    }

    fn bounds(&self, frame: &PlanarFrame<f32>) -> Bounds<Vector2<f32>> {
        Bounds::around(&frame.position, 1.2 * self.0)
    }
}
