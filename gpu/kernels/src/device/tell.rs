//! The stages that compute the result of a scan: sums over the particles in their order, each by one thread.

use super::group::{Group, whole};
use super::outputs::tell;
use super::room::{Between, give_pages_back};
use crate::buffer::{Status, halves};
use crate::launches::{CENTRE, SPREAD, WEIGHT};
use crate::memory::Particles;
use core::array::from_fn;
use core::slice::from_raw_parts;
use core::sync::atomic::{AtomicU32, Ordering};
use scphd::models::{PlanarPose, Pose};
use scphd::numerics::Symmetric;
use scphd::settings::Proposal;
use scphd::storage::{COUNTS, TERMS};
use scphd::{PoseEstimate, Real};

/// The elements of the covariance of the pose that are summed: the lower triangle, row by row.
const TRIANGLE: [(usize, usize); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
/// Number of values that are read before they are summed.
const READ: usize = 32;

/// The sum of a column.
fn summed(between: &Between, column: usize) -> f32 {
    f32::from_bits(between.sums.get(column).map_or(0, |sum| sum.load(Ordering::Relaxed)))
}

/// Sums a column in order. Columns that are not written yet are summed again later.
/// Safety: nothing writes the columns now, and a column has at least this number of elements.
pub(super) unsafe fn sum<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    let [particles, _] = between.scanning.particles();
    let count = if place < TERMS { between.drafts } else { particles };
    let column = from_raw_parts(group.columns.add(place * group.stride), count.min(group.stride));
    let (some, rest) = column.as_chunks::<READ>();
    let sum = some.iter().fold(0.0, |sum, numbers| numbers.iter().fold(sum, |sum, number| sum + number));
    let sum: f32 = rest.iter().fold(sum, |sum, number| sum + number);
    if let Some(slot) = between.sums.get(place) {
        slot.store(sum.to_bits(), Ordering::Relaxed);
    }
}
pub(super) use self::{sum as sum_centre, sum as sum_spread};

/// Safety: the particles are lent, and only this thread writes the terms at its place.
pub(super) unsafe fn centre<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    let [particles, _] = between.scanning.particles();
    let Some(particle) = between.lent.candidates.all().get(place).filter(|_| place < particles) else { return };
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
    let Some(between) = group.between() else { return };
    let [particles, _] = between.scanning.particles();
    let Some(particle) = between.lent.candidates.all().get(place).filter(|_| place < particles) else { return };
    let weight = Real::exp(particle.ln_weight) / summed(between, WEIGHT);
    let mut term = Symmetric::ZERO;
    term.add_outer(weight, &particle.pose.difference(&mean(between)));
    for (column, (row, of_row)) in (SPREAD..).zip(TRIANGLE) {
        *group.columns.add(column * group.stride + place) = term.get(row, of_row);
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
        let free = from_fn(|kind| {
            let of = |both: &[usize; 2]| both.get(kind).copied().unwrap_or(0);
            of(&between.free).saturating_sub(of(&between.wanted))
        });
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
    let mut outputs = group.outputs();
    let filter = (*room).filter.assume_init_ref();
    let detector = (*room).detector.assume_init_ref();
    let estimate = matches!(filter.config().proposal, Proposal::Blind).then_some(estimate);
    let told = tell(filter, detector, &report, &mut (*room).slot.estimates, &mut outputs, whole(group.scan), estimate);
    *group.status = match told {
        Ok(()) => Status { code: Status::DONE, scans: group.scan + 1 },
        Err(code) => Status { code, scans: group.scan },
    };
}

/// Safety: no other thread runs; there is a result for every scan.
pub(super) unsafe fn digest<M: Particles>(_place: usize, group: &Group<'_, M>) {
    if group.asks_for_digest() {
        (*group.results.add(whole(group.scan))).digest = halves((*group.room).filter.assume_init_ref().digest());
    }
}
