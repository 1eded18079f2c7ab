//! Optimal subpattern assignment distance (3.28–3.30).

use crate::cutoff::Cutoff;

/// OSPA distance and its two parts, in the unit of the points; `distanceᵖ = localizationᵖ + cardinalityᵖ`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ospa {
    /// The distance (3.28), 0 … c.
    pub distance: f64,
    /// The part due to positions.
    pub localization: f64,
    /// The part due to the number of points.
    pub cardinality: f64,
}

/// OSPA distance of two sets of points of any one dimension. Two empty sets are at distance 0.
///
/// # Panics
///
/// If points differ in dimension.
///
/// ```
/// use scphd_score::{cutoff::Cutoff, ospa::ospa};
///
/// let d = ospa(&[[0.0, 0.0]], &[[3.0, 4.0], [90.0, 0.0]], &Cutoff::new(1.0, 10.0));
/// assert_eq!((d.localization, d.cardinality, d.distance), (2.5, 5.0, 7.5));
/// ```
pub fn ospa<X: AsRef<[f64]>, Y: AsRef<[f64]>>(x: &[X], y: &[Y], cutoff: &Cutoff) -> Ospa {
    let n = x.len().max(y.len());
    if n == 0 {
        return Ospa { distance: 0.0, localization: 0.0, cardinality: 0.0 };
    }
    // In units of c, so that high powers do not overflow.
    let c = cutoff.distance();
    let near: f64 = cutoff.matched(x, y).into_iter().map(|d| cutoff.power(d / c)).sum();
    let localization = near / n as f64;
    let cardinality = x.len().abs_diff(y.len()) as f64 / n as f64;
    Ospa {
        distance: c * cutoff.root(localization + cardinality),
        localization: c * cutoff.root(localization),
        cardinality: c * cutoff.root(cardinality),
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
        assert_eq!(ospa(&NONE, &NONE, &cutoff).distance, 0.0);
        assert_eq!(ospa(&NONE, &[[1.0, 1.0]], &cutoff).distance, 10.0);
        assert_eq!(ospa(&[[0.0], [7.0]], &[[7.0], [0.0]], &cutoff).distance, 0.0);
        assert_eq!(ospa(&[[0.0, 0.0, 0.0]], &[[2.0, 3.0, 6.0]], &cutoff).distance, 7.0);
        assert_eq!(ospa(&[[0.0]], &[[1e300]], &cutoff).distance, 10.0);
        assert_eq!(ospa(&[[f64::NAN]], &[[0.0]], &cutoff).distance, 10.0);
        // One of two points missing: (c²/2)^½.
        let half = ospa(&[[0.0]], &[[0.0], [1.0]], &cutoff);
        assert_eq!((half.localization, half.cardinality), (0.0, half.distance));
        assert!((half.distance - 50.0_f64.sqrt()).abs() < 1e-14);
        // With a high order the distance tends to the greatest error.
        let high = ospa(&[[0.0], [100.0]], &[[3.0], [105.0]], &Cutoff::new(20.0, 10.0));
        let expected = 5.0 * (0.5 * (1.0 + 0.6_f64.powi(20))).powf(0.05);
        assert!((high.distance - expected).abs() < 1e-12);
    }

    #[test]
    fn ospa_is_a_metric() {
        let mut noise = Noise::new(3);
        let mut set = |n: usize| -> Vec<[f64; 3]> { (0..n).map(|_| [0; 3].map(|_| 4.0 * noise.normal())).collect() };
        for case in 0..200 {
            let (x, y, z) = (set(case % 5), set(case % 7), set(case % 4));
            let cutoff = Cutoff::new([1.0, 2.0, 3.5][case % 3], [3.0, 20.0][case % 2]);
            let d = ospa(&x, &y, &cutoff);
            assert!((d.distance - ospa(&y, &x, &cutoff).distance).abs() < 1e-12);
            assert_eq!(ospa(&x, &x, &cutoff).distance, 0.0);
            assert!((0.0..=cutoff.distance() * (1.0 + 1e-15)).contains(&d.distance));
            let around = ospa(&x, &z, &cutoff).distance + ospa(&z, &y, &cutoff).distance;
            assert!(d.distance <= around + 1e-12);
            let parts = cutoff.power(d.localization) + cutoff.power(d.cardinality);
            assert!((cutoff.power(d.distance) - parts).abs() < 1e-9 * parts.max(1.0));
        }
    }

    #[test]
    fn oracle() {
        check_oracle("ospa", |x, y, cutoff| ospa(x, y, cutoff).distance);
    }
}
