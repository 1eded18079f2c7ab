//! The outputs of a run on a device, through the interface of a filter.

use crate::batch::Batch;
use crate::device::Outcome;
use scphd::errors::Implausible;
use scphd::{Health, Real};
use scphd_filters::slam::{PoseAndCovariance, Refusal, ScanOutcome, Slam};
use scphd_gpu_kernels::{Feature, Run, ScanResult, Status};
use scphd_log::dimensions::{Coordinates, Planar};
use scphd_score::record::{MapFeature, MovingFeature, Usage};

/// One run of a batch, whose outputs are replayed scan by scan.
#[derive(Debug)]
pub struct Played<'o> {
    run: &'o Run,
    outcome: &'o Outcome,
    status: Status,
    /// Number of scans replayed, and whether a prediction has followed.
    told: usize,
    predicted: bool,
    state_bytes: usize,
}

impl<'o> Played<'o> {
    /// Run number `run` of a batch, by a filter with `state_bytes` bytes of state.
    pub fn of(batch: &'o Batch, outcome: &'o Outcome, run: usize, state_bytes: usize) -> Self {
        Self { run: &batch.runs[run], outcome, status: outcome.statuses[run], told: 0, predicted: true, state_bytes }
    }

    pub fn results(&self) -> &'o [ScanResult] {
        &self.outcome.results[self.run.first_scan as usize..][..self.status.scans as usize]
    }

    /// The pose before the next scan, if it was requested.
    pub fn predicted_pose(&self) -> Option<[f64; 3]> {
        self.results().get(self.told).map(|next| next.predicted.map(f64::from))
    }

    fn last(&self) -> Result<&'o ScanResult, Refusal> {
        self.results()[..self.told].last().ok_or_else(|| Refusal("not started".into()))
    }

    /// The estimated features of a scan, static and moving.
    fn features(&self, result: &ScanResult) -> (&'o [Feature], &'o [Feature]) {
        let from = self.outcome.features.get((self.run.first_feature + result.first_feature) as usize..);
        let both = from.and_then(|from| from.get(..(result.features + result.movers) as usize)).unwrap_or(&[]);
        both.split_at(both.len().min(result.features as usize))
    }
}

fn health_of(bits: u32) -> Health {
    let held = Health::all().filter(|condition| bits & u32::from(condition.bits()) != 0);
    held.fold(Health::GOOD, |health, condition| health | condition)
}

/// The symmetric matrix of an upper triangle, row by row.
fn square<const N: usize>(triangle: &[f32]) -> [[f64; N]; N] {
    <[f64; N]>::square(|row, column| {
        let (row, column) = (row.min(column), row.max(column));
        f64::from(triangle[row * N - row * (row + 1) / 2 + column])
    })
}

impl Slam<Planar> for Played<'_> {
    fn predict(&mut self, _control: [f64; 3], _dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        self.predicted = true;
        Ok(None)
    }

    fn scan(&mut self, _sensor: usize, _detections: &[[f64; 2]]) -> Result<ScanOutcome, Refusal> {
        let refused = || Refusal(format!("on the device: {}", Status::text(self.status.code)));
        let result = self.results().get(self.told).ok_or_else(refused)?;
        (self.told, self.predicted) = (self.told + 1, false);
        Ok(ScanOutcome {
            n_eff: f64::from(result.n_eff),
            resampled: result.resampled != 0,
            ln_evidence: Some(f64::from(result.ln_evidence)),
            innovation: Some(f64::from(result.innovation)).filter(|&innovation| innovation > 0.0),
            usage: Usage {
                in_view: result.in_view as usize,
                no_birth: result.no_birth as usize,
                pages_used: Some(result.pages_used as usize).filter(|_| self.run.particles > 0),
            },
            health: health_of(result.health),
            stages_us: None,
        })
    }

    /// Before a scan without a covariance.
    fn pose(&mut self) -> Result<PoseAndCovariance<Planar>, Refusal> {
        if let Some(pose) = self.predicted_pose().filter(|_| self.predicted) {
            return Ok((pose, [[0.0; 3]; 3]));
        }
        let result = self.last()?;
        Ok((result.pose.map(f64::from), square(&result.covariance)))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal> {
        let result = self.last()?;
        let features = self.features(result).0.iter().map(|feature| MapFeature {
            id: feature.label,
            weight: f64::from(Real::exp(feature.ln_weight)),
            mean: [feature.mean[0], feature.mean[1]].map(f64::from),
            covariance: square(&feature.covariance),
        });
        Ok((f64::from(result.expected_features), features.collect()))
    }

    fn moving(&mut self) -> Result<Vec<MovingFeature>, Refusal> {
        let result = self.last()?;
        let features = self.features(result).1.iter().map(|mover| {
            let [x, y, east, north] = mover.mean.map(f64::from);
            MovingFeature {
                id: mover.label,
                weight: f64::from(Real::exp(mover.ln_weight)),
                position: [x, y],
                velocity: [east, north],
                covariance: square(&mover.covariance),
            }
        });
        Ok(features.collect())
    }

    fn digest(&mut self) -> Option<u64> {
        self.last().ok().map(|result| bytemuck::cast(result.digest)).filter(|digest| *digest != 0)
    }

    fn state_bytes(&self) -> Option<u64> {
        Some(self.state_bytes as u64)
    }
}
