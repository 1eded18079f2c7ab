//! A sensor whose pose is known: turns the filter into a GM-PHD tracker (section 4.2).

use super::{Linearised, Motion, PlanarPose, Pose};
use crate::{Noise, Real, Symmetric};
use nalgebra::SMatrix;

/// A vehicle whose pose at the end of every prediction is given as its control.
///
/// With one particle and this motion the filter is the Gaussian-mixture PHD filter of section 4.2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct KnownPose;

impl<T: Real> Motion<T, 3> for KnownPose {
    type Pose = PlanarPose<T>;
    type Control = PlanarPose<T>;

    fn admits(&self, control: &Self::Control) -> bool {
        control.is_finite()
    }

    fn propagate(&self, _pose: &Self::Pose, control: &Self::Control, _dt: T) -> Self::Pose {
        *control
    }

    fn sample(&self, _pose: &Self::Pose, control: &Self::Control, _dt: T, _noise: &mut Noise) -> Self::Pose {
        *control
    }

    fn linearise(&self, _pose: &Self::Pose, _control: &Self::Control, _dt: T) -> Linearised<T, 3> {
        Linearised { transition: SMatrix::zeros(), noise: Symmetric::ZERO }
    }
}
