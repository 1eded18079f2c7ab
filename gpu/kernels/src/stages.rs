//! A scan as a sequence of launches, for any number of filters at once: the function of each thread in each launch.
//!
//! The stages are those of [`scphd::storage::Scanning`]. Weighing a candidate or updating the maps of a survivor is the work of
//! one thread. Steps that must be sequential are one thread for each filter, so that the state stays on the device. All threads
//! of a launch run the same stage, for all filters, so that all threads of a device execute the same code.

use crate::buffer::{Prediction, Run, Status};
use crate::group::{alone, between, give_pages_back, goes_on, whole};
use crate::motion::Vehicle;
use crate::room::{
    Between, COLUMNS, DraftPlace, Filters, Group, Lending, Listed, Many, Predicting, StreamPlace, TOGETHER, WHOLES,
    page_parts, parts, streams, words,
};
use crate::run::{Filter, Inputs, before, over};
use crate::size::Size;
use crate::{select, store, tell};
use core::mem::MaybeUninit;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::{AtomicU32, Ordering};
use scphd::storage::{COUNTS, Samples};

/// Number of threads of a launch for each filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Places {
    /// One.
    One,
    /// One for each page.
    Pages,
    /// One for each few hundred pages.
    PageParts,
    /// One for each candidate.
    Candidates,
    /// One for each particle.
    Particles,
    /// One for each few dozen candidates.
    CandidateParts,
    /// One for each few dozen particles.
    ParticleParts,
    /// Several for each particle, which write its pages together.
    Lanes,
    /// One for each column of numbers that are summed.
    Columns,
}

impl Places {
    /// The number of threads for a filter of this size with `particles` particles and `samples` samples of each.
    pub const fn count<M: Size>(self, particles: usize, samples: usize) -> usize {
        match self {
            Self::One => 1,
            Self::Pages => M::PAGES + M::MOVING_PAGES,
            Self::PageParts => {
                let [of_static, of_moving] = page_parts::<M>();
                of_static + of_moving
            }
            Self::Candidates => particles * samples,
            Self::Particles => particles,
            Self::Lanes => particles * store::LANES,
            Self::CandidateParts => parts(particles * samples),
            Self::ParticleParts => parts(particles),
            Self::Columns => COLUMNS,
        }
    }
}

/// Passes the launches to another macro, in their order: each with its name, its threads for each filter, and its function.
macro_rules! launches {
    ($then:ident! { $($with:tt)* }) => {
        $then! {
            $($with)*
            /// The launches that start the filters.
            STARTING {
                /// Starts the filters.
                START = "start", One, start;
                /// Makes a draft over each desk.
                DESKS = "desks", Particles, desks;
            }
            /// The launches of each prediction before a scan.
            PREDICTING {
                /// Begins the next prediction before a scan.
                PREDICT = "predict", One, predict;
                /// Moves the candidates (5.12).
                SAMPLE = "sample", Candidates, sample;
            }
            /// The launches of a scan, in order.
            SCANNING {
                /// Sorts the measurements.
                OPEN = "open", One, open;
                /// Predicts the moving features (5.14), and resets the numbers of maps that hold a page.
                DRIFT = "drift", Pages, drift;
                /// Draws the candidates of an informed proposal.
                PROPOSE = "propose", One, propose;
                /// Weighs the candidates (4.52).
                WEIGH = "weigh", Candidates, weigh;
                /// Sums ζ L over parts of the candidates.
                PRODUCTS = "products", CandidateParts, select::products;
                /// Adds these sums up.
                EVIDENCE = "evidence", One, select::evidence;
                /// Multiplies the weights by the likelihoods (5.23).
                MULTIPLY = "multiply", CandidateParts, select::multiply;
                /// Computes the divisor that the weights still need.
                REST = "rest", One, select::rest;
                /// Divides the weights by it, and computes their cumulative sums in parts.
                CUMULATE = "cumulate", CandidateParts, select::cumulate;
                /// Decides whether to resample.
                DECIDE = "decide", One, select::decide;
                /// Draws the survivors (5.2.2).
                DRAW = "draw", Particles, select::draw;
                /// Counts the different survivors, and finds the heaviest, in parts.
                RUNS = "runs", ParticleParts, select::runs;
                /// Begins the update of the survivors' maps.
                SETTLE = "settle", One, select::settle;
                /// Assigns a draft to each different survivor.
                ASSIGN = "assign", ParticleParts, select::assign;
                /// Updates the survivors' maps (5.17–5.22), each in its draft.
                MAKE = "make", Particles, store::make;
                /// Sums the labels and pages that the drafts allocate, in parts.
                CLAIM = "claim", ParticleParts, store::claim;
                /// Counts the pages that no map holds any more, in parts.
                UNHELD = "unheld", PageParts, store::unheld;
                /// Adds these sums up.
                ADD_UP = "add_up", One, store::add_up;
                /// Finds the positions of each draft's labels and pages, and whether there are enough pages.
                JUDGE = "judge", ParticleParts, store::judge;
                /// Lends the lists of pages; if there are too few pages, stores the drafts one after the other.
                COMMIT = "commit", One, store::commit;
                /// Lists the free pages.
                LIST = "list", PageParts, store::list;
                /// Allocates pages and labels for the drafts.
                TAKE = "take", Particles, store::take;
                /// Writes the pages.
                FILL = "fill", Lanes, store::fill;
                /// Gives every particle the list of its pages, and moves its candidate to the particle's place.
                SHARE = "share", Particles, store::share;
                /// Sums over drafts and particles.
                SUM = "sum", Columns, tell::sum;
                /// Computes the terms of the mean pose.
                CENTRE = "centre", Particles, tell::centre;
                /// Adds them up.
                SUM_CENTRE = "sum_centre", Columns, tell::sum_centre;
                /// Computes the terms of the covariance of the pose.
                SPREAD = "spread", Particles, tell::spread;
                /// Adds them up.
                SUM_SPREAD = "sum_spread", Columns, tell::sum_spread;
                /// Writes estimates and report.
                CLOSE = "close", One, tell::close;
            }
            /// The launch of a digest, after a scan for which it is requested.
            DIGESTING {
                /// Computes the digest of the state after a scan, if it is requested.
                DIGEST = "digest", One, tell::digest;
            }
        }
    };
}
#[cfg(target_arch = "nvptx64")]
pub(crate) use launches;

/// Defines a constant for each launch, and lists of them.
macro_rules! constants {
    ($($(#[$about:meta])* $list:ident {
        $($(#[$does:meta])* $stage:ident = $name:literal, $places:ident, $body:path;)+
    })+) => { $(
        $(
            $(#[$does])*
            pub const $stage: Self = Self { name: $name, places: Places::$places, body: $body };
        )+

        $(#[$about])*
        pub const $list: &[Self] = &[$(Self::$stage),+];
    )+ };
}

/// The function of a thread in a launch. Arguments: its place among the threads of its filter, the data of the filter, the scan,
/// and the number of scans between two digests.
pub(crate) type Body<M> = unsafe fn(usize, &Group<M>, u32, u32);

/// A launch.
#[derive(Debug, Clone, Copy)]
pub struct Stage<M: Size> {
    /// Its name. The name of its kernel has the prefix [`Size::NAME`].
    pub name: &'static str,
    /// The number of its threads.
    pub places: Places,
    body: Body<M>,
}

impl<M: Size> Stage<M> {
    launches!(constants! {});

    /// Runs the function of one thread. Places beyond the last do nothing; a run that has stopped does not change.
    ///
    /// # Safety
    /// Every pointer of the buffers is aligned and leads to as many values as the numbers of filters, runs, particles and samples
    /// require. The values live and do not move until the last launch has ended; rooms and desks start as zeros. The launches
    /// come in the order of [`STARTING`](Self::STARTING), and then for every scan [`PREDICTING`](Self::PREDICTING), once for each
    /// prediction before it in the run that has most, [`SCANNING`](Self::SCANNING) and, if requested, [`DIGEST`](Self::DIGEST).
    /// Each launch has one thread for each place, and ends before the next begins.
    #[inline(always)]
    pub unsafe fn run(&self, place: usize, filters: &Filters<M>, scan: u32, digest_every: u32) {
        let each = self.places.count::<M>(filters.particles as usize, filters.samples as usize);
        // Both fit into 32 bits, for which a device divides much faster.
        let (filter, place) = ((place as u32).checked_div(each as u32), (place as u32).checked_rem(each as u32));
        if let (Some(filter), Some(place)) = (filter, place)
            && u64::from(filter) < filters.count
        {
            // SAFETY: the index is below the number of filters; the caller guarantees the rest.
            unsafe { (self.body)(place as usize, &filters.group(filter as usize), scan, digest_every) }
        }
    }
}

impl<M: Size> Filters<M> {
    /// The data of one filter.
    ///
    /// # Safety
    /// There is such a filter, and every pointer leads to as many values as the numbers of filters, particles and samples and the
    /// runs require.
    unsafe fn group(&self, filter: usize) -> Group<M> {
        let particles = self.particles as usize;
        let samples = self.samples as usize;
        let candidates = particles * samples;
        // SAFETY: the caller guarantees it.
        unsafe {
            let cumulated = self.words.add(filter * words::<M>(particles, samples));
            let columns = cumulated.add(candidates);
            let wholes = columns.add(COLUMNS * particles);
            let held = wholes.add(WHOLES * particles);
            let run = self.runs.add(filter);
            let at = |first: fn(&Run) -> u32| first(&*run) as usize;
            Group {
                run,
                scans: self.scans.add(at(|run| run.first_scan)),
                predictions: self.predictions.add(at(|run| run.first_prediction)),
                measurements: self.measurements.add(at(|run| run.first_measurement)),
                room: self.rooms.add(filter),
                sights: self.sights.add(filter * candidates),
                desks: self.desks.add(filter * particles),
                drafts: self.drafts.add(filter * particles),
                streams: self.streams.add(filter * streams(candidates)),
                parts: self.parts.add(filter * parts(candidates)),
                cumulated: cumulated.cast(),
                stride: particles,
                columns: columns.cast(),
                wholes,
                held: held.cast(),
                firsts: held.add(M::PAGES + M::MOVING_PAGES),
                status: self.statuses.add(filter),
                results: self.results.add(at(|run| run.first_scan)),
                features: self.features.add(at(|run| run.first_feature)),
                movers: self.movers.add(at(|run| run.first_mover)),
            }
        }
    }
}

unsafe fn inputs<'r, M: Size>(group: &Group<M>) -> Inputs<'r> {
    // SAFETY: the inputs are where the run says, and are never written.
    unsafe {
        let run = &*group.run;
        Inputs {
            run,
            scans: from_raw_parts(group.scans, whole(run.scans)),
            predictions: from_raw_parts(group.predictions, whole(run.predictions)),
            measurements: from_raw_parts(group.measurements, whole(run.measurements)),
        }
    }
}

/// Starts the filter.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn start<M: Size>(place: usize, group: &Group<M>, _scan: u32, _digest_every: u32) {
    if place > 0 {
        return;
    }
    // SAFETY: no other thread runs. A room starts as zeros, which are a valid value, and does not move, so that it can hold
    // pointers to its own parts.
    unsafe {
        let room = group.room;
        let code = match over(inputs(group).run, &mut (*room).slot) {
            Ok((filter, detector, _)) => {
                (*room).filter = MaybeUninit::new(filter);
                (*room).detector = MaybeUninit::new(detector);
                Status::DONE
            }
            Err(code) => code,
        };
        *group.status = Status { code, scans: 0 };
    }
}

/// Makes a draft over the desk at this place.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn desks<M: Size>(place: usize, group: &Group<M>, _scan: u32, _digest_every: u32) {
    // SAFETY: there is a desk and a draft for each particle, and only this thread uses those at its place; the desks do not move.
    unsafe {
        if place < whole((*group.run).setup.particles) {
            let [draft] = (*group.desks.add(place)).memory.drafts();
            *group.drafts.add(place) = DraftPlace { draft: MaybeUninit::new(draft) };
        }
    }
}

/// Begins the next prediction before a scan, lends the candidates, and finds the positions of their numbers in the random stream.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn predict<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; `start` has initialised filter and detector.
    unsafe {
        if place > 0 || !goes_on(group, scan) {
            return;
        }
        let filter = (*group.room).filter.assume_init_mut();
        let predicting = &mut (*group.room).prediction;
        give_candidates_back(filter, predicting);
        let taken = whole(predicting.taken);
        let begun = before(inputs(group), whole(scan)).and_then(|(predictions, _)| {
            // Another run has more predictions before this scan.
            let Some(Prediction { control, dt_s }) = predictions.get(taken) else { return Ok(None) };
            predicting.taken += 1;
            filter.begin_predict(control, *dt_s).map_err(|_| Status::PREDICTION)
        });
        match begun {
            Ok(Some(Samples { candidates, in_use, selected, splits, mut noise })) => {
                for (place, first) in (0..in_use).step_by(TOGETHER).enumerate() {
                    *group.streams.add(place) = StreamPlace { stream: MaybeUninit::new(noise.clone()) };
                    noise.skip((in_use - first).min(TOGETHER) * Vehicle::NUMBERS);
                }
                predicting.after = MaybeUninit::new(noise);
                predicting.candidates = (candidates.as_mut_ptr(), candidates.len());
                predicting.particles = (selected.as_mut_ptr(), selected.len());
                predicting.in_use = in_use;
                predicting.splits = splits;
            }
            Ok(None) => {}
            Err(code) => (*group.status).code = code,
        }
    }
}

/// Moves one candidate (5.12).
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn sample<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: the candidates are lent, and each belongs to one place.
    unsafe {
        if !goes_on(group, scan) {
            return;
        }
        let Predicting { taken, candidates: (candidates, len), particles, in_use, splits, .. } =
            &(*group.room).prediction;
        if place < (*in_use).min(*len)
            && let Ok((predictions, _)) = before(inputs(group), whole(scan))
            && let Some(Prediction { control, dt_s }) = predictions.get(whole(taken.wrapping_sub(1)))
        {
            let mut noise = (*group.streams.add(place / TOGETHER)).stream.assume_init_ref().clone();
            noise.skip(place % TOGETHER * Vehicle::NUMBERS);
            let filter = (*group.room).filter.assume_init_ref();
            let candidate = &mut *candidates.add(place);
            let parent = place / whole((*group.run).setup.samples).max(1);
            if *splits && parent < particles.1 {
                *candidate = filter.child_of(&*particles.0.add(parent));
            }
            filter.sample(candidate, control, *dt_s, &mut noise);
        }
    }
}

/// Gives the candidates back, if they were lent.
unsafe fn give_candidates_back(filter: &mut Filter<'static>, predicting: &mut Predicting) {
    let Predicting { candidates: (candidates, len), particles, in_use, splits, after, .. } = predicting;
    if *len > 0 {
        // SAFETY: these are the slices that were lent, and nothing else refers to them; `after` was set when they were lent.
        let (candidates, selected, noise) = unsafe {
            let selected = from_raw_parts_mut(particles.0, particles.1);
            (from_raw_parts_mut(*candidates, *len), selected, after.assume_init_ref().clone())
        };
        filter.end_predict(Samples { candidates, in_use: *in_use, selected, splits: *splits, noise });
        (*len, *in_use) = (0, 0);
    }
}

/// Sorts the measurements of a scan, and lends the pages.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn open<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; `start` has initialised filter and detector.
    unsafe {
        if place > 0 || !goes_on(group, scan) {
            return;
        }
        let room = group.room;
        let filter = (*room).filter.assume_init_mut();
        let detector = (*room).detector.assume_init_mut();
        let predicting = &mut (*room).prediction;
        give_candidates_back(filter, predicting);
        predicting.taken = 0;
        let begun = before(inputs(group), whole(scan))
            .and_then(|(_, measurements)| filter.begin_scan(detector, measurements).map_err(|_| Status::SCAN));
        match begun {
            Ok((mut scanning, eta)) => {
                scanning.enter();
                let (pages, moving_pages) = scanning.lend_pages();
                (*room).between = MaybeUninit::new(Between {
                    scanning,
                    eta,
                    pages: Many::of(pages),
                    moving_pages: Many::of(moving_pages),
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
            }
            Err(code) => (*group.status).code = code,
        }
    }
}

/// Predicts the moving features of one page.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn drift<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: the pages are lent, and each page and each count belongs to one place.
    unsafe {
        let Some(Between { scanning, moving_pages, .. }) = between(group, scan) else { return };
        if place < M::PAGES + M::MOVING_PAGES {
            (*group.held.add(place)).store(0, Ordering::Relaxed);
        }
        if let Some(page) = moving_pages.one(place) {
            scanning.drift_page(place, page);
        }
    }
}

/// Draws the candidates of an informed proposal, and lends their ln L.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn propose<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; the pages that `open` has lent are given back.
    unsafe {
        let Some(between) = alone(place, group, scan) else { return };
        give_pages_back(between);
        let Between { scanning, eta, lent, .. } = between;
        scanning.propose(eta);
        lent.ln_likelihoods = Many::of(scanning.lend_ln_likelihoods());
        (*group.room).in_view.store(0, Ordering::Relaxed);
    }
}

/// Weighs one candidate.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn weigh<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: the ln L are lent, and each of them and of the sights belongs to one place.
    unsafe {
        if let Some(Between { scanning, lent, .. }) = between(group, scan)
            && place < scanning.candidates()
            && let Some(ln_likelihood) = lent.ln_likelihoods.one(place)
        {
            let in_view = scanning.weigh(place, ln_likelihood, &mut (*group.sights.add(place)).eta);
            (*group.room).in_view.fetch_max(u32::try_from(in_view).unwrap_or(u32::MAX), Ordering::Relaxed);
        }
    }
}
