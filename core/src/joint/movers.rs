//! Storage of moving-object tracks.

use crate::numerics::range::is_within_square;
use crate::settings::config::MovingConfig;
use crate::{Component, CovarianceOf, Linear, MovingOf, Pose, Real, ScalarOf, Symmetric, TangentOf, Vector};

/// Storage of up to `CAPACITY` moving-object tracks of a joint map, for [`with_movers`](super::JointSlam::with_movers).
///
/// A track in the plane takes 80 bytes in single precision. The storage is meant to be a `static`: when new, it is all zero.
#[derive(Debug)]
pub struct JointMovers<P: Pose, const CAPACITY: usize> {
    index: Common<P>,
    movers: [Mover<P>; CAPACITY],
}

/// The data that all tracks share.
#[derive(Debug, Clone, Copy)]
pub struct Common<P: Pose> {
    /// Number of tracks.
    pub(super) len: usize,
    /// Q: the covariance that the noise of the odometry has added to that of the pose since the last scan. The tracks
    /// are given the pose of that scan, so that Q is the uncertainty of the vehicle relative to them.
    pub(super) process_noise: CovarianceOf<P>,
}

/// A moving-object track.
#[derive(Debug, Clone, Copy)]
pub struct Mover<P: Pose> {
    /// Probability w that the object exists and moves, and position and velocity given the pose of the last scan. The
    /// label is that of the static feature that is the alternative hypothesis for the same object.
    pub(super) component: Component<MovingOf<P>>,
    /// p_D in the present scan, 0 out of view.
    pub(super) detection: ScalarOf<P>,
    /// The probability that the present scan detects neither the track nor the static feature of the same object.
    pub(super) not_detected: ScalarOf<P>,
    /// Σ a ν over the measurements of the present scan. If there is a static feature of the same object, its sum is used instead.
    pub(super) message_sum: ScalarOf<P>,
    /// Index of the static feature of the same object, or [`NONE`].
    pub(super) static_index: u16,
    /// Index of the measurement of the present scan that it caused, or [`NONE`]; only with several hypotheses.
    pub(super) measurement: u16,
}

/// The index of no landmark, no track and no measurement.
pub(super) const NONE: u16 = u16::MAX;
/// The bit that marks the index of a moving-object track in an association. Without it, the index is that of a landmark.
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
    pub const fn new() -> Self {
        const { assert!(CAPACITY < MOVES as usize, "at most 32767 movers") };
        Self { index: Common { len: 0, process_noise: Symmetric::ZERO }, movers: [Mover::ZERO; CAPACITY] }
    }

    pub(super) fn tracked(&mut self, config: MovingConfig<ScalarOf<P>>) -> Tracked<'_, P> {
        Tracked(Tracks { common: &mut self.index, movers: &mut self.movers, config })
    }
}

impl<T: Real, P: Pose<Scalar = T>> Common<P> {
    /// Whether the process noise can be a covariance.
    pub(super) fn is_sound(&self) -> bool {
        is_within_square(&self.process_noise)
            && (0..TangentOf::<P>::DIMENSION).all(|k| self.process_noise.get(k, k) >= T::ZERO)
    }
}

impl<T: Real, P: Pose<Scalar = T>> Mover<P> {
    pub(super) const ZERO: Self = Self {
        component: Component::ZERO,
        detection: T::ZERO,
        not_detected: T::ZERO,
        message_sum: T::ZERO,
        static_index: 0,
        measurement: 0,
    };

    /// A new track, without the data of a scan.
    pub(super) fn new(component: Component<MovingOf<P>>) -> Self {
        Self { component, static_index: NONE, ..Self::ZERO }
    }

    /// Index of the static feature of the same object.
    pub(super) fn static_index(&self) -> Option<u16> {
        Some(self.static_index).filter(|&index| index != NONE)
    }

    /// With several hypotheses: whether it may have caused one of the next measurements.
    pub(super) fn may_be_cause(&self) -> bool {
        self.measurement == NONE && self.detection > T::ZERO
    }

    /// w: the probability that the object exists and moves.
    pub(super) fn weight(&self) -> T {
        self.component.ln_weight.exp()
    }

    /// Whether all numbers are valid, so that a filter can have stored them.
    pub(super) fn is_sound(&self) -> bool {
        self.component.is_usable() && self.component.ln_weight <= T::from_f64(LN_GREATEST)
    }
}

/// Greatest ln of a probability, with an allowance for rounding errors.
const LN_GREATEST: f64 = 1e-3;

impl<T: Real, P: Pose<Scalar = T>> Tracks<'_, P> {
    /// Removes all tracks.
    pub(super) fn clear(&mut self) {
        *self.common = Common { len: 0, process_noise: Symmetric::ZERO };
    }

    /// Limits an invalid number of tracks to the capacity.
    pub(super) fn clamp(&mut self) {
        self.common.len = self.common.len.min(self.movers.len());
    }

    /// The tracks in use.
    pub(super) fn kept(&self) -> &[Mover<P>] {
        self.movers.get(..self.common.len).unwrap_or(&[])
    }

    /// The same, mutable.
    pub(super) fn kept_mut(&mut self) -> &mut [Mover<P>] {
        self.movers.get_mut(..self.common.len).unwrap_or(&mut [])
    }

    /// Drops a track; the last track gets its index.
    pub(super) fn drop_at(&mut self, index: usize) {
        let last = self.common.len.saturating_sub(1);
        if let Some(mover) = self.movers.get(last).copied()
            && let Some(dropped) = self.movers.get_mut(index)
        {
            *dropped = mover;
        }
        self.common.len = last;
    }

    /// Keeps the tracks for which `keep` is true. Returns the number of dropped tracks.
    pub(super) fn retain(&mut self, keep: impl Fn(&Mover<P>) -> bool) -> usize {
        let before = self.common.len;
        for index in (0..before).rev() {
            if !self.movers.get(index).is_some_and(&keep) {
                self.drop_at(index);
            }
        }
        before - self.common.len
    }

    /// Adds a track. If there is no room, it replaces the least likely track, or is discarded if no track is less
    /// likely. Returns the number of tracks that were lost.
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

    /// Adds a step of the vehicle to the process noise: Q ← F Q Fᵀ + `noise`, with F = `transition`.
    pub(super) fn carried(&mut self, transition: &Linear<TangentOf<P>, TangentOf<P>>, noise: &CovarianceOf<P>) {
        let process_noise = self.common.process_noise.congruence::<TangentOf<P>>(transition).plus(noise);
        // With implausibly large steps, rounding errors may make a variance negative.
        let process_noise = Symmetric::from_fn(|row, column| {
            let element = process_noise.get(row, column);
            if row == column { element.at_least(T::ZERO) } else { element }
        });
        if is_within_square(&process_noise) {
            self.common.process_noise = process_noise;
        }
    }

    /// Drops a track with invalid numbers. Returns whether it was dropped.
    pub(super) fn drop_unsound(&mut self, index: usize) -> bool {
        let unsound = self.kept().get(index).is_some_and(|mover| !mover.is_sound());
        if unsound {
            self.drop_at(index);
        }
        unsound
    }
}
