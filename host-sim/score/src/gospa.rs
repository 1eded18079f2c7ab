//! Generalised OSPA distance with α = 2 (Rahmathullah, García-Fernández and Svensson, 2017).

use crate::cutoff::Cutoff;

/// GOSPA distance and its parts, in the unit of the points;
/// `distanceᵖ = localizationᵖ + missedᵖ + falseᵖ`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gospa {
    pub distance: f64,
    /// The part due to the position errors of the matched estimates.
    pub localization: f64,
    /// The part due to true points without an estimate: `(missed_count · cᵖ/2)^(1/p)`.
    pub missed: f64,
    /// The part due to estimates without a true point: `(false_count · cᵖ/2)^(1/p)`.
    pub spurious: f64,
    /// Number of true points without an estimate nearer than c.
    pub missed_count: usize,
    /// Number of estimates without a true point nearer than c.
    pub spurious_count: usize,
}

/// GOSPA distance (α = 2) of `estimates` to the `truth`, points of any one dimension.
///
/// Two points at distance c or more are not a pair but a missed and a false point, which costs the same.
///
/// # Panics
///
/// If points differ in dimension.
///
/// ```
/// use scphd_score::{cutoff::Cutoff, gospa::gospa};
///
/// let d = gospa(&[[3.0, 4.0], [90.0, 0.0]], &[[0.0, 0.0]], &Cutoff::new(1.0, 10.0));
/// assert_eq!((d.localization, d.missed, d.spurious, d.distance), (5.0, 0.0, 5.0, 10.0));
/// ```
pub fn gospa<X: AsRef<[f64]>, Y: AsRef<[f64]>>(estimates: &[X], truth: &[Y], cutoff: &Cutoff) -> Gospa {
    let c = cutoff.distance();
    let mut pairs = cutoff.matched(estimates, truth);
    pairs.retain(|&d| d < c);
    let (missed_count, spurious_count) = (truth.len() - pairs.len(), estimates.len() - pairs.len());
    // In units of c, so that high powers do not overflow.
    let localization: f64 = pairs.iter().map(|d| cutoff.power(d / c)).sum();
    let (missed, spurious) = (0.5 * missed_count as f64, 0.5 * spurious_count as f64);
    Gospa {
        distance: c * cutoff.root(localization + missed + spurious),
        localization: c * cutoff.root(localization),
        missed: c * cutoff.root(missed),
        spurious: c * cutoff.root(spurious),
        missed_count,
        spurious_count,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutoff::tests::check_oracle;
    use scphd_log::noise::Noise;

    const NONE: [[f64; 2]; 0] = [];

    #[test]
    fn closed_forms() {
        let cutoff = Cutoff::new(2.0, 10.0);
        assert_eq!(gospa(&NONE, &NONE, &cutoff).distance, 0.0);
        let missed = gospa(&NONE, &[[1.0, 1.0], [2.0, 2.0]], &cutoff);
        assert_eq!((missed.distance, missed.missed_count, missed.spurious_count), (10.0, 2, 0));
        let spurious = gospa(&[[1.0, 1.0], [2.0, 2.0]], &NONE, &cutoff);
        assert_eq!((spurious.distance, spurious.missed_count, spurious.spurious_count), (10.0, 0, 2));
        // A distance of exactly c: a missed and a false point, not a pair.
        let apart = gospa(&[[0.0, 0.0]], &[[10.0, 0.0]], &cutoff);
        assert_eq!((apart.distance, apart.missed_count, apart.spurious_count), (10.0, 1, 1));
        assert_eq!(apart.localization, 0.0);
        let near = gospa(&[[0.0, 0.0]], &[[3.0, 4.0]], &cutoff);
        assert_eq!((near.distance, near.localization, near.missed, near.spurious), (5.0, 5.0, 0.0, 0.0));
    }

    #[test]
    fn swapping_the_sets_swaps_missed_and_false() {
        let mut noise = Noise::new(5);
        let mut set = |n: usize| -> Vec<[f64; 2]> { (0..n).map(|_| [0; 2].map(|_| 4.0 * noise.normal())).collect() };
        for case in 0..200 {
            let (x, y, z) = (set(case % 6), set(case % 7), set(case % 4));
            let cutoff = Cutoff::new([1.0, 2.0, 3.5][case % 3], [3.0, 20.0][case % 2]);
            let (d, back) = (gospa(&x, &y, &cutoff), gospa(&y, &x, &cutoff));
            assert!((d.distance - back.distance).abs() < 1e-12);
            assert_eq!((d.missed_count, d.spurious_count), (back.spurious_count, back.missed_count));
            assert_eq!(gospa(&x, &x, &cutoff).distance, 0.0);
            let around = gospa(&x, &z, &cutoff).distance + gospa(&z, &y, &cutoff).distance;
            assert!(d.distance <= around + 1e-12);
            let parts: f64 = [d.localization, d.missed, d.spurious].map(|part| cutoff.power(part)).iter().sum();
            assert!((cutoff.power(d.distance) - parts).abs() < 1e-9 * parts.max(1.0));
        }
    }

    #[test]
    fn oracle() {
        check_oracle("gospa_alpha2", |x, y, cutoff| gospa(x, y, cutoff).distance);
    }
}
