//! All memory of a filter.

use crate::map::{MapTable, MapTableMemory, Pool, PoolMemory};
use crate::scan::Measurement;
use crate::workspace::{Workspace, WorkspaceMemory};
use crate::{Dim, LnSum, Noise, Packed, Pose, Real, candidate::Candidate};

/// All memory of a filter: what it knows and its scratch, with every capacity in the type.
///
/// `size_of` this type is the RAM a filter takes. It belongs into a `static`: [`State::new`] is all zero and costs no
/// flash, and nothing of it ever crosses the stack.
///
/// | parameter | meaning |
/// |---|---|
/// | `T`, `P` | scalar and pose |
/// | `K`, `D`, `Z` | dimensions of pose, map and measurement |
/// | `PARTICLES` | particles |
/// | `CANDIDATES` | particles × samples, at least `PARTICLES` |
/// | `PAGES` | pages of [`PAGE_LEN`](crate::PAGE_LEN) components in the pool that all maps share |
/// | `MAP_PAGES` | pages one map can have |
/// | `MEASUREMENTS` | measurements in a scan |
/// | `VIEW` | components of one map that the update of a scan may touch, before reduction |
///
/// ```
/// use scphd::{PlanarPose, State};
///
/// static mut STATE: State<f32, PlanarPose<f32>, 3, 2, 2, 32, 64, 512, 32, 64, 512> = State::new();
/// assert!(size_of::<State<f32, PlanarPose<f32>, 3, 2, 2, 32, 64, 512, 32, 64, 512>>() < 160 * 1024);
/// ```
#[derive(Debug)]
pub struct State<
    T: Real,
    P,
    const K: usize,
    const D: usize,
    const Z: usize,
    const PARTICLES: usize,
    const CANDIDATES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
    const MEASUREMENTS: usize,
    const VIEW: usize,
> where
    Dim<D>: Packed,
{
    cursor: Cursor,
    candidates: [Candidate<T, P>; CANDIDATES],
    ln_likelihoods: [T; CANDIDATES],
    selected: [Candidate<T, P>; PARTICLES],
    survivors: [u16; PARTICLES],
    maps: MapTableMemory<PARTICLES, MAP_PAGES>,
    next_maps: MapTableMemory<PARTICLES, MAP_PAGES>,
    pool: PoolMemory<T, D, D, PAGES>,
    measurements: [Measurement<T, Z>; MEASUREMENTS],
    eta: [LnSum<T>; MEASUREMENTS],
    workspace: WorkspaceMemory<T, D, VIEW>,
}

impl<
    T: Real,
    P: Pose<T, K>,
    const K: usize,
    const D: usize,
    const Z: usize,
    const PARTICLES: usize,
    const CANDIDATES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
    const MEASUREMENTS: usize,
    const VIEW: usize,
> State<T, P, K, D, Z, PARTICLES, CANDIDATES, PAGES, MAP_PAGES, MEASUREMENTS, VIEW>
where
    Dim<D>: Packed,
{
    /// An empty state, all zero, to be started by [`ScPhd::reset`](crate::ScPhd::reset).
    ///
    /// Capacities that cannot work do not compile.
    #[must_use]
    pub const fn new() -> Self {
        const {
            assert!(PARTICLES >= 1, "a filter needs a particle");
            assert!(CANDIDATES >= PARTICLES, "CANDIDATES must be at least PARTICLES");
            assert!(CANDIDATES <= u16::MAX as usize, "candidates are counted in 16 bits");
            assert!(PAGES >= 1 && PAGES <= u16::MAX as usize, "pages are counted in 16 bits");
            assert!(MAP_PAGES >= 1 && MAP_PAGES <= PAGES, "a map cannot have more pages than the pool");
            assert!(MEASUREMENTS <= u16::MAX as usize, "measurements are counted in 16 bits");
            assert!(VIEW >= crate::PAGE_LEN && VIEW < u16::MAX as usize, "VIEW must hold a page, and fit 16 bits");
        }
        Self {
            cursor: Cursor::ZERO,
            candidates: [Candidate::zero::<K>(); CANDIDATES],
            ln_likelihoods: [T::ZERO; CANDIDATES],
            selected: [Candidate::zero::<K>(); PARTICLES],
            survivors: [0; PARTICLES],
            maps: MapTableMemory::ZERO,
            next_maps: MapTableMemory::ZERO,
            pool: PoolMemory::ZERO,
            measurements: [Measurement::ZERO; MEASUREMENTS],
            eta: [LnSum::ZERO; MEASUREMENTS],
            workspace: WorkspaceMemory::ZERO,
        }
    }

    /// The state as slices, whatever its capacities.
    pub(crate) fn memory(&mut self) -> Memory<'_, T, P, D, Z> {
        Memory {
            cursor: &mut self.cursor,
            candidates: &mut self.candidates,
            ln_likelihoods: &mut self.ln_likelihoods,
            selected: &mut self.selected,
            survivors: &mut self.survivors,
            maps: self.maps.view(),
            next_maps: self.next_maps.view(),
            pool: self.pool.view(),
            measurements: &mut self.measurements,
            eta: &mut self.eta,
            workspace: self.workspace.view(),
        }
    }
}

impl<
    T: Real,
    P: Pose<T, K>,
    const K: usize,
    const D: usize,
    const Z: usize,
    const PARTICLES: usize,
    const CANDIDATES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
    const MEASUREMENTS: usize,
    const VIEW: usize,
> Default for State<T, P, K, D, Z, PARTICLES, CANDIDATES, PAGES, MAP_PAGES, MEASUREMENTS, VIEW>
where
    Dim<D>: Packed,
{
    fn default() -> Self {
        Self::new()
    }
}

/// Where the recursion stands.
#[derive(Debug, Clone)]
pub(crate) struct Cursor {
    /// Particles in use; zero before the first reset.
    pub(crate) particles: usize,
    /// Candidates of every particle: M between a prediction and the next scan, otherwise 1.
    pub(crate) children: usize,
    /// Whether the candidates have moved since the last scan.
    pub(crate) predicted: bool,
    /// Candidates that the last scan weighed; zero before the first.
    pub(crate) weighed: usize,
    /// The particle whose map is the estimate: the one that continues the heaviest surviving candidate of the last
    /// scan.
    pub(crate) heaviest: usize,
    /// The random stream; none before the first reset.
    pub(crate) noise: Option<Noise>,
}

impl Cursor {
    const ZERO: Self = Self { particles: 0, children: 0, predicted: false, weighed: 0, heaviest: 0, noise: None };

    /// Number of candidates in use.
    pub(crate) fn candidates(&self) -> usize {
        self.particles * self.children
    }
}

/// The state as slices, whatever its capacities: what the recursion is written for.
#[derive(Debug)]
pub(crate) struct Memory<'s, T: Real, P, const D: usize, const Z: usize>
where
    Dim<D>: Packed,
{
    pub(crate) cursor: &'s mut Cursor,
    pub(crate) candidates: &'s mut [Candidate<T, P>],
    pub(crate) ln_likelihoods: &'s mut [T],
    pub(crate) selected: &'s mut [Candidate<T, P>],
    pub(crate) survivors: &'s mut [u16],
    pub(crate) maps: MapTable<'s>,
    pub(crate) next_maps: MapTable<'s>,
    pub(crate) pool: Pool<'s, T, D, D>,
    pub(crate) measurements: &'s mut [Measurement<T, Z>],
    pub(crate) eta: &'s mut [LnSum<T>],
    pub(crate) workspace: Workspace<'s, T, D>,
}

impl<T: Real, P, const D: usize, const Z: usize> Memory<'_, T, P, D, Z>
where
    Dim<D>: Packed,
{
    /// The candidates in use.
    pub(crate) fn candidates(&self) -> &[Candidate<T, P>] {
        self.candidates.get(..self.cursor.candidates()).unwrap_or(&[])
    }
}
