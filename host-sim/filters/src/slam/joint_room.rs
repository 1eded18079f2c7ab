//! Memory of a joint filter on the host.

use super::MEASUREMENTS;
use scphd::errors::SetupError;
use scphd::models::{Motion, ScalarOf};
use scphd::numerics::Vector;
use scphd::settings::MovingConfig;
use scphd::storage::{JointMovers, NoArchive, Tracked};
use scphd::{JointConfig, JointSlam, JointState};

/// Capacity of the host's state for features.
pub(super) const FEATURES: usize = 1024;
/// Capacity for moving objects.
pub(super) const MOVERS: usize = 256;

/// A joint state, and optional moving-object tracks.
pub(super) struct JointRoom<M: Motion, Z: Vector<Scalar = ScalarOf<M::Pose>>, const NUMBERS: usize> {
    state: JointState<M::Pose, Z, FEATURES, NUMBERS, MEASUREMENTS>,
    movers: Option<JointMovers<M::Pose, MOVERS>>,
    moving: Option<MovingConfig<ScalarOf<M::Pose>>>,
}

/// The filter over it.
pub(super) type Joint<'s, M, Z> = JointSlam<'s, M, Z, NoArchive, Option<Tracked<'s, <M as Motion>::Pose>>>;

impl<M: Motion, Z: Vector<Scalar = ScalarOf<M::Pose>>, const NUMBERS: usize> JointRoom<M, Z, NUMBERS> {
    /// A state without moving-object tracks, or with tracks of this motion model.
    pub(super) fn new(moving: Option<MovingConfig<ScalarOf<M::Pose>>>) -> Self {
        Self { state: JointState::new(), movers: moving.map(|_| JointMovers::new()), moving }
    }

    /// The filter over the state that the last filter left.
    pub(super) fn filter(
        &mut self,
        motion: M,
        config: JointConfig<ScalarOf<M::Pose>>,
    ) -> Result<Joint<'_, M, Z>, SetupError> {
        let movers = self.movers.as_mut().zip(self.moving);
        JointSlam::new(motion, config, &mut self.state)?.with_movers_if(movers)
    }
}
