//! Result of a run: its errors over time.

use super::plan::Job;
use crate::session::Session;
use scphd_log::angle::wrap;
use scphd_log::dimensions::{Coordinates, Dimensions};
use scphd_score::consistency;
use scphd_score::moving::MovingScore;
use scphd_score::record::ScanRecord;
use scphd_score::results::json::worse;

/// A figure of every scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curve {
    /// Distance of the estimated to the true position, m.
    PositionError,
    /// Absolute heading error, degrees.
    HeadingError,
    /// Distance of dead reckoning from the true position, m.
    DeadReckoningError,
    /// OSPA of the map, order 1, cut-off 1 m.
    OspaNear,
    /// Its localisation part.
    OspaNearLocalization,
    /// Its cardinality part.
    OspaNearCardinality,
    /// OSPA of the map, order 1, cut-off 10 m.
    OspaFar,
    /// Its localisation part.
    OspaFarLocalization,
    /// Its cardinality part.
    OspaFarCardinality,
}

impl Curve {
    /// All curves, in the order of [`Series::values`].
    pub const ALL: [Self; 9] = [
        Self::PositionError,
        Self::HeadingError,
        Self::DeadReckoningError,
        Self::OspaNear,
        Self::OspaNearLocalization,
        Self::OspaNearCardinality,
        Self::OspaFar,
        Self::OspaFarLocalization,
        Self::OspaFarCardinality,
    ];

    /// Its name in tables, with the unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::PositionError => "position_error_m",
            Self::HeadingError => "heading_error_deg",
            Self::DeadReckoningError => "dead_reckoning_error_m",
            Self::OspaNear => "ospa_c1_m",
            Self::OspaNearLocalization => "ospa_c1_localization_m",
            Self::OspaNearCardinality => "ospa_c1_cardinality_m",
            Self::OspaFar => "ospa_c10_m",
            Self::OspaFarLocalization => "ospa_c10_localization_m",
            Self::OspaFarCardinality => "ospa_c10_cardinality_m",
        }
    }

    /// Its value at a scan; `None` if the truth is not known or the value is not finite.
    fn of<D: Dimensions>(self, scan: &ScanRecord<D>) -> Option<f64> {
        let heading = || Some(wrap(D::heading(&scan.pose) - scan.true_heading_rad?));
        let value = match self {
            Self::PositionError => scan.position_error_m()?,
            Self::HeadingError => heading()?.abs().to_degrees(),
            Self::DeadReckoningError => scan.dead_reckoning_error_m()?,
            Self::OspaNear => scan.map_error?.near.distance,
            Self::OspaNearLocalization => scan.map_error?.near.localization,
            Self::OspaNearCardinality => scan.map_error?.near.cardinality,
            Self::OspaFar => scan.map_error?.far.distance,
            Self::OspaFarLocalization => scan.map_error?.far.localization,
            Self::OspaFarCardinality => scan.map_error?.far.cardinality,
        };
        Some(value).filter(|value| value.is_finite())
    }
}

/// The curves of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Time of every scan since the first, s.
    pub t_s: Vec<f64>,
    /// For each of [`Curve::ALL`] a value for each scan, if known.
    pub values: [Vec<Option<f64>>; Curve::ALL.len()],
}

impl Series {
    pub fn of<D: Dimensions>(scans: &[ScanRecord<D>]) -> Self {
        let start_s = scans.first().map_or(0.0, |scan| scan.t_s);
        Self {
            t_s: scans.iter().map(|scan| scan.t_s - start_s).collect(),
            values: Curve::ALL.map(|curve| scans.iter().map(|scan| curve.of(scan)).collect()),
        }
    }

    pub fn curve(&self, curve: Curve) -> &[Option<f64>] {
        &self.values[curve as usize]
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct RunResult {
    pub run: usize,
    pub log: String,
    pub filter: String,
    pub scenario_seed: u64,
    pub filter_seed: u64,
    pub particles: u64,
    pub samples: u64,
    pub series: Series,
    pub nees: Vec<Option<f64>>,
    pub dimension: usize,
    pub moving: Option<MovingScore>,
    pub scan_us_mean: Option<f64>,
}

impl RunResult {
    /// Collects the result of a session that executed `job` with `samples` samples.
    pub fn of<D: Dimensions>(job: &Job, samples: usize, session: Session<D>) -> Self {
        let Session { record, summary, moving, .. } = session;
        Self {
            run: job.run,
            log: summary.log,
            filter: summary.filter,
            scenario_seed: job.scenario_seed,
            filter_seed: job.filter_seed,
            particles: summary.particles,
            samples: samples as u64,
            series: Series::of(&record.scans),
            nees: record.scans.iter().map(consistency::of_position).collect(),
            dimension: D::Position::COUNT,
            moving,
            scan_us_mean: summary.scan_us_mean,
        }
    }

    /// Whether the position RMSE is greater than that of dead reckoning; `None` without truth.
    pub fn worse_than_dead_reckoning(&self) -> Option<bool> {
        let rmse = |curve| {
            let errors: Vec<f64> = self.series.curve(curve).iter().flatten().copied().collect();
            let squares: f64 = errors.iter().map(|error| error * error).sum();
            (!errors.is_empty()).then(|| (squares / errors.len() as f64).sqrt())
        };
        worse(rmse(Curve::PositionError), rmse(Curve::DeadReckoningError))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_in_order_with_distinct_names() {
        for (place, curve) in Curve::ALL.into_iter().enumerate() {
            assert_eq!(curve as usize, place);
            assert!(Curve::ALL[..place].iter().all(|other| other.name() != curve.name()));
        }
    }
}
