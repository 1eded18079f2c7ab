//! One run: a filter over the scans of a scenario, from start to end.

use crate::buffer::{Feature, Prediction, Run, Scan, ScanResult, Status, halves, joined};
use crate::kind::Particles;
use crate::setup::{Sighting, control_of, describe};
use crate::slot::{FEATURES, MOVERS, Slot};
use bytemuck::Zeroable;
use nalgebra::{Vector2, Vector4};
use scphd::models::{
    PlanarMotion, PlanarPose, RangeBearing, RangeBearingWindow, RangeNoise, UniformClutter, WithNoise,
};
use scphd::numerics::Vector;
use scphd::storage::ScanRoom;
use scphd::{Component, Detector, Health, PoseEstimate, ScPhd, ScanReport};
use scphd_vehicle::{Description, Filter as Tuning};

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
}

/// Whether a digest is needed after `taken` scans: after every `every` scans and after the last; for 0, only after the last.
pub fn asks_for_digest(every: usize, taken: usize, last: bool) -> bool {
    last || taken.checked_rem(every) == Some(0)
}

/// Processes all scans of a run by the library's own scan, on one core.
pub fn follow<M: Particles>(
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
pub(crate) type Filter<'s> = ScPhd<'s, PlanarMotion<f32>>;
/// The models of a sensor.
pub(crate) type Sensing =
    scphd::models::Sensing<WithNoise<RangeBearing<f32>, RangeNoise<f32>>, RangeBearingWindow<f32>, UniformClutter<f32>>;
/// The sensor of a run.
pub(crate) type Sighted<'s> = Detector<Sensing, ScanRoom<'s, Vector2<f32>>>;
/// Memory for the estimates of one scan.
pub(crate) type Lists<'s> = (&'s mut [Component<Vector2<f32>>; FEATURES], &'s mut [Component<Vector4<f32>>; MOVERS]);

/// The started filter and the sensor over a slot, and the memory for estimates.
pub(crate) fn over<'s, M: Particles>(
    run: &Run,
    slot: &'s mut Slot<M>,
) -> Result<(Filter<'s>, Sighted<'s>, Lists<'s>), u32> {
    let Slot { memory, scratch, features, movers } = slot;
    let refused = Status::SETUP;
    let mut description = Description::robot();
    let (motion, sensor) = describe(&mut description, &run.setup).ok_or(refused)?;
    let Tuning::Mixture(config) = description.filter else { return Err(refused) };
    let mut filter = memory.filter(motion, config).map_err(|_| refused)?;
    let detector = Sighting::over(sensor, scratch).map_err(|_| refused)?;
    filter.check(&detector).map_err(|_| refused)?;
    filter.reset(description.start.pose, joined(run.seed)).map_err(|_| refused)?;
    Ok((filter, detector, (features, movers)))
}

fn scans<M: Particles>(
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

/// Writes the result of a scan, with the pose if it is already estimated.
pub(crate) fn tell(
    filter: &Filter<'_>,
    detector: &Sighted<'_>,
    report: &ScanReport<f32>,
    (features, movers): Lists<'_>,
    outputs: &mut Outputs<'_>,
    place: usize,
    (digest, estimate): (bool, Option<PoseEstimate<PlanarPose<f32>>>),
) -> Result<(), u32> {
    let estimate = estimate.or_else(|| filter.estimate_pose()).ok_or(Status::SCAN)?;
    let map = filter.estimate_map(detector, features);
    let moving = filter.estimate_moving(movers);
    if map.left_out + moving.left_out > 0 {
        return Err(Status::FEATURES);
    }
    let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    let result = ScanResult {
        digest: halves(if digest { filter.digest() } else { 0 }),
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
    pub(crate) fn write(
        &mut self,
        place: usize,
        result: ScanResult,
        features: impl Iterator<Item = Component<Vector2<f32>>>,
        movers: impl Iterator<Item = Component<Vector4<f32>>>,
    ) -> Result<(), u32> {
        let before = place.checked_sub(1).and_then(|before| self.results.get(before));
        let first_feature = before.map_or(0, |before| before.first_feature + before.features + before.movers);
        let slot = self.results.get_mut(place).ok_or(Status::BUFFERS)?;
        let mut room = self.features.get_mut(first_feature as usize..).unwrap_or(&mut []).iter_mut();
        let moving = |component: &Component<Vector4<f32>>| component.mean.into();
        let features = append(&mut room, features, |component| [component.mean.x, component.mean.y, 0.0, 0.0])?;
        let movers = append(&mut room, movers, moving)?;
        *slot = ScanResult { first_feature, features, movers, ..result };
        Ok(())
    }
}

/// Processes the predictions before a scan. Returns its measurements.
fn predict<'i>(inputs: Inputs<'i>, place: usize, filter: &mut Filter<'_>) -> Result<&'i [Vector2<f32>], u32> {
    let (predictions, measurements) = before(inputs, place)?;
    for Prediction { control, dt_s } in predictions {
        let control = control_of(filter.motion(), *control);
        filter.predict(&control, *dt_s).map_err(|_| Status::PREDICTION)?;
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
pub(crate) fn of_estimate(estimate: &PoseEstimate<PlanarPose<f32>>, health: Health) -> ScanResult {
    let PoseEstimate { mean, covariance } = estimate;
    ScanResult {
        pose: [mean.x_m, mean.y_m, mean.heading_rad],
        covariance: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(row, column)| covariance.get(row, column)),
        health: u32::from(health.bits()),
        ..Zeroable::zeroed()
    }
}
