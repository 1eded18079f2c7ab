//! Prediction of measurements by positions of earlier ones: the score by which settings are judged.
//!
//! With a right trajectory, a feature is measured at the same position whenever it is in view again; with a wrong one, beside or
//! around its old position. Therefore the positions of earlier measurements, as a density, predict those of later measurements as
//! seen from the pose before their scan:
//!
//! ```text
//! score = Σ_z ln( ε / A + (1 − ε) / n Σ_i t(y_z; y_i, 2 R*_z) )
//! ```
//!
//! with the position y_z of a measurement, its covariance R*_z by the default settings for the log, the n positions y_i of all
//! earlier measurements except recent ones, Student's t of two degrees of freedom (whose tail still distinguishes near from far
//! misses), and a share ε of false measurements over the area of the view, in space its volume, A. The score has no setting of
//! the filter: noise, p_D and clutter of a candidate cannot improve it, only its trajectory can, and scores of any filters and
//! settings over the same log can be compared.

use nalgebra::DMatrix;
use scphd_log::dimensions::Coordinates;
use std::f64::consts::TAU;

/// ε.
const FALSE_SHARE: f64 = 0.1;
/// Least age of the predicting measurements, as a share of the log's duration. Features that stay in view say nothing about the
/// trajectory.
const AGO_SHARE: f64 = 0.1;
/// Greatest number of positions; more are thinned out by scans, because the time grows with their square.
const MOST_PLACES: usize = 60_000;

/// The position of a measurement from the predicted pose, and its covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting<P> {
    pub place: P,
    /// R*, m².
    pub covariance: DMatrix<f64>,
}

/// The measurements of one scan in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Look<P> {
    pub t_s: f64,
    /// The measurements from the pose before the scan.
    pub predicted: Vec<Sighting<P>>,
    /// Their positions from the pose after the scan, m.
    pub settled: Vec<P>,
}

/// The score of every scan, nats; `view` is A, m² or m³.
pub fn scores<P: Coordinates>(looks: &[Look<P>], view: f64) -> Vec<f64> {
    let (Some(first), Some(last)) = (looks.first(), looks.last()) else { return Vec::new() };
    let ago_s = AGO_SHARE * (last.t_s - first.t_s);
    let all: usize = looks.iter().map(|look| look.settled.len()).sum();
    let stride = all.div_ceil(MOST_PLACES).max(1);
    let mut places: Vec<P> = Vec::new();
    let mut old = 0;
    let scan = |(index, look): (usize, &Look<P>)| {
        while looks[old].t_s + ago_s < look.t_s {
            if old.is_multiple_of(stride) {
                places.extend(&looks[old].settled);
            }
            old += 1;
        }
        if !index.is_multiple_of(stride) {
            return 0.0;
        }
        look.predicted.iter().filter_map(|sighting| ln_density(sighting, &places, view)).sum()
    };
    looks.iter().enumerate().map(scan).collect()
}

/// Log density of a sighting; `None` if its covariance has no inverse.
fn ln_density<P: Coordinates>(sighting: &Sighting<P>, places: &[P], view: f64) -> Option<f64> {
    let doubled = (2.0 * &sighting.covariance).cholesky()?;
    let precision = doubled.inverse();
    let precision = P::square(|row, column| precision[(row, column)]);
    let (at, precision) = (sighting.place.as_ref(), precision.as_ref());
    let dimensions = P::COUNT as f64;
    let density = |place: &P| {
        let apart = P::with(|k| at[k] - place.as_ref()[k]);
        let apart = apart.as_ref();
        let product = |row: &P| row.as_ref().iter().zip(apart).map(|(p, a)| p * a).sum::<f64>();
        let distance: f64 = apart.iter().zip(precision).map(|(a, row)| a * product(row)).sum();
        power(1.0 + 0.5 * distance, P::COUNT)
    };
    let sum: f64 = places.iter().map(density).sum();
    // Γ((2 + D)/2) / Γ(1) divided by (2π)^(D/2) √det.
    let peak = libm::tgamma(1.0 + 0.5 * dimensions) / (TAU.powf(0.5 * dimensions) * doubled.determinant().sqrt());
    let foreseen = if places.is_empty() { 0.0 } else { peak * sum / places.len() as f64 };
    Some((FALSE_SHARE / view + (1.0 - FALSE_SHARE) * foreseen).ln())
}

/// x to the power of −(2 + D)/2, optimised: most of the time is spent here.
fn power(x: f64, dimensions: usize) -> f64 {
    let whole = x.powi(-(1 + dimensions as i32 / 2));
    if dimensions.is_multiple_of(2) { whole } else { whole / x.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;
    use std::f64::consts::PI;

    fn sighting(x: f64, y: f64) -> Sighting<[f64; 2]> {
        Sighting { place: [x, y], covariance: DMatrix::from_diagonal(&DVector::from_vec(vec![0.5, 2.0])) }
    }

    fn look(t_s: f64, x: f64) -> Look<[f64; 2]> {
        Look { t_s, predicted: vec![sighting(x, 0.0)], settled: vec![[x, 0.0]] }
    }

    #[test]
    fn the_density_integrates_to_one_over_the_plane_and_the_view() {
        let places = [[0.3, -0.2], [-4.0, 1.0]];
        let (step, half) = (0.5, 150.0);
        let steps = (2.0 * half / step) as usize;
        let at = |k: usize| step * k as f64 - half;
        let cells = (0..steps).flat_map(|i| (0..steps).map(move |k| sighting(at(i), at(k))));
        let area = 4.0 * half * half;
        let mass: f64 = cells.map(|cell| ln_density(&cell, &places, area).unwrap().exp() * step * step).sum();
        assert!((mass - 1.0).abs() < 1e-3, "{mass}");
        // Closed form at a position: (1 − ε)/n /(2π √det 2R*), plus the tail of the other.
        let one = ln_density(&sighting(1.0, 1.0), &[[1.0, 1.0]], 10.0).unwrap().exp();
        assert!((one - (0.01 + 0.9 / (2.0 * PI * 2.0))).abs() < 1e-12);
    }

    #[test]
    fn the_density_integrates_to_one_in_space() {
        // Integral over spherical shells of area 4π r², as the density does not depend on the direction; the rest is the tail.
        let covariance = DMatrix::identity(3, 3) * 0.5;
        let at = |x: f64| Sighting { place: [x, 0.0, 0.0], covariance: covariance.clone() };
        let (step, last) = (0.01, 400.0);
        let shells = (0..(last / step) as usize).map(|k| step * (k as f64 + 0.5));
        // With an infinite view the density of false measurements is zero.
        let density = |x: f64| ln_density(&at(x), &[[0.0; 3]], f64::INFINITY).unwrap().exp() / (1.0 - FALSE_SHARE);
        let mass: f64 = shells.map(|radius| 4.0 * PI * radius * radius * density(radius) * step).sum();
        assert!((mass - 1.0).abs() < 1e-4, "{mass}");
    }

    #[test]
    fn only_old_measurements_predict() {
        // The third scan is 1.5 s after the second, and a tenth of the log is 2 s.
        let looks = [look(0.0, 0.0), look(8.5, 5.0), look(10.0, 5.0), look(20.0, 5.0)];
        let scores = scores(&looks, 10.0);
        let expected = |x: f64, places: &[f64]| {
            let places: Vec<_> = places.iter().map(|&x| [x, 0.0]).collect();
            ln_density(&sighting(x, 0.0), &places, 10.0).unwrap()
        };
        assert_eq!(
            scores,
            [expected(0.0, &[]), expected(5.0, &[0.0]), expected(5.0, &[0.0]), expected(5.0, &[0.0, 5.0, 5.0])]
        );
        assert!(scores[3] > scores[2]);
        assert_eq!(super::scores::<[f64; 2]>(&[], 1.0), Vec::<f64>::new());
    }

    #[test]
    fn a_wrong_trajectory_scores_less_the_farther_it_is_off() {
        let round = |drift: f64| {
            let looks: Vec<Look<_>> =
                (0..40).map(|k| look(f64::from(k), f64::from(k % 10) * 10.0 + drift * f64::from(k / 10))).collect();
            scores(&looks, 100.0).iter().sum::<f64>()
        };
        assert!(round(0.0) > round(1.0) && round(1.0) > round(3.0), "{} {} {}", round(0.0), round(1.0), round(3.0));
    }
}
