//! Snapshots of several hypotheses.

use super::super::movers::Movers;
use super::super::snapshot::shape;
use super::super::walk::{audit_movers, fill_movers, walk_movers};
use super::filter::MultiHypothesisSlam;
use super::slot::{Slot, Weight};
use crate::snapshot::frame::{Content, Head};
use crate::snapshot::read::{Reader, checked};
use crate::snapshot::visit::{Visit, Walk};
use crate::snapshot::write::write;
use crate::{Flaw, Motion, Pose, Real, RestoreError, SaveError, Vector};

impl<T: Real, P: Pose<Scalar = T>, V: Movers<P>> Slot<'_, P, V> {
    fn walk(&self, visit: &mut impl Visit) {
        visit.word(self.header.len as u32);
        visit.word(self.movers.kept().len() as u32);
        visit.scalar(self.weight.ln);
        self.estimate().walk(visit);
        if let Some((common, _)) = self.movers.common() {
            walk_movers(self.movers.kept(), common, visit);
        }
    }
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    MultiHypothesisSlam<'_, M, Z, V, OTHERS>
{
    /// [`JointSlam::audit`](crate::JointSlam::audit) of every hypothesis, and of their weights.
    ///
    /// # Errors
    /// The first flaw that is found.
    pub fn audit(&self) -> Result<(), Flaw> {
        self.slam.audit()?;
        if !self.slam.memory.header.started {
            return Ok(());
        }
        for other in &self.others {
            if !other.weight.is_sound() {
                return Err(Flaw::Weights);
            }
            if other.weight.alive {
                if !other.header.started {
                    return Err(Flaw::Cursor);
                }
                other.estimate().audit()?;
                audit_movers(&other.movers)?;
            }
        }
        Ok(())
    }

    /// [`JointSlam::save`](crate::JointSlam::save) of all hypotheses.
    ///
    /// # Errors
    /// As there; the state is unchanged.
    pub fn save<E>(&self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        let header = &*self.slam.memory.header;
        if !header.started {
            return Err(SaveError::NotStarted);
        }
        self.audit().map_err(SaveError::Damaged)?;
        let features = u32::try_from(header.len).unwrap_or(u32::MAX);
        let others = self.alive().last().unwrap_or(0) as u32;
        let movers = if self.slam.movers.are_tracked() { 1 + self.slam.movers.kept().len() as u32 } else { 0 };
        let shape = shape::<M::Pose>(Content::Hypotheses, kind);
        write(Head { shape, flags: 0, len: 0, sizes: [features, others, movers] }, self, [&mut [], &mut []], sink)
    }

    /// Continues from a [snapshot](Self::save), with the same bits as the filter that wrote it.
    ///
    /// # Errors
    /// As for [`JointSlam::restore`](crate::JointSlam::restore).
    pub fn restore<E>(
        &mut self,
        kind: u32,
        mut source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        let head = checked(&mut source, shape::<M::Pose>(Content::Hypotheses, kind))?;
        let [features, others, movers] = head.sizes.map(|size| usize::try_from(size).unwrap_or(usize::MAX));
        RestoreError::check_room("features", features, self.slam.memory.landmarks.len())?;
        RestoreError::check_room("hypotheses", others, OTHERS)?;
        let room = self.slam.movers.tracks().map_or(0, |tracks| 1 + tracks.movers.len());
        RestoreError::check_room("movers", movers, room)?;
        let mut reader = Reader::behind(&head, &mut source);
        self.drop_others();
        self.slam.fill(features, movers.checked_sub(1), &mut reader);
        for place in 1..=others {
            if reader.word() == 0 {
                continue;
            }
            let (features, tracks) = (reader.word() as usize, reader.word() as usize);
            let ln = reader.scalar();
            self.with(place, |slam| slam.fill(features, movers.checked_sub(1).map(|_| tracks), &mut reader));
            if let Some(other) = self.others.get_mut(place - 1) {
                *other.weight = Weight { alive: true, ln };
            }
        }
        let taken = reader.end().and_then(|()| {
            let sound = if self.slam.memory.header.started { self.audit() } else { Err(Flaw::Cursor) };
            sound.map_err(RestoreError::Flawed)
        });
        if taken.is_err() {
            (self.slam.memory.header.started, self.slam.memory.header.len) = (false, 0);
            self.drop_others();
        }
        taken.map(|()| head.len())
    }
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>>
    crate::JointSlam<'_, M, Z, crate::storage::NoArchive, V>
{
    /// Reads the state from what a walk with this number of features and tracks has written.
    fn fill<S, E>(&mut self, features: usize, movers: Option<usize>, from: &mut Reader<'_, S, E>)
    where
        S: FnMut(usize, &mut [u8]) -> Result<(), E>,
    {
        self.memory.fill(features, from);
        if let Some(mut tracks) = self.movers.tracks() {
            tracks.clear();
            if let Some(movers) = movers {
                fill_movers(&mut tracks, movers, from);
            }
        }
    }
}

/// Visits the likeliest hypothesis as a [`JointSlam`](crate::JointSlam) does, and the other places up to the last in use.
impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize> Walk
    for MultiHypothesisSlam<'_, M, Z, V, OTHERS>
{
    fn walk(&self, visit: &mut impl Visit) {
        self.slam.walk(visit);
        let last = self.alive().last().unwrap_or(0);
        for other in self.others.iter().take(last) {
            visit.word(u32::from(other.weight.alive));
            if other.weight.alive {
                other.walk(visit);
            }
        }
    }
}
