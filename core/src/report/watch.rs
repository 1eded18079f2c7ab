//! A watch over the estimate: whether the vehicle is where it is taken to be, and whether its sensors still speak.
//!
//! A cumulative sum (Page 1954) of logarithms of likelihood ratios, "lost" against "here". Here means either of two things. What has been known
//! for a while is detected at two thirds of its usual rate at least, whatever else is measured: a burst of clutter, or a third of all landmarks hidden in
//! a row. Or what nothing known explains comes at its usual rate, whatever is detected: a view that is blocked, or one that shows nothing known. Lost
//! means that what is known is detected by chance, and that its measurements come from elsewhere. The smaller of the two logarithms is taken, so
//! that under either E[exp(step)] ≤ 1, whichever of them holds at which scan, and a sum of h is reached once in exp(h) scans at most.

use crate::{Health, Real};

/// "Here" is at least this share of the usual detections, or at most the usual number of measurements that nothing known explains.
const STILL_DETECTED: f64 = 2.0 / 3.0;
/// ln of how much rarer detections of what is known are where the vehicle is lost, ln 1/5: what lies by chance where it is expected, and
/// one or two landmarks that the pose has come to follow.
const LN_BY_CHANCE: f64 = -1.609_437_912_434_100_3;
/// So many known landmarks may be missed scan after scan: one stands at the rim of the view, or is gone.
const MISSED_IN_A_ROW: f64 = 1.0;
/// Lost, the vehicle sees at least this share of as many landmarks as it expects.
const SEEN_ELSEWHERE: f64 = 0.5;
/// What is unusual is counted beyond half a measurement a scan more than usual: the mean over the last scans is not known better.
const SPARE_MEASUREMENTS: f64 = 0.5;

/// ln 10⁴: a false alarm in ten thousand scans at most.
const LN_LOST: f64 = 9.210_340_371_976_184;
/// ln 10²: a hundred scans at most.
const LN_SUSPECTED: f64 = 4.605_170_185_988_092;
/// Known landmarks are those born before this many scans, or twice as many: long enough for the doubt to grow, where the vehicle is lost and
/// maps what it takes for another place.
const KNOWN_SCANS: u32 = 32;
/// Scans over which what is usual is learnt.
const USUAL_SCANS: u32 = 32;
/// The least number of scans that a mean is over which begins anew.
const RESTART_SCANS: u32 = 4;
/// Below this doubt all is as usual.
const DOUBT_USUAL: f64 = 1.0;
/// Scans after which 1/e is left of a doubt while nothing known is expected.
const DOUBT_SCANS: f64 = 64.0;
/// The same of landmarks that were given up for being missed: by then they would have left the view.
const GIVEN_UP_SCANS: f64 = 20.0;
/// A scan without a measurement is of a sensor that sees nothing, where so many detections were to be expected.
const BLIND: f64 = 3.0;
/// So many landmarks in view that had no part in a scan are a doubt, and this much of one.
const ASIDE: f64 = 1.5;
const ASIDE_DOUBT: f64 = 0.2;
/// Measurements that nothing known explains are far more than usual beyond so many standard deviations of their number, and so many more.
const CLUTTER_DEVIATIONS: f64 = 5.0;
const CLUTTER_MORE: f64 = 3.0;
/// Detections are low where this share of what is expected is missed.
const MISSED_SHARE: f64 = 0.2;
/// No scan for so many times the usual, and for so long, s: the input is lost.
const WAITED_TIMES: f64 = 8.0;
const WAITED_S: f64 = 1.0;

/// What became of the known landmarks in view in a scan, each by its probability of being there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Recognised<T> {
    /// Σ p_D w.
    pub(crate) expected: T,
    /// Detections.
    pub(crate) detected: T,
    /// Σ p_D (w − w⁺): by how much the scan has made one believe in them less.
    pub(crate) given_up: T,
}

impl<T: Real> Recognised<T> {
    pub(crate) const NOTHING: Self = Self { expected: T::ZERO, detected: T::ZERO, given_up: T::ZERO };

    pub(crate) fn add(&mut self, other: &Self) {
        self.expected += other.expected;
        self.detected += other.detected;
        self.given_up += other.given_up;
    }

    /// In the mean over so many maps.
    pub(crate) fn over(self, maps: usize) -> Self {
        let maps = T::from_usize(maps.max(1));
        Self { expected: self.expected / maps, detected: self.detected / maps, given_up: self.given_up / maps }
    }
}

/// Whether a label is none of those given away from `known_below` on up to `next_label`. Labels run in a circle: after 2³² of them come the
/// small ones again.
pub(crate) fn is_known(label: u32, known_below: u32, next_label: u32) -> bool {
    label.wrapping_sub(known_below) >= next_label.wrapping_sub(known_below)
}

/// What is usual, and how much speaks against it. All zero before the first scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Watch<T> {
    /// ln of the odds that the vehicle is lost.
    pub(crate) doubt: T,
    /// Whether it has been found lost, and since then not where it is taken to be.
    pub(crate) lost: bool,
    /// Expected detections of what was given up.
    pub(crate) given_up: T,
    /// Which share of what is expected is usually not detected.
    pub(crate) usually_missed: T,
    /// How many measurements nothing known usually explains.
    pub(crate) usually_new: T,
    /// How many false ones of them the detectors usually state: λ, in the mean over the same scans.
    pub(crate) usually_stated: T,
    /// The usual time between scans, s.
    pub(crate) usually_waited_s: T,
    /// Scans so far; stops at a number that does not matter.
    pub(crate) scans: u32,
    /// Landmarks are known that have no label from this one on.
    pub(crate) known_below: u32,
    /// The same from the next time on.
    pub(crate) next_known_below: u32,
}

impl<T: Real> Watch<T> {
    pub(crate) const ZERO: Self = Self {
        doubt: T::ZERO,
        lost: false,
        given_up: T::ZERO,
        usually_missed: T::ZERO,
        usually_new: T::ZERO,
        usually_stated: T::ZERO,
        usually_waited_s: T::ZERO,
        scans: 0,
        known_below: 0,
        next_known_below: 0,
    };

    /// Whether the landmark of this label is known, where the next one gets `next_label`.
    pub(crate) fn knows(&self, label: u32, next_label: u32) -> bool {
        is_known(label, self.known_below, next_label)
    }

    /// All landmarks with lesser labels are known from now on.
    pub(crate) fn know_below(&mut self, label: u32) {
        (self.known_below, self.next_known_below) = (label, label);
    }

    /// Forgets the doubt: the pose was set, or made uncertain.
    pub(crate) fn calm(&mut self) {
        (self.doubt, self.lost, self.given_up) = (T::ZERO, false, T::ZERO);
    }

    /// Conditions of a vehicle that has waited for a scan for so long, s.
    pub(crate) fn waiting(&self, waited_s: T) -> Health {
        let usual = self.usually_waited_s * T::from_f64(WAITED_TIMES);
        Health::INPUT_LOST.when(self.scans > 0 && waited_s > usual.at_least(T::from_f64(WAITED_S)))
    }

    /// Landmarks in view, of which so many detections are to be expected, have no part in a scan of so many measurements: the pose is known too
    /// badly to tell which measurement is of which of them. Until the vehicle has found its place among them, the doubt grows.
    pub(crate) fn exclude_expected(&mut self, expected: T, measurements: usize) {
        let enough = T::from_f64(ASIDE);
        if expected >= enough && T::from_usize(measurements) >= enough {
            self.doubt += T::from_f64(ASIDE_DOUBT);
        }
    }

    /// Takes in what a scan of so many measurements has shown, of which the detector states so many to be false, after a time, s; the
    /// next landmark gets this label.
    pub(crate) fn scanned(
        &mut self,
        seen: &Recognised<T>,
        (measurements, stated): (usize, T),
        waited_s: T,
        next_label: u32,
    ) -> Health {
        if !self.is_sound() {
            *self = Self::ZERO;
        }
        let expected = seen.expected + self.given_up;
        let new = (T::from_usize(measurements) - seen.detected).at_least(T::ZERO);
        let stated = if stated >= T::ZERO && stated.is_finite() { stated } else { T::ZERO };
        let usually_new = self.usually_new_of(stated);
        let (lost, suspected) = (T::from_f64(LN_LOST), T::from_f64(LN_SUSPECTED));
        let usual = (expected * (T::ONE - self.usually_missed) - T::from_f64(MISSED_IN_A_ROW)).at_least(T::ZERO);
        let blind = measurements == 0 && expected >= T::from_f64(BLIND);
        if usual == T::ZERO && !self.lost {
            self.doubt *= T::from_f64(1.0 - 1.0 / DOUBT_SCANS);
        }
        let step = Self::step(usual, usually_new, seen.detected, new);
        self.doubt = (self.doubt + step).at_least(T::ZERO).at_most(lost + lost);
        self.lost = self.doubt >= lost || self.lost && self.doubt > T::ZERO;

        let faded = self.given_up * T::from_f64(1.0 - 1.0 / GIVEN_UP_SCANS) + seen.given_up;
        // What is missed while nothing is seen is expected as soon as something is.
        self.given_up = faded.at_least(if blind { self.given_up } else { T::ZERO });
        let crowded = self.is_crowded(usually_new, new);
        self.scans = self.scans.saturating_add(1);
        // A sensor that sees nothing shows nothing of what is usual.
        if self.doubt < T::from_f64(DOUBT_USUAL) && !blind {
            self.learn((expected, seen.detected), (new, stated), waited_s);
            if self.scans.is_multiple_of(KNOWN_SCANS) {
                (self.known_below, self.next_known_below) = (self.next_known_below, next_label);
            }
        }
        Health::LOST.when(self.lost)
            | Health::DIVERGENCE_SUSPECTED.when(!self.lost && self.doubt >= suspected)
            | Health::CLUTTER_HIGH.when(crowded)
            | Health::DETECTIONS_LOW.when(blind || self.usually_missed > T::from_f64(MISSED_SHARE))
    }

    /// How many measurements of a detector that states so many false ones nothing known usually explains: as many more or less than
    /// stated as of all detectors. With one detector, that is what is usual.
    fn usually_new_of(&self, stated: T) -> T {
        (self.usually_new + (stated - self.usually_stated)).at_least(T::ZERO)
    }

    /// Whether so many measurements that nothing known explains are far more than usual. Not before that is known.
    fn is_crowded(&self, usually_new: T, new: T) -> bool {
        let deviations = (usually_new + T::ONE).sqrt() * T::from_f64(CLUTTER_DEVIATIONS);
        self.scans >= USUAL_SCANS && new > usually_new + deviations + T::from_f64(CLUTTER_MORE)
    }

    /// ln of the likelihood ratio of a scan.
    fn step(usual: T, usually_new: T, detected: T, new: T) -> T {
        let real = T::from_f64;
        // A share d of a detection lies between 0 and 1, and so E[exp(θ d)] ≤ 1 − (1 − exp θ) E[d] ≤ exp(−(1 − exp θ) E[d]), θ < 0.
        let ln_by_chance = real(LN_BY_CHANCE);
        let by_detections = ln_by_chance * detected + (T::ONE - ln_by_chance.exp()) * real(STILL_DETECTED) * usual;
        // Poisson, at the greatest rate that is usual.
        let rate = usually_new + real(SPARE_MEASUREMENTS);
        let more = usual * real(SEEN_ELSEWHERE);
        let by_new = new * (T::ONE + more / rate).ln() - more;
        by_detections.at_most(by_new)
    }

    /// Learns what is usual.
    fn learn(&mut self, (expected, detected): (T, T), (new, stated): (T, T), waited_s: T) {
        // Until the first landmarks are known, every measurement is new: what is usual is learnt afresh from then on.
        let since_known = self.scans.saturating_sub(2 * KNOWN_SCANS);
        let over = if since_known > 0 { since_known.max(RESTART_SCANS) } else { self.scans };
        let rate = T::ONE / T::from_f64(f64::from(over.min(USUAL_SCANS)));
        self.usually_new += (new - self.usually_new) * rate;
        self.usually_stated += (stated - self.usually_stated) * rate;
        self.usually_waited_s += (waited_s - self.usually_waited_s) * rate;
        if expected > T::ONE {
            let missed = (T::ONE - detected / expected).at_least(T::ZERO);
            self.usually_missed += (missed - self.usually_missed) * T::from_f64(1.0 / f64::from(USUAL_SCANS));
        }
    }

    /// Whether every number is one that a scan can leave. One that is not was damaged, and the watch starts afresh.
    fn is_sound(&self) -> bool {
        let Self { doubt, given_up, usually_missed, usually_new, usually_stated, usually_waited_s, .. } = *self;
        let numbers = [doubt, given_up, usually_missed, usually_new, usually_stated, usually_waited_s];
        numbers.iter().all(|&number| number >= T::ZERO && number.is_finite()) && usually_missed <= T::ONE
    }
}

#[cfg(test)]
mod tests {
    use super::{LN_LOST, Recognised, STILL_DETECTED, Watch};
    use crate::{Health, Noise};

    /// Ten landmarks of p_D 0.9 are known, and two measurements a scan are new.
    fn used_to_ten() -> Watch<f64> {
        let mut watch = Watch::ZERO;
        for _ in 0..200 {
            assert!(scan(&mut watch, 9.0, 9.0, 11).is_good());
        }
        watch
    }

    fn scan(watch: &mut Watch<f64>, expected: f64, detected: f64, measurements: usize) -> Health {
        watch.scanned(&Recognised { expected, detected, given_up: 0.0 }, (measurements, 0.0), 0.1, 7)
    }

    #[test]
    fn counts_over_maps_are_means() {
        let counts = Recognised { expected: 6.0_f64, detected: 4.0, given_up: 2.0 };
        let mean = counts.over(4);
        assert_eq!([mean.expected, mean.detected, mean.given_up], [1.5, 1.0, 0.5]);
        assert_eq!(counts.over(0).expected, 6.0);
    }

    #[test]
    fn here_the_likelihood_ratio_is_one_in_the_mean_at_most() {
        for (usual, new_rate) in [(2.0_f64, 0.0), (4.5, 2.0), (9.0, 20.0), (30.0, 5.0)] {
            // At least two thirds of the usual detections, of as many landmarks as there may be, whatever else is measured.
            for landmarks in [5, 20, 60].into_iter().filter(|&landmarks| f64::from(landmarks) >= usual) {
                let p = STILL_DETECTED * usual / f64::from(landmarks);
                for (p, new) in [(p, 0.0), (p, 300.0), (1.4 * p, 300.0)] {
                    let (mut chance, mut mean) = ((1.0 - p).powi(landmarks), 0.0);
                    for detected in 0..=landmarks {
                        mean += chance * Watch::<f64>::step(usual, new_rate, f64::from(detected), new).exp();
                        chance *= f64::from(landmarks - detected) / f64::from(detected + 1) * p / (1.0 - p);
                    }
                    assert!(mean <= 1.0 + 1e-12, "{usual} {landmarks} {p} {new}: {mean}");
                }
            }
            // At most as many new measurements as usual, whatever is detected.
            for rate in [new_rate, 0.5 * new_rate] {
                let (mut chance, mut mean) = ((-rate).exp(), 0.0);
                for new in 0..200_u32 {
                    mean += chance * Watch::<f64>::step(usual, new_rate, 0.0, f64::from(new)).exp();
                    chance *= rate / f64::from(new + 1);
                }
                assert!(mean <= 1.0 + 1e-12, "{usual} {rate}: {mean}");
            }
        }
    }

    #[test]
    fn who_misses_all_and_sees_others_is_lost_until_all_is_found_again() {
        let mut watch = used_to_ten();
        let healths: std::vec::Vec<Health> = (0..6).map(|_| scan(&mut watch, 9.0, 0.0, 11)).collect();
        assert!(healths.contains(&Health::DIVERGENCE_SUSPECTED) && healths[5].contains(Health::LOST), "{healths:?}");
        // However well the vehicle comes to know the other place, and wherever nothing is expected.
        for _ in 0..1000 {
            scan(&mut watch, 9.0, 0.0, 11);
            assert_eq!(scan(&mut watch, 0.0, 0.0, 11), Health::LOST);
        }
        assert!((0..3).any(|_| scan(&mut watch, 9.0, 9.0, 11).is_good()));

        (0..6).for_each(|_| _ = scan(&mut watch, 9.0, 0.0, 11));
        watch.calm();
        assert!(scan(&mut watch, 9.0, 9.0, 11).is_good());
    }

    #[test]
    fn hidden_blocked_burst_and_left_are_not_lost() {
        let troubles: [(f64, f64, usize); 5] = [
            // Half of all is hidden; all of it is; clutter bursts; nothing known is in view; one landmark is left, and not seen.
            (9.0, 4.5, 13),
            (9.0, 0.0, 2),
            (9.0, 9.0, 60),
            (0.0, 0.0, 40),
            (0.9, 0.0, 40),
        ];
        for (expected, detected, measurements) in troubles {
            let mut watch = used_to_ten();
            for _ in 0..1000 {
                let health = scan(&mut watch, expected, detected, measurements);
                let of_sight = Health::CLUTTER_HIGH | Health::DETECTIONS_LOW;
                assert!(health.bits() & !of_sight.bits() == 0, "{expected} {detected} {health:?}");
            }
        }
    }

    #[test]
    fn a_burst_is_told_at_once_and_blindness_within_ten_scans() {
        let mut watch = used_to_ten();
        assert_eq!(scan(&mut watch, 9.0, 9.0, 30), Health::CLUTTER_HIGH);
        assert!(scan(&mut watch, 9.0, 9.0, 15).is_good());
        let mut watch = used_to_ten();
        let told = (0..10).position(|_| scan(&mut watch, 9.0, 1.0, 3) == Health::DETECTIONS_LOW);
        assert!(matches!(told, Some(5..10)), "{told:?}");
        // Who has only begun does not know what is usual.
        let mut fresh = Watch::ZERO;
        assert!(scan(&mut fresh, 0.0, 0.0, 60).is_good());
    }

    /// Two sensors by turns, each with as many false measurements as it states: neither is crowded, a burst of either is, and who is
    /// lost is told by the one that sees clearly, however much the other one measures.
    #[test]
    fn every_detector_is_held_against_what_it_states() {
        for crowd in [20.0, 30.0, 60.0, 100.0, 150.0_f64] {
            let mut watch = Watch::<f64>::ZERO;
            let mut noise = Noise::seeded(5);
            let mut turn = |watch: &mut Watch<f64>, stated: f64, detected: f64, more: f64| {
                // Poisson, near enough.
                let clutter = (stated + stated.sqrt() * noise.normal::<f64>()).max(0.0).round() + more;
                let seen = Recognised { expected: 9.0, detected, given_up: 0.0 };
                watch.scanned(&seen, ((detected + clutter) as usize, stated), 0.1, 7)
            };
            let stated = |scan: usize| if scan.is_multiple_of(2) { 1.0 } else { crowd };
            for scan in 0..2000 {
                let health = turn(&mut watch, stated(scan), 9.0, 0.0);
                assert!(health.is_good(), "{crowd}: {health:?} in scan {scan}");
            }
            for stated in [1.0, crowd] {
                let more = 10.0 * (stated + 1.0).sqrt();
                assert_eq!(turn(&mut watch, stated, 9.0, more), Health::CLUTTER_HIGH, "{crowd} {stated}");
            }
            let lost = (0..20).any(|scan| turn(&mut watch, stated(scan), 0.0, 9.0).contains(Health::LOST));
            assert!(lost, "{crowd}: {watch:?}");
        }
    }

    #[test]
    fn what_was_given_up_is_still_expected_for_a_while() {
        let mut watch = used_to_ten();
        let gone = Recognised { expected: 9.0, detected: 0.0, given_up: 8.0 };
        watch.scanned(&gone, (11, 0.0), 0.1, 7);
        assert!((0..6).any(|_| scan(&mut watch, 0.0, 0.0, 11) == Health::LOST), "{watch:?}");
        assert!(watch.doubt <= 2.0 * LN_LOST);
    }

    /// A sensor that saw nothing for a minute, and then what nothing known explains.
    #[test]
    fn what_was_missed_while_nothing_was_seen_is_expected_when_something_is() {
        let mut watch = used_to_ten();
        let mut expected = 9.0;
        for _ in 0..600 {
            let seen = Recognised { expected, detected: 0.0, given_up: 0.2 * expected };
            // Detections are low, and no more than that.
            assert_eq!(watch.scanned(&seen, (0, 0.0), 0.1, 7), Health::DETECTIONS_LOW);
            expected *= 0.8;
        }
        assert!(watch.given_up > 5.0 && watch.given_up < 9.0, "{watch:?}");
        assert!((0..6).any(|_| scan(&mut watch, 0.0, 0.0, 11) == Health::LOST), "{watch:?}");
        // What comes back where it was is found again.
        let mut watch = used_to_ten();
        (0..600).for_each(|_| {
            _ = watch.scanned(&Recognised { expected: 9.0, detected: 0.0, given_up: 0.0 }, (0, 0.0), 0.1, 7)
        });
        assert!(scan(&mut watch, 9.0, 9.0, 11).is_good());
    }

    /// A place that is not found among landmarks that are in view, for a pose that is known too badly.
    #[test]
    fn landmarks_that_have_no_part_for_long_are_a_doubt() {
        let mut watch = used_to_ten();
        let mut aside = |expected, measurements, scans| -> std::vec::Vec<Health> {
            let one = |_| {
                watch.exclude_expected(expected, measurements);
                scan(&mut watch, 0.0, 0.0, measurements)
            };
            (0..scans).map(one).collect()
        };
        // One alone, or none that is measured.
        assert!(aside(0.9, 11, 400).iter().all(|health| !health.contains(Health::LOST)));
        assert!(aside(9.0, 1, 400).iter().all(|health| !health.contains(Health::LOST)));
        let healths = aside(5.0, 11, 120);
        let told = |what: Health| healths.iter().position(|health| health.contains(what));
        assert!(matches!(told(Health::DIVERGENCE_SUSPECTED), Some(20..40)), "{healths:?}");
        assert!(matches!(told(Health::LOST), Some(60..100)), "{healths:?}");
        assert!((0..5).any(|_| scan(&mut watch, 9.0, 9.0, 11).is_good()));
    }

    #[test]
    fn landmarks_are_known_for_having_been_there_for_a_while() {
        let mut watch = Watch::<f64>::ZERO;
        let mut known_since = None;
        for label in 0..90 {
            watch.scanned(&Recognised::NOTHING, (1, 0.0), 0.1, label + 1);
            if watch.knows(0, label + 1) {
                known_since = known_since.or(Some(label));
            }
        }
        assert_eq!(known_since, Some(63));
        // Not those that the vehicle comes to know while there is doubt.
        watch.doubt = 5.0;
        let below = watch.known_below;
        (0..40)
            .for_each(|_| _ = watch.scanned(&Recognised { expected: 9.0, ..Recognised::NOTHING }, (9, 0.0), 0.1, 99));
        assert_eq!(watch.known_below, below);
    }

    #[test]
    fn landmarks_are_known_after_labels_have_begun_again() {
        let born = u32::MAX - 500;
        let mut watch = Watch::<f64>::ZERO;
        watch.know_below(born);
        for scan in 1..=100 {
            // Twenty a scan: labels begin again after 25.
            let next_label = born.wrapping_add(20 * scan);
            watch.scanned(&Recognised::NOTHING, (20, 0.0), 0.1, next_label);
            assert!(watch.knows(born.wrapping_sub(1), next_label), "one that was loaded, in scan {scan}");
            assert_eq!(watch.knows(born, next_label), scan >= 64, "scan {scan}");
            assert!(!watch.knows(next_label.wrapping_sub(1), next_label), "scan {scan}");
        }
    }

    #[test]
    fn scans_that_do_not_come_are_input_that_is_lost() {
        let mut watch = Watch::<f64>::ZERO;
        assert!(watch.waiting(100.0).is_good(), "no scan has been promised");
        watch = used_to_ten();
        assert!(watch.waiting(0.99).is_good() && watch.waiting(1.01) == Health::INPUT_LOST);
        watch.usually_waited_s = 0.5;
        assert!(watch.waiting(3.9).is_good() && watch.waiting(4.1) == Health::INPUT_LOST);
    }

    #[test]
    fn a_damaged_watch_starts_afresh() {
        for spoil in [f64::NAN, f64::INFINITY, -1.0] {
            let mut watch = Watch { usually_new: spoil, ..used_to_ten() };
            assert!(scan(&mut watch, 9.0, 0.0, 11).bits() & !Health::DIVERGENCE_SUSPECTED.bits() == 0);
            assert!(watch.scans == 1 && watch.is_sound());
        }
    }
}
