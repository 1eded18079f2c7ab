//! A scan as a sequence of launches, for any number of filters at once: what each thread does in each of them.
//!
//! The stages are those of [`scphd::storage::Scanning`]. What weighs a candidate, or updates the map of a survivor, is a thread; what goes on from
//! one to the next is one thread for a filter, so that everything stays where it is. A launch is of one stage, whatever the number of filters,
//! so that all threads of a device execute the same code.

use crate::buffer::{Feature, Mover, Prediction, Run, Status};
use crate::motion::Vehicle;
use crate::room::{Between, DraftOf, DraftPlace, Filters, Group, Predicting, StreamPlace, TOGETHER, streams};
use crate::run::{Filter, Inputs, Outputs, asks_for_digest, before, over, tell};
use crate::size::Size;
use core::mem::MaybeUninit;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::Ordering;
use scphd::storage::Samples;

/// How many threads a launch is of, for each filter.
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
    pub const fn count(self, moving_pages: usize, particles: usize, samples: usize) -> usize {
        match self {
            Self::One => 1,
            Self::MovingPages => moving_pages,
            Self::Candidates => particles * samples,
            Self::Particles => particles,
        }
    }
}

/// What a thread does in a launch: its place among those of its filter, the filter's buffers, the scan, and after how many scans a digest is
/// asked for.
type Body<M> = unsafe fn(usize, &Group<M>, u32, u32);

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
    const fn new(name: &'static str, places: Places, body: Body<M>) -> Self {
        Self { name, places, body }
    }

    /// Makes a draft over every desk.
    pub const DESKS: Self = Self::new("desks", Places::Particles, desks);
    /// Starts the filters.
    pub const START: Self = Self::new("start", Places::One, start);
    /// Begins the next prediction before a scan.
    pub const PREDICT: Self = Self::new("predict", Places::One, predict);
    /// Moves the candidates (5.12).
    pub const SAMPLE: Self = Self::new("sample", Places::Candidates, sample);
    /// Sorts the measurements.
    pub const OPEN: Self = Self::new("open", Places::One, open);
    /// Moves the moving features (5.14).
    pub const DRIFT: Self = Self::new("drift", Places::MovingPages, drift);
    /// Draws candidates of an informed proposal.
    pub const PROPOSE: Self = Self::new("propose", Places::One, propose);
    /// Weighs the candidates (4.52).
    pub const WEIGH: Self = Self::new("weigh", Places::Candidates, weigh);
    /// Selects the survivors (5.23).
    pub const SELECT: Self = Self::new("select", Places::One, select);
    /// Updates their maps (5.17–5.22), each in a draft.
    pub const MAKE: Self = Self::new("make", Places::Particles, make);
    /// Gives the drafts pages.
    pub const STORE: Self = Self::new("store", Places::One, store);
    /// Writes the pages.
    pub const FILL: Self = Self::new("fill", Places::Particles, fill);
    /// Estimates and report.
    pub const CLOSE: Self = Self::new("close", Places::One, close);

    /// The launches that start the filters.
    pub const STARTING: [Self; 2] = [Self::START, Self::DESKS];
    /// The launches of every prediction before a scan.
    pub const PREDICTING: [Self; 2] = [Self::PREDICT, Self::SAMPLE];
    /// The launches of a scan, in order.
    pub const SCANNING: [Self; 9] = [
        Self::OPEN,
        Self::DRIFT,
        Self::PROPOSE,
        Self::WEIGH,
        Self::SELECT,
        Self::MAKE,
        Self::STORE,
        Self::FILL,
        Self::CLOSE,
    ];

    /// What the thread of that place does. Places beyond the last have nothing to do; a run that has stopped stays as it is.
    ///
    /// # Safety
    /// Every pointer of the buffers is aligned and leads to as many values as the filters, runs, particles and samples say, which live and stay
    /// where they are until the last launch has ended; rooms and desks begin as zeros. The launches come in the order of
    /// [`STARTING`](Self::STARTING), and for every scan of [`PREDICTING`](Self::PREDICTING), as many times as there are predictions before it
    /// in any run, and [`SCANNING`](Self::SCANNING), each with a thread for every place, once, and ends before the next begins.
    #[inline(always)]
    pub unsafe fn run(&self, place: usize, filters: &Filters<M>, scan: u32, digest_every: u32) {
        let each = self.places.count(M::MOVING_PAGES, filters.particles as usize, filters.samples as usize);
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
        let candidates = particles * self.samples as usize;
        // SAFETY: the caller's word.
        unsafe {
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
                status: self.statuses.add(filter),
                results: self.results.add(at(|run| run.first_scan)),
                features: self.features.add(at(|run| run.first_feature)),
                movers: self.movers.add(at(|run| run.first_mover)),
            }
        }
    }
}

/// A number of things on a machine that has at least 32 bits.
fn whole(number: u32) -> usize {
    number as usize
}

/// What is between the launches of a scan; nothing where the run has stopped.
unsafe fn between<'r, M: Size>(group: &Group<M>, scan: u32) -> Option<&'r Between> {
    // SAFETY: `open` has put it there where it did not stop the run.
    unsafe { goes_on(group, scan).then(|| (*group.room).between.assume_init_ref()) }
}

/// The same for the one thread of its launch.
unsafe fn alone<'r, M: Size>(place: usize, group: &Group<M>, scan: u32) -> Option<&'r mut Between> {
    // SAFETY: as of `between`, and no other thread looks at it.
    unsafe { (place == 0 && goes_on(group, scan)).then(|| (*group.room).between.assume_init_mut()) }
}

/// Whether the run has not stopped and has such a scan.
unsafe fn goes_on<M: Size>(group: &Group<M>, scan: u32) -> bool {
    // SAFETY: there is a status, which only the one thread of a launch writes, and a run, which nobody does.
    unsafe { (*group.status).code == Status::DONE && scan < (*group.run).scans }
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
            Ok(Some(Samples { candidates, in_use, mut noise })) => {
                for (place, first) in (0..in_use).step_by(TOGETHER).enumerate() {
                    *group.streams.add(place) = StreamPlace { stream: MaybeUninit::new(noise.clone()) };
                    noise.skip((in_use - first).min(TOGETHER) * Vehicle::NUMBERS);
                }
                predicting.after = MaybeUninit::new(noise);
                predicting.candidates = (candidates.as_mut_ptr(), candidates.len());
                predicting.in_use = in_use;
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
        let Predicting { taken, candidates: (candidates, len), in_use, .. } = &(*group.room).prediction;
        if place < (*in_use).min(*len)
            && let Ok((predictions, _)) = before(inputs(group), whole(scan))
            && let Some(Prediction { control, dt_s }) = predictions.get(whole(taken.wrapping_sub(1)))
        {
            let mut noise = (*group.streams.add(place / TOGETHER)).stream.assume_init_ref().clone();
            noise.skip(place % TOGETHER * Vehicle::NUMBERS);
            let filter = (*group.room).filter.assume_init_ref();
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
                    ln_likelihoods: (core::ptr::null_mut(), 0),
                    pages: (pages.as_mut_ptr(), pages.len()),
                    moving_pages: (moving_pages.as_mut_ptr(), moving_pages.len()),
                    drafts: 0,
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
    // SAFETY: the pages are lent, and each is that of one place.
    unsafe {
        if let Some(Between { scanning, moving_pages: (pages, len), .. }) = between(group, scan)
            && place < *len
        {
            scanning.drift_page(place, &mut *pages.add(place));
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
        let Between { scanning, eta, ln_likelihoods, .. } = between;
        scanning.propose(eta);
        let lent = scanning.lend_ln_likelihoods();
        *ln_likelihoods = (lent.as_mut_ptr(), lent.len());
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
        if let Some(Between { scanning, ln_likelihoods: (ln_likelihoods, len), .. }) = between(group, scan)
            && place < scanning.candidates().min(*len)
        {
            let eta = &mut (*group.sights.add(place)).eta;
            let in_view = scanning.weigh(place, &mut *ln_likelihoods.add(place), eta);
            (*group.room).in_view.fetch_max(u32::try_from(in_view).unwrap_or(u32::MAX), Ordering::Relaxed);
        }
    }
}

/// Selects the candidates that go on, and gives every draft one of them.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn select<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; the ln L come back that `propose` has lent; there are as many drafts as particles.
    unsafe {
        let Some(Between { scanning, ln_likelihoods: (ln_likelihoods, len), drafts, .. }) = alone(place, group, scan)
        else {
            return;
        };
        let in_view = (*group.room).in_view.load(Ordering::Relaxed);
        scanning.weighed(from_raw_parts_mut(*ln_likelihoods, *len), whole(in_view));
        scanning.select();
        scanning.begin_update();
        *drafts = scanning.assign(all_drafts(group, whole((*group.run).setup.particles)));
    }
}

/// Updates the maps of one survivor.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn make<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: maps are only read; each draft and each sight is that of one place.
    unsafe {
        if let Some(Between { scanning, drafts, .. }) = between(group, scan)
            && place < *drafts
        {
            let draft = (*group.drafts.add(place)).draft.assume_init_mut();
            scanning.make(draft, &mut (*group.sights.add(place)).eta);
        }
    }
}

/// Gives the updated maps pages, in the order of the survivors, and lends them.
///
/// # Safety
/// As of [`Stage::run`].
unsafe fn store<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs.
    unsafe {
        let Some(Between { scanning, eta, pages, moving_pages, drafts, .. }) = alone(place, group, scan) else {
            return;
        };
        let first_fresh = scanning.next_label();
        for draft in all_drafts(group, *drafts) {
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
/// As of [`Stage::run`].
unsafe fn fill<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: the pages are lent, and no two drafts have been given the same one; each draft is that of one place.
    unsafe {
        if let Some(&Between { drafts, pages: (pages, len), moving_pages: (moving_pages, moving_len), .. }) =
            between(group, scan)
            && place < drafts
        {
            let draft = (*group.drafts.add(place)).draft.assume_init_mut();
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
/// As of [`Stage::run`].
unsafe fn close<M: Size>(place: usize, group: &Group<M>, scan: u32, digest_every: u32) {
    // SAFETY: no other thread runs; the pages come back that `store` has lent; what is between the launches of a scan ends with it, and
    // before the filter is looked at again. Where the run says that its outputs lie they do.
    unsafe {
        let Some(between) = alone(place, group, scan) else { return };
        give_pages_back(between);
        let room = group.room;
        let Between { scanning, .. } = (*room).between.assume_init_read();
        let report = scanning.finish();
        let run = &*group.run;
        let mut outputs = Outputs {
            results: from_raw_parts_mut(group.results, whole(run.scans)),
            features: from_raw_parts_mut::<Feature>(group.features, whole(run.features)),
            movers: from_raw_parts_mut::<Mover>(group.movers, whole(run.movers)),
        };
        let taken = whole(scan) + 1;
        let digest = asks_for_digest(whole(digest_every), taken, taken == whole(run.scans));
        let filter = (*room).filter.assume_init_ref();
        let detector = (*room).detector.assume_init_ref();
        let lists = (&mut (*room).slot.features, &mut (*room).slot.movers);
        let told = tell(filter, detector, &report, lists, &mut outputs, whole(scan), digest);
        *group.status = match told {
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
unsafe fn all_drafts<'r, M: Size>(group: &Group<M>, count: usize) -> &'r mut [DraftOf] {
    // SAFETY: `desks` has made as many as there are particles, and a place is a draft and nothing else.
    unsafe { from_raw_parts_mut(group.drafts.cast(), count) }
}

// A place for a draft is no larger than a draft.
const _: () = assert!(size_of::<DraftPlace>() == size_of::<DraftOf>());
