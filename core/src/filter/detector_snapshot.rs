//! Snapshots of what a detector has learnt.

use crate::detection::online::{Learnt, Ratio};
use crate::snapshot::frame::{Content, Head, Shape};
use crate::snapshot::read::{Reader, checked};
use crate::snapshot::visit::{Visit, Walk};
use crate::snapshot::write::write;
use crate::{Detector, Flaw, MeasurementModel, Pose, Real, RestoreError, SaveError, ScanRoom, Vector};

impl<T: Real> Walk for Learnt<T> {
    fn walk(&self, visit: &mut impl Visit) {
        for ratio in [&self.detections, &self.clutter] {
            visit.scalar(ratio.happened);
            visit.scalar(ratio.expected);
        }
    }
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>> Detector<X, ScanRoom<'_, X::Measurement>> {
    /// What snapshots of such a detector have in common.
    fn shape(kind: u32) -> Shape {
        let dimensions = [0, 0, X::Measurement::DIMENSION as u8];
        Shape { content: Content::Detector, scalar: size_of::<T>() as u8, dimensions, kind }
    }

    /// Writes down what was learnt, as [`ScPhd::save`](crate::ScPhd::save) does of the filter: a few dozen bytes. `kind` tells
    /// detectors apart, of one vehicle too.
    ///
    /// # Errors
    /// What was learnt is damaged, or the sink takes no more.
    pub fn save<E>(&self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        if !self.room.learnt.is_in_range() {
            return Err(SaveError::Damaged(Flaw::Cursor));
        }
        let head = Head { shape: Self::shape(kind), flags: 0, len: 0, sizes: [0; 3] };
        write(head, self.room.learnt, [&mut [], &mut []], sink)
    }

    /// Goes on from what was [saved](Self::save), as [`ScPhd::restore`](crate::ScPhd::restore) does.
    ///
    /// # Errors
    /// It is no snapshot of such a detector, damaged or cut off; what was learnt here stays.
    pub fn restore<E>(
        &mut self,
        kind: u32,
        mut source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        let head = checked(&mut source, Self::shape(kind))?;
        let mut reader = Reader::behind(&head, &mut source);
        let [detections, clutter] =
            core::array::from_fn(|_| Ratio { happened: reader.scalar(), expected: reader.scalar() });
        reader.end()?;
        let learnt = Learnt { detections, clutter };
        if !learnt.is_in_range() {
            return Err(RestoreError::Flawed(Flaw::Cursor));
        }
        *self.room.learnt = learnt;
        Ok(head.len())
    }
}
