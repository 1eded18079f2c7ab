//! Monitor of filter divergence: is the estimated pose wrong, or do sensors fail?
//!
//! A CUSUM test (Page 1954) with log-likelihood ratios of two hypotheses, "lost" against "localised". A localised vehicle is in one
//! of two cases:
//!
//! * known landmarks are detected at two thirds of their usual rate or more, whatever else is measured. This covers a burst of
//!   clutter, and occlusion of a third of all landmarks;
//! * measurements from no known landmark come at most at their usual rate, whatever is detected. This covers a blocked view, and a
//!   view without known landmarks.
//!
//! The known landmarks of a lost vehicle are detected only by chance, and measurements appear elsewhere instead. A step of the sum
//! is the smaller of the two log-likelihood ratios. E[exp(step)] is therefore at most 1 in either case, which may change from scan
//! to scan, and the sum reaches h at most once in exp(h) scans.

use crate::{Health, Real};

/// Least share of the usual detections under the hypothesis "localised".
const STILL_DETECTED: f64 = 2.0 / 3.0;
/// ln 1/5: logarithm of the rate of detections of known landmarks under "lost", divided by the usual rate. Some measurements lie by
/// chance where a landmark is expected, and the pose may follow one or two landmarks.
const LN_BY_CHANCE: f64 = -1.609_437_912_434_100_3;
/// Number of known landmarks that may be missed in every scan: one at the edge of the view, or one that was removed.
const MISSED_IN_A_ROW: f64 = 1.0;
/// Least number of measurements of a lost vehicle from unexpected landmarks, divided by the number of expected detections.
const SEEN_ELSEWHERE: f64 = 0.5;
/// Added to the usual number of new measurements a scan, to allow for the error of the mean over the last scans.
const SPARE_MEASUREMENTS: f64 = 0.5;

/// Threshold of LOST, ln 10⁴: at most one false alarm in ten thousand scans.
const LN_LOST: f64 = 9.210_340_371_976_184;
/// Threshold of DIVERGENCE_SUSPECTED, ln 10²: at most one false alarm in a hundred scans.
const LN_SUSPECTED: f64 = 4.605_170_185_988_092;
/// A landmark becomes known when its age is between this number of scans and twice that. A lost vehicle maps its surroundings
/// again, and the sum must reach its threshold before these landmarks are known.
const KNOWN_SCANS: u32 = 32;
/// Time constant of the usual rates, scans.
const USUAL_SCANS: u32 = 32;
/// Least number of scans in the time constant of a mean that is started again.
const RESTART_SCANS: u32 = 4;
/// The usual rates are updated while the sum is below this value.
const LEARNS_BELOW: f64 = 1.0;
/// Time constant with which the sum decays while no known landmark is expected, scans.
const DECAY_SCANS: f64 = 64.0;
/// Time constant with which the expected detections of removed landmarks decay, scans: these would leave the view.
const EXISTENCE_LOSS_SCANS: f64 = 20.0;
/// An empty scan means a blocked sensor if at least this number of detections was expected.
const BLIND: f64 = 3.0;
/// Least number of expected detections of excluded landmarks, and of measurements, in a scan that counts as not associated.
const EXCLUDED: f64 = 1.5;
/// Added to the sum for each such scan.
const EXCLUDED_STEP: f64 = 0.2;
/// CLUTTER_HIGH: the number of new measurements is above the usual one by these many standard deviations and this number more.
const CLUTTER_DEVIATIONS: f64 = 5.0;
const CLUTTER_MORE: f64 = 3.0;
/// DETECTIONS_LOW: this share of the expected detections is missed.
const MISSED_SHARE: f64 = 0.2;
/// INPUT_LOST: no scan for this multiple of the usual time between scans, and for at least this time, s.
const WAITED_TIMES: f64 = 8.0;
const WAITED_S: f64 = 1.0;

/// Known landmarks in view in a scan, expected and detected, weighted with their existence probabilities w.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Recognised<T> {
    /// Σ p_D w.
    pub(crate) expected: T,
    /// Expected number of detections given the scan.
    pub(crate) detected: T,
    /// Σ p_D (w − w⁺): decrease of the expected detections because the scan lowered existence probabilities.
    pub(crate) existence_loss: T,
}

impl<T: Real> Recognised<T> {
    pub(crate) const NOTHING: Self = Self { expected: T::ZERO, detected: T::ZERO, existence_loss: T::ZERO };

    pub(crate) fn add(&mut self, other: &Self) {
        self.expected += other.expected;
        self.detected += other.detected;
        self.existence_loss += other.existence_loss;
    }

    /// Mean over this number of maps.
    pub(crate) fn over(self, maps: usize) -> Self {
        let maps = T::from_usize(maps.max(1));
        Self {
            expected: self.expected / maps,
            detected: self.detected / maps,
            existence_loss: self.existence_loss / maps,
        }
    }
}

/// Whether a label was not assigned between `known_below` and `next_label`. Labels wrap around after 2³².
pub(crate) fn is_known(label: u32, known_below: u32, next_label: u32) -> bool {
    label.wrapping_sub(known_below) >= next_label.wrapping_sub(known_below)
}

/// State of the monitor: the usual rates and the CUSUM sum. All zero before the first scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Watch<T> {
    /// The CUSUM sum of log-likelihood ratios of "lost" against "localised".
    pub(crate) cusum: T,
    /// Whether the sum has reached the threshold of LOST, and has not been zero since.
    pub(crate) lost: bool,
    /// Expected detections of landmarks whose existence probability was lowered by misses.
    pub(crate) existence_loss: T,
    /// Usual share of expected detections that are missed.
    pub(crate) usually_missed: T,
    /// Usual number of measurements a scan that are not of known landmarks ("new").
    pub(crate) usually_new: T,
    /// Mean over the same scans of the number of false measurements that the detector states, λ.
    pub(crate) usually_stated: T,
    /// The usual time between scans, s.
    pub(crate) usually_waited_s: T,
    /// Number of scans; saturates.
    pub(crate) scans: u32,
    /// Landmarks with labels from this one on are not known.
    pub(crate) known_below: u32,
    /// The value that `known_below` takes next.
    pub(crate) next_known_below: u32,
}

impl<T: Real> Watch<T> {
    pub(crate) const ZERO: Self = Self {
        cusum: T::ZERO,
        lost: false,
        existence_loss: T::ZERO,
        usually_missed: T::ZERO,
        usually_new: T::ZERO,
        usually_stated: T::ZERO,
        usually_waited_s: T::ZERO,
        scans: 0,
        known_below: 0,
        next_known_below: 0,
    };

    /// Whether the landmark with this label is known; `next_label` is the label of the next birth.
    pub(crate) fn knows(&self, label: u32, next_label: u32) -> bool {
        is_known(label, self.known_below, next_label)
    }

    /// Makes all landmarks with smaller labels known.
    pub(crate) fn know_below(&mut self, label: u32) {
        (self.known_below, self.next_known_below) = (label, label);
    }

    /// Resets the sum, because the pose was set or made uncertain.
    pub(crate) fn reset_sum(&mut self) {
        (self.cusum, self.lost, self.existence_loss) = (T::ZERO, false, T::ZERO);
    }

    /// Health flags when no scan has come for `waited_s`.
    pub(crate) fn waiting(&self, waited_s: T) -> Health {
        let usual = self.usually_waited_s * T::from_f64(WAITED_TIMES);
        Health::INPUT_LOST.when(self.scans > 0 && waited_s > usual.at_least(T::from_f64(WAITED_S)))
    }

    /// Increases the sum for a scan in which landmarks in view were excluded from the association, because they are too uncertain.
    /// `expected` is the number of their expected detections.
    pub(crate) fn exclude_expected(&mut self, expected: T, measurements: usize) {
        let enough = T::from_f64(EXCLUDED);
        if expected >= enough && T::from_usize(measurements) >= enough {
            self.cusum += T::from_f64(EXCLUDED_STEP);
        }
    }

    /// Updates the monitor with a scan: known landmarks, number of measurements and of false ones that the detector states, time
    /// since the last scan, s, and label of the next birth.
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
        let expected = seen.expected + self.existence_loss;
        let new = (T::from_usize(measurements) - seen.detected).at_least(T::ZERO);
        let stated = if stated >= T::ZERO && stated.is_finite() { stated } else { T::ZERO };
        let usually_new = self.usually_new_of(stated);
        let (lost, suspected) = (T::from_f64(LN_LOST), T::from_f64(LN_SUSPECTED));
        let usual = (expected * (T::ONE - self.usually_missed) - T::from_f64(MISSED_IN_A_ROW)).at_least(T::ZERO);
        let blind = measurements == 0 && expected >= T::from_f64(BLIND);
        if usual == T::ZERO && !self.lost {
            self.cusum *= T::from_f64(1.0 - 1.0 / DECAY_SCANS);
        }
        let step = Self::step(usual, usually_new, seen.detected, new);
        self.cusum = (self.cusum + step).at_least(T::ZERO).at_most(lost + lost);
        self.lost = self.cusum >= lost || self.lost && self.cusum > T::ZERO;

        let faded = self.existence_loss * T::from_f64(1.0 - 1.0 / EXISTENCE_LOSS_SCANS) + seen.existence_loss;
        // Landmarks missed by a blocked sensor are expected again in the first scan that is not empty.
        self.existence_loss = faded.at_least(if blind { self.existence_loss } else { T::ZERO });
        let crowded = self.is_crowded(usually_new, new);
        self.scans = self.scans.saturating_add(1);
        // A blocked sensor does not change the usual rates.
        if self.cusum < T::from_f64(LEARNS_BELOW) && !blind {
            self.learn((expected, seen.detected), (new, stated), waited_s);
            if self.scans.is_multiple_of(KNOWN_SCANS) {
                (self.known_below, self.next_known_below) = (self.next_known_below, next_label);
            }
        }
        Health::LOST.when(self.lost)
            | Health::DIVERGENCE_SUSPECTED.when(!self.lost && self.cusum >= suspected)
            | Health::CLUTTER_HIGH.when(crowded)
            | Health::DETECTIONS_LOW.when(blind || self.usually_missed > T::from_f64(MISSED_SHARE))
    }

    /// Usual number of new measurements of a detector that states this number of false ones: its excess over the stated number is
    /// assumed to be the mean excess of all detectors. With one detector this is the mean itself.
    fn usually_new_of(&self, stated: T) -> T {
        (self.usually_new + (stated - self.usually_stated)).at_least(T::ZERO)
    }

    /// Whether this number of new measurements is far above the usual one. False until the usual one is known.
    fn is_crowded(&self, usually_new: T, new: T) -> bool {
        let deviations = (usually_new + T::ONE).sqrt() * T::from_f64(CLUTTER_DEVIATIONS);
        self.scans >= USUAL_SCANS && new > usually_new + deviations + T::from_f64(CLUTTER_MORE)
    }

    /// Log-likelihood ratio of "lost" against "localised" for a scan.
    fn step(usual: T, usually_new: T, detected: T, new: T) -> T {
        let real = T::from_f64;
        // An association probability d is between 0 and 1, so that for θ < 0 E[exp(θ d)] ≤ 1 − (1 − exp θ) E[d]
        // ≤ exp(−(1 − exp θ) E[d]).
        let ln_by_chance = real(LN_BY_CHANCE);
        let by_detections = ln_by_chance * detected + (T::ONE - ln_by_chance.exp()) * real(STILL_DETECTED) * usual;
        // Ratio of two Poisson distributions, with the greatest usual rate.
        let rate = usually_new + real(SPARE_MEASUREMENTS);
        let more = usual * real(SEEN_ELSEWHERE);
        let by_new = new * (T::ONE + more / rate).ln() - more;
        by_detections.at_most(by_new)
    }

    /// Updates the usual rates.
    fn learn(&mut self, (expected, detected): (T, T), (new, stated): (T, T), waited_s: T) {
        // Every measurement is new until the first landmarks are known. The means are therefore started again at that time.
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

    /// Whether every number is in its range. Memory errors can change them; the monitor then starts again.
    fn is_sound(&self) -> bool {
        let Self { cusum, existence_loss, usually_missed, usually_new, usually_stated, usually_waited_s, .. } = *self;
        let numbers = [cusum, existence_loss, usually_missed, usually_new, usually_stated, usually_waited_s];
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
        watch.scanned(&Recognised { expected, detected, existence_loss: 0.0 }, (measurements, 0.0), 0.1, 7)
    }

    #[test]
    fn counts_over_maps_are_means() {
        let counts = Recognised { expected: 6.0_f64, detected: 4.0, existence_loss: 2.0 };
        let mean = counts.over(4);
        assert_eq!([mean.expected, mean.detected, mean.existence_loss], [1.5, 1.0, 0.5]);
        assert_eq!(counts.over(0).expected, 6.0);
    }

    #[test]
    fn the_mean_likelihood_ratio_of_a_localised_vehicle_is_at_most_one() {
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
    fn missing_all_landmarks_and_seeing_new_ones_is_lost_until_they_are_detected_again() {
        let mut watch = used_to_ten();
        let healths: std::vec::Vec<Health> = (0..6).map(|_| scan(&mut watch, 9.0, 0.0, 11)).collect();
        assert!(healths.contains(&Health::DIVERGENCE_SUSPECTED) && healths[5].contains(Health::LOST), "{healths:?}");
        // It stays lost in a place mapped anew, and where nothing is expected.
        for _ in 0..1000 {
            scan(&mut watch, 9.0, 0.0, 11);
            assert_eq!(scan(&mut watch, 0.0, 0.0, 11), Health::LOST);
        }
        assert!((0..3).any(|_| scan(&mut watch, 9.0, 9.0, 11).is_good()));

        (0..6).for_each(|_| _ = scan(&mut watch, 9.0, 0.0, 11));
        watch.reset_sum();
        assert!(scan(&mut watch, 9.0, 9.0, 11).is_good());
    }

    #[test]
    fn occlusion_blocked_view_clutter_and_leaving_the_map_are_not_lost() {
        let troubles: [(f64, f64, usize); 5] = [
            // Half of the landmarks occluded; all of them; a burst of clutter; no known landmark in view; one in view, and missed.
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
                let of_view = Health::CLUTTER_HIGH | Health::DETECTIONS_LOW;
                assert!(health.bits() & !of_view.bits() == 0, "{expected} {detected} {health:?}");
            }
        }
    }

    #[test]
    fn a_burst_of_clutter_is_reported_at_once_and_low_detections_within_ten_scans() {
        let mut watch = used_to_ten();
        assert_eq!(scan(&mut watch, 9.0, 9.0, 30), Health::CLUTTER_HIGH);
        assert!(scan(&mut watch, 9.0, 9.0, 15).is_good());
        let mut watch = used_to_ten();
        let first = (0..10).position(|_| scan(&mut watch, 9.0, 1.0, 3) == Health::DETECTIONS_LOW);
        assert!(matches!(first, Some(5..10)), "{first:?}");
        // Not before the usual rate is known.
        let mut fresh = Watch::ZERO;
        assert!(scan(&mut fresh, 0.0, 0.0, 60).is_good());
    }

    /// Two alternating sensors with as many false measurements as each states: CLUTTER_HIGH is raised only by a burst of one of
    /// them, and LOST is raised although one of them has much clutter.
    #[test]
    fn clutter_is_compared_with_the_stated_rate_of_each_detector() {
        for crowd in [20.0, 30.0, 60.0, 100.0, 150.0_f64] {
            let mut watch = Watch::<f64>::ZERO;
            let mut noise = Noise::seeded(5);
            let mut turn = |watch: &mut Watch<f64>, stated: f64, detected: f64, more: f64| {
                // Approximately Poisson.
                let clutter = (stated + stated.sqrt() * noise.normal::<f64>()).max(0.0).round() + more;
                let seen = Recognised { expected: 9.0, detected, existence_loss: 0.0 };
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
    fn removed_landmarks_are_still_expected_for_a_while() {
        let mut watch = used_to_ten();
        let gone = Recognised { expected: 9.0, detected: 0.0, existence_loss: 8.0 };
        watch.scanned(&gone, (11, 0.0), 0.1, 7);
        assert!((0..6).any(|_| scan(&mut watch, 0.0, 0.0, 11) == Health::LOST), "{watch:?}");
        assert!(watch.cusum <= 2.0 * LN_LOST);
    }

    /// A sensor is blocked for a minute, and then has new measurements.
    #[test]
    fn landmarks_missed_by_a_blocked_sensor_are_expected_again() {
        let mut watch = used_to_ten();
        let mut expected = 9.0;
        for _ in 0..600 {
            let seen = Recognised { expected, detected: 0.0, existence_loss: 0.2 * expected };
            // No other flag than DETECTIONS_LOW.
            assert_eq!(watch.scanned(&seen, (0, 0.0), 0.1, 7), Health::DETECTIONS_LOW);
            expected *= 0.8;
        }
        assert!(watch.existence_loss > 5.0 && watch.existence_loss < 9.0, "{watch:?}");
        assert!((0..6).any(|_| scan(&mut watch, 0.0, 0.0, 11) == Health::LOST), "{watch:?}");
        // Landmarks detected again where they were: no flag.
        let mut watch = used_to_ten();
        (0..600).for_each(|_| {
            _ = watch.scanned(&Recognised { expected: 9.0, detected: 0.0, existence_loss: 0.0 }, (0, 0.0), 0.1, 7)
        });
        assert!(scan(&mut watch, 9.0, 9.0, 11).is_good());
    }

    /// Scans that are not associated because the pose is too uncertain.
    #[test]
    fn scans_that_are_not_associated_lead_to_lost() {
        let mut watch = used_to_ten();
        let mut exclude = |expected, measurements, scans| -> std::vec::Vec<Health> {
            let one = |_| {
                watch.exclude_expected(expected, measurements);
                scan(&mut watch, 0.0, 0.0, measurements)
            };
            (0..scans).map(one).collect()
        };
        // One landmark, or one measurement, is not enough.
        assert!(exclude(0.9, 11, 400).iter().all(|health| !health.contains(Health::LOST)));
        assert!(exclude(9.0, 1, 400).iter().all(|health| !health.contains(Health::LOST)));
        let healths = exclude(5.0, 11, 120);
        let first = |what: Health| healths.iter().position(|health| health.contains(what));
        assert!(matches!(first(Health::DIVERGENCE_SUSPECTED), Some(20..40)), "{healths:?}");
        assert!(matches!(first(Health::LOST), Some(60..100)), "{healths:?}");
        assert!((0..5).any(|_| scan(&mut watch, 9.0, 9.0, 11).is_good()));
    }

    #[test]
    fn no_landmark_becomes_known_while_the_sum_is_high() {
        let mut watch = used_to_ten();
        watch.cusum = 5.0;
        let below = watch.known_below;
        (0..40)
            .for_each(|_| _ = watch.scanned(&Recognised { expected: 9.0, ..Recognised::NOTHING }, (9, 0.0), 0.1, 99));
        assert_eq!(watch.known_below, below);
    }

    #[test]
    fn landmarks_are_known_after_labels_wrapped_around() {
        let born = u32::MAX - 500;
        let mut watch = Watch::<f64>::ZERO;
        watch.know_below(born);
        for scan in 1..=100 {
            // Twenty births a scan: labels wrap around after 25 scans.
            let next_label = born.wrapping_add(20 * scan);
            watch.scanned(&Recognised::NOTHING, (20, 0.0), 0.1, next_label);
            assert!(watch.knows(born.wrapping_sub(1), next_label), "a loaded landmark, in scan {scan}");
            assert_eq!(watch.knows(born, next_label), scan >= 64, "scan {scan}");
            assert!(!watch.knows(next_label.wrapping_sub(1), next_label), "scan {scan}");
        }
    }

    #[test]
    fn input_is_lost_when_no_scan_comes() {
        let mut watch = Watch::<f64>::ZERO;
        assert!(watch.waiting(100.0).is_good(), "no scan before");
        watch = used_to_ten();
        assert!(watch.waiting(0.99).is_good() && watch.waiting(1.01) == Health::INPUT_LOST);
        watch.usually_waited_s = 0.5;
        assert!(watch.waiting(3.9).is_good() && watch.waiting(4.1) == Health::INPUT_LOST);
    }

    #[test]
    fn a_monitor_with_memory_errors_starts_again() {
        for spoil in [f64::NAN, f64::INFINITY, -1.0] {
            let mut watch = Watch { usually_new: spoil, ..used_to_ten() };
            assert!(scan(&mut watch, 9.0, 0.0, 11).bits() & !Health::DIVERGENCE_SUSPECTED.bits() == 0);
            assert!(watch.scans == 1 && watch.is_sound());
        }
    }
}
