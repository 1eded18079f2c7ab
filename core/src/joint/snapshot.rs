//! Snapshots of the joint filter.

use super::archive::Archive;
use super::filter::JointSlam;
use super::walk::{audit_archive, fill_archive, walk_archive};
use crate::snapshot::frame::{Content, Head, Shape};
use crate::snapshot::read::{Reader, checked, numbers};
use crate::snapshot::visit::{Visit, Walk};
use crate::snapshot::write::write;
use crate::{Flaw, Motion, Pose, Real, RestoreError, SaveError, TangentOf, Vector};

/// What snapshots of such a filter have in common.
fn shape<P: Pose>(kind: u32) -> Shape {
    Shape {
        content: Content::Joint,
        scalar: size_of::<P::Scalar>() as u8,
        dimensions: [TangentOf::<P>::DIMENSION as u8, P::Position::DIMENSION as u8, numbers::<P>()],
        kind,
    }
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>> JointSlam<'_, M, Z, A> {
    /// Looks over everything that the filter knows: the pose, every feature, every number of the covariance. Linear in the state,
    /// and no part of a step.
    ///
    /// # Errors
    /// The first flaw that was found. A variance that rounding has spoilt is none: the next scan mends it, or drops the feature.
    pub fn audit(&self) -> Result<(), Flaw> {
        if self.memory.known.started {
            self.memory.audit()?;
            audit_archive(self.archive.kept())?;
        }
        Ok(())
    }

    /// Writes down all that decides how the filter goes on, as [`ScPhd::save`](crate::ScPhd::save) does.
    ///
    /// # Errors
    /// The filter has not been reset, the state is damaged, or the sink takes no more; the state is as it was.
    pub fn save<E>(&self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        let memory = &self.memory;
        if !memory.known.started {
            return Err(SaveError::NotStarted);
        }
        self.audit().map_err(SaveError::Damaged)?;
        let [features, archived] =
            [memory.known.len, self.archive.kept().len()].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        let with_archive = u32::from(self.archive.index().is_some());
        let head = Head { shape: shape::<M::Pose>(kind), flags: 0, len: 0, sizes: [features, archived, with_archive] };
        write(head, self, [&mut [], &mut []], sink)
    }

    /// Goes on from a [snapshot](Self::save), as if nothing had been, as [`ScPhd::restore`](crate::ScPhd::restore) does.
    ///
    /// # Errors
    /// As for that: whatever the first look at the bytes finds leaves the state as it was. If the source gives something else the
    /// second time, or a snapshot whose checks agree was not written by a filter, the filter is not started.
    pub fn restore<E>(
        &mut self,
        kind: u32,
        mut source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        let memory = &mut self.memory;
        let head = checked(&mut source, shape::<M::Pose>(kind))?;
        let [features, archived, with_archive] = head.sizes.map(|size| usize::try_from(size).unwrap_or(usize::MAX));
        RestoreError::check_room("features", features, memory.slots.len())?;
        let mut shelf = self.archive.shelf();
        let room = shelf.as_ref().map_or(0, |shelf| shelf.entries.len());
        RestoreError::check_room("archived features", archived, room)?;
        RestoreError::check_room("archives", with_archive, usize::from(shelf.is_some()))?;
        let mut reader = Reader::behind(&head, &mut source);
        memory.fill(features, &mut reader);
        if let Some(shelf) = &mut shelf {
            shelf.clear();
            if with_archive > 0 {
                fill_archive(shelf, archived, &mut reader);
            }
        }
        let kept = || shelf.as_ref().and_then(|shelf| shelf.entries.get(..shelf.index.len)).unwrap_or(&[]);
        let taken = reader.end().and_then(|()| {
            let sound = if memory.known.started { memory.audit() } else { Err(Flaw::Cursor) };
            sound.and_then(|()| audit_archive(kept())).map_err(RestoreError::Flawed)
        });
        if taken.is_err() {
            (memory.known.started, memory.known.len) = (false, 0);
        }
        taken.map(|()| head.len())
    }
}

/// The state, and the archive if there is one.
impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>> Walk
    for JointSlam<'_, M, Z, A>
{
    fn walk(&self, visit: &mut impl Visit) {
        self.memory.walk(visit);
        if let Some(index) = self.archive.index() {
            walk_archive(self.archive.kept(), index, visit);
        }
    }
}
