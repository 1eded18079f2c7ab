//! The stages that compute the result of a scan: sums over the particles in their order, each by one thread.
//!
//! Every function is the body of a [`Stage`](crate::Stage), whose safety requirements apply.

use crate::buffer::{Status, halves};
use crate::group::{alone, asks, between, give_pages_back, outputs, whole};
use crate::room::Size;
use crate::room::{Between, COLUMNS, Group};
use crate::run::tell;
use core::array::from_fn;
use core::slice::from_raw_parts;
use core::sync::atomic::Ordering;
use scphd::models::{PlanarPose, Pose};
use scphd::numerics::Symmetric;
use scphd::settings::Proposal;
use scphd::storage::{COUNTS, TERMS};
use scphd::{PoseEstimate, Real};

/// Number of columns for the terms of the mean pose: x, y, sine and cosine.
const CENTRE: usize = 4;
/// Columns of the terms of the covariance of the pose, row by row of the lower triangle.
const SPREAD: [(usize, usize); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
/// Number of values that are read before they are summed.
const READ: usize = 32;

/// Sums the first `count` numbers of a column in order.
unsafe fn sum_column<M: Size>(place: usize, group: &Group<M>, count: usize, between: &Between) {
    // SAFETY: nothing writes the columns now, and a column has at least this number of elements.
    let column = unsafe { from_raw_parts(group.columns.add(place * group.stride), count.min(group.stride)) };
    let (some, rest) = column.as_chunks::<READ>();
    let sum = some.iter().fold(0.0, |sum, numbers| numbers.iter().fold(sum, |sum, number| sum + number));
    let sum: f32 = rest.iter().fold(sum, |sum, number| sum + number);
    if let Some(slot) = between.sums.get(place) {
        slot.store(sum.to_bits(), Ordering::Relaxed);
    }
}

/// The sum of a column.
fn summed(between: &Between, column: usize) -> f32 {
    f32::from_bits(between.sums.get(column).map_or(0, |sum| sum.load(Ordering::Relaxed)))
}

pub(crate) unsafe fn sum<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: as for the stage.
    unsafe {
        let Some(between) = between(group, scan) else { return };
        let [particles, _] = between.scanning.particles();
        sum_column(place, group, if place < TERMS { between.drafts } else { particles }, between);
    }
}

pub(crate) unsafe fn centre<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: the particles are lent, and only this thread writes the terms at its place.
    unsafe {
        let Some(between) = between(group, scan) else { return };
        let [particles, _] = between.scanning.particles();
        let Some(particle) = between.lent.candidates.all().get(place).filter(|_| place < particles) else { return };
        if place == 0 {
            // The sums of the terms overwrite these sums, so they are copied.
            for (column, kept) in (*group.rooms).kept.iter().enumerate() {
                kept.store(summed(between, column).to_bits(), Ordering::Relaxed);
            }
        }
        let weight = Real::exp(particle.ln_weight) / summed(between, TERMS);
        let (sine, cosine) = Real::sin_cos(particle.pose.heading_rad);
        let terms = [weight * particle.pose.x_m, weight * particle.pose.y_m, weight * sine, weight * cosine];
        for (column, term) in terms.into_iter().enumerate() {
            *group.columns.add(column * group.stride + place) = term;
        }
    }
}

pub(crate) unsafe fn sum_centre<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: as for the stage.
    unsafe {
        let Some(between) = between(group, scan) else { return };
        if place < CENTRE {
            let [particles, _] = between.scanning.particles();
            sum_column(place, group, particles, between);
        }
    }
}

/// The mean pose.
fn mean(between: &Between) -> PlanarPose<f32> {
    let [x, y, sine, cosine] = from_fn::<_, CENTRE, _>(|column| summed(between, column));
    PlanarPose::new(x, y, Real::atan2(sine, cosine))
}

pub(crate) unsafe fn spread<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: the particles are lent, and only this thread writes the terms at its place.
    unsafe {
        let Some(between) = between(group, scan) else { return };
        let [particles, _] = between.scanning.particles();
        let Some(particle) = between.lent.candidates.all().get(place).filter(|_| place < particles) else { return };
        let mean = mean(between);
        if place == 0 {
            for (kept, number) in (*group.rooms).centre.iter().zip([mean.x_m, mean.y_m, mean.heading_rad]) {
                kept.store(number.to_bits(), Ordering::Relaxed);
            }
        }
        let weight = Real::exp(particle.ln_weight) / summed(between, TERMS);
        let mut term = Symmetric::ZERO;
        term.add_outer(weight, &particle.pose.difference(&mean));
        for (column, (row, of_row)) in SPREAD.into_iter().enumerate() {
            *group.columns.add(column * group.stride + place) = term.get(row, of_row);
        }
    }
}

pub(crate) unsafe fn sum_spread<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: as for the stage.
    unsafe {
        let Some(between) = between(group, scan) else { return };
        if place < SPREAD.len() {
            let [particles, _] = between.scanning.particles();
            sum_column(place, group, particles, between);
        }
    }
}

pub(crate) unsafe fn close<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; lent data is given back. The state between the launches ends with the scan, before the filter
    // is used again. The outputs are where the run says.
    unsafe {
        let Some(between) = alone(place, group, scan) else { return };
        give_pages_back(between);
        between.scanning.give_particles_back(between.lent.back());
        let room = group.rooms;
        let read = |kept: &core::sync::atomic::AtomicU32| kept.load(Ordering::Relaxed);
        if !between.in_turn {
            let [of_static, of_moving] = between.lists;
            let free = from_fn(|kind| {
                let of = |both: &[usize; 2]| both.get(kind).copied().unwrap_or(0);
                of(&between.free).saturating_sub(of(&between.wanted))
            });
            between.scanning.give_lists_back((of_static.back(), of_moving.back()), free);
            let number = |place: usize| whole(between.counts.get(place).map_or(0, read));
            let peaks = from_fn(|kind| [number(COUNTS + kind), number(COUNTS + 2 + kind)]);
            let terms = from_fn(|column| f32::from_bits((*room).kept.get(column).map_or(0, read)));
            between.scanning.count(terms, from_fn(number), peaks, between.labels);
        }
        let [x, y, heading] = (*room).centre.each_ref().map(|number| f32::from_bits(read(number)));
        let covariance = Symmetric::from_fn(|row, column| {
            let at = SPREAD.iter().position(|&place| place == (row.max(column), row.min(column)));
            let element = summed(between, at.unwrap_or(COLUMNS));
            if row == column { Real::at_least(element, 0.0) } else { element }
        });
        let estimate = PoseEstimate { mean: PlanarPose::new(x, y, heading), covariance };
        let Between { scanning, .. } = (*room).between.assume_init_read();
        let report = scanning.finish_adopted();
        let mut outputs = outputs(group);
        let filter = (*room).filter.assume_init_ref();
        let detector = (*room).detector.assume_init_ref();
        let lists = (&mut (*room).slot.features, &mut (*room).slot.movers);
        let estimate = matches!(filter.config().proposal, Proposal::Blind).then_some(estimate);
        let told = tell(filter, detector, &report, lists, &mut outputs, whole(scan), (false, estimate));
        *group.statuses = match told {
            Ok(()) => Status { code: Status::DONE, scans: scan + 1 },
            Err(code) => Status { code, scans: scan },
        };
    }
}

pub(crate) unsafe fn digest<M: Size>(place: usize, group: &Group<M>, scan: u32, digest_every: u32) {
    // SAFETY: no other thread runs; there is a result for every scan.
    unsafe {
        if place == 0 && asks(group, scan, digest_every) {
            (*group.results.add(whole(scan))).digest = halves((*group.rooms).filter.assume_init_ref().digest());
        }
    }
}
