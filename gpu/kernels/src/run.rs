//! One run: a filter over the scans of a scenario, from wherever the last launch left off.

use crate::buffer::{Feature, Mover, Prediction, Run, Scan, ScanResult, Status};
use crate::motion::Vehicle;
use crate::setup::{Made, Models};
use crate::slot::Slot;
use nalgebra::Vector2;
use scphd::{Component, Detector, PlanarPose, PoseEstimate, ScPhd, ScanReport, ScanRoom, Symmetric, Vector};

/// What a run takes in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Inputs<'a> {
    pub(crate) run: &'a Run,
    pub(crate) scans: &'a [Scan],
    pub(crate) predictions: &'a [Prediction],
    pub(crate) measurements: &'a [Vector2<f32>],
}

/// What it leaves.
#[derive(Debug)]
pub(crate) struct Outputs<'a> {
    pub(crate) results: &'a mut [ScanResult],
    pub(crate) features: &'a mut [Feature],
    pub(crate) movers: &'a mut [Mover],
}

/// Which scans, and after which of them a digest is asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span {
    pub(crate) first: usize,
    pub(crate) scans: usize,
    /// After every so many scans of the run, and after its last; 0: after its last alone.
    pub(crate) digest_every: usize,
}

impl Span {
    fn asks_for_digest(self, taken: usize, last: bool) -> bool {
        last || taken.checked_rem(self.digest_every) == Some(0)
    }
}

/// Takes in the scans of a span. Where it is the first, the filter is started; otherwise it goes on from what the slot holds.
pub(crate) fn follow(inputs: Inputs<'_>, slot: &mut Slot, outputs: &mut Outputs<'_>, span: Span) -> Status {
    let mut taken = span.first.min(inputs.scans.len());
    let code = match scans(inputs, slot, outputs, span, &mut taken) {
        Ok(()) => Status::DONE,
        Err(code) => code,
    };
    Status { code, scans: u32::try_from(taken).unwrap_or(u32::MAX) }
}

type Filter<'s> = ScPhd<'s, Vehicle>;
type Sighted<'s> = Detector<Models, ScanRoom<'s, Vector2<f32>>>;

fn scans(
    inputs: Inputs<'_>,
    slot: &mut Slot,
    outputs: &mut Outputs<'_>,
    span: Span,
    taken: &mut usize,
) -> Result<(), u32> {
    let Slot { memory, scratch, features, movers } = slot;
    let refused = Status::SETUP;
    let Made { vehicle, config, detector, start } = inputs.run.setup.make().ok_or(refused)?;
    let mut filter = ScPhd::new(vehicle, config, memory).map_err(|_| refused)?;
    let mut detector = detector.over(scratch).map_err(|_| refused)?;
    if span.first == 0 {
        filter.check(&detector).map_err(|_| refused)?;
        filter.reset(start, inputs.run.seed()).map_err(|_| refused)?;
    }
    // The lists of earlier scans stay where they are.
    let before = span.first.checked_sub(1).and_then(|place| outputs.results.get(place)).copied();
    let mut next = before.map_or([0, 0], |result| {
        [result.first_feature.saturating_add(result.features), result.first_mover.saturating_add(result.movers)]
    });
    let of_span = inputs.scans.iter().zip(outputs.results.iter_mut()).skip(span.first).take(span.scans);
    for (scan, result) in of_span {
        let report = take(inputs, scan, &mut filter, &mut detector)?;
        let is_last = *taken + 1 == inputs.scans.len();
        let estimate = filter.estimate_pose().ok_or(Status::SCAN)?;
        *result = of_report(&report, &estimate);
        if span.asks_for_digest(*taken + 1, is_last) {
            result.digest = detector.digest(filter.digest());
        }
        let map = filter.estimate_map(&detector, features);
        let moving = filter.estimate_moving(movers);
        if map.left_out + moving.left_out > 0 {
            return Err(Status::FEATURES);
        }
        result.expected_features = map.expected_features;
        [result.first_feature, result.first_mover] = next;
        let found = features.iter().take(map.features).map(feature);
        result.features = append(outputs.features, next[0], found).ok_or(Status::FEATURES)?;
        let found = movers.iter().take(moving.features).map(mover);
        result.movers = append(outputs.movers, next[1], found).ok_or(Status::FEATURES)?;
        next = [next[0].saturating_add(result.features), next[1].saturating_add(result.movers)];
        *taken += 1;
    }
    Ok(())
}

/// The predictions before a scan, and the scan.
fn take(
    inputs: Inputs<'_>,
    scan: &Scan,
    filter: &mut Filter<'_>,
    detector: &mut Sighted<'_>,
) -> Result<ScanReport<f32>, u32> {
    let predictions = part(inputs.predictions, scan.first_prediction, scan.predictions).ok_or(Status::BUFFERS)?;
    let measurements = part(inputs.measurements, scan.first_measurement, scan.measurements).ok_or(Status::BUFFERS)?;
    for Prediction { control, dt_s } in predictions {
        filter.predict(control, *dt_s).map_err(|_| Status::PREDICTION)?;
    }
    filter.scan(detector, measurements).map_err(|_| Status::SCAN)
}

/// So many from a place on; `None` where there are not as many.
fn part<T>(all: &[T], first: u32, count: u32) -> Option<&[T]> {
    let first = usize::try_from(first).ok()?;
    all.get(first..)?.get(..usize::try_from(count).ok()?)
}

/// Writes items from a place on: how many; `None` where there is no room for them.
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

/// The covariance of the position.
fn of_position<V: Vector<Scalar = f32>>(covariance: &Symmetric<V>) -> [f32; 3] {
    [(0, 0), (0, 1), (1, 1)].map(|(row, column)| covariance.get(row, column))
}

fn feature(component: &Component<Vector2<f32>>) -> Feature {
    let Component { label, ln_weight, mean, covariance } = component;
    Feature { label: *label, ln_weight: *ln_weight, mean: [mean.x, mean.y], covariance: of_position(covariance) }
}

fn mover(component: &Component<nalgebra::Vector4<f32>>) -> Mover {
    let Component { label, ln_weight, mean, covariance } = component;
    let mean = [mean.x, mean.y, mean.z, mean.w];
    Mover { label: *label, ln_weight: *ln_weight, mean, covariance: of_position(covariance) }
}
