//! Saving a snapshot of the filter.

use crate::filter::state::{Held, Memory};
use crate::map::Maps;
use crate::snapshot::frame::{Content, Head, Shape, pair};
use crate::snapshot::read::numbers;
use crate::snapshot::visit::{Visit, Walk};
use crate::snapshot::write::write;
use crate::{Feature, Motion, Pose, Proposal, Real, SaveError, ScPhd, Vector};

/// Flags of a head.
pub(super) const PREDICTED: u8 = 1;
pub(super) const INFORMED: u8 = 2;
pub(super) const HAS_MOVING: u8 = 4;
pub(super) const HAS_WAITING: u8 = 8;

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// Writes a snapshot for [`restore`](Self::restore): all data that influences later results, which are poses, weights, maps,
    /// the random stream and the time since the last scan. The sink gets the bytes in slices of at most 64. `kind` identifies the
    /// type of vehicle, so that a snapshot of another type is refused.
    ///
    /// The cost is linear in the size of the state; no step calls it. The reference counts of the pages are used as working memory
    /// and then restored, as in an [audit](Self::audit); the state is the same afterwards. Returns the number of bytes.
    /// `docs/snapshot.md` has the format.
    ///
    /// ```
    /// use scphd::models::{ControlNoise, PlanarPose, Step, Unicycle, UnicycleControl};
    /// use scphd::snapshot::{from_slice, into_slice};
    /// use scphd::{Config, ScPhd, memory};
    ///
    /// memory! {
    ///     type Memory: Unicycle<f32> { particles: 4, samples: 1, features { pages: 16, pages_per_map: 4, in_view: 32 } }
    /// }
    /// /// Any number that identifies this type of vehicle and its tuning.
    /// const KIND: u32 = 7;
    ///
    /// let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05))?;
    /// let (mut state, mut bytes) = (Box::new(Memory::new()), [0; 4096]);
    /// let mut slam = ScPhd::new(motion, Config::informed(4), &mut *state)?;
    /// slam.reset(PlanarPose::new(3.0, 0.0, 1.5), 1)?;
    /// let ahead = UnicycleControl { speed_mps: 1.0, rate_radps: 0.1 };
    /// slam.predict(&ahead, 0.1)?;
    /// let len = slam.save(KIND, into_slice(&mut bytes))?;
    ///
    /// // After a brown-out, in fresh memory.
    /// let mut state = Box::new(Memory::new());
    /// let mut restored = ScPhd::new(motion, Config::informed(4), &mut *state)?;
    /// restored.restore(KIND, from_slice(&bytes[..len]))?;
    /// assert_eq!(restored.digest(), slam.digest());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The filter has not been reset, the state is damaged, or the sink returns an error; the state is unchanged.
    pub fn save<E>(&mut self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        let informed = matches!(self.config.proposal, Proposal::Informed(_));
        let memory = &mut self.memory;
        if memory.cursor.particles == 0 {
            return Err(SaveError::NotStarted);
        }
        memory.check_counts(&self.config).and_then(|()| memory.audit()).map_err(SaveError::Damaged)?;
        let head = memory.head(kind, informed);
        let (of_static, of_moving) = (memory.static_maps.pool.lend_counts(), memory.moving_maps.pool.lend_counts());
        let written = write(head, &State { memory, informed }, [&mut *of_static, &mut *of_moving], sink);
        let particles = memory.cursor.particles;
        memory.static_maps.recount(particles, of_static);
        memory.moving_maps.recount(particles, of_moving);
        written
    }
}

/// A state to write, and whether the proposal is `informed`, in which case it has covariances of poses.
struct State<'m, 's, P: Pose> {
    memory: &'m Memory<'s, P>,
    informed: bool,
}

impl<T: Real, P: Pose<Scalar = T>> Walk for State<'_, '_, P> {
    fn walk(&self, visit: &mut impl Visit) {
        self.memory.walk(self.informed, visit);
    }
}

/// Properties that all snapshots of this type of filter have in common.
pub(super) fn shape<P: Pose>(kind: u32) -> Shape {
    Shape {
        content: Content::Mixture,
        scalar: size_of::<P::Scalar>() as u8,
        dimensions: [P::Tangent::DIMENSION as u8, P::Position::DIMENSION as u8, numbers::<P>()],
        kind,
    }
}

impl<T: Real, P: Pose<Scalar = T>> Memory<'_, P> {
    /// The head of a snapshot, without its length.
    fn head(&self, kind: u32, informed: bool) -> Head {
        let held = self.held(informed);
        let flag = |holds, flag| if holds { flag } else { 0 };
        let flags = flag(held.predicted, PREDICTED)
            | flag(held.has_covariances, INFORMED)
            | flag(!self.moving_maps.table.is_none(), HAS_MOVING)
            | flag(self.waiting.is_anything(), HAS_WAITING);
        let (static_maps, moving_maps) = (&self.static_maps, &self.moving_maps);
        let sizes = [
            pair(held.particles, held.children),
            pair(static_maps.pages_used(), static_maps.longest(held.particles)),
            pair(moving_maps.pages_used(), moving_maps.longest(held.particles)),
        ];
        Head { shape: shape::<P>(kind), flags, len: 0, sizes }
    }

    /// The properties of the state that a configuration must match to continue.
    fn held(&self, has_covariances: bool) -> Held {
        let cursor = &*self.cursor;
        Held { particles: cursor.particles, children: cursor.children, predicted: cursor.predicted, has_covariances }
    }
}

impl<'s, T: Real, F: Feature<Position: Vector<Scalar = T>>> Maps<'s, F> {
    /// Number of pages of the longest map.
    fn longest(&self, particles: usize) -> usize {
        (0..particles).map(|particle| self.table.pages(particle).len()).max().unwrap_or(0)
    }

    /// Takes the array of reference counts back after its use as scratch, and recomputes the counts.
    fn recount(&mut self, particles: usize, counts: &'s mut [u16]) {
        let Self { table, pool, .. } = self;
        pool.recount_all(counts, (0..particles).flat_map(|particle| table.pages(particle)));
    }
}
