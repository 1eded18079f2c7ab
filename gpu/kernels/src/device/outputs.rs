//! The outputs of a run.

use crate::buffer::{Feature, ScanResult, Status};
use crate::memory::Estimates;
use crate::run::{Filter, Sighted};
use bytemuck::Zeroable;
use nalgebra::{Vector2, Vector4};
use scphd::models::PlanarPose;
use scphd::numerics::Vector;
use scphd::{Component, Health, PoseEstimate, ScanReport};

/// The outputs of a run.
pub(super) struct Outputs<'a> {
    /// A result for every scan.
    pub(super) results: &'a mut [ScanResult],
    /// Memory for the estimated features of all scans.
    pub(super) features: &'a mut [Feature],
}

/// Writes the result of a scan, with the pose if it is already estimated.
pub(super) fn tell(
    filter: &Filter<'_>,
    detector: &Sighted<'_>,
    report: &ScanReport<f32>,
    (features, movers): &mut Estimates,
    outputs: &mut Outputs<'_>,
    place: usize,
    estimate: Option<PoseEstimate<PlanarPose<f32>>>,
) -> Result<(), u32> {
    let estimate = estimate.or_else(|| filter.estimate_pose()).ok_or(Status::SCAN)?;
    let map = filter.estimate_map(detector, features);
    let moving = filter.estimate_moving(movers);
    if map.left_out + moving.left_out > 0 {
        return Err(Status::FEATURES);
    }
    let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    let result = ScanResult {
        n_eff: report.n_eff,
        ln_evidence: report.ln_evidence,
        innovation: report.innovation,
        expected_features: map.expected_features,
        resampled: u32::from(report.resampled),
        in_view: number(report.in_view),
        no_birth: number(report.no_birth),
        pages_used: number(report.pages_used),
        peak_pages: number(report.peak.pages),
        peak_moving_pages: number(report.moving_peak.pages),
        ..of_estimate(&estimate, report.health)
    };
    let (features, movers) = (features.iter().take(map.features), movers.iter().take(moving.features));
    outputs.write(place, result, features.copied(), movers.copied())
}

impl Outputs<'_> {
    /// Writes the result and the estimates of a scan behind those of the scan before. The lists of earlier scans are not moved.
    pub(super) fn write(
        &mut self,
        place: usize,
        result: ScanResult,
        features: impl Iterator<Item = Component<Vector2<f32>>>,
        movers: impl Iterator<Item = Component<Vector4<f32>>>,
    ) -> Result<(), u32> {
        let before = place.checked_sub(1).and_then(|before| self.results.get(before));
        let first_feature = before.map_or(0, |before| before.first_feature + before.features + before.movers);
        let slot = self.results.get_mut(place).ok_or(Status::SCAN)?;
        let mut room = self.features.get_mut(first_feature as usize..).unwrap_or(&mut []).iter_mut();
        let moving = |component: &Component<Vector4<f32>>| component.mean.into();
        let features = append(&mut room, features, |component| [component.mean.x, component.mean.y, 0.0, 0.0])?;
        let movers = append(&mut room, movers, moving)?;
        *slot = ScanResult { first_feature, features, movers, ..result };
        Ok(())
    }
}

/// Writes components. Returns their number; an error if the capacity is too small.
fn append<'f, V: Vector<Scalar = f32>>(
    room: &mut impl Iterator<Item = &'f mut Feature>,
    components: impl Iterator<Item = Component<V>>,
    mean: impl Fn(&Component<V>) -> [f32; 4],
) -> Result<u32, u32> {
    let mut count = 0;
    for component in components {
        let covariance = [(0, 0), (0, 1), (1, 1)].map(|(row, column)| component.covariance.get(row, column));
        let (label, ln_weight) = (component.label, component.ln_weight);
        *room.next().ok_or(Status::FEATURES)? = Feature { label, ln_weight, mean: mean(&component), covariance };
        count += 1;
    }
    Ok(count)
}

/// A result with this estimate of the pose; everything else is zero.
pub(super) fn of_estimate(estimate: &PoseEstimate<PlanarPose<f32>>, health: Health) -> ScanResult {
    let PoseEstimate { mean, covariance } = estimate;
    ScanResult {
        pose: [mean.x_m, mean.y_m, mean.heading_rad],
        covariance: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(row, column)| covariance.get(row, column)),
        health: u32::from(health.bits()),
        ..Zeroable::zeroed()
    }
}
