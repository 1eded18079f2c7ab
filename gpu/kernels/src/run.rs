//! One run: a filter over the scans of a scenario, from start to end.

use crate::buffer::{Feature, Mover, Prediction, Run, Scan, ScanResult, Status};
use crate::motion::Vehicle;
use crate::setup::{Made, Models};
use crate::size::Size;
use crate::slot::{FEATURES, MOVERS, Slot};
use nalgebra::{Vector2, Vector4};
use scphd::models::PlanarPose;
use scphd::numerics::{Symmetric, Vector};
use scphd::storage::ScanRoom;
use scphd::{Component, Detector, PoseEstimate, ScPhd, ScanReport};

/// The inputs of a run.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// The filter.
    pub run: &'a Run,
    /// All scans of the run.
    pub scans: &'a [Scan],
    /// All predictions of the run.
    pub predictions: &'a [Prediction],
    /// All measurements of the run.
    pub measurements: &'a [Vector2<f32>],
}

/// The outputs of a run.
#[derive(Debug)]
pub struct Outputs<'a> {
    /// A result for every scan.
    pub results: &'a mut [ScanResult],
    /// Memory for the estimated features of all scans.
    pub features: &'a mut [Feature],
    /// Memory for the estimated moving features of all scans.
    pub movers: &'a mut [Mover],
}

/// Whether a digest is needed after `taken` scans: after every `every` scans and after the last; for 0, only after the last.
pub fn asks_for_digest(every: usize, taken: usize, last: bool) -> bool {
    last || taken.checked_rem(every) == Some(0)
}

/// Processes all scans of a run by the library's own scan, on one core.
pub fn follow<M: Size>(
    inputs: Inputs<'_>,
    slot: &mut Slot<M>,
    outputs: &mut Outputs<'_>,
    digest_every: usize,
) -> Status {
    let mut taken = 0;
    let code = match scans(inputs, slot, outputs, digest_every, &mut taken) {
        Ok(()) => Status::DONE,
        Err(code) => code,
    };
    Status { code, scans: u32::try_from(taken).unwrap_or(u32::MAX) }
}

/// A filter over a slot's state, of any capacities.
pub(crate) type Filter<'s> = ScPhd<'s, Vehicle>;
/// The sensor of a run.
pub(crate) type Sighted<'s> = Detector<Models, ScanRoom<'s, Vector2<f32>>>;
/// Memory for the estimates of one scan.
pub(crate) type Lists<'s> = (&'s mut [Component<Vector2<f32>>; FEATURES], &'s mut [Component<Vector4<f32>>; MOVERS]);

/// The started filter and the sensor over a slot, and the memory for estimates.
pub(crate) fn over<'s, M: Size>(run: &Run, slot: &'s mut Slot<M>) -> Result<(Filter<'s>, Sighted<'s>, Lists<'s>), u32> {
    let Slot { memory, scratch, features, movers } = slot;
    let refused = Status::SETUP;
    let Made { vehicle, config, detector, start } = run.setup.make().ok_or(refused)?;
    let mut filter = memory.filter(vehicle, config).map_err(|_| refused)?;
    let detector = detector.over(scratch).map_err(|_| refused)?;
    filter.check(&detector).map_err(|_| refused)?;
    filter.reset(start, run.seed()).map_err(|_| refused)?;
    Ok((filter, detector, (features, movers)))
}

fn scans<M: Size>(
    inputs: Inputs<'_>,
    slot: &mut Slot<M>,
    outputs: &mut Outputs<'_>,
    digest_every: usize,
    taken: &mut usize,
) -> Result<(), u32> {
    let (mut filter, mut detector, (features, movers)) = over(inputs.run, slot)?;
    for place in 0..inputs.scans.len() {
        let measurements = predict(inputs, place, &mut filter)?;
        let report = filter.scan(&mut detector, measurements).map_err(|_| Status::SCAN)?;
        let is_last = place + 1 == inputs.scans.len();
        let digest = asks_for_digest(digest_every, place + 1, is_last);
        tell(&filter, &detector, &report, (&mut *features, &mut *movers), outputs, place, (digest, None))?;
        *taken += 1;
    }
    Ok(())
}

/// Writes the result of a scan, with the pose if it is already estimated. The lists of earlier scans are not moved.
pub(crate) fn tell(
    filter: &Filter<'_>,
    detector: &Sighted<'_>,
    report: &ScanReport<f32>,
    (features, movers): Lists<'_>,
    outputs: &mut Outputs<'_>,
    place: usize,
    (digest, estimate): (bool, Option<PoseEstimate<PlanarPose<f32>>>),
) -> Result<(), u32> {
    let Outputs { results, features: all_features, movers: all_movers } = outputs;
    let before = place.checked_sub(1).and_then(|before| results.get(before)).copied();
    let [first_feature, first_mover] = before.map_or([0, 0], |result| {
        [result.first_feature.saturating_add(result.features), result.first_mover.saturating_add(result.movers)]
    });
    let result = results.get_mut(place).ok_or(Status::BUFFERS)?;
    let estimate = estimate.or_else(|| filter.estimate_pose()).ok_or(Status::SCAN)?;
    *result = of_report(report, &estimate);
    if digest {
        result.digest = filter.digest();
    }
    let map = filter.estimate_map(detector, features);
    let moving = filter.estimate_moving(movers);
    if map.left_out + moving.left_out > 0 {
        return Err(Status::FEATURES);
    }
    result.expected_features = map.expected_features;
    (result.first_feature, result.first_mover) = (first_feature, first_mover);
    let found = features.iter().take(map.features).map(feature);
    result.features = append(all_features, first_feature, found).ok_or(Status::FEATURES)?;
    let found = movers.iter().take(moving.features).map(mover);
    result.movers = append(all_movers, first_mover, found).ok_or(Status::FEATURES)?;
    Ok(())
}

/// Processes the predictions before a scan. Returns its measurements.
fn predict<'i>(inputs: Inputs<'i>, place: usize, filter: &mut Filter<'_>) -> Result<&'i [Vector2<f32>], u32> {
    let (predictions, measurements) = before(inputs, place)?;
    for Prediction { control, dt_s } in predictions {
        filter.predict(control, *dt_s).map_err(|_| Status::PREDICTION)?;
    }
    Ok(measurements)
}

/// The predictions before a scan, and its measurements.
pub(crate) fn before<'i>(inputs: Inputs<'i>, place: usize) -> Result<(&'i [Prediction], &'i [Vector2<f32>]), u32> {
    let scan = inputs.scans.get(place).ok_or(Status::BUFFERS)?;
    let predictions = part(inputs.predictions, scan.first_prediction, scan.predictions).ok_or(Status::BUFFERS)?;
    let measurements = part(inputs.measurements, scan.first_measurement, scan.measurements).ok_or(Status::BUFFERS)?;
    Ok((predictions, measurements))
}

/// `count` elements from `first` on; `None` if there are fewer.
fn part<T>(all: &[T], first: u32, count: u32) -> Option<&[T]> {
    let first = usize::try_from(first).ok()?;
    all.get(first..)?.get(..usize::try_from(count).ok()?)
}

/// Writes items from index `first` on. Returns their number; `None` if the capacity is too small.
fn append<T>(to: &mut [T], first: u32, items: impl ExactSizeIterator<Item = T>) -> Option<u32> {
    let count = items.len();
    let room = to.get_mut(usize::try_from(first).ok()?..)?.get_mut(..count)?;
    room.iter_mut().zip(items).for_each(|(slot, item)| *slot = item);
    u32::try_from(count).ok()
}

fn of_report(report: &ScanReport<f32>, estimate: &PoseEstimate<PlanarPose<f32>>) -> ScanResult {
    let PoseEstimate { mean, covariance } = estimate;
    let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    ScanResult {
        digest: 0,
        pose: [mean.x_m, mean.y_m, mean.heading_rad],
        covariance: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(row, column)| covariance.get(row, column)),
        n_eff: report.n_eff,
        ln_evidence: report.ln_evidence,
        innovation: report.innovation,
        expected_features: 0.0,
        resampled: u32::from(report.resampled),
        in_view: number(report.in_view),
        no_birth: number(report.no_birth),
        pages_used: number(report.pages_used),
        peak_pages: number(report.peak.pages),
        peak_moving_pages: number(report.moving_peak.pages),
        health: u32::from(report.health.bits()),
        first_feature: 0,
        features: 0,
        first_mover: 0,
        movers: 0,
    }
}

/// The covariance of the position: xx, xy, yy.
fn of_position<V: Vector<Scalar = f32>>(covariance: &Symmetric<V>) -> [f32; 3] {
    [(0, 0), (0, 1), (1, 1)].map(|(row, column)| covariance.get(row, column))
}

fn feature(component: &Component<Vector2<f32>>) -> Feature {
    let Component { label, ln_weight, mean, covariance } = component;
    Feature { label: *label, ln_weight: *ln_weight, mean: [mean.x, mean.y], covariance: of_position(covariance) }
}

fn mover(component: &Component<Vector4<f32>>) -> Mover {
    let Component { label, ln_weight, mean, covariance } = component;
    let mean = [mean.x, mean.y, mean.z, mean.w];
    Mover { label: *label, ln_weight: *ln_weight, mean, covariance: of_position(covariance) }
}
