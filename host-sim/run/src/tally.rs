//! Counts over the scans of any vehicle: reported conditions and times.

use scphd::Health;

/// Number of scans in which a filter reported each condition.
#[derive(Debug, Clone, PartialEq)]
pub struct HealthCounts(Vec<(Health, usize)>);

impl HealthCounts {
    /// Adds the report of a scan.
    pub fn add(&mut self, health: Health) {
        for (condition, count) in &mut self.0 {
            *count += usize::from(health.contains(*condition));
        }
    }

    /// The conditions that were reported, with their numbers of scans.
    pub fn reported(self) -> Vec<(Health, usize)> {
        self.0.into_iter().filter(|&(_, count)| count > 0).collect()
    }
}

impl Default for HealthCounts {
    fn default() -> Self {
        Self(Health::all().map(|condition| (condition, 0)).collect())
    }
}

/// Wall time of the scans of a run, µs; `None` without scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanTimes {
    pub mean_us: Option<f64>,
    pub p99_us: Option<f64>,
}

impl ScanTimes {
    /// Computes both from the times of all scans, µs.
    pub fn of(times_us: impl Iterator<Item = f64>) -> Self {
        let mut times: Vec<f64> = times_us.collect();
        times.sort_by(f64::total_cmp);
        Self {
            mean_us: (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64),
            p99_us: percentile(&times, 99),
        }
    }
}

/// The `percent` percentile of the ascending `values`, by the nearest rank.
fn percentile(values: &[f64], percent: usize) -> Option<f64> {
    let rank = (percent * values.len()).div_ceil(100);
    values.get(rank.checked_sub(1)?).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_by_nearest_rank() {
        let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(percentile(&hundred, 99), Some(99.0));
        assert_eq!(percentile(&hundred[..3], 99), Some(3.0));
        assert_eq!(percentile(&[], 99), None);
    }

    #[test]
    fn times_may_be_in_any_order() {
        let times = ScanTimes::of([3.0, 1.0, 8.0].into_iter());
        assert_eq!((times.mean_us, times.p99_us), (Some(4.0), Some(8.0)));
        assert_eq!(ScanTimes::of(std::iter::empty()).mean_us, None);
    }

    #[test]
    fn conditions_are_counted_separately() {
        let mut counts = HealthCounts::default();
        counts.add(Health::DEGENERATE);
        counts.add(Health::DEGENERATE | Health::COMPONENTS_LOST);
        counts.add(Health::GOOD);
        assert_eq!(counts.reported(), [(Health::DEGENERATE, 2), (Health::COMPONENTS_LOST, 1)]);
    }
}
