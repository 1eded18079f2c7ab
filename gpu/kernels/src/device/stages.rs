//! A scan as a sequence of launches, for any number of filters at once: the function of each thread in each launch.
//!
//! The stages are those of [`scphd::storage::Scanning`]. Weighing a candidate or updating the maps of a survivor is the work of
//! one thread. Steps that must be sequential are one thread for each filter, so that the state stays on the device.
//!
//! The functions of stages have the safety requirements of `run` in `kernel.rs`.

use super::group::{Group, whole};
use super::room::{Between, Kind, Lending, Listed, Many, Predicted, Predicting, give_pages_back};
use crate::buffer::{Prediction, Status};
use crate::launches::COLUMNS;
use crate::memory::Particles;
use crate::setup::{Filter, control_of, numbers_of, over};
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};
use scphd::PoseEstimate;
use scphd::settings::Proposal;
use scphd::storage::{COUNTS, Family, Samples};

/// Starts the filter. Safety: no other thread runs. A room starts as zeros, which are a valid
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
}

/// Makes the draft over a desk. Safety: each belongs to one place.
pub(super) unsafe fn furnish<M: Particles>(place: usize, group: &Group<'_, M>) {
    let [draft] = (*group.desks.add(place)).drafts();
    *group.drafts.add(place) = MaybeUninit::new(draft);
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
        Ok(Some(Samples { candidates, in_use, selected, pose_covariances, splits, mut noise })) => {
            let numbers = if is_informed(filter) { 0 } else { numbers_of(filter.motion()) };
            let first = noise.clone();
            noise.skip(in_use * numbers);
            let (candidates, particles) = (Many::lent(candidates), Many::lent(selected));
            predicting.lent = Some(Predicted {
                candidates,
                particles,
                covariances: Many::lent(pose_covariances),
                noise: [first, noise],
            });
            predicting.in_use = in_use;
            predicting.splits = splits;
        }
        Ok(None) => {}
        Err(_) => (*group.status).code = Status::PREDICTION,
    }
}

/// Whether the proposal is informed: then particles have covariances.
pub(super) fn is_informed(filter: &Filter<'_>) -> bool {
    matches!(filter.config().proposal, Proposal::Informed(_))
}

/// Moves one candidate (5.12), or one particle of an informed proposal. Safety: they are lent, and each belongs to one place.
pub(super) unsafe fn sample<M: Particles>(place: usize, group: &Group<'_, M>) {
    if !group.goes_on() {
        return;
    }
    let Predicting { taken, lent: Some(lent), in_use, splits, .. } = &(*group.room).prediction else { return };
    if place < *in_use
        && let Some(candidate) = lent.candidates.one(place)
        && let Some(Prediction { control, dt_s }) = group.predictions().get(whole(taken.wrapping_sub(1)))
    {
        let filter = (*group.room).filter.assume_init_ref();
        let control = control_of(filter.motion(), *control);
        if is_informed(filter) {
            if let Some(covariance) = lent.covariances.one(place) {
                filter.grow(candidate, covariance, &control, *dt_s);
            }
            return;
        }
        let [mut noise, _] = lent.noise.clone();
        noise.skip(place * numbers_of(filter.motion()));
        if *splits && let Some(parent) = lent.particles.one(place / whole((*group.run).samples).max(1)) {
            *candidate = filter.child_of(parent);
        }
        filter.sample(candidate, &control, *dt_s, &mut noise);
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
    if let Some(Predicted { candidates, particles, covariances, noise: [_, noise] }) = predicting.lent.take() {
        let (candidates, selected, pose_covariances) = (candidates.back(), particles.back(), covariances.back());
        filter.end_predict(Samples { candidates, in_use, selected, pose_covariances, splits, noise });
    }
    Some((filter, predicting))
}

/// Estimates the predicted pose. Safety: no other thread runs; there is a result for every scan.
pub(super) unsafe fn forecast<M: Particles>(_place: usize, group: &Group<'_, M>) {
    if let Some((filter, _)) = with_candidates(group)
        && let Some(PoseEstimate { mean, .. }) = filter.estimate_pose()
    {
        (*group.results.add(whole(group.scan))).predicted = [mean.x_m, mean.y_m, mean.heading_rad];
    }
}

/// Sorts the measurements of a scan, and lends pages, candidates and particles. Safety: no other thread runs; `start` has initialised filter and
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
                numbers: 0,
                noise: None,
                short: AtomicU32::new(0),
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
            between.numbers = between.scanning.begin_proposal();
            between.lent = Lending::of(between.scanning.lend_particles());
        }
        Err(_) => (*group.status).code = Status::SCAN,
    }
}

/// Predicts the moving features of one page, and copies one particle. Safety: pages and particles are lent, and each page, count and
/// particle belongs to one place.
pub(super) unsafe fn drift<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(Between { scanning, moving_pages, lent, numbers, .. }) = group.between() else { return };
    if place < M::ALL_PAGES {
        (*group.held.add(place)).store(0, Ordering::Relaxed);
    }
    if let Some(page) = moving_pages.one(place) {
        scanning.drift_page(place, page);
    }
    if *numbers > 0
        && place < scanning.particles()[0]
        && let Some(copy) = lent.selected.one(place)
        && let Some(particle) = lent.candidates.one(place)
    {
        *copy = *particle;
    }
}

/// Moves the random stream behind the proposal's numbers. Safety: no other thread runs; the pages that `open` has lent
/// are given back.
pub(super) unsafe fn line_up<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some(between) = group.alone() else { return };
    give_pages_back(between);
    let Between { scanning, numbers, noise, .. } = between;
    let [particles, _] = scanning.particles();
    *noise = Some(scanning.noise().clone());
    scanning.noise().skip(particles * *numbers);
    (*group.room).in_view.store(0, Ordering::Relaxed);
}

/// Draws the candidates of one particle, for an informed proposal. Safety: candidates and particles are lent, and each particle with
/// its candidates, draft and sight belongs to one place.
pub(super) unsafe fn propose<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(Between { scanning, lent, numbers, noise: Some(noise), short, .. }) = group.between() else { return };
    let [particles, children] = scanning.particles();
    if place < particles
        && let Some(parent) = lent.selected.all().get(place)
        && let Some(pose_covariance) = lent.pose_covariances.one(place)
    {
        let candidates = place * children..(place + 1) * children;
        let ln_corrections = lent.ln_likelihoods.some(candidates.clone());
        ln_corrections.fill(0.0);
        if *numbers == 0 {
            return;
        }
        let candidates = lent.candidates.some(candidates);
        let family = Family { particle: place, candidates, ln_corrections, pose_covariance };
        let mut noise = noise.clone();
        noise.skip(place * *numbers);
        let (draft, eta) = (group.draft(place), &mut *group.sights.add(place));
        short.fetch_add(scanning.propose_one(parent, family, draft, eta, &mut noise).into(), Ordering::Relaxed);
    }
}

/// Weighs one candidate. Safety: the ln L are lent, and each of them and of the sights belongs to one place.
pub(super) unsafe fn weigh<M: Particles>(place: usize, group: &Group<'_, M>) {
    if let Some(Between { scanning, lent, .. }) = group.between()
        && place < scanning.candidates()
        && let Some(candidate) = lent.candidates.all().get(place)
        && let Some(ln_likelihood) = lent.ln_likelihoods.one(place)
    {
        let in_view = scanning.weigh(place, candidate, ln_likelihood, &mut *group.sights.add(place));
        (*group.room).in_view.fetch_max(u32::try_from(in_view).unwrap_or(u32::MAX), Ordering::Relaxed);
    }
}
