//! Whether a landmark is there, and whether it can be seen: a two-state chain, so that misses may come in a row.
//!
//! A landmark that is there is in sight or hidden, and goes from one to the other with constant rates. Only one in sight can be
//! detected. What is missed is therefore first taken for hidden, and only as time goes by for gone.

use crate::{ConfigError, Real};

/// How landmarks hide and vanish.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Persistence<T> {
    /// Mean time that a landmark stays in sight before something hides it, s; infinite: nothing ever does.
    pub in_sight_s: T,
    /// Mean time that it stays hidden, s.
    pub hidden_s: T,
    /// Mean time until it is taken away, s; infinite: never.
    pub lifetime_s: T,
}

impl<T: Real> Persistence<T> {
    /// Nothing hides and nothing vanishes: every detection that is missed is missed by chance.
    pub const FOR_EVER: Self = Self { in_sight_s: T::INFINITY, hidden_s: T::ONE, lifetime_s: T::INFINITY };

    /// The field that is out of range, if any.
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let times = [
            (self.in_sight_s, "persistence.in_sight_s"),
            (self.hidden_s, "persistence.hidden_s"),
            (self.lifetime_s, "persistence.lifetime_s"),
        ];
        match times.into_iter().find(|&(time, _)| !(time > T::ZERO)) {
            Some((_, field)) => Err(ConfigError { field, range: "positive" }),
            None => Ok(()),
        }
    }

    /// What becomes of all landmarks in a time of `dt` seconds.
    pub(super) fn over(&self, dt: T) -> Passage<T> {
        let (hide, show) = (T::ONE / self.in_sight_s, T::ONE / self.hidden_s);
        let both = hide + show;
        Passage {
            hidden_share: if both > T::ZERO { hide / both } else { T::ZERO },
            kept: (-(both * dt)).exp(),
            survives: (-(dt / self.lifetime_s)).exp(),
        }
    }
}

/// What the same feature may be instead, if it moves, in a scan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside<T> {
    /// The probability that it is there, moves and is detected.
    pub(super) expected: T,
    /// And is not detected.
    pub(super) left: T,
    /// Its share of the detections.
    pub(super) detected: T,
}

impl<T: Real> Beside<T> {
    /// It stands, if it is there.
    pub(super) const NOTHING: Self = Self { expected: T::ZERO, left: T::ZERO, detected: T::ZERO };
}

/// What becomes of landmarks in one step of time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passage<T> {
    /// Share of the time that a landmark is hidden, in the long run.
    hidden_share: T,
    /// What is left of the difference from it.
    kept: T,
    /// Probability that it is not taken away.
    survives: T,
}

/// The probability that a landmark is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Existence<T> {
    /// And in sight.
    pub(super) in_sight: T,
    /// And hidden.
    pub(super) hidden: T,
}

impl<T: Real> Existence<T> {
    pub(super) const NONE: Self = Self { in_sight: T::ZERO, hidden: T::ZERO };

    /// That it is there at all.
    pub(super) fn total(self) -> T {
        self.in_sight + self.hidden
    }

    /// After the time of `passage`.
    pub(super) fn after(self, passage: &Passage<T>) -> Self {
        let total = self.total();
        let settled = total * passage.hidden_share;
        let hidden = settled + (self.hidden - settled) * passage.kept;
        Self { in_sight: (total - hidden) * passage.survives, hidden: hidden * passage.survives }
    }

    /// After a scan that expected to detect it with probability p_D where it is in sight, and in which it has, in all, that
    /// share of the detections, beside what it may be instead.
    pub(super) fn scanned(self, detection: T, detected: T, beside: &Beside<T>) -> Self {
        // Rounding may have taken the sum of both a little above one: what is left must not be less than they leave.
        let left = self.in_sight * (T::ONE - detection) + self.hidden + beside.left;
        let not_detected = (T::ONE - self.in_sight * detection - beside.expected).at_least(left);
        // Messages that have not settled leave shares that sum to a little more than one.
        let missed = (T::ONE - detected - beside.detected).at_least(T::ZERO);
        if !(not_detected > T::ZERO) {
            return Self { in_sight: T::ONE, hidden: T::ZERO };
        }
        let share = missed / not_detected;
        let in_sight = detected + share * self.in_sight * (T::ONE - detection);
        Self { in_sight: in_sight.at_most(T::ONE), hidden: share * self.hidden }
    }
}

#[cfg(test)]
mod tests {
    use super::{Beside, Existence, Persistence};

    #[test]
    fn without_hiding_it_is_the_bernoulli_update() {
        let before = Existence { in_sight: 0.8_f64, hidden: 0.0 };
        let after = before.after(&Persistence::FOR_EVER.over(3.0)).scanned(0.7, 0.0, &Beside::NOTHING);
        assert!((after.total() - 0.8 * 0.3 / (1.0 - 0.8 * 0.7)).abs() < 1e-15);
        // A weight that is small falls as that of an intensity does.
        let light = Existence { in_sight: 1e-6_f64, hidden: 0.0 }.scanned(0.7, 0.0, &Beside::NOTHING);
        assert!((light.in_sight / 3e-7 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn bayes_over_three_hypotheses() {
        let before = Existence { in_sight: 0.5_f64, hidden: 0.3 };
        let seen = 0.25;
        let evidence = 1.0 - 0.5 * 0.9;
        let after = before.scanned(0.9, seen, &Beside::NOTHING);
        assert!((after.in_sight - (seen + (1.0 - seen) * 0.5 * 0.1 / evidence)).abs() < 1e-15);
        assert!((after.hidden - (1.0 - seen) * 0.3 / evidence).abs() < 1e-15);
    }

    /// Shares that sum to more than one, and probabilities that rounding has taken above it, leave a probability.
    #[test]
    fn a_probability_stays_one() {
        let eps = f32::EPSILON;
        for hidden in [0.0, 1e-12, eps, 0.25, 0.5 + eps] {
            for detection in [0.3, 0.9, 1.0 - eps] {
                for detected in [0.0, 0.5, 1.0, 1.0 + eps, 1.02] {
                    let before = Existence { in_sight: 1.0 - hidden + eps, hidden };
                    let after = before.scanned(detection, detected, &Beside::NOTHING);
                    assert!(
                        after.in_sight >= 0.0 && after.hidden >= 0.0,
                        "{before:?} {detection} {detected} {after:?}"
                    );
                    assert!(after.total() <= 1.0 + 4.0 * eps, "{before:?} {detection} {detected} {after:?}");
                }
            }
        }
    }

    #[test]
    fn time_is_taken_in_one_step_as_in_many() {
        let chain = Persistence { in_sight_s: 20.0_f64, hidden_s: 2.0, lifetime_s: 300.0 };
        let start = Existence { in_sight: 0.9, hidden: 0.05 };
        let at_once = start.after(&chain.over(5.0));
        let in_steps = (0..50).fold(start, |now, _| now.after(&chain.over(0.1)));
        assert!((at_once.in_sight - in_steps.in_sight).abs() < 1e-12);
        assert!((at_once.hidden - in_steps.hidden).abs() < 1e-12);
        assert!((at_once.total() - 0.95 * (-5.0_f64 / 300.0).exp()).abs() < 1e-12);
    }
}
