//! Memory of a joint filter on the host.

use scphd::{JointConfig, JointSlam, JointState, Motion, ScalarOf, SetupError, Vector};
use std::fmt::Debug;

/// Features and measurements in a scan that the host's state has room for.
pub(super) const FEATURES: usize = 1024;
pub(super) const MEASUREMENTS: usize = 256;

/// A joint state of whatever capacities.
pub(crate) trait JointRoom<M: Motion, Z: Vector>: Debug {
    /// The filter over it, which goes on from where the last one left off.
    fn filter(&mut self, motion: M, config: JointConfig<ScalarOf<M::Pose>>) -> Result<JointSlam<'_, M, Z>, SetupError>;
}

impl<M, Z, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize> JointRoom<M, Z>
    for JointState<M::Pose, Z, FEATURES, NUMBERS, MEASUREMENTS>
where
    M: Motion,
    Z: Vector<Scalar = ScalarOf<M::Pose>>,
{
    fn filter(&mut self, motion: M, config: JointConfig<ScalarOf<M::Pose>>) -> Result<JointSlam<'_, M, Z>, SetupError> {
        JointSlam::new(motion, config, self)
    }
}
