//! Restoring a snapshot.

use crate::filter::save::{HAS_MOVING, HAS_WAITING, INFORMED, PREDICTED, shape};
use crate::filter::state::{Held, Memory};
use crate::particles::cursor::Cursor;
use crate::snapshot::frame::{Head, halves};
use crate::snapshot::read::{Reader, checked};
use crate::{Flaw, Motion, Pose, Real, RestoreError, ScPhd, SetupError, Symmetric};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// Continues from a [snapshot](Self::save), with the same bits as the filter that wrote it. The memory may have another
    /// capacity if the snapshot fits in it; with another capacity or tuning, later results differ where they depend on these.
    /// [`ln_likelihoods`](Self::ln_likelihoods) and [`survivors`](Self::survivors) are empty until the next scan.
    ///
    /// `source` is called with an offset and returns at most 64 bytes from there. All bytes are read twice: the first pass checks
    /// them and changes nothing, the second restores them. Returns the number of bytes; bytes behind the snapshot are ignored.
    ///
    /// # Errors
    /// The bytes are not a snapshot, or one of another version, another type of vehicle or another filter; they are damaged or
    /// truncated; or they do not fit the memory or the configuration: the state is unchanged. If the source returns other bytes in
    /// the second pass, or a snapshot with correct checksums was not written by a filter, the state may be lost: then there are no
    /// [particles](Self::particles), as before a reset.
    pub fn restore<E>(
        &mut self,
        kind: u32,
        mut source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        let Self { config, memory, .. } = self;
        let head = checked(&mut source, shape::<M::Pose>(kind))?;
        let held = memory.has_room_for(&head)?;
        held.check(config).map_err(RestoreError::Setup)?;
        memory.empty();
        let taken = memory.take(&head, held, &mut source).and_then(|()| {
            memory.check(config).map_err(|error| match error {
                SetupError::HeldDamaged(flaw) => RestoreError::Flawed(flaw),
                other => RestoreError::Setup(other),
            })
        });
        if taken.is_err() {
            memory.empty();
        }
        taken.map(|()| head.len())
    }
}

impl<T: Real, P: Pose<Scalar = T>> Memory<'_, P> {
    /// Sets the state to that before the first reset.
    fn empty(&mut self) {
        *self.cursor = Cursor::ZERO;
        self.pose_covariances.fill(Symmetric::ZERO);
        self.static_maps.clear();
        self.moving_maps.clear();
        self.waiting.forget();
    }

    /// The content of a snapshot, if the memory has room for it.
    fn has_room_for<E>(&self, head: &Head) -> Result<Held, RestoreError<E>> {
        let [[particles, children], [static_pages, longest], [moving, longest_moving]] = head.sizes.map(halves);
        let needs = [
            ("particles", particles, self.pose_covariances.len()),
            ("candidates", particles.saturating_mul(children), self.candidates.len()),
            ("pages", static_pages, self.static_maps.pool.capacity()),
            ("pages in a map", longest, self.static_maps.table.map_pages()),
            ("pages of moving features", moving, self.moving_maps.pool.capacity()),
            ("pages of moving features in a map", longest_moving, self.moving_maps.table.map_pages()),
        ];
        for (what, needed, capacity) in needs {
            RestoreError::check_room(what, needed, capacity)?;
        }
        let (predicted, has_covariances) = (head.flags & PREDICTED != 0, head.flags & INFORMED != 0);
        Ok(Held { particles, children, predicted, has_covariances })
    }

    /// Fills an empty state from the data behind a head with this content.
    fn take<S, E>(&mut self, head: &Head, held: Held, source: &mut S) -> Result<(), RestoreError<E>>
    where
        S: FnMut(usize, &mut [u8]) -> Result<(), E>,
    {
        let mut reader = Reader::behind(head, source);
        self.fill(held.has_covariances, head.flags & HAS_MOVING != 0, head.flags & HAS_WAITING != 0, &mut reader)?;
        reader.end()?;
        let Cursor { particles, children, predicted, .. } = *self.cursor;
        if particles == 0 || (particles, children, predicted) != (held.particles, held.children, held.predicted) {
            return Err(RestoreError::Flawed(Flaw::Cursor));
        }
        // `is_finite` also covers the parts of a pose that are not coordinates.
        let finite = self.candidates().iter().all(|candidate| candidate.pose.is_finite());
        if finite { Ok(()) } else { Err(RestoreError::Flawed(Flaw::Pose)) }
    }
}
