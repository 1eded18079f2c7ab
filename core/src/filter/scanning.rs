//! One scan between its stages.

use crate::detection::scan::Scan;
use crate::detection::view::View;
use crate::detection::weigh::weigh;
use crate::filter::draft::Draft;
use crate::filter::drift::{drift, drift_on, step};
use crate::filter::executor::shares;
use crate::filter::given::{Beginning, Given, Sights};
use crate::filter::stages::{Grounds, Outcome, Weighing, adopt, explained, propose, report, take_selected};
use crate::filter::state::Memory;
use crate::filter::tally::Tally;
use crate::filter::task::{Task, runs, tasks};
use crate::filter::update::Update;
use crate::filter::waiting::enter::enter;
use crate::map::Page;
use crate::models::OnVehicle;
use crate::particles::candidate::{effective_number, reweigh};
use crate::particles::select::{Selection, Weighed, select};
use crate::{
    Clutter, Config, Detector, Dynamic, Executor, LnSum, MeasurementModel, Noise, Place, Pose, PositionOf, Probe, Real,
    ScalarOf, ScanError, ScanReport, ScanRoom, Sensor, Static, Symmetric,
};

/// A scan that is being taken in: what its stages read and change, and what has come of those before.
///
/// [`ScPhd::scan`](crate::ScPhd::scan) goes through them from top to bottom, in the order of the methods; a GPU does so launch by launch,
/// with the scan kept in its memory. What takes `&self` is for any number of threads at once.
pub struct Scanning<'a, 's, X: MeasurementModel> {
    pub(crate) given: Given<'a, X>,
    pub(crate) memory: &'a mut Memory<'s, X::Pose>,
    pub(crate) noise: Noise,
    /// What births have counted that had waited.
    pub(crate) entering: Tally<ScalarOf<X::Pose>>,
    /// Particles for whose proposal the workspace was too small.
    crowded: usize,
    pub(crate) grounds: Grounds,
    pub(crate) weighing: Weighing<ScalarOf<X::Pose>>,
    pub(crate) selection: Selection,
    pub(crate) beginning: Beginning<ScalarOf<X::Pose>>,
    /// What the updates have counted.
    pub(crate) tally: Tally<ScalarOf<X::Pose>>,
}

/// A scan with scratch for η, and for |V| of every worker.
pub(crate) type Begun<'a, 's, X> =
    (Scanning<'a, 's, X>, &'a mut [LnSum<ScalarOf<<X as MeasurementModel>::Pose>>], &'a mut [u16]);

/// The pages of all static maps, and of all moving ones.
pub type AllPages<'s, D> = (&'s mut [Page<Static<D>>], &'s mut [Page<Dynamic<D>>]);

impl<X: MeasurementModel> core::fmt::Debug for Scanning<'_, '_, X> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Scanning").field("grounds", &self.grounds).finish_non_exhaustive()
    }
}

impl<'a, 's, T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P> + 'a> Scanning<'a, 's, X> {
    /// Sorts the measurements, which have been checked.
    pub(crate) fn begin<'m>(
        config: &'a Config<T>,
        memory: &'a mut Memory<'s, P>,
        detector: &'a mut Detector<X, ScanRoom<'m, X::Measurement>>,
        measured: &[X::Measurement],
    ) -> Result<Begun<'a, 's, X>, ScanError> {
        let Detector { sensing, mounting, births, room } = detector;
        let ScanRoom { measurements, eta, most_in_view } = room;
        let Some(noise) = memory.cursor.noise.clone() else { return Err(ScanError::NotStarted) };
        let OnVehicle { sensor, field_of_view, clutter } = OnVehicle::of(&*sensing, *mounting);
        let Some(noise_factor) = sensor.noise().factor() else { return Err(ScanError::SensorNoise) };
        let scan = Scan::sort::<X::Sensor>(measurements, measured, clutter, births.total());
        let given = Given {
            config,
            births,
            sensor,
            field_of_view,
            scan,
            measured: measured.len(),
            clutter_per_scan: clutter.per_scan(),
            ln_negligible: config.negligible.ln(),
            ln_sharpest: noise_factor.ln_peak(),
            most_births: memory.static_maps.workspace.capacity(),
        };
        let scanning = Self {
            given,
            grounds: Grounds::of(config, memory.cursor),
            memory,
            noise,
            entering: Tally::new(),
            crowded: 0,
            weighing: Weighing::NONE,
            selection: Selection::NONE,
            beginning: Beginning::NONE,
            tally: Tally::new(),
        };
        Ok((scanning, eta, most_in_view))
    }

    /// What the scan before has left waiting enters the maps, or is missed.
    pub fn enter(&mut self) {
        let Given { config, births, scan, .. } = &self.given;
        enter(config, births, &self.given.views(), scan, self.memory, &mut self.entering);
    }

    /// What moves has moved (5.14), once for all the steps since the last scan.
    pub(crate) fn drift(&mut self) {
        drift(&mut self.memory.moving_maps.pool, self.given.config, self.memory.cursor.waited_s);
    }

    /// The same in one job for each of the workers.
    pub(crate) fn drift_on(&mut self, (executor, workers): (&impl Executor, usize)) {
        let pool = &mut self.memory.moving_maps.pool;
        drift_on(pool, self.given.config, self.memory.cursor.waited_s, (executor, workers));
    }

    /// The same for one of the pages, [lent](Self::lend_pages).
    pub fn drift_page(&self, index: usize, page: &mut Page<Dynamic<PositionOf<P>>>) {
        let waited_s = self.memory.cursor.waited_s;
        if waited_s > T::ZERO && self.memory.moving_maps.pool.is_held(index) {
            step(self.given.config, waited_s)(page);
        }
    }

    /// Hands over all pages, for writing by several threads; until they are [given back](Self::give_pages_back) every map is empty.
    pub fn lend_pages(&mut self) -> AllPages<'s, PositionOf<P>> {
        (self.memory.static_maps.pool.lend_pages(), self.memory.moving_maps.pool.lend_pages())
    }

    /// Takes them back.
    pub fn give_pages_back(&mut self, (of_static, of_moving): AllPages<'s, PositionOf<P>>) {
        self.memory.static_maps.pool.give_pages_back(of_static);
        self.memory.moving_maps.pool.give_pages_back(of_moving);
    }

    /// Candidates: those of the prediction, or drawn now, from poses that the scan has been taken into.
    pub fn propose(&mut self, eta: &mut [LnSum<T>]) {
        let Given { config, scan, .. } = &self.given;
        self.crowded = propose(config, &self.given.views(), scan, self.memory, eta, &mut self.noise);
        self.grounds = Grounds::of(config, self.memory.cursor);
    }

    /// Number of candidates.
    #[must_use]
    pub fn candidates(&self) -> usize {
        self.grounds.candidates()
    }

    /// Whether there is but one candidate, which the update weighs.
    pub(crate) fn is_lone(&self) -> bool {
        self.grounds.lone
    }

    /// How well a candidate explains the scan (4.52): adds it to its ln L, and returns |V|. The maps are those of the prediction.
    pub fn weigh(&self, candidate: usize, ln_likelihood: &mut T, eta: &mut [LnSum<T>]) -> usize {
        let Memory { candidates, static_maps, moving_maps, waiting, .. } = &*self.memory;
        let parent = self.grounds.parent_of(candidate);
        let Some(candidate) = candidates.get(candidate) else { return 0 };
        let missed = waiting.missed.get(parent).copied().unwrap_or(T::ZERO);
        let view = View { missed, ..self.given.views().from(&candidate.pose) };
        let weighed = weigh(&view, parent, (static_maps, moving_maps), &self.given.scan, eta);
        *ln_likelihood = explained(*ln_likelihood + weighed.ln_likelihood);
        weighed.in_view
    }

    /// Weighs all candidates, in one share for each of the workers.
    pub(crate) fn weigh_all(&mut self, eta: &mut [LnSum<T>], most_in_view: &mut [u16], executor: &impl Executor) {
        let ln_likelihoods = self.lend_ln_likelihoods();
        let in_question = if self.grounds.lone { 0 } else { self.candidates() };
        let of_candidates = ln_likelihoods.get_mut(..in_question).unwrap_or(&mut []);
        most_in_view.fill(0);
        executor.run(shares(of_candidates, eta, most_in_view), |share| {
            let each = share.ln_likelihoods.iter_mut().enumerate();
            let in_view = each.map(|(offset, ln_l)| self.weigh(share.first + offset, ln_l, share.eta)).max();
            *share.most_in_view = in_view.unwrap_or(0).min(usize::from(u16::MAX)) as u16;
        });
        let in_view = most_in_view.iter().copied().max().map_or(0, usize::from);
        self.weighed(ln_likelihoods, in_view);
    }

    /// Hands over the place of every candidate's ln L, which holds the part of it that corrects for where it was drawn.
    pub fn lend_ln_likelihoods(&mut self) -> &'s mut [T] {
        core::mem::take(&mut self.memory.ln_likelihoods)
    }

    /// Takes them back complete, and multiplies the candidates' weights by them (5.23). `in_view` is the greatest |V| of all.
    pub fn weighed(&mut self, ln_likelihoods: &'s mut [T], in_view: usize) {
        self.memory.ln_likelihoods = ln_likelihoods;
        let Memory { candidates, ln_likelihoods, .. } = &mut *self.memory;
        let candidates = candidates.get_mut(..self.grounds.candidates()).unwrap_or(&mut []);
        let ln_evidence = reweigh(candidates, ln_likelihoods);
        self.weighing = Weighing { ln_evidence, n_eff: effective_number(candidates), in_view };
    }

    /// Back to one candidate a particle (5.2.2).
    pub fn select(&mut self) {
        let Memory { candidates, survivors, selected, .. } = &mut *self.memory;
        let Grounds { particles, children, .. } = self.grounds;
        let candidates = candidates.get(..self.grounds.candidates()).unwrap_or(&[]);
        let weighed = Weighed { candidates, particles, children, n_eff: self.weighing.n_eff };
        self.selection = select(&weighed, self.given.config, &mut self.noise, survivors, selected);
    }

    /// Begins the update of the survivors' maps (5.17–5.22): gives labels to the scan, frees the maps that nobody goes on with, and finds
    /// out what all survivors see.
    pub fn begin_update(&mut self) {
        let all = self.memory.survivors.get(..self.grounds.particles).unwrap_or(&[]);
        self.open_update(runs(all).count());
        self.free_unneeded();
    }

    /// Gives labels to the scan, and finds out what all survivors see, of whom so many differ.
    pub(crate) fn open_update(&mut self, distinct: usize) {
        self.tally.survivors = distinct;
        let Given { config, sensor, scan, .. } = &self.given;
        let Memory { cursor, waiting, .. } = &mut *self.memory;
        let first_label = cursor.next_label;
        self.beginning = Beginning {
            first_label,
            most_births: 0,
            known_below: cursor.watch.known_below,
            ln_confirmed: config.confirmed_weight.ln(),
            births_wait: waiting.await_scan::<X>(config, sensor, scan, first_label),
        };
        let measurements = scan.len();
        let first_look = self.memory.survivors.first().and_then(|&survivor| self.sights().view(survivor));
        let (most_births, more) = first_look.map_or((0, false), |view| view.count_births());
        self.beginning.most_births = most_births;
        self.tally.lost += usize::from(more);
        self.memory.cursor.next_label = first_label.wrapping_add((measurements + most_births) as u32);
    }

    /// Frees the maps that nobody goes on with.
    pub(crate) fn free_unneeded(&mut self) {
        let grounds = self.grounds;
        let survivors = core::mem::take(&mut self.memory.survivors);
        let all = survivors.get(..grounds.particles).unwrap_or(&[]);
        let alive = all.iter().map(|&survivor| grounds.parent_of(usize::from(survivor)));
        self.parts().1.begin(grounds.particles, alive);
        self.memory.survivors = survivors;
    }

    /// What the survivors see.
    fn sights(&self) -> Sights<'_, 'a, X> {
        let Memory { candidates, pose_covariances, waiting, .. } = &*self.memory;
        Sights {
            given: &self.given,
            views: self.given.views(),
            grounds: self.grounds,
            beginning: self.beginning,
            candidates,
            pose_covariances,
            missed: waiting.missed,
        }
    }

    /// The same, beside the maps that the update writes.
    fn parts(&mut self) -> (Sights<'_, 'a, X>, Update<'_, 's, PositionOf<P>>) {
        let Memory { cursor, candidates, pose_covariances, static_maps, moving_maps, waiting, .. } = &mut *self.memory;
        let sights = Sights {
            given: &self.given,
            views: self.given.views(),
            grounds: self.grounds,
            beginning: self.beginning,
            candidates,
            pose_covariances,
            missed: waiting.missed,
        };
        let update = Update {
            static_maps,
            moving_maps,
            weighs: self.grounds.lone,
            next_label: &mut cursor.next_label,
            noted: waiting.noted.reborrow(),
            tally: &mut self.tally,
        };
        (sights, update)
    }

    /// Pages that are left free: one for every particle that its births may enter by.
    pub(crate) fn reserved(&self) -> usize {
        if self.beginning.births_wait > 0 { self.grounds.particles } else { 0 }
    }

    /// One task for each of the survivors that differ.
    fn tasks<'t>(&self, survivors: &'t [u16]) -> impl Iterator<Item = Task> + 't {
        let (grounds, reserved) = (self.grounds, self.reserved());
        let survivors = survivors.get(..grounds.particles).unwrap_or(&[]);
        tasks(survivors, self.tally.survivors, reserved, move |survivor| grounds.parent_of(usize::from(survivor)))
    }

    /// Updates the maps of all survivors, one after the other.
    pub(crate) fn update(&mut self, eta: &mut [LnSum<T>], probe: &mut impl Probe) {
        let survivors = core::mem::take(&mut self.memory.survivors);
        let tasks = self.tasks(survivors);
        let (sights, mut update) = self.parts();
        for task in tasks {
            if let Some(scan_view) = sights.of(task.survivor) {
                update.one(&task, &scan_view, eta, probe);
            }
            update.share(&task);
        }
        self.memory.survivors = survivors;
    }

    /// The same, with as many survivors at a time as there are drafts, in one job for each of the workers: their maps are read and
    /// updated in drafts, which are stored in order as if one had been updated after the other.
    pub(crate) fn update_on(
        &mut self,
        eta: &mut [LnSum<T>],
        (executor, workers): (&impl Executor, usize),
        drafts: &mut [Draft<'_, PositionOf<P>>],
        probe: &mut impl Probe,
    ) {
        let survivors = core::mem::take(&mut self.memory.survivors);
        let mut tasks = self.tasks(survivors);
        let each = drafts.len().div_ceil(workers.max(1)).max(1);
        let scratch = (eta.len() / workers.max(1)).max(1);
        // A round takes a task for every draft.
        for _ in 0..self.tally.survivors.div_ceil(drafts.len().max(1)) {
            let begun = assign(&mut tasks, drafts);
            let drafts = drafts.get_mut(..begun).unwrap_or(&mut []);
            executor.run(drafts.chunks_mut(each).zip(eta.chunks_mut(scratch)), |(drafts, eta)| {
                drafts.iter_mut().for_each(|draft| self.make(draft, eta));
            });
            let first_fresh = self.memory.cursor.next_label;
            for draft in drafts {
                self.store(draft, first_fresh, eta, probe);
                let Memory { static_maps, moving_maps, .. } = &mut *self.memory;
                draft.fill(|id, page| static_maps.pool.write(id, page), |id, page| moving_maps.pool.write(id, page));
            }
        }
        drop(tasks);
        self.memory.survivors = survivors;
    }

    /// Gives every draft the task of a survivor, as far as there are drafts; how many have got one.
    pub fn assign(&self, drafts: &mut [Draft<'_, PositionOf<P>>]) -> usize {
        assign(&mut self.tasks(self.memory.survivors), drafts)
    }

    /// Updates the maps of a draft's survivor, reading those of its parent.
    pub fn make(&self, draft: &mut Draft<'_, PositionOf<P>>, eta: &mut [LnSum<T>]) {
        let maps = (&self.memory.static_maps, &self.memory.moving_maps);
        if draft.fits(maps)
            && let Some(scan_view) = self.sights().of(draft.task.survivor)
        {
            draft.make(&scan_view, maps, eta, self.memory.cursor.next_label);
        }
    }

    /// The label that the first of a round of drafts began with.
    #[must_use]
    pub fn next_label(&self) -> u32 {
        self.memory.cursor.next_label
    }

    /// Stores a draft, the next in order, but for the [contents](Draft::fill) of its pages. Its fresh labels begin with `first_fresh`.
    ///
    /// What a draft cannot tell, for want of room for its terms or because it was not made, is done again.
    pub fn store(
        &mut self,
        draft: &mut Draft<'_, PositionOf<P>>,
        first_fresh: u32,
        eta: &mut [LnSum<T>],
        probe: &mut impl Probe,
    ) {
        let task = draft.task;
        let (sights, mut update) = self.parts();
        if draft.is_whole {
            update.store_draft(draft, first_fresh);
        } else if let Some(scan_view) = sights.of(task.survivor) {
            update.one(&task, &scan_view, eta, probe);
        }
        update.share(&task);
    }

    /// Ends the update: the maps are those of the survivors, and it is noted where births wait.
    pub fn end_update(&mut self) {
        let particles = self.grounds.particles;
        self.parts().1.finish(particles);
        self.tally.entered(&self.entering);
        if self.beginning.births_wait == 0 {
            return;
        }
        let Memory { candidates, survivors, pose_covariances, waiting, .. } = &mut *self.memory;
        for (particle, &survivor) in survivors.iter().take(particles).enumerate() {
            let parent = self.grounds.parent_of(usize::from(survivor));
            let pose_covariance = pose_covariances.get(parent).filter(|_| self.grounds.blurs);
            if let Some(candidate) = candidates.get(usize::from(survivor)) {
                let pose_covariance = pose_covariance.copied().unwrap_or(Symmetric::ZERO);
                waiting.place(particle, candidate.pose, pose_covariance);
            }
        }
    }

    /// The selected candidates are the particles.
    pub fn finish(self) -> ScanReport<T> {
        take_selected(&self.grounds, self.memory);
        self.finish_adopted()
    }

    /// The same of candidates that have been moved to their places.
    pub fn finish_adopted(self) -> ScanReport<T> {
        let Self { given, memory, noise, crowded, grounds, weighing, selection, tally, .. } = self;
        let weighing = weighing.completed(&grounds, &tally, memory.ln_likelihoods);
        let cursor = &mut *memory.cursor;
        let watched = cursor.watch.scanned(
            &tally.recognised(),
            (given.measured, given.clutter_per_scan),
            cursor.waited_s,
            cursor.next_label,
        );
        let refused = adopt(&grounds, &selection, memory.cursor, noise);
        let outcome = Outcome { grounds, weighing, selection, tally, crowded, refused, watched };
        report::<P, X::Measurement>(&outcome, memory, given.measured)
    }
}

/// Gives every draft a task, as far as there are both; how many have got one.
fn assign<D: Place>(tasks: &mut impl Iterator<Item = Task>, drafts: &mut [Draft<'_, D>]) -> usize {
    let mut assigned = 0;
    for (draft, task) in drafts.iter_mut().zip(tasks) {
        draft.begin(task);
        assigned += 1;
    }
    assigned
}
