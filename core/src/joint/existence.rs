//! Existence and visibility of a landmark as a Markov chain, so that consecutive misses are possible.
//!
//! A landmark that exists is visible or occluded, and changes between the two with constant rates. Only a visible landmark can be
//! detected. A missed landmark is therefore first assumed to be occluded, and only after some time to be removed.

use crate::{ConfigError, Real};

/// Occlusion and survival of landmarks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Persistence<T> {
    /// Mean time until a visible landmark is occluded, s; infinite: never.
    pub visible_s: T,
    /// Mean time for which it is occluded, s.
    pub occluded_s: T,
    /// Mean time until a landmark is removed from the world, s; infinite: never.
    pub lifetime_s: T,
}

impl<T: Real> Persistence<T> {
    /// Landmarks are never occluded and never removed: every missed detection is missed by chance, and a feature that
    /// is missed about ten times in a row never existed.
    pub const FOR_EVER: Self = Self { visible_s: T::INFINITY, occluded_s: T::ONE, lifetime_s: T::INFINITY };

    /// Posts, trees and similar landmarks, where people and cars pass, leaves move, and not every beam hits: 20 s
    /// visible, 10 s occluded, removed after some hours. The visible time has little effect in random worlds; if
    /// landmarks are occluded for long, a short occluded time makes the filter remove them.
    pub fn posts() -> Self {
        let of = T::from_f64;
        Self { visible_s: of(20.0), occluded_s: of(10.0), lifetime_s: of(1e4) }
    }

    /// The field that is out of range, if any.
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let times = [
            (self.visible_s, "persistence.visible_s"),
            (self.occluded_s, "persistence.occluded_s"),
            (self.lifetime_s, "persistence.lifetime_s"),
        ];
        match times.into_iter().find(|&(time, _)| !(time > T::ZERO)) {
            Some((_, field)) => Err(ConfigError { field, range: "positive" }),
            None => Ok(()),
        }
    }

    /// The transition probabilities over `dt` seconds.
    pub(super) fn over(&self, dt: T) -> Passage<T> {
        let (hide, show) = (T::ONE / self.visible_s, T::ONE / self.occluded_s);
        let both = hide + show;
        let survives = (-(dt / self.lifetime_s)).exp();
        // 1 − exp(−x) without cancellation for small x (Kahan): the rounding error of exp(−x) is also in its logarithm.
        let lived = -survives.ln();
        let vanishes =
            if lived > T::ZERO { (T::ONE - survives) * (dt / self.lifetime_s / lived) } else { dt / self.lifetime_s };
        Passage {
            occluded_fraction: if both > T::ZERO { hide / both } else { T::ZERO },
            kept: (-(both * dt)).exp(),
            survives,
            vanishes: vanishes.at_most(T::ONE),
        }
    }
}

/// The hypothesis that the object moves: probabilities of its moving-object track in a scan.
#[derive(Debug, Clone, Copy)]
pub(super) struct MovingHypothesis<T> {
    /// p_D w: the probability that it exists, moves and is detected.
    pub(super) expected: T,
    /// (1 − p_D) w: the probability that it exists, moves and is not detected.
    pub(super) left: T,
    /// Σ s: the sum of the association probabilities of the track.
    pub(super) detected: T,
}

impl<T: Real> MovingHypothesis<T> {
    /// There is no such track.
    pub(super) const NOTHING: Self = Self { expected: T::ZERO, left: T::ZERO, detected: T::ZERO };
}

/// Transition of the Markov chain over a step of time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passage<T> {
    /// Stationary probability that an existing landmark is occluded.
    occluded_fraction: T,
    /// Factor by which the deviation from the stationary probability decays.
    kept: T,
    /// Probability that a landmark is not removed.
    survives: T,
    /// Probability that it is removed: 1 − `survives`, which single precision would round to 0 if the lifetime is long.
    vanishes: T,
}

/// Least probability that a landmark does not exist, after any number of detections.
const LEAST_ABSENT: f64 = 1e-12;

/// The probabilities that a landmark exists and that it does not. Their sum is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Existence<T> {
    /// v: it exists and is visible.
    pub(super) visible: T,
    /// h: it exists and is occluded.
    pub(super) occluded: T,
    /// g: it does not exist, or it moves. It is stored in addition to the other two, because one minus their sum would
    /// be rounded to 0 after a few detections, and a removed landmark would then remain in the map for ever.
    pub(super) absent: T,
}

impl<T: Real> Existence<T> {
    /// Value of an unused slot. It is all zero, so that a static state takes no flash.
    pub(super) const NONE: Self = Self { visible: T::ZERO, occluded: T::ZERO, absent: T::ZERO };

    /// A landmark that is visible with this probability, and otherwise does not exist.
    pub(super) fn of(visible: T) -> Self {
        let absent = (T::ONE - visible).at_least(T::from_f64(LEAST_ABSENT));
        Self { visible, occluded: T::ZERO, absent }
    }

    /// v + h: the probability that it exists.
    pub(super) fn total(self) -> T {
        self.visible + self.occluded
    }

    /// The prediction over the time of `passage`.
    pub(super) fn after(self, passage: &Passage<T>) -> Self {
        let total = self.total();
        let settled = total * passage.occluded_fraction;
        let occluded = (settled + (self.occluded - settled) * passage.kept) * passage.survives;
        let (there, absent) = (total * passage.survives, self.absent + total * passage.vanishes);
        // The sum is normalised to one, from which rounding errors would move it in a million scans.
        let all = there + absent;
        Self { visible: (there - occluded).at_least(T::ZERO) / all, occluded: occluded / all, absent: absent / all }
    }

    /// The update with a scan, by Bayes: `detection` is p_D of a visible landmark, `detected` the sum β of its
    /// association probabilities, and `moving` the hypothesis that the object moves.
    pub(super) fn scanned(self, detection: T, detected: T, moving: &MovingHypothesis<T>) -> Self {
        let visible = self.visible * (T::ONE - detection);
        let gone = (self.absent - moving.expected - moving.left).at_least(T::ZERO);
        // 1 − p_D v − p_D w as a sum of terms that are not negative: a difference would lose the digits of the small
        // terms.
        let not_detected = visible + self.occluded + gone + moving.left;
        // If the messages have not converged, the association probabilities sum to slightly more than one.
        let missed = (T::ONE - detected - moving.detected).at_least(T::ZERO);
        if !(not_detected > T::ZERO) {
            return Self::of(T::ONE);
        }
        let probability = missed / not_detected;
        Self {
            visible: (detected + probability * visible).at_most(T::ONE),
            occluded: probability * self.occluded,
            absent: (moving.detected + probability * (gone + moving.left)).at_least(T::from_f64(LEAST_ABSENT)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Existence, MovingHypothesis, Persistence};
    use crate::Real;

    #[test]
    fn without_occlusion_it_is_the_bernoulli_update() {
        let before = Existence::of(0.8_f64);
        let after = before.after(&Persistence::FOR_EVER.over(3.0)).scanned(0.7, 0.0, &MovingHypothesis::NOTHING);
        assert!((after.total() - 0.8 * 0.3 / (1.0 - 0.8 * 0.7)).abs() < 1e-15);
        // A small existence probability decreases as the weight of a component of an intensity does.
        let light = Existence::of(1e-6_f64).scanned(0.7, 0.0, &MovingHypothesis::NOTHING);
        assert!((light.visible / 3e-7 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn bayes_over_three_hypotheses() {
        let before = Existence { visible: 0.5_f64, occluded: 0.3, absent: 0.2 };
        let seen = 0.25;
        let evidence = 1.0 - 0.5 * 0.9;
        let after = before.scanned(0.9, seen, &MovingHypothesis::NOTHING);
        assert!((after.visible - (seen + (1.0 - seen) * 0.5 * 0.1 / evidence)).abs() < 1e-15);
        assert!((after.occluded - (1.0 - seen) * 0.3 / evidence).abs() < 1e-15);
        assert!((after.absent - (1.0 - seen) * 0.2 / evidence).abs() < 1e-15);
    }

    /// The probabilities remain valid if association probabilities sum to more than one, or if rounding errors have
    /// made the existence probability greater than one.
    #[test]
    fn probabilities_sum_to_at_most_one() {
        let eps = f32::EPSILON;
        for occluded in [0.0, 1e-12, eps, 0.25, 0.5 + eps] {
            for detection in [0.3, 0.9, 1.0 - eps] {
                for detected in [0.0, 0.5, 1.0, 1.0 + eps, 1.02] {
                    let before = Existence { visible: 1.0 - occluded + eps, occluded, absent: eps };
                    let after = before.scanned(detection, detected, &MovingHypothesis::NOTHING);
                    assert!(
                        after.visible >= 0.0 && after.occluded >= 0.0,
                        "{before:?} {detection} {detected} {after:?}"
                    );
                    assert!(after.total() <= 1.0 + 4.0 * eps, "{before:?} {detection} {detected} {after:?}");
                }
            }
        }
    }

    #[test]
    fn one_time_step_equals_many_short_ones() {
        let chain = Persistence { visible_s: 20.0_f64, occluded_s: 2.0, lifetime_s: 300.0 };
        let start = Existence { visible: 0.9, occluded: 0.05, absent: 0.05 };
        let at_once = start.after(&chain.over(5.0));
        let in_steps = (0..50).fold(start, |now, _| now.after(&chain.over(0.1)));
        assert!((at_once.visible - in_steps.visible).abs() < 1e-12);
        assert!((at_once.occluded - in_steps.occluded).abs() < 1e-12);
        assert!((at_once.total() - 0.95 * (-5.0_f64 / 300.0).exp()).abs() < 1e-12);
        assert!((at_once.total() + at_once.absent - 1.0).abs() < 1e-12);
    }

    /// A lifetime of three years at 10 Hz: the time between scans is 1e-9 of it.
    #[test]
    fn a_long_lifetime_has_an_effect_in_single_precision() {
        fn an_hour<T: Real>() -> f64 {
            let chain = Persistence { lifetime_s: T::from_f64(1e8), ..Persistence::FOR_EVER }.over(T::from_f64(0.1));
            let there = (0..36_000).fold(Existence::of(T::ONE), |now, _| now.after(&chain));
            there.absent.to_f64()
        }
        let exact = -(-3600.0_f64 / 1e8).exp_m1();
        assert!((an_hour::<f64>() / exact - 1.0).abs() < 1e-6, "{}", an_hour::<f64>());
        assert!((an_hour::<f32>() / exact - 1.0).abs() < 5e-3, "{}", an_hour::<f32>());
    }

    /// A landmark that is no longer detected is dropped after the number of misses that follows from the model, however
    /// often it was detected before.
    #[test]
    fn a_missed_landmark_is_dropped_however_certain_it_was() {
        fn misses<T: Real>(chain: Persistence<T>, detection: f64) -> usize {
            let (passage, detection) = (chain.over(T::from_f64(0.1)), T::from_f64(detection));
            let mut now = Existence::of(T::ONE);
            for _ in 0..1000 {
                now = now.after(&passage).scanned(detection, T::ONE, &MovingHypothesis::NOTHING);
            }
            (0..2000)
                .take_while(|_| {
                    now = now.after(&passage).scanned(detection, T::ZERO, &MovingHypothesis::NOTHING);
                    now.total() >= T::from_f64(1e-3)
                })
                .count()
        }
        for detection in [0.5, 0.9, 1.0 - 1e-6] {
            // Without occlusion: until the odds of existence have decreased from 10¹² to 10⁻³.
            let expected = (1e-15_f64.ln() / (1.0 - detection).ln()).floor();
            let [single, double] = [
                misses::<f32>(Persistence::FOR_EVER, detection) as f64,
                misses::<f64>(Persistence::FOR_EVER, detection) as f64,
            ];
            assert!((single - expected).abs() <= 1.0 && (double - expected).abs() <= 1.0, "{single} {double}");
            // With occlusion it remains in the map for at least 30 s, equally long in both precisions.
            let [single, double] = [
                misses(Persistence { visible_s: 20.0_f32, occluded_s: 10.0, lifetime_s: 1e4 }, detection) as f64,
                misses(Persistence { visible_s: 20.0_f64, occluded_s: 10.0, lifetime_s: 1e4 }, detection) as f64,
            ];
            assert!((single / double - 1.0).abs() < 0.02 && (300.0..1900.0).contains(&double), "{single} {double}");
        }
    }
}
