//! Means and standard deviations over runs.

use super::run::{Curve, RunResult};
use scphd_score::chi_squared;

/// Mean and standard deviation over runs at one scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Time since the first scan, s, in the first run that has this scan.
    pub t_s: f64,
    /// Mean over the runs with a known value.
    pub mean: f64,
    /// Standard deviation over them (divisor one less than their number); 0 for a single one.
    pub sigma: f64,
}

/// Mean and ±1σ of a curve at every scan; scans without a known value are left out.
pub fn band(results: &[&RunResult], curve: Curve) -> Vec<Band> {
    let scans = results.iter().map(|result| result.series.t_s.len()).max().unwrap_or(0);
    let at = |scan: usize| {
        let t_s = results.iter().find_map(|result| result.series.t_s.get(scan))?;
        let values: Vec<f64> =
            results.iter().filter_map(|result| result.series.curve(curve).get(scan).copied().flatten()).collect();
        let mean = mean(values.iter().copied())?;
        Some(Band { t_s: *t_s, mean, sigma: standard_deviation(&values).unwrap_or(0.0) })
    };
    (0..scans).filter_map(at).collect()
}

/// Mean of the values; `None` for an empty list.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.into_iter().fold((0_usize, 0.0), |(count, sum), value| (count + 1, sum + value));
    (count > 0).then(|| sum / count as f64)
}

/// Standard deviation of a sample (divisor one less than its size); `None` for less than two values.
pub fn standard_deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values.iter().copied()).filter(|_| values.len() > 1)?;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    Some((squares / (values.len() - 1) as f64).sqrt())
}

/// Share of the scans at which the mean over runs of a NEES, divided by its dimension, is within the two-sided 95 % bounds of χ²
/// for this number of independent runs. Scans known in fewer than two runs are left out; `None` if all are.
pub fn consistent_share(runs: &[&[Option<f64>]], dimension: usize) -> Option<f64> {
    let scans = runs.iter().map(|run| run.len()).max().unwrap_or(0);
    let known = (0..scans).filter_map(|scan| {
        let values: Vec<f64> = runs.iter().filter_map(|run| run.get(scan).copied().flatten()).collect();
        let sum: f64 = values.iter().sum();
        (values.len() > 1).then(|| chi_squared::is_within(sum * dimension as f64, dimension * values.len()))
    });
    let within: Vec<bool> = known.collect();
    mean(within.into_iter().map(|within| if within { 1.0 } else { 0.0 }))
}

/// Mean of the known values.
pub(super) fn whole(values: &[Option<f64>]) -> Option<f64> {
    mean(values.iter().copied().flatten())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monte_carlo::made_up::{plan, result};

    #[test]
    fn means_over_runs_have_narrower_bounds_than_single_runs() {
        // The bounds for the mean of ten runs in two dimensions are 0.48 and 1.71.
        let runs: Vec<Vec<Option<f64>>> =
            (0..10).map(|run| vec![Some(1.0), Some(2.0), None, Some(f64::from(run))]).collect();
        let runs: Vec<&[Option<f64>]> = runs.iter().map(Vec::as_slice).collect();
        assert_eq!(consistent_share(&runs, 2), Some(1.0 / 3.0));
        assert_eq!(consistent_share(&runs[..2], 2), Some(1.0));
        assert_eq!(consistent_share(&runs[..1], 2), None);
    }

    #[test]
    fn means_and_standard_deviations_of_three_runs() {
        let plan = plan(3, 3);
        let runs: Vec<RunResult> = (0..3).map(|run| result(&plan.job(run), "scphd", 0.0)).collect();
        let bands = band(&runs.iter().collect::<Vec<_>>(), Curve::PositionError);
        // The first scan has no value; the others have a third a scan plus 0, 0.1 and 0.2.
        assert_eq!(bands.len(), 5);
        assert!((bands[0].mean - (0.1 + 1.0 / 3.0)).abs() < 1e-12 && (bands[0].t_s - 0.1).abs() < 1e-12);
        assert!(bands.iter().all(|band| (band.sigma - 0.1).abs() < 1e-12));
        assert_eq!(band(&[&runs[0]], Curve::OspaFar)[2].sigma, 0.0);
        assert!(band(&[], Curve::OspaFar).is_empty());
    }
}
