//! A scan as a sequence of launches, for any number of filters at once: the function of each thread in each launch.
//!
//! The stages are those of [`scphd::storage::Scanning`]. Weighing a candidate or updating the maps of a survivor is the work of
//! one thread. Steps that must be sequential are one thread for each filter, so that the state stays on the device. All threads
//! of a launch run the same stage, for all filters, so that all threads of a device execute the same code.
//!
//! The functions of stages have the safety requirements of [`Stage::run`].

use crate::buffer::{Prediction, Run, Status};
use crate::group::{alone, between, give_pages_back, goes_on, inputs, whole};
use crate::joint::Joint;
use crate::kind::Kind;
use crate::room::Size;
use crate::room::{
    Between, COLUMNS, Filters, Group, Lending, Listed, Many, Predicting, TOGETHER, WHOLES, page_parts, parts, streams,
    words,
};
use crate::run::{Filter, before, over};
use crate::setup::{control_of, numbers_of};
use crate::store;
use core::mem::MaybeUninit;
use core::slice::from_raw_parts_mut;
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
    /// One for each filter, in a block of its own with [`HELPERS`](crate::joint::HELPERS).
    Leader,
}

impl Places {
    /// The number of threads for a filter of this size with `particles` particles and `samples` samples of each.
    pub const fn count<M: Kind>(self, particles: usize, samples: usize) -> usize {
        match self {
            Self::One | Self::Leader => 1,
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

/// Passes the launches to another macro, in their order: those that start the filters, those of each prediction before a scan, those
/// of a scan, and that of a requested digest. Each has its function, after which its kernel is named, and its threads for each filter.
macro_rules! launches {
    ($then:ident! { $($with:tt)* }) => {
        $then! {
            $($with)*
            {
                stages::start One; // Starts the filters.
                stages::desks Particles; // Makes a draft over each desk.
            }
            {
                stages::predict One; // Begins the next prediction before a scan.
                stages::sample Candidates; // Moves the candidates (5.12).
            }
            {
                stages::open One; // Sorts the measurements.
                stages::drift Pages; // Predicts the moving features (5.14), and resets the numbers of maps that hold a page.
                stages::propose One; // Draws the candidates of an informed proposal.
                stages::weigh Candidates; // Weighs the candidates (4.52).
                select::products CandidateParts; // Sums ζ L over parts of the candidates.
                select::evidence One; // Adds these sums up.
                select::multiply CandidateParts; // Multiplies the weights by the likelihoods (5.23).
                select::rest One; // Computes the divisor that the weights still need.
                select::cumulate CandidateParts; // Divides the weights by it, and computes their cumulative sums in parts.
                select::decide One; // Decides whether to resample.
                select::draw Particles; // Draws the survivors (5.2.2).
                select::runs ParticleParts; // Counts the different survivors, and finds the heaviest, in parts.
                select::settle One; // Begins the update of the survivors' maps.
                select::assign ParticleParts; // Assigns a draft to each different survivor.
                store::make Particles; // Updates the survivors' maps (5.17–5.22), each in its draft.
                store::claim ParticleParts; // Sums the labels and pages that the drafts allocate, in parts.
                store::unheld PageParts; // Counts the pages that no map holds any more, in parts.
                store::add_up One; // Adds these sums up.
                store::judge ParticleParts; // Finds the positions of each draft's labels and pages, and whether there are enough pages.
                store::commit One; // Lends the lists of pages; if there are too few pages, stores the drafts one after the other.
                store::list PageParts; // Lists the free pages.
                store::take Particles; // Allocates pages and labels for the drafts.
                store::fill Lanes; // Writes the pages.
                store::share Particles; // Gives every particle the list of its pages, and moves its candidate to the particle's place.
                tell::sum Columns; // Sums over drafts and particles.
                tell::centre Particles; // Computes the terms of the mean pose.
                tell::sum_centre Columns; // Adds them up.
                tell::spread Particles; // Computes the terms of the covariance of the pose.
                tell::sum_spread Columns; // Adds them up.
                tell::close One; // Writes estimates and report.
            }
            {
                tell::digest One; // Computes the digest of the state after a scan, if it is requested.
            }
        }
    };
}

/// The launches of joint maps, whose predictions are a part of the scan.
macro_rules! joint_launches {
    ($then:ident! { $($with:tt)* }) => {
        $then! {
            $($with)*
            { joint::start One; }
            {}
            { joint::scan Leader; }
            { joint::digest One; }
        }
    };
}
#[cfg(target_arch = "nvptx64")]
pub(crate) use {joint_launches, launches};

/// Lists of the launches.
macro_rules! lists {
    ($({ $($file:ident::$body:ident $places:ident;)* })+) => {
        [$(&[$(Stage { name: stringify!($body), places: Places::$places, body: crate::$file::$body }),*]),+]
    };
}

/// A kind of filters with its launches.
pub trait Launches: Kind {
    /// Those that start the filters, those of each prediction, those of a scan, and that of a digest.
    const LAUNCHES: [&'static [Stage<Self>]; 4];
}

impl<M: Size> Launches for M {
    const LAUNCHES: [&'static [Stage<Self>]; 4] = launches!(lists! {});
}

impl Launches for Joint {
    const LAUNCHES: [&'static [Stage<Self>]; 4] = joint_launches!(lists! {});
}

/// The function of a thread in a launch. Arguments: its place among the threads of its filter, the data of the filter, the scan,
/// and the number of scans between two digests.
pub(crate) type Body<M> = unsafe fn(usize, &Group<M>, u32, u32);

/// A launch.
#[derive(Debug, Clone, Copy)]
pub struct Stage<M: Kind> {
    /// Its name. The name of its kernel has the prefix [`Kind::NAME`].
    pub name: &'static str,
    /// The number of its threads.
    pub places: Places,
    pub(crate) body: Body<M>,
}

impl<M: Kind> Stage<M> {
    /// Runs the function of one thread. Places beyond the last do nothing; a run that has stopped does not change.
    ///
    /// # Safety
    /// Every pointer of the buffers is aligned and leads to as many values as the numbers of filters, runs, particles and samples
    /// require. The values live and do not move until the last launch has ended; rooms and desks start as zeros. The launches
    /// come in the order of [`Launches::LAUNCHES`]: those of a start, and then for every scan those of a prediction, once for each
    /// prediction before it in the run that has most, those of a scan and, if requested, that of a digest.
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

impl<M: Kind> Filters<M> {
    /// The data of one filter.
    ///
    /// # Safety
    /// There is such a filter, and every pointer leads to as many values as the numbers of filters, particles and samples and the
    /// runs require.
    pub(crate) unsafe fn group(&self, filter: usize) -> Group<M> {
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
            let own = Self {
                runs: run,
                scans: self.scans.add(at(|run| run.first_scan)),
                predictions: self.predictions.add(at(|run| run.first_prediction)),
                measurements: self.measurements.add(at(|run| run.first_measurement)),
                rooms: self.rooms.add(filter),
                sights: self.sights.add(filter * candidates),
                desks: self.desks.add(filter * particles),
                drafts: self.drafts.add(filter * particles),
                streams: self.streams.add(filter * streams(candidates)),
                parts: self.parts.add(filter * parts(candidates)),
                statuses: self.statuses.add(filter),
                results: self.results.add(at(|run| run.first_scan)),
                features: self.features.add(at(|run| run.first_feature)),
                ..*self
            };
            Group {
                own,
                cumulated: cumulated.cast(),
                stride: particles,
                columns: columns.cast(),
                wholes,
                held: held.cast(),
                firsts: held.add(M::PAGES + M::MOVING_PAGES),
            }
        }
    }
}

/// Starts the filter.
pub(crate) unsafe fn start<M: Size>(place: usize, group: &Group<M>, _scan: u32, _digest_every: u32) {
    if place > 0 {
        return;
    }
    // SAFETY: no other thread runs. A room starts as zeros, which are a valid value, and does not move, so that it can hold
    // pointers to its own parts.
    unsafe {
        let room = group.rooms;
        let code = match over(inputs(group).run, &mut (*room).slot) {
            Ok((filter, detector, _)) => {
                (*room).filter = MaybeUninit::new(filter);
                (*room).detector = MaybeUninit::new(detector);
                Status::DONE
            }
            Err(code) => code,
        };
        *group.statuses = Status { code, scans: 0 };
    }
}

/// Makes a draft over the desk at this place.
pub(crate) unsafe fn desks<M: Size>(place: usize, group: &Group<M>, _scan: u32, _digest_every: u32) {
    // SAFETY: there is a desk and a draft for each particle, and only this thread uses those at its place; the desks do not move.
    unsafe {
        if place < whole((*group.runs).particles) {
            let [draft] = (*group.desks.add(place)).drafts();
            *group.drafts.add(place) = MaybeUninit::new(draft);
        }
    }
}

/// Begins the next prediction before a scan, lends the candidates, and finds the positions of their numbers in the random stream.
pub(crate) unsafe fn predict<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; `start` has initialised filter and detector.
    unsafe {
        if place > 0 || !goes_on(group, scan) {
            return;
        }
        let filter = (*group.rooms).filter.assume_init_mut();
        let predicting = &mut (*group.rooms).prediction;
        give_candidates_back(filter, predicting);
        let taken = whole(predicting.taken);
        let begun = before(inputs(group), whole(scan)).and_then(|(predictions, _)| {
            // Another run has more predictions before this scan.
            let Some(Prediction { control, dt_s }) = predictions.get(taken) else { return Ok(None) };
            predicting.taken += 1;
            let control = control_of(filter.motion(), *control);
            filter.begin_predict(&control, *dt_s).map_err(|_| Status::PREDICTION)
        });
        match begun {
            Ok(Some(Samples { candidates, in_use, selected, splits, mut noise })) => {
                let numbers = numbers_of(filter.motion());
                for (place, first) in (0..in_use).step_by(TOGETHER).enumerate() {
                    *group.streams.add(place) = MaybeUninit::new(noise.clone());
                    noise.skip((in_use - first).min(TOGETHER) * numbers);
                }
                predicting.after = MaybeUninit::new(noise);
                predicting.candidates = (candidates.as_mut_ptr(), candidates.len());
                predicting.particles = (selected.as_mut_ptr(), selected.len());
                predicting.in_use = in_use;
                predicting.splits = splits;
            }
            Ok(None) => {}
            Err(code) => (*group.statuses).code = code,
        }
    }
}

/// Moves one candidate (5.12).
pub(crate) unsafe fn sample<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: the candidates are lent, and each belongs to one place.
    unsafe {
        if !goes_on(group, scan) {
            return;
        }
        let Predicting { taken, candidates: (candidates, len), particles, in_use, splits, .. } =
            &(*group.rooms).prediction;
        if place < (*in_use).min(*len)
            && let Ok((predictions, _)) = before(inputs(group), whole(scan))
            && let Some(Prediction { control, dt_s }) = predictions.get(whole(taken.wrapping_sub(1)))
        {
            let mut noise = (*group.streams.add(place / TOGETHER)).assume_init_ref().clone();
            let filter = (*group.rooms).filter.assume_init_ref();
            noise.skip(place % TOGETHER * numbers_of(filter.motion()));
            let candidate = &mut *candidates.add(place);
            let parent = place / whole((*group.runs).samples).max(1);
            if *splits && parent < particles.1 {
                *candidate = filter.child_of(&*particles.0.add(parent));
            }
            filter.sample(candidate, &control_of(filter.motion(), *control), *dt_s, &mut noise);
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
pub(crate) unsafe fn open<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; `start` has initialised filter and detector.
    unsafe {
        if place > 0 || !goes_on(group, scan) {
            return;
        }
        let room = group.rooms;
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
            Err(code) => (*group.statuses).code = code,
        }
    }
}

/// Predicts the moving features of one page.
pub(crate) unsafe fn drift<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
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
pub(crate) unsafe fn propose<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: no other thread runs; the pages that `open` has lent are given back.
    unsafe {
        let Some(between) = alone(place, group, scan) else { return };
        give_pages_back(between);
        let Between { scanning, eta, lent, .. } = between;
        scanning.propose(eta);
        lent.ln_likelihoods = Many::of(scanning.lend_ln_likelihoods());
        (*group.rooms).in_view.store(0, Ordering::Relaxed);
    }
}

/// Weighs one candidate.
pub(crate) unsafe fn weigh<M: Size>(place: usize, group: &Group<M>, scan: u32, _digest_every: u32) {
    // SAFETY: the ln L are lent, and each of them and of the sights belongs to one place.
    unsafe {
        if let Some(Between { scanning, lent, .. }) = between(group, scan)
            && place < scanning.candidates()
            && let Some(ln_likelihood) = lent.ln_likelihoods.one(place)
        {
            let in_view = scanning.weigh(place, ln_likelihood, &mut *group.sights.add(place));
            (*group.rooms).in_view.fetch_max(u32::try_from(in_view).unwrap_or(u32::MAX), Ordering::Relaxed);
        }
    }
}
