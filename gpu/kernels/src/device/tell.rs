//! The stages that compute the result of a scan: sums over the particles in their order, each by one thread; and the outputs.

use super::group::{Group, whole};
use super::room::{Between, Kind, give_pages_back};
use super::stages::is_informed;
use crate::buffer::{Feature, ScanResult, Status};
use crate::launches::{BLUR, CENTRE, SPREAD, WEIGHT};
use crate::memory::Particles;
use bytemuck::Zeroable;
use core::array::from_fn;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::{AtomicU32, Ordering};
use nalgebra::{Vector2, Vector4};
use scphd::models::{PlanarPose, Pose};
use scphd::numerics::{Symmetric, Vector};
use scphd::storage::{COUNTS, TERMS};
use scphd::{Component, Health, PoseEstimate, Real};

/// The elements of the covariance of the pose that are summed: the lower triangle, row by row.
const TRIANGLE: [(usize, usize); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];

/// The sum of a column.
fn summed(between: &Between, column: usize) -> f32 {
    f32::from_bits(between.sums.get(column).map_or(0, |sum| sum.load(Ordering::Relaxed)))
}

/// Sums a column in order; after the terms of the covariance those of the particles' own covariances. Columns that are not written yet are summed again later. Safety: nothing writes the columns now, and a
/// column has at least this number of elements.
pub(super) unsafe fn sum<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    let [particles, _] = between.scanning.particles();
    let count = if place < TERMS { between.drafts } else { particles };
    let add = |sum: f32, column: usize| {
        let column = from_raw_parts(group.columns.add(column * group.stride), count.min(group.stride));
        // Several values are read before they are summed.
        let (some, rest) = column.as_chunks::<32>();
        let sum = some.iter().fold(sum, |sum, numbers| numbers.iter().fold(sum, |sum, number| sum + number));
        rest.iter().fold(sum, |sum, number| sum + number)
    };
    let mut sum = add(0.0, place);
    if (SPREAD..BLUR).contains(&place) && is_informed((*group.room).filter.assume_init_ref()) {
        sum = add(sum, place - SPREAD + BLUR);
    }
    if let Some(slot) = between.sums.get(place) {
        slot.store(sum.to_bits(), Ordering::Relaxed);
    }
}
pub(super) use self::{sum as sum_centre, sum as sum_spread};

/// Safety: the particles are lent, and only this thread writes the terms at its place.
pub(super) unsafe fn centre<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between().filter(|between| place < between.scanning.particles()[0]) else { return };
    let Some(particle) = between.lent.candidates.all().get(place) else { return };
    let weight = Real::exp(particle.ln_weight) / summed(between, WEIGHT);
    let (sine, cosine) = Real::sin_cos(particle.pose.heading_rad);
    let terms = [weight * particle.pose.x_m, weight * particle.pose.y_m, weight * sine, weight * cosine];
    for (column, term) in (CENTRE..).zip(terms) {
        *group.columns.add(column * group.stride + place) = term;
    }
}

/// The mean pose.
fn mean(between: &Between) -> PlanarPose<f32> {
    let [x, y, sine, cosine] = from_fn(|column| summed(between, CENTRE + column));
    PlanarPose::new(x, y, Real::atan2(sine, cosine))
}

/// Safety: the particles are lent, and only this thread writes the terms at its place.
pub(super) unsafe fn spread<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between().filter(|between| place < between.scanning.particles()[0]) else { return };
    let Some(particle) = between.lent.candidates.all().get(place) else { return };
    let weight = Real::exp(particle.ln_weight) / summed(between, WEIGHT);
    let mut term = Symmetric::ZERO;
    term.add_outer(weight, &particle.pose.difference(&mean(between)));
    for (column, (row, of_row)) in (SPREAD..).zip(TRIANGLE) {
        *group.columns.add(column * group.stride + place) = term.get(row, of_row);
    }
    if is_informed((*group.room).filter.assume_init_ref())
        && let Some(covariance) = between.lent.pose_covariances.all().get(place)
    {
        for (column, (row, of_row)) in (BLUR..).zip(TRIANGLE) {
            *group.columns.add(column * group.stride + place) = covariance.get(row, of_row) * weight;
        }
    }
}

/// Safety: no other thread runs; lent data is given back. The state between the launches ends with the scan, before the filter is
/// used again. The outputs are where the run says.
pub(super) unsafe fn close<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some(between) = group.alone() else { return };
    give_pages_back(between);
    between.scanning.give_particles_back(between.lent.back());
    let room = group.room;
    if !between.in_turn {
        let [of_static, of_moving] = between.lists;
        let ([free, free_moving], [wanted, wanted_moving]) = (between.free, between.wanted);
        let free = [free.saturating_sub(wanted), free_moving.saturating_sub(wanted_moving)];
        between.scanning.give_lists_back((of_static.back(), of_moving.back()), free);
        let read = |count: &AtomicU32| whole(count.load(Ordering::Relaxed));
        let number = |place: usize| between.counts.get(place).map_or(0, read);
        let peaks = from_fn(|kind| [number(COUNTS + kind), number(COUNTS + 2 + kind)]);
        let terms = from_fn(|column| summed(between, column));
        between.scanning.count(terms, from_fn(number), peaks, between.labels);
    }
    let covariance = Symmetric::from_fn(|row, column| {
        let at = TRIANGLE.iter().position(|&place| place == (row.max(column), row.min(column)));
        let element = summed(between, SPREAD + at.unwrap_or(0));
        if row == column { Real::at_least(element, 0.0) } else { element }
    });
    let estimate = PoseEstimate { mean: mean(between), covariance };
    let Between { scanning, .. } = (*room).between.assume_init_read();
    let report = scanning.finish_adopted();
    let (filter, detector) = ((*room).filter.assume_init_ref(), (*room).detector.assume_init_ref());
    let (features, movers) = &mut (*room).slot.estimates;
    let (map, moving) = (filter.estimate_map(detector, features), filter.estimate_moving(movers));
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
        ..of_estimate(&estimate, report.health)
    };
    let (features, movers) = (features.iter().take(map.features), movers.iter().take(moving.features));
    let told = Outputs::of(group).write(whole(group.scan), result, features.copied(), movers.copied());
    *group.status = match told {
        Ok(()) if map.left_out + moving.left_out == 0 => Status { code: Status::DONE, scans: group.scan + 1 },
        Ok(()) => Status { code: Status::FEATURES, scans: group.scan },
        Err(code) => Status { code, scans: group.scan },
    };
}

/// Safety: no other thread runs; there is a result for every scan.
pub(super) unsafe fn digest<M: Particles>(_place: usize, group: &Group<'_, M>) {
    if group.asks_for_digest() {
        (*group.results.add(whole(group.scan))).digest =
            bytemuck::cast((*group.room).filter.assume_init_ref().digest());
    }
}

/// The outputs of a run.
pub(super) struct Outputs<'a> {
    /// A result for every scan.
    pub(super) results: &'a mut [ScanResult],
    /// Memory for the estimated features of all scans.
    pub(super) features: &'a mut [Feature],
}

impl<'r> Outputs<'r> {
    /// Those of a filter, for the only thread that writes them. Safety: they are where the run says.
    pub(super) unsafe fn of<M: Kind>(group: &Group<'_, M>) -> Self {
        let run = &*group.run;
        Self {
            results: from_raw_parts_mut(group.results, whole(run.scans)),
            features: from_raw_parts_mut(group.features, whole(run.features)),
        }
    }

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
        *slot = ScanResult { first_feature, features, movers, predicted: slot.predicted, ..result };
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
