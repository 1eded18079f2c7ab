//! Memory of joint filters on the host.

use super::MEASUREMENTS;
use super::fixes::Observes;
use scphd::errors::SetupError;
use scphd::models::{Motion, ScalarOf};
use scphd::numerics::Vector;
use scphd::settings::{HypothesesConfig, MovingConfig};
use scphd::storage::{JointFilter, JointHypotheses, JointMovers, NoArchive, Tracked};
use scphd::{JointConfig, JointSlam, JointState, MultiHypothesisSlam};

/// Capacity of the host's state for features.
pub(super) const FEATURES: usize = 1024;
/// Capacity of each of several hypotheses for features.
pub(super) const FEATURES_OF_EACH: usize = 512;
/// Capacity for hypotheses beside the likeliest.
const OTHERS: usize = 15;
/// Capacity for moving objects.
pub(super) const MOVERS: usize = 256;

type Numbers<M> = ScalarOf<<M as Motion>::Pose>;

/// The memory of a joint filter.
pub(super) trait JointRoom<M: Motion> {
    /// Whether the filter has one hypothesis, as the reference.
    const HAS_REFERENCE: bool;
    /// The filter over this memory.
    type Filter<'s>: JointFilter<Motion = M> + Observes<M::Pose>
    where
        Self: 's;

    /// The filter over the state that the last filter left.
    fn filter(&mut self, motion: M, config: JointConfig<Numbers<M>>) -> Result<Self::Filter<'_>, SetupError>;
}

/// The state of one hypothesis, and optional moving-object tracks.
pub(super) struct One<M: Motion, Z: Vector<Scalar = Numbers<M>>, const FEATURES: usize, const NUMBERS: usize> {
    state: JointState<M::Pose, Z, FEATURES, NUMBERS, MEASUREMENTS>,
    movers: Option<JointMovers<M::Pose, MOVERS>>,
    moving: Option<MovingConfig<Numbers<M>>>,
}

impl<M: Motion, Z: Vector<Scalar = Numbers<M>>, const FEATURES: usize, const NUMBERS: usize>
    One<M, Z, FEATURES, NUMBERS>
{
    /// A state without moving-object tracks, or with tracks of this motion model.
    pub(super) fn new(moving: Option<MovingConfig<Numbers<M>>>) -> Self {
        Self { state: JointState::new(), movers: moving.map(|_| JointMovers::new()), moving }
    }
}

type Single<'s, M, Z> = JointSlam<'s, M, Z, NoArchive, Option<Tracked<'s, <M as Motion>::Pose>>>;

impl<M: Motion + 'static, Z: Vector<Scalar = Numbers<M>>, const FEATURES: usize, const NUMBERS: usize> JointRoom<M>
    for One<M, Z, FEATURES, NUMBERS>
{
    const HAS_REFERENCE: bool = true;
    type Filter<'s> = Single<'s, M, Z>;

    fn filter(&mut self, motion: M, config: JointConfig<Numbers<M>>) -> Result<Single<'_, M, Z>, SetupError> {
        let movers = self.movers.as_mut().zip(self.moving);
        JointSlam::new(motion, config, &mut self.state)?.with_movers_if(movers)
    }
}

/// The state of up to 16 hypotheses.
pub(super) struct Several<M: Motion, Z: Vector<Scalar = Numbers<M>>, const NUMBERS: usize> {
    likeliest: One<M, Z, FEATURES_OF_EACH, NUMBERS>,
    others: JointHypotheses<M::Pose, OTHERS, FEATURES_OF_EACH, NUMBERS, MOVERS>,
    hypotheses: HypothesesConfig<Numbers<M>>,
}

impl<M: Motion, Z: Vector<Scalar = Numbers<M>>, const NUMBERS: usize> Several<M, Z, NUMBERS> {
    /// A state with so many hypotheses at most.
    pub(super) fn new(most: usize, moving: Option<MovingConfig<Numbers<M>>>) -> Self {
        let hypotheses = HypothesesConfig { most, ..HypothesesConfig::default() };
        Self { likeliest: One::new(moving), others: JointHypotheses::new(), hypotheses }
    }
}

impl<M: Motion + 'static, Z: Vector<Scalar = Numbers<M>>, const NUMBERS: usize> JointRoom<M>
    for Several<M, Z, NUMBERS>
{
    const HAS_REFERENCE: bool = false;
    type Filter<'s> = MultiHypothesisSlam<'s, M, Z, Option<Tracked<'s, M::Pose>>, OTHERS>;

    fn filter(&mut self, motion: M, config: JointConfig<Numbers<M>>) -> Result<Self::Filter<'_>, SetupError> {
        self.likeliest.filter(motion, config)?.with_hypotheses(&mut self.others, self.hypotheses)
    }
}
