//! Tracks of moving objects of each hypothesis.

use super::super::movers::{JointMovers, Movers, NoMovers, Tracked};
use crate::Pose;

/// Tracks that each of several hypotheses can have.
pub trait MoversOf<'s, P: Pose>: Movers<P> + Sized {
    /// Tracks with the same tuning over other memory.
    #[doc(hidden)]
    fn over<const TRACKS: usize>(&self, memory: &'s mut JointMovers<P, TRACKS>) -> Self;
}

impl<'s, P: Pose> MoversOf<'s, P> for NoMovers {
    fn over<const TRACKS: usize>(&self, _memory: &'s mut JointMovers<P, TRACKS>) -> Self {
        Self
    }
}

impl<'s, P: Pose> MoversOf<'s, P> for Tracked<'s, P> {
    fn over<const TRACKS: usize>(&self, memory: &'s mut JointMovers<P, TRACKS>) -> Self {
        memory.tracked(self.config())
    }
}

impl<'s, P: Pose, V: MoversOf<'s, P>> MoversOf<'s, P> for Option<V> {
    fn over<const TRACKS: usize>(&self, memory: &'s mut JointMovers<P, TRACKS>) -> Self {
        self.as_ref().map(|movers| movers.over(memory))
    }
}
