//! The RFS likelihood of a scan with several features of the map at once (Leung, Inostroza, Adams 2016): by how much the scan speaks
//! for them together, less by how much the update has made of that already.
//!
//! RB-PHD SLAM may take any set of features M for it. A scan is explained by M in as many ways as measurements can be given to its
//! features, which is exponential in what has measurements in common. So M is chosen such that the sum stays short, and every bound
//! below is one of M, not of the sum over it, which is complete.

use crate::detection::maps::StaticMaps;
use crate::detection::scan::Scan;
use crate::detection::view::{Detection, View};
use crate::map::reduce::heavier;
use crate::map::within;
use crate::{Component, Factor, LnSum, MeasurementModel, Pose, PositionOf, Real, ScalarOf, Sensor};

/// Features in M, at most: the heaviest static ones in view.
const POINTS: usize = 16;
/// Least weight of a feature in M: what may well not be there says nothing for or against a pose.
const LEAST_WEIGHT: f64 = 0.75;
/// A measurement may be of a feature up to this squared Mahalanobis distance under the sensor's noise alone: e⁻¹⁶ of its peak, far
/// below the chance to miss a feature.
const FARTHEST: f64 = 32.0;
/// Measurements that may be of one feature of M, at most.
const PAIRS: usize = 8;
/// Features of M that are linked by measurements which may be of either, at most.
const GROUP: usize = 6;

/// A feature that may come into M, as one pose sees it.
#[derive(Debug)]
struct Eligible<'m, X: MeasurementModel> {
    feature: &'m Component<PositionOf<X::Pose>>,
    /// ẑ.
    expected: X::Measurement,
    detection: Detection<ScalarOf<X::Pose>>,
}

/// A feature of M.
#[derive(Debug, Clone, Copy)]
struct Point<T> {
    /// ln(1 − p_D).
    ln_missed: T,
    /// The measurements that may be of it, by their places in the scan, with ln( p_D g(z|m)/κ(z) ).
    pairs: [(usize, T); PAIRS],
    len: usize,
    /// Its group: the same number as all that it is linked with.
    group: usize,
}

impl<T: Real> Point<T> {
    /// All zero; a placeholder for unused memory.
    const ZERO: Self = Self { ln_missed: T::ZERO, pairs: [(0, T::ZERO); PAIRS], len: 0, group: 0 };

    /// The feature with all measurements that may be of it, and ln[ 1 − p_D + p_D Σ g/η ]; `None` where they are too many.
    fn of<X: MeasurementModel<Pose: Pose<Scalar = T>>>(
        sensor: &X::Sensor,
        noise: &Factor<X::Measurement>,
        eligible: &Eligible<'_, X>,
        scan: &Scan<'_, X::Measurement>,
        eta: &[LnSum<T>],
    ) -> Option<(Self, T)> {
        let Detection { ln_detected, ln_missed, .. } = eligible.detection;
        let mut point = Self { ln_missed, ..Self::ZERO };
        let mut made_of_it = LnSum::of(ln_missed);
        for (index, (measurement, eta)) in scan.iter().zip(eta).enumerate() {
            let distance = noise.mahalanobis(&sensor.innovation(&measurement.z, &eligible.expected));
            // Written so that NaN is too far.
            if !(distance <= T::from_f64(FARTHEST)) {
                continue;
            }
            let ln_caused = ln_detected + noise.ln_peak() - T::from_f64(0.5) * distance;
            *point.pairs.get_mut(point.len)? = (index, ln_caused - measurement.ln_clutter);
            point.len += 1;
            made_of_it.add(ln_caused - eta.ln());
        }
        Some((point, made_of_it.ln()))
    }

    fn pairs(&self) -> &[(usize, T)] {
        self.pairs.get(..self.len).unwrap_or(&[])
    }

    /// ln( p_D g/κ ) of the measurement at that place of the scan; `None` where it cannot be of the feature.
    fn pair(&self, measurement: usize) -> Option<T> {
        self.pairs().iter().find(|(index, _)| *index == measurement).map(|(_, ln_term)| *ln_term)
    }

    fn is_linked(&self, other: &Self) -> bool {
        self.pairs().iter().any(|(index, _)| other.pair(*index).is_some())
    }
}

/// M, with the groups that its features make.
#[derive(Debug)]
struct EvaluationSet<T> {
    points: [Point<T>; POINTS],
    len: usize,
}

impl<T: Real> EvaluationSet<T> {
    fn points(&self) -> &[Point<T>] {
        self.points.get(..self.len).unwrap_or(&[])
    }

    /// Takes the feature in, unless that would make a group too great; whether it did.
    fn take(&mut self, point: Point<T>) -> bool {
        // The groups that it would link to one, as bits.
        let mut linked = 0_u32;
        for held in self.points().iter().filter(|held| held.is_linked(&point)) {
            linked |= 1 << held.group;
        }
        let is_of_them = |held: &Point<T>| linked & (1 << held.group) != 0;
        if 1 + self.points().iter().filter(|held| is_of_them(held)).count() > GROUP {
            return false;
        }
        let group = self.len;
        self.points.iter_mut().take(group).filter(|held| is_of_them(held)).for_each(|held| held.group = group);
        let Some(slot) = self.points.get_mut(group) else { return false };
        *slot = Point { group, ..point };
        self.len += 1;
        true
    }

    /// ln of Σ over all ways to give each feature of M one measurement of its own or none, of Π (1 − p_D) over the missed features and
    /// Π p_D g/κ over the others. Groups have no measurement in common, so that the sum is a product of theirs.
    fn ln_sum(&self) -> T {
        (0..self.len).fold(T::ZERO, |sum, group| sum + self.ln_sum_of(group))
    }

    /// The factor of one group; ln 1 of a group that is none.
    fn ln_sum_of(&self, group: usize) -> T {
        let mut members = [Point::ZERO; GROUP];
        let mut len = 0;
        for (slot, point) in members.iter_mut().zip(self.points().iter().filter(|point| point.group == group)) {
            *slot = *point;
            len += 1;
        }
        let members = members.get(..len).unwrap_or(&[]);
        // Of every set of members, as bits: the ways to give each of them one of the measurements that came so far.
        let mut given = [LnSum::EMPTY; 1 << GROUP];
        let given = given.get_mut(..1 << len).unwrap_or(&mut []);
        given.iter_mut().take(1).for_each(|nothing| *nothing = LnSum::of(T::ZERO));
        for (place, member) in members.iter().enumerate() {
            for &(measurement, _) in member.pairs() {
                // Every measurement comes once, with the first member that it may be of.
                if members.iter().take(place).all(|before| before.pair(measurement).is_none()) {
                    give(given, members, measurement);
                }
            }
        }
        let mut sum = LnSum::EMPTY;
        for (set, ways) in given.iter().enumerate() {
            let missed = members.iter().enumerate().filter(|(bit, _)| set & (1 << bit) == 0);
            sum.add(missed.fold(ways.ln(), |ln_ways, (_, member)| ln_ways + member.ln_missed));
        }
        sum.ln()
    }
}

/// Lets a measurement be of one more member of every set, or of none.
fn give<T: Real>(given: &mut [LnSum<T>], members: &[Point<T>], measurement: usize) {
    // Greater sets first: what they come from is still without this measurement.
    for set in (1..given.len()).rev() {
        let mut ways = given.get(set).copied().unwrap_or(LnSum::EMPTY);
        for (bit, member) in members.iter().enumerate().filter(|(bit, _)| set & (1 << bit) != 0) {
            if let Some((before, ln_term)) = given.get(set & !(1 << bit)).zip(member.pair(measurement)) {
                ways.add(before.ln() + ln_term);
            }
        }
        if let Some(slot) = given.get_mut(set) {
            *slot = ways;
        }
    }
}

/// ln g(Z|M) − Σ ln κ(z), up to the clutter rate λ, less Σ ln v(m)/v⁻(m) over M: what the likelihood with M has beyond that with the empty
/// map. Zero where there is no feature for M.
#[inline(never)]
pub(crate) fn ln_beyond_empty<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    view: &View<'_, X>,
    particle: usize,
    static_maps: &StaticMaps<'_, X::Pose>,
    scan: &Scan<'_, X::Measurement>,
    eta: &[LnSum<T>],
) -> T {
    let Some(noise) = view.sensor.noise().factor() else { return T::ZERO };
    let ln_least = T::from_f64(LEAST_WEIGHT).ln();
    let mut heaviest: [Option<Eligible<'_, X>>; POINTS] = [const { None }; POINTS];
    let bounds = view.bounds();
    for feature in within(static_maps, particle, &bounds) {
        if !(feature.ln_weight >= ln_least) {
            continue;
        }
        let Some(expectation) = view.expect(feature) else { continue };
        let (expected, detection) = (expectation.expected().measurement, expectation.detection);
        let mut placed = Some(Eligible { feature, expected, detection });
        for slot in &mut heaviest {
            let Some(new) = &placed else { break };
            if slot.as_ref().is_none_or(|held| heavier(new.feature, held.feature)) {
                core::mem::swap(slot, &mut placed);
            }
        }
    }
    let mut set = EvaluationSet { points: [Point::ZERO; POINTS], len: 0 };
    let mut ln_made_of_it = T::ZERO;
    for eligible in heaviest.iter().flatten() {
        if let Some((point, ln_ratio)) = Point::of::<X>(view.sensor, &noise, eligible, scan, eta)
            && set.take(point)
        {
            ln_made_of_it += ln_ratio;
        }
    }
    set.ln_sum() - ln_made_of_it
}

#[cfg(test)]
mod tests {
    use super::{EvaluationSet, GROUP, PAIRS, POINTS, Point};
    use std::vec::Vec;

    fn point(missed: f64, pairs: &[(usize, f64)]) -> Point<f64> {
        let mut point = Point { ln_missed: missed.ln(), len: pairs.len(), ..Point::ZERO };
        for (slot, &(measurement, term)) in point.pairs.iter_mut().zip(pairs) {
            *slot = (measurement, term.ln());
        }
        point
    }

    fn set(points: &[Point<f64>]) -> EvaluationSet<f64> {
        let mut set = EvaluationSet { points: [Point::ZERO; POINTS], len: 0 };
        for &point in points {
            set.take(point);
        }
        set
    }

    /// Every association, one after the other.
    fn enumerated(points: &[Point<f64>], used: &mut Vec<usize>) -> f64 {
        let Some((first, rest)) = points.split_first() else { return 1.0 };
        let mut sum = first.ln_missed.exp() * enumerated(rest, used);
        for &(measurement, ln_term) in first.pairs() {
            if !used.contains(&measurement) {
                used.push(measurement);
                sum += ln_term.exp() * enumerated(rest, used);
                used.pop();
            }
        }
        sum
    }

    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12 * expected.abs().max(1.0), "{found} instead of {expected}");
    }

    #[test]
    fn apart_the_features_are_independent() {
        let points = [point(0.1, &[(0, 3.0)]), point(0.2, &[(1, 5.0), (2, 0.5)]), point(0.3, &[])];
        close(set(&points).ln_sum(), (3.1_f64 * 5.7 * 0.3).ln());
        assert_eq!(set(&[]).ln_sum(), 0.0);
    }

    #[test]
    fn two_features_cannot_both_have_the_one_measurement() {
        let points = [point(0.1, &[(4, 3.0)]), point(0.2, &[(4, 5.0)])];
        // Both missed, or one of them.
        close(set(&points).ln_sum(), (0.1 * 0.2 + 3.0 * 0.2 + 0.1 * 5.0_f64).ln());
    }

    #[test]
    fn all_associations_of_tangled_features() {
        let term = |k: usize, z: usize| 0.1 + ((k * 7 + z * 5) % 11) as f64;
        // Two groups of features that share measurements with their neighbours.
        let points: Vec<Point<f64>> = (0..9)
            .map(|k| {
                let first = 10 * usize::from(k > 4) + k;
                point(0.05 + 0.1 * k as f64, &[0, 1, 3].map(|z| (first + z, term(k, z))))
            })
            .collect();
        let set = set(&points);
        assert_eq!(set.len, 9);
        assert_eq!(set.points().iter().map(|point| point.group).collect::<Vec<_>>(), [4, 4, 4, 4, 4, 8, 8, 8, 8]);
        close(set.ln_sum(), enumerated(&points, &mut Vec::new()).ln());
    }

    #[test]
    fn the_greatest_group_with_the_most_measurements() {
        let terms: Vec<(usize, f64)> = (0..PAIRS).map(|z| (z, 1.0 + z as f64)).collect();
        let points: Vec<Point<f64>> = (0..=GROUP).map(|k| point(0.01 * (1 + k) as f64, &terms)).collect();
        let set = set(&points);
        // One more would make it too great; one apart from it would not.
        assert_eq!(set.len, GROUP);
        close(set.ln_sum(), enumerated(&points[..GROUP], &mut Vec::new()).ln());
    }

    #[test]
    fn nothing_vanishes_in_single_precision() {
        let mut set = EvaluationSet { points: [Point::<f32>::ZERO; POINTS], len: 0 };
        for _ in 0..GROUP {
            let mut point = Point { ln_missed: -40.0, len: 1, ..Point::ZERO };
            point.pairs[0] = (3, 80.0);
            assert!(set.take(point));
        }
        // One of six has it, five are missed: e^(80 − 200) six times.
        assert!((set.ln_sum() - (-120.0 + 6.0_f32.ln())).abs() < 1e-4);
    }
}
