//! Storage of moving-object tracks.

use crate::numerics::range::is_within_square;
use crate::settings::config::MovingConfig;
use crate::{Component, Linear, MovingOf, Pose, Real, ScalarOf, Symmetric, TangentOf, Vector};

/// Storage of up to `CAPACITY` moving-object tracks beside a joint map: for [`with_movers`](super::JointSlam::with_movers).
///
/// A track in the plane takes 80 bytes in single precision. Meant to be a `static`: a new one is all zero.
#[derive(Debug)]
pub struct JointMovers<P: Pose, const CAPACITY: usize> {
    index: Common<P>,
    movers: [Mover<P>; CAPACITY],
}

/// The data that all tracks share.
#[derive(Debug, Clone, Copy)]
pub struct Common<P: Pose> {
    /// How many there are.
    pub(super) len: usize,
    /// What the noise of the odometry has added to the covariance of the pose since the last scan: as much is not known of where the
    /// vehicle is, seen from where it saw them last.
    pub(super) process_noise: Symmetric<TangentOf<P>>,
}

/// A moving-object track.
#[derive(Debug, Clone, Copy)]
pub struct Mover<P: Pose> {
    /// How likely it is that it is there and moves; where it is and how it moves, given the pose of the last scan. The label is that of the static
    /// feature that it may be instead, as long as there is such a one.
    pub(super) component: Component<MovingOf<P>>,
    /// p_D in the scan at hand, 0 out of view.
    pub(super) detection: ScalarOf<P>,
    /// The probability that the scan at hand does not detect it, whichever kind of feature it is.
    pub(super) not_detected: ScalarOf<P>,
    /// Σ a ν over the measurements of the scan at hand that it may have caused; nothing where there is a static feature that it may be instead.
    pub(super) message_sum: ScalarOf<P>,
    /// The place of the static feature that it may be instead, or [`NONE`].
    pub(super) rival: u16,
}

/// No place.
pub(super) const NONE: u16 = u16::MAX;
/// This bit of the number in an association tells a moving track from a static landmark.
pub(super) const MOVES: u16 = 1 << 15;

/// Borrowed tracks, of any capacity.
#[derive(Debug)]
pub struct Tracks<'s, P: Pose> {
    pub(super) common: &'s mut Common<P>,
    pub(super) movers: &'s mut [Mover<P>],
    pub(super) config: MovingConfig<ScalarOf<P>>,
}

mod sealed {
    pub trait Sealed {}
}

/// Whether a joint filter tracks moving objects: [`NoMovers`] or [`Tracked`].
pub trait Movers<P: Pose>: sealed::Sealed {
    /// Whether moving objects are tracked.
    #[doc(hidden)]
    fn are_tracked(&self) -> bool;
    /// The tracks, mutable, if there are any.
    #[doc(hidden)]
    fn tracks(&mut self) -> Option<Tracks<'_, P>>;
    /// The tracks in use.
    #[doc(hidden)]
    fn kept(&self) -> &[Mover<P>];
    /// The shared data and the motion of the tracks, if moving objects are tracked.
    #[doc(hidden)]
    fn common(&self) -> Option<(&Common<P>, &MovingConfig<ScalarOf<P>>)>;
}

/// No tracks: all features are static.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoMovers;

/// Borrowed [`JointMovers`].
#[derive(Debug)]
pub struct Tracked<'s, P: Pose>(Tracks<'s, P>);

impl sealed::Sealed for NoMovers {}

impl<P: Pose> Movers<P> for NoMovers {
    fn are_tracked(&self) -> bool {
        false
    }

    fn tracks(&mut self) -> Option<Tracks<'_, P>> {
        None
    }

    fn kept(&self) -> &[Mover<P>] {
        &[]
    }

    fn common(&self) -> Option<(&Common<P>, &MovingConfig<ScalarOf<P>>)> {
        None
    }
}

impl<P: Pose> sealed::Sealed for Tracked<'_, P> {}

impl<P: Pose> Tracked<'_, P> {
    pub(super) fn config(&self) -> MovingConfig<ScalarOf<P>> {
        self.0.config
    }
}

impl<P: Pose> Movers<P> for Tracked<'_, P> {
    fn are_tracked(&self) -> bool {
        true
    }

    fn tracks(&mut self) -> Option<Tracks<'_, P>> {
        let Self(Tracks { common, movers, config }) = self;
        Some(Tracks { common, movers, config: *config })
    }

    fn kept(&self) -> &[Mover<P>] {
        self.0.movers.get(..self.0.common.len).unwrap_or(&[])
    }

    fn common(&self) -> Option<(&Common<P>, &MovingConfig<ScalarOf<P>>)> {
        Some((self.0.common, &self.0.config))
    }
}

impl<V: sealed::Sealed> sealed::Sealed for Option<V> {}

/// For a program that decides at run time whether to track moving objects.
impl<P: Pose, V: Movers<P>> Movers<P> for Option<V> {
    fn are_tracked(&self) -> bool {
        self.as_ref().is_some_and(V::are_tracked)
    }

    fn tracks(&mut self) -> Option<Tracks<'_, P>> {
        self.as_mut()?.tracks()
    }

    fn kept(&self) -> &[Mover<P>] {
        self.as_ref().map_or(&[], V::kept)
    }

    fn common(&self) -> Option<(&Common<P>, &MovingConfig<ScalarOf<P>>)> {
        self.as_ref()?.common()
    }
}

impl<P: Pose, const CAPACITY: usize> JointMovers<P, CAPACITY> {
    /// No tracks.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(CAPACITY < MOVES as usize, "at most 32767 movers") };
        Self { index: Common { len: 0, process_noise: Symmetric::ZERO }, movers: [Mover::ZERO; CAPACITY] }
    }

    pub(super) fn tracked(&mut self, config: MovingConfig<ScalarOf<P>>) -> Tracked<'_, P> {
        Tracked(Tracks { common: &mut self.index, movers: &mut self.movers, config })
    }
}

impl<P: Pose, const CAPACITY: usize> Default for JointMovers<P, CAPACITY> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, P: Pose<Scalar = T>> Common<P> {
    /// Whether it may be a covariance.
    pub(super) fn is_sound(&self) -> bool {
        is_within_square(&self.process_noise)
            && (0..TangentOf::<P>::DIMENSION).all(|k| self.process_noise.get(k, k) >= T::ZERO)
    }
}

impl<T: Real, P: Pose<Scalar = T>> Mover<P> {
    pub(super) const ZERO: Self =
        Self { component: Component::ZERO, detection: T::ZERO, not_detected: T::ZERO, message_sum: T::ZERO, rival: 0 };

    /// Of a component, not yet looked at.
    pub(super) fn new(component: Component<MovingOf<P>>) -> Self {
        Self { component, rival: NONE, ..Self::ZERO }
    }

    /// The static feature that it may be instead.
    pub(super) fn static_index(&self) -> Option<u16> {
        Some(self.rival).filter(|&index| index != NONE)
    }

    /// The probability that it is there and moves.
    pub(super) fn weight(&self) -> T {
        self.component.ln_weight.exp()
    }

    /// Whether it is what a filter may have put there.
    pub(super) fn is_sound(&self) -> bool {
        self.component.is_usable() && self.component.ln_weight <= T::from_f64(LN_GREATEST)
    }
}

/// ln of how far rounding may take a probability.
const LN_GREATEST: f64 = 1e-3;

impl<T: Real, P: Pose<Scalar = T>> Tracks<'_, P> {
    /// Forgets all of them.
    pub(super) fn clear(&mut self) {
        *self.common = Common { len: 0, process_noise: Symmetric::ZERO };
    }

    /// Takes a count that no room is for as what there is room for.
    pub(super) fn clamp(&mut self) {
        self.common.len = self.common.len.min(self.movers.len());
    }

    /// Those there are.
    pub(super) fn kept(&self) -> &[Mover<P>] {
        self.movers.get(..self.common.len).unwrap_or(&[])
    }

    /// The same, to be changed.
    pub(super) fn kept_mut(&mut self) -> &mut [Mover<P>] {
        self.movers.get_mut(..self.common.len).unwrap_or(&mut [])
    }

    /// Drops one: the last one takes its place.
    pub(super) fn drop_at(&mut self, index: usize) {
        let last = self.common.len.saturating_sub(1);
        if let Some(mover) = self.movers.get(last).copied()
            && let Some(dropped) = self.movers.get_mut(index)
        {
            *dropped = mover;
        }
        self.common.len = last;
    }

    /// Keeps those that satisfy `keep`; how many went.
    pub(super) fn retain(&mut self, keep: impl Fn(&Mover<P>) -> bool) -> usize {
        let before = self.common.len;
        for index in (0..before).rev() {
            if !self.movers.get(index).is_some_and(&keep) {
                self.drop_at(index);
            }
        }
        before - self.common.len
    }

    /// Adds one. Where there is no room, the least likely one goes, or this one does; how many went.
    pub(super) fn put(&mut self, component: Component<MovingOf<P>>) -> usize {
        if let Some(slot) = self.movers.get_mut(self.common.len) {
            *slot = Mover::new(component);
            self.common.len += 1;
            return 0;
        }
        let mut least = (component.ln_weight, None);
        for (index, mover) in self.movers.iter().enumerate() {
            if mover.component.ln_weight < least.0 {
                least = (mover.component.ln_weight, Some(index));
            }
        }
        if let (_, Some(index)) = least
            && let Some(slot) = self.movers.get_mut(index)
        {
            *slot = Mover::new(component);
        }
        1
    }

    /// Takes note of a step of the vehicle.
    pub(super) fn carried(&mut self, transition: &Linear<TangentOf<P>, TangentOf<P>>, noise: &Symmetric<TangentOf<P>>) {
        let process_noise = self.common.process_noise.congruence::<TangentOf<P>>(transition).plus(noise);
        // Where steps are beyond all vehicles, rounding may leave less than nothing.
        let process_noise = Symmetric::from_fn(|row, column| {
            let element = process_noise.get(row, column);
            if row == column { element.at_least(T::ZERO) } else { element }
        });
        if is_within_square(&process_noise) {
            self.common.process_noise = process_noise;
        }
    }

    /// Drops one if it cannot be; whether it did.
    pub(super) fn drop_unsound(&mut self, index: usize) -> bool {
        let unsound = self.kept().get(index).is_some_and(|mover| !mover.is_sound());
        if unsound {
            self.drop_at(index);
        }
        unsound
    }
}
