//! Memory of a joint filter on the host.

use scphd::errors::SetupError;
use scphd::models::{Motion, ScalarOf};
use scphd::numerics::Vector;
use scphd::settings::MovingConfig;
use scphd::storage::{JointMovers, Movers, NoArchive, NoMovers, Tracked};
use scphd::{JointConfig, JointSlam, JointState};
use std::fmt::Debug;

/// Features that the host's state has room for.
pub(super) const FEATURES: usize = 1024;
/// Features that may move.
pub(super) const MOVERS: usize = 256;

/// A joint state of whatever capacities.
pub(crate) trait JointRoom<M: Motion, Z: Vector>: Debug + 'static {
    /// What moves beside it, if anything may.
    type Moving<'s>: Movers<M::Pose>;

    /// The filter over it, which goes on from where the last one left off.
    fn filter(
        &mut self,
        motion: M,
        config: JointConfig<ScalarOf<M::Pose>>,
    ) -> Result<JointSlam<'_, M, Z, NoArchive, Self::Moving<'_>>, SetupError>;
}

impl<M, Z, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize> JointRoom<M, Z>
    for JointState<M::Pose, Z, FEATURES, NUMBERS, MEASUREMENTS>
where
    M: Motion<Pose: 'static>,
    Z: Vector<Scalar = ScalarOf<M::Pose>> + 'static,
{
    type Moving<'s> = NoMovers;

    fn filter(&mut self, motion: M, config: JointConfig<ScalarOf<M::Pose>>) -> Result<JointSlam<'_, M, Z>, SetupError> {
        JointSlam::new(motion, config, self)
    }
}

/// A joint state, and what moves beside it.
#[derive(Debug)]
pub(super) struct WithMovers<M: Motion, S> {
    pub(super) state: S,
    pub(super) movers: JointMovers<M::Pose, MOVERS>,
    pub(super) moving: MovingConfig<ScalarOf<M::Pose>>,
}

impl<M, Z, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize> JointRoom<M, Z>
    for WithMovers<M, JointState<M::Pose, Z, FEATURES, NUMBERS, MEASUREMENTS>>
where
    M: Motion<Pose: 'static> + Debug + 'static,
    Z: Vector<Scalar = ScalarOf<M::Pose>> + 'static,
{
    type Moving<'s> = Tracked<'s, M::Pose>;

    fn filter(
        &mut self,
        motion: M,
        config: JointConfig<ScalarOf<M::Pose>>,
    ) -> Result<JointSlam<'_, M, Z, NoArchive, Tracked<'_, M::Pose>>, SetupError> {
        JointSlam::new(motion, config, &mut self.state)?.with_movers(&mut self.movers, self.moving)
    }
}
