//! All memory of a filter.

use crate::map::{MapStorage, Maps, NoMoving};
use crate::{Config, Dim, Noise, Packed, Pose, Proposal, Real, SetupError, Symmetric, Twice, candidate::Candidate};

/// All memory of a filter: what it knows and its scratch, with every capacity in the type.
///
/// `size_of` this type is the RAM a filter takes. It belongs into a `static`: [`State::new`] is all zero and costs no
/// flash, and nothing of it ever crosses the stack.
///
/// | parameter | meaning |
/// |---|---|
/// | `T`, `P` | scalar and pose |
/// | `K` | dimension of the pose |
/// | `PARTICLES` | particles |
/// | `CANDIDATES` | particles × samples, at least `PARTICLES` |
/// | `S` | memory of the static features, a [`MapMemory`](crate::MapMemory) |
/// | `V` | memory of the moving features, a [`MapMemory`](crate::MapMemory) or [`NoMoving`] |
///
/// ```
/// use scphd::{MapMemory, PlanarPose, State};
///
/// // Maps in the plane: a static feature has a state of dimension 2, a moving one of dimension 4.
/// type Still = MapMemory<f32, 2, 2, 32, 240, 16, 256>;
/// type Moving = MapMemory<f32, 4, 2, 32, 48, 8, 128>;
/// type Memory = State<f32, PlanarPose<f32>, 3, 32, 64, Still, Moving>;
/// static mut STATE: Memory = State::new();
/// assert!(size_of::<Memory>() < 128 * 1024);
/// ```
#[derive(Debug)]
pub struct State<T: Real, P, const K: usize, const PARTICLES: usize, const CANDIDATES: usize, S, V = NoMoving>
where
    Dim<K>: Packed,
{
    cursor: Cursor<T>,
    spreads: [Symmetric<T, K>; PARTICLES],
    selected_spreads: [Symmetric<T, K>; PARTICLES],
    candidates: [Candidate<T, P>; CANDIDATES],
    ln_likelihoods: [T; CANDIDATES],
    selected: [Candidate<T, P>; PARTICLES],
    survivors: [u16; PARTICLES],
    still: S,
    moving: V,
}

impl<T: Real, P: Pose<T, K>, const K: usize, const PARTICLES: usize, const CANDIDATES: usize, S, V>
    State<T, P, K, PARTICLES, CANDIDATES, S, V>
where
    Dim<K>: Packed,
{
    /// An empty state, all zero, to be started by [`ScPhd::reset`](crate::ScPhd::reset).
    ///
    /// Capacities that cannot work do not compile.
    #[must_use]
    pub const fn new<const D: usize, const E: usize>() -> Self
    where
        S: MapStorage<T, D, D>,
        V: MapStorage<T, E, D>,
        Dim<D>: Packed + Twice<E>,
        Dim<E>: Packed,
    {
        const {
            assert!(PARTICLES >= 1, "a filter needs a particle");
            assert!(CANDIDATES >= PARTICLES, "CANDIDATES must be at least PARTICLES");
            assert!(CANDIDATES <= u16::MAX as usize, "candidates are counted in 16 bits");
            assert!(S::PARTICLES >= PARTICLES, "every particle needs a static map");
            assert!(V::PARTICLES >= PARTICLES || V::PARTICLES == 0, "every particle needs a moving map, or none");
        }
        Self {
            cursor: Cursor::ZERO,
            spreads: [Symmetric::ZERO; PARTICLES],
            selected_spreads: [Symmetric::ZERO; PARTICLES],
            candidates: [Candidate::zero::<K>(); CANDIDATES],
            ln_likelihoods: [T::ZERO; CANDIDATES],
            selected: [Candidate::zero::<K>(); PARTICLES],
            survivors: [0; PARTICLES],
            still: S::ZERO,
            moving: V::ZERO,
        }
    }

    /// Forgets what a filter has left here, so that a filter of any configuration can be started on it. The maps are emptied when
    /// that is [reset](crate::ScPhd::reset).
    pub fn clear(&mut self) {
        self.cursor = Cursor::ZERO;
    }

    /// The state as slices, whatever its capacities.
    pub(crate) fn memory<const D: usize, const E: usize>(&mut self) -> Memory<'_, T, P, K, D, E>
    where
        S: MapStorage<T, D, D>,
        V: MapStorage<T, E, D>,
        Dim<D>: Packed,
        Dim<E>: Packed,
    {
        Memory {
            cursor: &mut self.cursor,
            spreads: &mut self.spreads,
            selected_spreads: &mut self.selected_spreads,
            candidates: &mut self.candidates,
            ln_likelihoods: &mut self.ln_likelihoods,
            selected: &mut self.selected,
            survivors: &mut self.survivors,
            still: self.still.maps(),
            moving: self.moving.maps(),
        }
    }
}

/// The time since the last scan, with so much more. Times that no number can hold together stand still.
pub(crate) fn passed<T: Real>(waited_s: T, dt: T) -> T {
    let sum = waited_s + dt;
    if sum.is_finite() { sum } else { waited_s }
}

/// Where the recursion stands.
#[derive(Debug, Clone)]
pub(crate) struct Cursor<T> {
    /// Particles in use; zero before the first reset.
    pub(crate) particles: usize,
    /// Candidates of every particle: M between a prediction and the next scan, otherwise 1.
    pub(crate) children: usize,
    /// Whether the candidates have moved since the last scan.
    pub(crate) predicted: bool,
    /// Summed dt of the predictions since the last scan, s, which the moving features have still to be moved by.
    pub(crate) waited_s: T,
    /// Predictions refused since the last scan.
    pub(crate) refused: u16,
    /// Candidates that the last scan weighed; zero before the first.
    pub(crate) weighed: usize,
    /// The particle whose map is the estimate: the one that continues the heaviest surviving candidate of the last
    /// scan.
    pub(crate) heaviest: usize,
    /// The tag that the next feature gets. It wraps after four thousand million.
    pub(crate) next_tag: u32,
    /// The random stream; none before the first reset.
    pub(crate) noise: Option<Noise>,
}

impl<T: Real> Cursor<T> {
    const ZERO: Self = Self {
        particles: 0,
        children: 0,
        predicted: false,
        waited_s: T::ZERO,
        refused: 0,
        weighed: 0,
        heaviest: 0,
        next_tag: 0,
        noise: None,
    };

    /// So much more time has passed.
    pub(crate) fn wait(&mut self, dt: T) {
        self.waited_s = passed(self.waited_s, dt);
    }

    /// Number of candidates in use.
    pub(crate) fn candidates(&self) -> usize {
        self.particles.saturating_mul(self.children)
    }
}

/// The state as slices, whatever its capacities: what the recursion is written for.
#[derive(Debug)]
pub(crate) struct Memory<'s, T: Real, P, const K: usize, const D: usize, const E: usize>
where
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<E>: Packed,
{
    pub(crate) cursor: &'s mut Cursor<T>,
    /// With the informed proposal, the covariance of every particle's pose since the last scan; otherwise zero.
    pub(crate) spreads: &'s mut [Symmetric<T, K>],
    /// The same of the particles that go on.
    pub(crate) selected_spreads: &'s mut [Symmetric<T, K>],
    pub(crate) candidates: &'s mut [Candidate<T, P>],
    pub(crate) ln_likelihoods: &'s mut [T],
    pub(crate) selected: &'s mut [Candidate<T, P>],
    pub(crate) survivors: &'s mut [u16],
    pub(crate) still: Maps<'s, T, D, D>,
    pub(crate) moving: Maps<'s, T, E, D>,
}

impl<T: Real, P, const K: usize, const D: usize, const E: usize> Memory<'_, T, P, K, D, E>
where
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<E>: Packed,
{
    /// Whether a filter of this configuration, which fits the memory, can go on from what an earlier one has left in it.
    pub(crate) fn check(&mut self, config: &Config<T>) -> Result<(), SetupError>
    where
        P: Pose<T, K>,
    {
        let (held, configured) = (self.cursor.particles, config.particles);
        if held == 0 {
            return Ok(());
        }
        // Fewer are what a resampling has left that adapts their number.
        if held > configured || (held < configured && config.adaptive.is_none()) {
            return Err(SetupError::HeldParticles { held, configured });
        }
        let Cursor { children, predicted, .. } = *self.cursor;
        let informed = matches!(config.proposal, Proposal::Informed(_));
        let configured = if informed { 1 } else { config.samples };
        // Between a scan and the next prediction any number will do.
        if children != 1 && !predicted || predicted && children != configured {
            return Err(SetupError::HeldSamples { held: children, configured });
        }
        let spreads = self.spreads.get(..held).unwrap_or(&[]);
        if !informed && spreads.iter().any(|spread| *spread != Symmetric::ZERO) {
            return Err(SetupError::HeldSpread);
        }
        self.audit().map_err(SetupError::HeldDamaged)
    }

    /// The candidates in use.
    pub(crate) fn candidates(&self) -> &[Candidate<T, P>] {
        self.candidates.get(..self.cursor.candidates()).unwrap_or(&[])
    }
}
