//! All memory of a filter.

use crate::detection::maps::{DynamicMaps, StaticMaps};
use crate::filter::waiting::memory::{MOST_WORDS, Waiting, WaitingMemory};
use crate::map::{MapStorage, NoMoving};
use crate::particles::candidate::Candidate;
use crate::particles::cursor::Cursor;
use crate::{Config, CovarianceOf, Dynamic, Flaw, Pose, Proposal, Real, ScalarOf, SetupError, Static, Symmetric};

/// All memory of a filter: its estimate and its working memory, with every capacity in the type.
///
/// `size_of` this type is the RAM of a filter. It is meant to be a `static`: [`State::new`] is all zero and takes no flash, and the
/// state is never copied through the stack.
///
/// | parameter | meaning |
/// |---|---|
/// | `P` | pose |
/// | `PARTICLES` | maximum number of particles |
/// | `CANDIDATES` | particles × samples, at least `PARTICLES` |
/// | `S` | memory of the static features, a [`MapMemory`](crate::MapMemory) |
/// | `V` | memory of the moving features, a [`MapMemory`](crate::MapMemory) or [`NoMoving`] |
/// | `WAITING` | 1 to 4 words of 64 measurements each, whose births can [wait](crate::Config::births_wait) for the next scan |
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::PlanarPose;
/// use scphd::storage::{Dynamic, MapMemory, Static};
/// use scphd::State;
///
/// type Still = MapMemory<Static<Vector2<f32>>, 32, 240, 16, 256>;
/// type Moving = MapMemory<Dynamic<Vector2<f32>>, 32, 48, 8, 128>;
/// type Memory = State<PlanarPose<f32>, 32, 64, Still, Moving>;
/// static mut STATE: Memory = State::new();
/// assert!(size_of::<Memory>() < 128 * 1024);
/// ```
#[derive(Debug)]
pub struct State<P: Pose, const PARTICLES: usize, const CANDIDATES: usize, S, V = NoMoving, const WAITING: usize = 1> {
    cursor: Cursor<P::Scalar>,
    pose_covariances: [Symmetric<P::Tangent>; PARTICLES],
    selected_covariances: [Symmetric<P::Tangent>; PARTICLES],
    candidates: [Candidate<P>; CANDIDATES],
    ln_likelihoods: [P::Scalar; CANDIDATES],
    selected: [Candidate<P>; PARTICLES],
    survivors: [u16; PARTICLES],
    static_maps: S,
    moving_maps: V,
    waiting: WaitingMemory<P, PARTICLES, CANDIDATES, WAITING>,
}

impl<T: Real, P: Pose<Scalar = T>, const PARTICLES: usize, const CANDIDATES: usize, S, V, const WAITING: usize>
    State<P, PARTICLES, CANDIDATES, S, V, WAITING>
where
    S: MapStorage<Static<P::Position>>,
    V: MapStorage<Dynamic<P::Position>>,
{
    /// An empty state, all zero, to be started by [`ScPhd::reset`](crate::ScPhd::reset).
    ///
    /// Invalid capacities do not compile.
    pub const fn new() -> Self {
        const {
            assert!(PARTICLES >= 1, "a filter needs a particle");
            assert!(CANDIDATES >= PARTICLES, "CANDIDATES must be at least PARTICLES");
            assert!(CANDIDATES <= u16::MAX as usize, "candidates are counted in 16 bits");
            assert!(WAITING >= 1 && WAITING <= MOST_WORDS, "WAITING is one to four words of 64 measurements");
            assert!(S::PARTICLES >= PARTICLES, "every particle needs a static map");
            assert!(V::PARTICLES >= PARTICLES || V::PARTICLES == 0, "every particle needs a moving map, or none");
        }
        Self {
            cursor: Cursor::ZERO,
            pose_covariances: [Symmetric::ZERO; PARTICLES],
            selected_covariances: [Symmetric::ZERO; PARTICLES],
            candidates: [Candidate::ZERO; CANDIDATES],
            ln_likelihoods: [T::ZERO; CANDIDATES],
            selected: [Candidate::ZERO; PARTICLES],
            survivors: [0; PARTICLES],
            static_maps: S::ZERO,
            moving_maps: V::ZERO,
            waiting: WaitingMemory::ZERO,
        }
    }

    /// Marks the state as empty, so that a filter with any configuration can be started on it. Its [reset](crate::ScPhd::reset)
    /// then empties the maps.
    pub fn clear(&mut self) {
        self.cursor = Cursor::ZERO;
    }

    /// The state as slices, independent of its capacities.
    pub(crate) fn memory(&mut self) -> Memory<'_, P> {
        Memory {
            cursor: &mut self.cursor,
            pose_covariances: &mut self.pose_covariances,
            selected_covariances: &mut self.selected_covariances,
            candidates: &mut self.candidates,
            ln_likelihoods: &mut self.ln_likelihoods,
            selected: &mut self.selected,
            survivors: &mut self.survivors,
            static_maps: self.static_maps.maps(),
            moving_maps: self.moving_maps.maps(),
            waiting: self.waiting.view(),
        }
    }
}

/// The properties of a state that a configuration must match to continue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Held {
    pub(crate) particles: usize,
    /// Candidates of each particle.
    pub(crate) children: usize,
    /// Whether there was a prediction since the last scan.
    pub(crate) predicted: bool,
    /// Whether poses have covariances.
    pub(crate) has_covariances: bool,
}

impl Held {
    /// Whether a filter with this configuration can continue from the state.
    pub(crate) fn check<T: Real>(self, config: &Config<T>) -> Result<(), SetupError> {
        let (held, configured) = (self.particles, config.particles);
        if held != configured {
            return Err(SetupError::HeldParticles { held, configured });
        }
        let (held, informed) = (self.children, matches!(config.proposal, Proposal::Informed(_)));
        let configured = if informed { 1 } else { config.samples };
        // Between a scan and the next prediction, any number of samples is valid.
        if held != 1 && !self.predicted || self.predicted && held != configured {
            return Err(SetupError::HeldSamples { held, configured });
        }
        if self.has_covariances && !informed { Err(SetupError::HeldCovariance) } else { Ok(()) }
    }
}

/// The state as slices, independent of its capacities: the recursion works on this type.
#[derive(Debug)]
pub(crate) struct Memory<'s, P: Pose> {
    pub(crate) cursor: &'s mut Cursor<ScalarOf<P>>,
    /// With the informed proposal, the covariance of every particle's pose since the last scan; otherwise zero.
    pub(crate) pose_covariances: &'s mut [CovarianceOf<P>],
    /// Covariances of the selected candidates.
    pub(crate) selected_covariances: &'s mut [CovarianceOf<P>],
    pub(crate) candidates: &'s mut [Candidate<P>],
    pub(crate) ln_likelihoods: &'s mut [ScalarOf<P>],
    pub(crate) selected: &'s mut [Candidate<P>],
    pub(crate) survivors: &'s mut [u16],
    pub(crate) static_maps: StaticMaps<'s, P>,
    pub(crate) moving_maps: DynamicMaps<'s, P>,
    /// Delayed births.
    pub(crate) waiting: Waiting<'s, P>,
}

impl<T: Real, P: Pose<Scalar = T>> Memory<'_, P> {
    /// Whether a filter with this configuration, which fits the memory, can continue from the content of the memory.
    pub(crate) fn check(&mut self, config: &Config<T>) -> Result<(), SetupError> {
        self.check_held(config)?;
        self.audit().map_err(SetupError::HeldDamaged)
    }

    /// The same check without the audit.
    pub(crate) fn check_held(&self, config: &Config<T>) -> Result<(), SetupError> {
        let Cursor { particles, children, predicted, .. } = *self.cursor;
        if particles == 0 {
            return Ok(());
        }
        let pose_covariances = self.pose_covariances.get(..particles).unwrap_or(&[]);
        let has_covariances = pose_covariances.iter().any(|pose_covariance| *pose_covariance != Symmetric::ZERO);
        Held { particles, children, predicted, has_covariances }.check(config)
    }

    /// Whether the counts match the configuration. There may be fewer particles than the capacity.
    pub(crate) fn check_counts(&self, config: &Config<T>) -> Result<(), Flaw> {
        let Cursor { particles, children, predicted, .. } = *self.cursor;
        Held { particles, children, predicted, has_covariances: false }.check(config).map_err(|_| Flaw::Cursor)
    }

    /// The candidates in use.
    pub(crate) fn candidates(&self) -> &[Candidate<P>] {
        self.candidates.get(..self.cursor.candidates()).unwrap_or(&[])
    }
}
