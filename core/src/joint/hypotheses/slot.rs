//! A hypothesis other than that in the filter's state, borrowed.

use super::super::covariance::used;
use super::super::landmark::Landmark;
use super::super::movers::Movers;
use super::super::state::{Header, Memory};
use super::super::walk::Estimate;
use crate::{Pose, PositionOf, Real, ScalarOf, Vector};

/// The weight of a hypothesis relative to that of the likeliest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weight<T> {
    /// Whether the place is in use.
    pub(super) alive: bool,
    /// ln of the weight, at most 0.
    pub(super) ln: T,
}

impl<T: Real> Weight<T> {
    pub(super) const NONE: Self = Self { alive: false, ln: T::ZERO };

    /// Whether a filter can have stored this weight.
    pub(super) fn is_sound(&self) -> bool {
        !self.alive || self.ln <= T::ZERO && self.ln > T::NEG_INFINITY
    }
}

/// A hypothesis other than that in the filter's state. It has no working memory: while it is processed, its references are
/// exchanged with those of the hypothesis in the state.
#[derive(Debug)]
pub(super) struct Slot<'s, P: Pose, V> {
    pub(super) weight: &'s mut Weight<ScalarOf<P>>,
    pub(super) header: &'s mut Header<P>,
    pub(super) landmarks: &'s mut [Landmark<PositionOf<P>>],
    pub(super) numbers: &'s mut [ScalarOf<P>],
    pub(super) movers: V,
}

impl<'s, T: Real, P: Pose<Scalar = T>, V: Movers<P>> Slot<'s, P, V> {
    pub(super) fn estimate(&self) -> Estimate<'_, P> {
        Estimate { header: self.header, landmarks: self.landmarks, numbers: self.numbers }
    }

    /// Exchanges the references with those of the filter.
    pub(super) fn exchange<Z: Vector<Scalar = T>>(&mut self, memory: &mut Memory<'s, P, Z>, movers: &mut V) {
        core::mem::swap(&mut self.header, &mut memory.header);
        core::mem::swap(&mut self.landmarks, &mut memory.landmarks);
        core::mem::swap(&mut self.numbers, &mut memory.joint.numbers);
        core::mem::swap(&mut self.movers, movers);
    }

    /// Overwrites this hypothesis with another one.
    pub(super) fn copy(&mut self, from: &Estimate<'_, P>, movers: &V) {
        let features = from.header.len;
        *self.header = *from.header;
        assign(self.landmarks, from.landmarks.get(..features).unwrap_or(&[]));
        assign(self.numbers, used::<P>(from.numbers, features));
        if let (Some(tracks), Some((common, _))) = (self.movers.tracks(), movers.common()) {
            *tracks.common = *common;
            assign(tracks.movers, movers.kept());
        }
    }

    /// Exchanges all data with the hypothesis in the filter's state.
    pub(super) fn exchange_data<Z: Vector<Scalar = T>>(&mut self, memory: &mut Memory<'s, P, Z>, movers: &mut V) {
        let features = self.header.len.max(memory.header.len);
        core::mem::swap(self.header, memory.header);
        exchange(self.landmarks, memory.landmarks, features);
        exchange(self.numbers, memory.joint.numbers, used::<P>(memory.joint.numbers, features).len());
        if let (Some(ours), Some(theirs)) = (self.movers.tracks(), movers.tracks()) {
            let tracks = ours.common.len.max(theirs.common.len);
            core::mem::swap(ours.common, theirs.common);
            exchange(ours.movers, theirs.movers, tracks);
        }
    }
}

fn assign<E: Copy>(to: &mut [E], from: &[E]) {
    to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
}

fn exchange<E>(one: &mut [E], other: &mut [E], count: usize) {
    one.iter_mut().zip(other).take(count).for_each(|(one, other)| core::mem::swap(one, other));
}
