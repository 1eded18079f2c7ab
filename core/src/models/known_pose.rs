//! A sensor with a known pose, with which the filter is a GM-PHD tracker (section 4.2).

use super::{Linearised, Motion, Pose, Rates};
use crate::{Noise, ScalarOf, Symmetric, TangentOf, Zero};
use core::marker::PhantomData;

/// A vehicle whose pose at the end of every prediction is given as the control.
///
/// With one particle and this motion the filter is the Gaussian-mixture PHD filter of section 4.2.
///
/// A prediction with `dt` = 0 does not change the pose; to move the sensor in zero time, use [`relocate`](crate::ScPhd::relocate).
///
/// ```
/// use scphd::models::{KnownPose, PlanarPose};
///
/// let mast = KnownPose::<PlanarPose<f32>>::new();
/// # let _ = mast;
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KnownPose<P>(PhantomData<P>);

impl<P> KnownPose<P> {
    /// A vehicle with this type of pose.
    pub const fn new() -> Self {
        Self(PhantomData)
    }
}

impl<P> Default for KnownPose<P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<P: Pose> Motion for KnownPose<P> {
    type Pose = P;
    type Control = P;

    fn admits(&self, control: &P) -> bool {
        control.is_finite()
    }

    fn rates(&self, _control: &P) -> Rates<ScalarOf<P>> {
        Rates::NONE
    }

    fn propagate(&self, _pose: &P, control: &P, _dt: ScalarOf<P>) -> P {
        *control
    }

    fn sample(&self, _pose: &P, control: &P, _dt: ScalarOf<P>, _noise: &mut Noise) -> P {
        *control
    }

    fn linearise(&self, _pose: &P, _control: &P, _dt: ScalarOf<P>) -> Linearised<TangentOf<P>> {
        Linearised { transition: Zero::ZERO, noise: Symmetric::ZERO }
    }
}
