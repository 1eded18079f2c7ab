//! A scan as a sequence of launches, for any number of filters at once: what each thread does in each of them.
//!
//! The stages are those of [`scphd::storage::Scanning`]. What weighs a candidate, or updates the map of a survivor, is a thread; what goes on from
//! one to the next is one thread for a filter, so that everything stays where it is. A launch is of one stage, whatever the number of filters,
//! so that all threads of a device execute the same code.

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

/// How many threads a launch is of, for each filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Places {
    /// One.
    One,
    /// One for every page.
    Pages,
    /// One for every few hundred pages.
    PageParts,
    /// One for every candidate.
    Candidates,
    /// One for every particle.
    Particles,
    /// One for every few dozens of candidates.
    CandidateParts,
    /// The same of particles.
    ParticleParts,
    /// So many for every particle as write pages together.
    Lanes,
    /// One for every column of numbers that are summed.
    Columns,
}

impl Places {
    /// How many that is for a filter of a size with so many particles and samples.
    #[must_use]
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

/// Hands the launches to another macro, in their order: each with its name, its threads for a filter, and what one of them does.
macro_rules! launches {
    ($then:ident! { $($with:tt)* }) => {
        $then! {
            $($with)*
            /// The launches that start the filters.
            STARTING {
                /// Starts the filters.
                START = "start", One, start;
                /// Makes a draft over every desk.
                DESKS = "desks", Particles, desks;
            }
            /// The launches of every prediction before a scan.
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
                /// Moves the moving features (5.14), and counts no page as held.
                DRIFT = "drift", Pages, drift;
                /// Draws candidates of an informed proposal.
                PROPOSE = "propose", One, propose;
                /// Weighs the candidates (4.52).
                WEIGH = "weigh", Candidates, weigh;
                /// Sums ζ L over parts of the candidates.
                PRODUCTS = "products", CandidateParts, select::products;
                /// Sums these.
                EVIDENCE = "evidence", One, select::evidence;
                /// Multiplies the weights by the likelihoods (5.23).
                MULTIPLY = "multiply", CandidateParts, select::multiply;
                /// Finds what they are still to be divided by.
                REST = "rest", One, select::rest;
                /// Divides them by that, and cumulates them in parts.
                CUMULATE = "cumulate", CandidateParts, select::cumulate;
                /// Decides whether all particles are drawn anew.
                DECIDE = "decide", One, select::decide;
                /// Draws the survivors (5.2.2).
                DRAW = "draw", Particles, select::draw;
                /// Counts those that differ, and finds the heaviest, in parts.
                RUNS = "runs", ParticleParts, select::runs;
                /// Begins the update of the survivors' maps.
                SETTLE = "settle", One, select::settle;
                /// Gives every survivor that differs a draft.
                ASSIGN = "assign", ParticleParts, select::assign;
                /// Updates their maps (5.17–5.22), each in its draft.
                MAKE = "make", Particles, store::make;
                /// Sums the labels and pages that drafts take, in parts.
                CLAIM = "claim", ParticleParts, store::claim;
                /// Counts the pages that no map holds any more, in parts.
                UNHELD = "unheld", PageParts, store::unheld;
                /// Adds up these sums.
                ADD_UP = "add_up", One, store::add_up;
                /// Finds the places of every draft's labels and pages, and whether there are enough pages.
                JUDGE = "judge", ParticleParts, store::judge;
                /// Lends the lists of pages; where there are not enough, stores the drafts one after the other.
                COMMIT = "commit", One, store::commit;
                /// Lists the free pages.
                LIST = "list", PageParts, store::list;
                /// Takes pages and labels for the drafts.
                TAKE = "take", Particles, store::take;
                /// Writes the pages.
                FILL = "fill", Lanes, store::fill;
                /// Gives every particle the list of its pages, and its candidate the particle's place.
                SHARE = "share", Particles, store::share;
                /// Sums over drafts and particles.
                SUM = "sum", Columns, tell::sum;
                /// The terms of the mean pose.
                CENTRE = "centre", Particles, tell::centre;
                /// Sums them.
                SUM_CENTRE = "sum_centre", Columns, tell::sum_centre;
                /// The terms of its covariance.
                SPREAD = "spread", Particles, tell::spread;
                /// Sums them.
                SUM_SPREAD = "sum_spread", Columns, tell::sum_spread;
                /// Estimates and report.
                CLOSE = "close", One, tell::close;
            }
            /// The launch of a digest, after a scan for which it is asked.
            DIGESTING {
                /// The digest of the state after a scan, where it is asked for.
                DIGEST = "digest", One, tell::digest;
            }
        }
    };
}
#[cfg(target_arch = "nvptx64")]
pub(crate) use launches;

/// A constant for every launch, and lists of them.
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

/// What a thread does in a launch: its place among those of its filter, the filter's buffers, the scan, and after how many scans a digest is
/// asked for.
pub(crate) type Body<M> = unsafe fn(usize, &Group<M>, u32, u32);

/// A launch.
#[derive(Debug, Clone, Copy)]
pub struct Stage<M: Size> {
    /// Its name; that of its kernel begins with [`Size::NAME`].
    pub name: &'static str,
    /// Its threads.
    pub places: Places,
    body: Body<M>,
}

impl<M: Size> Stage<M> {
    launches!(constants! {});

    /// What the thread of that place does. Places beyond the last have nothing to do; a run that has stopped stays as it is.
    ///
    /// # Safety
    /// Every pointer of the buffers is aligned and leads to as many values as the filters, runs, particles and samples say, which live and stay
    /// where they are until the last launch has ended; rooms and desks begin as zeros. The launches come in the order of
    /// [`STARTING`](Self::STARTING), and for every scan of [`PREDICTING`](Self::PREDICTING), as many times as there are predictions before it
    /// in any run, [`SCANNING`](Self::SCANNING) and, where it is asked for, [`DIGEST`](Self::DIGEST), each with a thread for every place, once, and ends before the next begins.
    #[inline(always)]
    pub unsafe fn run(&self, place: usize, filters: &Filters<M>, scan: u32, digest_every: u32) {
        let each = self.places.count::<M>(filters.particles as usize, filters.samples as usize);
        // Both fit into 32 bits, in which a device divides much faster.
        let (filter, place) = ((place as u32).checked_div(each as u32), (place as u32).checked_rem(each as u32));
        if let (Some(filter), Some(place)) = (filter, place)
            && u64::from(filter) < filters.count
        {
            // SAFETY: there is such a filter; the rest is the caller's word.
            unsafe { (self.body)(place as usize, &filters.group(filter as usize), scan, digest_every) }
        }
    }
}

impl<M: Size> Filters<M> {
    /// What belongs to the filter of that number.
    ///
    /// # Safety
    /// There is such a filter, and every pointer leads to as many values as there are filters, particles and samples, and as the runs say.
    unsafe fn group(&self, filter: usize) -> Group<M> {
        let particles = self.particles as usize;
        let samples = self.samples as usize;
        let candidates = particles * samples;
        // SAFETY: the caller's word.
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
    // SAFETY: where the run says that its inputs lie they do, and nobody writes them.
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
    // SAFETY: no other thread runs; a room begins as zeros, which are a value of it, and stays where it is, so that what points into it
    // may be kept beside it.
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

/// Makes a draft over the desk of this place.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn desks<M: Size>(place: usize, group: &Group<M>, _scan: u32, _digest_every: u32) {
    // SAFETY: there are as many desks and drafts as particles, and those of a place are its thread's own; the desks stay where they are.
    unsafe {
        if place < whole((*group.run).setup.particles) {
            let [draft] = (*group.desks.add(place)).memory.drafts();
            *group.drafts.add(place) = DraftPlace { draft: MaybeUninit::new(draft) };
        }
    }
}

/// Begins the next of the predictions before a scan, lends the candidates, and finds where in the random stream their numbers are.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn predict<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; `start` has made filter and detector.
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
    // SAFETY: the candidates are lent, and each is that of one place.
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

/// The candidates come back, if they were lent.
unsafe fn give_candidates_back(filter: &mut Filter<'static>, predicting: &mut Predicting) {
    let Predicting { candidates: (candidates, len), particles, in_use, splits, after, .. } = predicting;
    if *len > 0 {
        // SAFETY: these are the slices that were lent, and nobody else has them any more; what is behind the last one was set as they were lent.
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
    // SAFETY: no other thread runs; `start` has made filter and detector.
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

/// Moves what moves on one page.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn drift<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: the pages are lent, and each is that of one place, as is each count.
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

/// Draws candidates of an informed proposal, and lends their ln L.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn propose<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs, and the pages come back that `open` has lent.
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
    // SAFETY: the ln L are lent, and each of them and of the sights is that of one place.
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
