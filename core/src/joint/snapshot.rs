//! Snapshots of the joint filter.

use super::archive::Archive;
use super::archiving::mark_anchors;
use super::filter::JointSlam;
use super::movers::Movers;
use super::walk::{audit_archive, audit_movers, fill_archive, fill_movers, walk_archive, walk_movers};
use crate::snapshot::frame::{Content, Head, Shape};
use crate::snapshot::read::{Reader, checked, numbers};
use crate::snapshot::visit::{Visit, Walk};
use crate::snapshot::write::write;
use crate::{Flaw, Motion, Pose, Real, RestoreError, SaveError, TangentOf, Vector};

/// The third size of a head has the number of moving-object tracks plus one from this bit on; 0 without tracks.
const MOVERS_AT: u32 = 16;

/// The shape of a snapshot with joint maps.
pub(super) fn shape<P: Pose>(content: Content, kind: u32) -> Shape {
    Shape {
        content,
        scalar: size_of::<P::Scalar>() as u8,
        dimensions: [TangentOf::<P>::DIMENSION as u8, P::Position::DIMENSION as u8, numbers::<P>()],
        kind,
    }
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, A, V>
{
    /// Checks the complete filter state: the pose, every feature, every number of the covariance. The cost is linear in
    /// the size of the state; no step calls it.
    ///
    /// # Errors
    /// The first flaw that is found. A variance that rounding has made invalid is not a flaw: the next scan repairs it
    /// or removes the feature.
    pub fn audit(&self) -> Result<(), Flaw> {
        if self.memory.header.started {
            self.memory.estimate().audit()?;
            audit_archive(self.archive.kept())?;
            audit_movers(&self.movers)?;
        }
        Ok(())
    }

    /// Writes a snapshot of the filter, as [`ScPhd::save`](crate::ScPhd::save) does.
    ///
    /// # Errors
    /// The filter has not been reset, the state is damaged, or the sink returns an error; the state is unchanged.
    pub fn save<E>(&self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        let memory = &self.memory;
        if !memory.header.started {
            return Err(SaveError::NotStarted);
        }
        self.audit().map_err(SaveError::Damaged)?;
        let [features, archived] =
            [memory.header.len, self.archive.kept().len()].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        let with_archive = u32::from(self.archive.index().is_some());
        let with_movers = if self.movers.are_tracked() { 1 + self.movers.kept().len() as u32 } else { 0 };
        let sizes = [features, archived, with_archive | with_movers << MOVERS_AT];
        let head = Head { shape: shape::<M::Pose>(Content::Joint, kind), flags: 0, len: 0, sizes };
        write(head, self, [&mut [], &mut []], sink)
    }

    /// Continues from a [snapshot](Self::save), with the same bits as the filter that wrote it, as
    /// [`ScPhd::restore`](crate::ScPhd::restore) does.
    ///
    /// # Errors
    /// As for [`ScPhd::restore`](crate::ScPhd::restore): an error that is found in the first pass over the bytes leaves
    /// the state unchanged. If the source gives other bytes in the second pass, or a snapshot with correct checksums
    /// was not written by a filter, the filter is left not started.
    pub fn restore<E>(
        &mut self,
        kind: u32,
        mut source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        let memory = &mut self.memory;
        let head = checked(&mut source, shape::<M::Pose>(Content::Joint, kind))?;
        let [features, archived, others] = head.sizes.map(|size| usize::try_from(size).unwrap_or(usize::MAX));
        let (with_archive, with_movers) = (others & ((1 << MOVERS_AT) - 1), others >> MOVERS_AT);
        RestoreError::check_room("features", features, memory.landmarks.len())?;
        let mut view = self.archive.view();
        let room = view.as_ref().map_or(0, |view| view.entries.len());
        RestoreError::check_room("archived features", archived, room)?;
        RestoreError::check_room("archives", with_archive, usize::from(view.is_some()))?;
        let mut tracks = self.movers.tracks();
        let room = tracks.as_ref().map_or(0, |tracks| 1 + tracks.movers.len());
        RestoreError::check_room("movers", with_movers, room)?;
        let mut reader = Reader::behind(&head, &mut source);
        memory.fill(features, &mut reader);
        if let Some(view) = &mut view {
            view.clear();
            if with_archive > 0 {
                fill_archive(view, archived, &mut reader);
                mark_anchors(view, memory);
            }
        }
        if let Some(tracks) = &mut tracks {
            tracks.clear();
            if let Some(movers) = with_movers.checked_sub(1) {
                fill_movers(tracks, movers, &mut reader);
            }
        }
        let kept = || view.as_ref().and_then(|view| view.entries.get(..view.index.len)).unwrap_or(&[]);
        let taken = reader.end().and_then(|()| {
            let sound = if memory.header.started { memory.estimate().audit() } else { Err(Flaw::Cursor) };
            let sound = sound.and_then(|()| audit_archive(kept())).and_then(|()| audit_movers(&self.movers));
            sound.map_err(RestoreError::Flawed)
        });
        if taken.is_err() {
            (memory.header.started, memory.header.len) = (false, 0);
        }
        taken.map(|()| head.len())
    }
}

/// The state, and the archive and the tracks if there are any.
impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>> Walk
    for JointSlam<'_, M, Z, A, V>
{
    fn walk(&self, visit: &mut impl Visit) {
        self.memory.estimate().walk(visit);
        if let Some(index) = self.archive.index() {
            walk_archive(self.archive.kept(), index, visit);
        }
        if let Some((common, _)) = self.movers.common() {
            walk_movers(self.movers.kept(), common, visit);
        }
    }
}
