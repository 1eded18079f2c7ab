//! One large filter, a scan as a sequence of launches: what each thread does in each of them.
//!
//! The stages are those of [`scphd::storage::Scanning`]. What weighs a candidate, or updates the map of a survivor, is a thread; what goes on from
//! one to the next is one thread for all, so that everything stays where it is.

use crate::buffer::{Feature, Mover, Prediction, Status};
use crate::motion::Vehicle;
use crate::room::{Between, DraftOf, DraftPlace, LARGE_PAGES, Large, Predicting, TOGETHER};
use crate::run::{Filter, Inputs, Outputs, Span, before, over, tell};
use crate::thread::whole;
use core::mem::MaybeUninit;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::Ordering;
use scphd::storage::Samples;

/// How many threads a launch is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Places {
    /// One.
    One,
    /// One for every page of moving features.
    MovingPages,
    /// One for every candidate.
    Candidates,
    /// One for every particle.
    Particles,
}

impl Places {
    /// How many that is.
    #[must_use]
    pub const fn count(self, particles: usize, samples: usize) -> usize {
        match self {
            Self::One => 1,
            Self::MovingPages => LARGE_PAGES,
            Self::Candidates => particles * samples,
            Self::Particles => particles,
        }
    }
}

/// What a thread does in a launch: its place, the buffers, the scan, and after how many scans a digest is asked for.
///
/// # Safety
/// The buffers must be what the launches before have left, and no two threads of a launch may have the same place.
pub type Body = unsafe fn(usize, &Large, u32, u32);

/// A launch: the name of its kernel, its threads and what each of them does.
pub type Stage = (&'static str, Places, Body);

/// The launches that start a filter.
pub const START: [Stage; 2] =
    [("scphd_large_start", Places::One, start), ("scphd_large_desks", Places::Particles, desks)];

/// The launches of every prediction before a scan.
pub const PREDICT: [Stage; 2] =
    [("scphd_large_predict", Places::One, predict), ("scphd_large_sample", Places::Candidates, sample)];

/// The launches of a scan, in order.
pub const STAGES: [Stage; 9] = [
    ("scphd_large_open", Places::One, open),
    ("scphd_large_drift", Places::MovingPages, drift),
    ("scphd_large_propose", Places::One, propose),
    ("scphd_large_weigh", Places::Candidates, weigh),
    ("scphd_large_select", Places::One, select),
    ("scphd_large_make", Places::Particles, make),
    ("scphd_large_store", Places::One, store),
    ("scphd_large_fill", Places::Particles, fill),
    ("scphd_large_close", Places::One, close),
];

/// What is between the launches of a scan; nothing where the run has stopped.
unsafe fn between<'r>(large: &Large) -> Option<&'r Between> {
    // SAFETY: `open` has put it there where it did not stop the run.
    unsafe { goes_on(large).then(|| (*large.room).between.assume_init_ref()) }
}

/// The same for the one thread of its launch.
unsafe fn alone<'r>(place: usize, large: &Large) -> Option<&'r mut Between> {
    // SAFETY: as of `between`, and no other thread looks at it.
    unsafe { (place == 0 && goes_on(large)).then(|| (*large.room).between.assume_init_mut()) }
}

unsafe fn goes_on(large: &Large) -> bool {
    // SAFETY: there is a status, which only a launch of one thread writes.
    unsafe { (*large.status).code == Status::DONE }
}

unsafe fn inputs<'r>(large: &Large) -> Inputs<'r> {
    // SAFETY: where the run says that its inputs lie they do, and nobody writes them.
    unsafe {
        let run = &*large.run;
        Inputs {
            run,
            scans: from_raw_parts(large.scans, whole(run.scans)),
            predictions: from_raw_parts(large.predictions, whole(run.predictions)),
            measurements: from_raw_parts(large.measurements, whole(run.measurements)),
        }
    }
}

/// Starts the filter.
///
/// # Safety
/// As of [`open`]; room and desks are zeros.
pub unsafe fn start(place: usize, large: &Large, _scan: u32, _digest_every: u32) {
    if place > 0 {
        return;
    }
    // SAFETY: no other thread runs; a room begins as zeros, which are a value of it, and stays where it is, so that what points into it
    // may be kept beside it.
    unsafe {
        let room = large.room;
        let code = match over(inputs(large).run, &mut (*room).slot, false) {
            Ok((filter, detector, _)) => {
                (*room).filter = MaybeUninit::new(filter);
                (*room).detector = MaybeUninit::new(detector);
                Status::DONE
            }
            Err(code) => code,
        };
        *large.status = Status { code, scans: 0 };
    }
}

/// Makes a draft over the desk of this place.
///
/// # Safety
/// As of [`open`]; the desks are zeros.
pub unsafe fn desks(place: usize, large: &Large, _scan: u32, _digest_every: u32) {
    // SAFETY: there are as many desks and drafts as particles, and those of a place are its thread's own; the desks stay where they are.
    unsafe {
        if place < whole((*large.run).setup.particles) {
            let [draft] = (*large.desks.add(place)).memory.drafts();
            *large.drafts.add(place) = DraftPlace { draft: MaybeUninit::new(draft) };
        }
    }
}

/// Begins the next of the predictions before a scan, lends the candidates, and finds where in the random stream their numbers are.
///
/// # Safety
/// As of [`open`].
pub unsafe fn predict(place: usize, large: &Large, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; `start` has made filter and detector.
    unsafe {
        if place > 0 || !goes_on(large) {
            return;
        }
        let filter = (*large.room).filter.assume_init_mut();
        let predicting = &mut (*large.room).prediction;
        give_candidates_back(filter, predicting);
        let taken = whole(predicting.taken);
        predicting.taken += 1;
        let begun = before(inputs(large), whole(scan))
            .and_then(|(predictions, _)| predictions.get(taken).ok_or(Status::BUFFERS))
            .and_then(|Prediction { control, dt_s }| {
                filter.begin_predict(control, *dt_s).map_err(|_| Status::PREDICTION)
            });
        match begun {
            Ok(Some(Samples { candidates, in_use, mut noise })) => {
                for (first, stream) in (0..in_use).step_by(TOGETHER).zip(&mut predicting.streams) {
                    *stream = MaybeUninit::new(noise.clone());
                    noise.skip((in_use - first).min(TOGETHER) * Vehicle::NUMBERS);
                }
                predicting.after = MaybeUninit::new(noise);
                predicting.candidates = (candidates.as_mut_ptr(), candidates.len());
                predicting.in_use = in_use;
            }
            Ok(None) => {}
            Err(code) => (*large.status).code = code,
        }
    }
}

/// Moves one candidate (5.12).
///
/// # Safety
/// What every stage is handed, as `open` is.
pub unsafe fn sample(place: usize, large: &Large, scan: u32, _digest_every: u32) {
    // SAFETY: the candidates are lent, and each is that of one place.
    unsafe {
        if !goes_on(large) {
            return;
        }
        let Predicting { taken, candidates: (candidates, len), in_use, streams, .. } = &(*large.room).prediction;
        if place < (*in_use).min(*len)
            && let Ok((predictions, _)) = before(inputs(large), whole(scan))
            && let Some(Prediction { control, dt_s }) = predictions.get(whole(taken.wrapping_sub(1)))
            && let Some(stream) = streams.get(place / TOGETHER)
        {
            let mut noise = stream.assume_init_ref().clone();
            noise.skip(place % TOGETHER * Vehicle::NUMBERS);
            let filter = (*large.room).filter.assume_init_ref();
            filter.sample(&mut *candidates.add(place), control, *dt_s, &mut noise);
        }
    }
}

/// The candidates come back, if they were lent.
unsafe fn give_candidates_back(filter: &mut Filter<'static>, predicting: &mut Predicting) {
    let Predicting { candidates: (candidates, len), in_use, after, .. } = predicting;
    if *len > 0 {
        // SAFETY: this is the slice that was lent, and nobody else has it any more; what is behind the last one was set as it was lent.
        let (candidates, noise) = unsafe { (from_raw_parts_mut(*candidates, *len), after.assume_init_ref().clone()) };
        filter.end_predict(Samples { candidates, in_use: *in_use, noise });
        (*len, *in_use) = (0, 0);
    }
}

/// Sorts the measurements of a scan, and lends the pages.
///
/// # Safety
/// Every pointer of the buffers is aligned and leads to as many values as the run and its particles and samples say, which live and stay
/// where they are until the last launch has ended. The launches come in the order of [`START`], and for every scan of [`PREDICT`], as many
/// times as there are predictions before it, and [`STAGES`], each with a thread for every place, once, and ends before the next begins.
pub unsafe fn open(place: usize, large: &Large, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; `start` has made filter and detector.
    unsafe {
        if place > 0 || !goes_on(large) {
            return;
        }
        let room = large.room;
        let filter = (*room).filter.assume_init_mut();
        let detector = (*room).detector.assume_init_mut();
        let predicting = &mut (*room).prediction;
        give_candidates_back(filter, predicting);
        predicting.taken = 0;
        let begun = before(inputs(large), whole(scan))
            .and_then(|(_, measurements)| filter.begin_scan(detector, measurements).map_err(|_| Status::SCAN));
        match begun {
            Ok((mut scanning, eta)) => {
                scanning.enter();
                let (pages, moving_pages) = scanning.lend_pages();
                (*room).between = MaybeUninit::new(Between {
                    scanning,
                    eta,
                    ln_likelihoods: (core::ptr::null_mut(), 0),
                    pages: (pages.as_mut_ptr(), pages.len()),
                    moving_pages: (moving_pages.as_mut_ptr(), moving_pages.len()),
                    drafts: 0,
                });
            }
            Err(code) => (*large.status).code = code,
        }
    }
}

/// Moves what moves on one page.
///
/// # Safety
/// What every stage is handed, as `open` is.
pub unsafe fn drift(place: usize, large: &Large, _scan: u32, _digest_every: u32) {
    // SAFETY: the pages are lent, and each is that of one place.
    unsafe {
        if let Some(Between { scanning, moving_pages: (pages, len), .. }) = between(large)
            && place < *len
        {
            scanning.drift_page(place, &mut *pages.add(place));
        }
    }
}

/// Draws candidates of an informed proposal, and lends their ln L.
///
/// # Safety
/// What every stage is handed, as `open` is.
pub unsafe fn propose(place: usize, large: &Large, _scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs, and the pages come back that `open` has lent.
    unsafe {
        let Some(between) = alone(place, large) else { return };
        give_pages_back(between);
        let Between { scanning, eta, ln_likelihoods, .. } = between;
        scanning.propose(eta);
        let lent = scanning.lend_ln_likelihoods();
        *ln_likelihoods = (lent.as_mut_ptr(), lent.len());
        (*large.room).in_view.store(0, Ordering::Relaxed);
    }
}

/// Weighs one candidate.
///
/// # Safety
/// What every stage is handed, as `open` is.
pub unsafe fn weigh(place: usize, large: &Large, _scan: u32, _digest_every: u32) {
    // SAFETY: the ln L are lent, and each of them and of the sights is that of one place.
    unsafe {
        if let Some(Between { scanning, ln_likelihoods: (ln_likelihoods, len), .. }) = between(large)
            && place < scanning.candidates().min(*len)
        {
            let eta = &mut (*large.sights.add(place)).eta;
            let in_view = scanning.weigh(place, &mut *ln_likelihoods.add(place), eta);
            (*large.room).in_view.fetch_max(u32::try_from(in_view).unwrap_or(u32::MAX), Ordering::Relaxed);
        }
    }
}

/// Selects the candidates that go on, and gives every draft one of them.
///
/// # Safety
/// What every stage is handed, as `open` is.
pub unsafe fn select(place: usize, large: &Large, _scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; the ln L come back that `propose` has lent; there are as many drafts as particles.
    unsafe {
        let Some(Between { scanning, ln_likelihoods: (ln_likelihoods, len), drafts, .. }) = alone(place, large) else {
            return;
        };
        let in_view = (*large.room).in_view.load(Ordering::Relaxed);
        scanning.weighed(from_raw_parts_mut(*ln_likelihoods, *len), whole(in_view));
        scanning.select();
        scanning.begin_update();
        *drafts = scanning.assign(all_drafts(large, whole((*large.run).setup.particles)));
    }
}

/// Updates the maps of one survivor.
///
/// # Safety
/// What every stage is handed, as `open` is.
pub unsafe fn make(place: usize, large: &Large, _scan: u32, _digest_every: u32) {
    // SAFETY: maps are only read; each draft and each sight is that of one place.
    unsafe {
        if let Some(Between { scanning, drafts, .. }) = between(large)
            && place < *drafts
        {
            let draft = (*large.drafts.add(place)).draft.assume_init_mut();
            scanning.make(draft, &mut (*large.sights.add(place)).eta);
        }
    }
}

/// Gives the updated maps pages, in the order of the survivors, and lends them.
///
/// # Safety
/// What every stage is handed, as `open` is.
pub unsafe fn store(place: usize, large: &Large, _scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs.
    unsafe {
        let Some(Between { scanning, eta, pages, moving_pages, drafts, .. }) = alone(place, large) else { return };
        let first_fresh = scanning.next_label();
        for draft in all_drafts(large, *drafts) {
            scanning.store(draft, first_fresh, eta, &mut ());
        }
        scanning.end_update();
        let (lent, lent_moving) = scanning.lend_pages();
        *pages = (lent.as_mut_ptr(), lent.len());
        *moving_pages = (lent_moving.as_mut_ptr(), lent_moving.len());
    }
}

/// Writes the pages of one survivor's maps.
///
/// # Safety
/// What every stage is handed, as `open` is.
pub unsafe fn fill(place: usize, large: &Large, _scan: u32, _digest_every: u32) {
    // SAFETY: the pages are lent, and no two drafts have been given the same one; each draft is that of one place.
    unsafe {
        if let Some(&Between { drafts, pages: (pages, len), moving_pages: (moving_pages, moving_len), .. }) =
            between(large)
            && place < drafts
        {
            let draft = (*large.drafts.add(place)).draft.assume_init_mut();
            draft.fill(
                |id, page| {
                    if id.index() < len {
                        (*pages.add(id.index())).copy_from(page);
                    }
                },
                |id, page| {
                    if id.index() < moving_len {
                        (*moving_pages.add(id.index())).copy_from(page);
                    }
                },
            );
        }
    }
}

/// Ends the scan, and tells what is known then.
///
/// # Safety
/// What every stage is handed, as `open` is.
pub unsafe fn close(place: usize, large: &Large, scan: u32, digest_every: u32) {
    // SAFETY: no other thread runs; the pages come back that `store` has lent; what is between the launches of a scan ends with it, and
    // before the filter is looked at again. Where the run says that its outputs lie they do.
    unsafe {
        let Some(between) = alone(place, large) else { return };
        give_pages_back(between);
        let room = large.room;
        let Between { scanning, .. } = (*room).between.assume_init_read();
        let report = scanning.finish();
        let run = &*large.run;
        let mut outputs = Outputs {
            results: from_raw_parts_mut(large.results, whole(run.scans)),
            features: from_raw_parts_mut::<Feature>(large.features, whole(run.features)),
            movers: from_raw_parts_mut::<Mover>(large.movers, whole(run.movers)),
        };
        let taken = whole(scan) + 1;
        let span = Span { first: 0, scans: 0, digest_every: whole(digest_every) };
        let digest = span.asks_for_digest(taken, taken == whole(run.scans));
        let filter = (*room).filter.assume_init_ref();
        let detector = (*room).detector.assume_init_ref();
        let lists = (&mut (*room).slot.features, &mut (*room).slot.movers);
        let told = tell(filter, detector, &report, lists, &mut outputs, whole(scan), digest);
        *large.status = match told {
            Ok(()) => Status { code: Status::DONE, scans: scan + 1 },
            Err(code) => Status { code, scans: scan },
        };
    }
}

/// The pages come back that were lent.
unsafe fn give_pages_back(between: &mut Between) {
    let Between { scanning, pages: (pages, len), moving_pages: (moving_pages, moving_len), .. } = between;
    // SAFETY: these are the slices that were lent, and nobody else has them any more.
    unsafe {
        let pages = from_raw_parts_mut(*pages, *len);
        scanning.give_pages_back((pages, from_raw_parts_mut(*moving_pages, *moving_len)));
    }
}

/// So many drafts, for one thread.
unsafe fn all_drafts<'r>(large: &Large, count: usize) -> &'r mut [DraftOf] {
    // SAFETY: `desks` has made as many as there are particles, and a place is a draft and nothing else.
    unsafe { from_raw_parts_mut(large.drafts.cast(), count) }
}

// A place for a draft is no larger than a draft.
const _: () = assert!(size_of::<DraftPlace>() == size_of::<DraftOf>());
