//! A scan as a sequence of launches, for any number of filters at once: the function of each thread in each launch.
//!
//! The stages are those of [`scphd::storage::Scanning`]. Weighing a candidate or updating the maps of a survivor is the work of
//! one thread. Steps that must be sequential are one thread for each filter, so that the state stays on the device.
//!
//! The functions of stages have the safety requirements of `run` in `kernel.rs`.

use super::group::{Group, whole};
use super::room::{Between, Kind, Lending, Listed, Many, Predicting, TOGETHER, give_pages_back};
use crate::buffer::{Prediction, Status};
use crate::launches::COLUMNS;
use crate::memory::Particles;
use crate::setup::{Filter, control_of, numbers_of, over};
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};
use scphd::storage::{COUNTS, Samples};

/// Starts the filter, and makes a draft over each desk. Safety: no other thread runs. A room starts as zeros, which are a valid
/// value, and does not move, so that it can hold pointers to its own parts.
pub(super) unsafe fn start<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let room = group.room;
    let code = match over(&*group.run, &mut (*room).slot) {
        Ok((filter, detector)) => {
            (*room).filter = MaybeUninit::new(filter);
            (*room).detector = MaybeUninit::new(detector);
            Status::DONE
        }
        Err(code) => code,
    };
    *group.status = Status { code, scans: 0 };
    for place in 0..whole((*group.run).particles) {
        let [draft] = (*group.desks.add(place)).drafts();
        *group.drafts.add(place) = MaybeUninit::new(draft);
    }
}

/// Begins the next prediction before a scan, lends the candidates, and finds the positions of their numbers in the random stream.
/// Safety: no other thread runs; `start` has initialised filter and detector.
pub(super) unsafe fn predict<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some((filter, predicting)) = with_candidates(group) else { return };
    let taken = whole(predicting.taken);
    // Another run may have more predictions before this scan.
    let Some(Prediction { control, dt_s }) = group.predictions().get(taken) else { return };
    predicting.taken += 1;
    match filter.begin_predict(&control_of(filter.motion(), *control), *dt_s) {
        Ok(Some(Samples { candidates, in_use, selected, splits, mut noise })) => {
            let numbers = numbers_of(filter.motion());
            for (place, first) in (0..in_use).step_by(TOGETHER).enumerate() {
                *group.streams.add(place) = MaybeUninit::new(noise.clone());
                noise.skip((in_use - first).min(TOGETHER) * numbers);
            }
            predicting.after = MaybeUninit::new(noise);
            predicting.lent = Some([Many::lent(candidates), Many::lent(selected)]);
            predicting.in_use = in_use;
            predicting.splits = splits;
        }
        Ok(None) => {}
        Err(_) => (*group.status).code = Status::PREDICTION,
    }
}

/// Moves one candidate (5.12). Safety: the candidates are lent, and each belongs to one place.
pub(super) unsafe fn sample<M: Particles>(place: usize, group: &Group<'_, M>) {
    if !group.goes_on() {
        return;
    }
    let Predicting { taken, lent: Some([candidates, particles]), in_use, splits, .. } = &(*group.room).prediction
    else {
        return;
    };
    if place < *in_use
        && let Some(candidate) = candidates.one(place)
        && let Some(Prediction { control, dt_s }) = group.predictions().get(whole(taken.wrapping_sub(1)))
    {
        let mut noise = (*group.streams.add(place / TOGETHER)).assume_init_ref().clone();
        let filter = (*group.room).filter.assume_init_ref();
        noise.skip(place % TOGETHER * numbers_of(filter.motion()));
        if *splits && let Some(parent) = particles.one(place / whole((*group.run).samples).max(1)) {
            *candidate = filter.child_of(parent);
        }
        filter.sample(candidate, &control_of(filter.motion(), *control), *dt_s, &mut noise);
    }
}

/// The filter, which gets its candidates back if they were lent, and the prediction; `None` if the run has stopped. Safety: no other
/// thread runs; `start` has initialised the filter.
unsafe fn with_candidates<'r, M: Particles>(
    group: &Group<'_, M>,
) -> Option<(&'r mut Filter<'static>, &'r mut Predicting)> {
    let (filter, predicting) =
        group.goes_on().then(|| ((*group.room).filter.assume_init_mut(), &mut (*group.room).prediction))?;
    let &mut Predicting { in_use, splits, .. } = predicting;
    if let Some([candidates, selected]) = predicting.lent.take() {
        let (candidates, selected) = (candidates.back(), selected.back());
        let noise = predicting.after.assume_init_ref().clone();
        filter.end_predict(Samples { candidates, in_use, selected, splits, noise });
    }
    Some((filter, predicting))
}

/// Sorts the measurements of a scan, and lends the pages. Safety: no other thread runs; `start` has initialised filter and
/// detector.
pub(super) unsafe fn open<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some((filter, predicting)) = with_candidates(group) else { return };
    let room = group.room;
    let detector = (*room).detector.assume_init_mut();
    predicting.taken = 0;
    match filter.begin_scan(detector, group.measurements()) {
        Ok((scanning, eta)) => {
            let between = (*room).between.write(Between {
                scanning,
                eta,
                pages: Many::NONE,
                moving_pages: Many::NONE,
                lent: Lending::NONE,
                rest: 0.0,
                uniform: None,
                last: 0,
                drafts: 0,
                first_fresh: 0,
                labels: 0,
                free: [0; 2],
                wanted: [0; 2],
                lists: [Listed::NONE; 2],
                in_turn: false,
                crowded: AtomicU32::new(0),
                counts: [const { AtomicU32::new(0) }; COUNTS + 4],
                sums: [const { AtomicU32::new(0) }; COLUMNS],
            });
            between.scanning.enter();
            let (pages, moving_pages) = between.scanning.lend_pages();
            (between.pages, between.moving_pages) = (Many::lent(pages), Many::lent(moving_pages));
        }
        Err(_) => (*group.status).code = Status::SCAN,
    }
}

/// Predicts the moving features of one page. Safety: the pages are lent, and each page and each count belongs to one place.
pub(super) unsafe fn drift<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(Between { scanning, moving_pages, .. }) = group.between() else { return };
    if place < M::ALL_PAGES {
        (*group.held.add(place)).store(0, Ordering::Relaxed);
    }
    if let Some(page) = moving_pages.one(place) {
        scanning.drift_page(place, page);
    }
}

/// Draws the candidates of an informed proposal, and lends their ln L. Safety: no other thread runs; the pages that `open` has lent
/// are given back.
pub(super) unsafe fn propose<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some(between) = group.alone() else { return };
    give_pages_back(between);
    let Between { scanning, eta, lent, .. } = between;
    scanning.propose(eta);
    lent.ln_likelihoods = Many::lent(scanning.lend_ln_likelihoods());
    (*group.room).in_view.store(0, Ordering::Relaxed);
}

/// Weighs one candidate. Safety: the ln L are lent, and each of them and of the sights belongs to one place.
pub(super) unsafe fn weigh<M: Particles>(place: usize, group: &Group<'_, M>) {
    if let Some(Between { scanning, lent, .. }) = group.between()
        && place < scanning.candidates()
        && let Some(ln_likelihood) = lent.ln_likelihoods.one(place)
    {
        let in_view = scanning.weigh(place, ln_likelihood, &mut *group.sights.add(place));
        (*group.room).in_view.fetch_max(u32::try_from(in_view).unwrap_or(u32::MAX), Ordering::Relaxed);
    }
}
