//! The state of a scan update between its stages.

use crate::detection::scan::Scan;
use crate::detection::view::View;
use crate::detection::weigh::weigh;
use crate::filter::context::{ScanContext, SurvivorViews, UpdateContext};
use crate::filter::draft::Draft;
use crate::filter::executor::shares;
use crate::filter::newborn::Newborn;
use crate::filter::predict_moving::{predict_moving, predict_moving_on, predict_page};
use crate::filter::stages::{
    Outcome, ParticleLayout, Weighing, adopt, finite_ln_likelihood, propose, report, take_selected,
};
use crate::filter::state::Memory;
use crate::filter::tally::Tally;
use crate::filter::task::{Task, runs, tasks};
use crate::filter::update::Update;
use crate::filter::waiting::enter::enter;
use crate::map::Page;
use crate::models::OnVehicle;
use crate::particles::candidate::{Candidate, effective_number, reweigh};
use crate::particles::select::{Selection, Weighed, select};
use crate::{
    Clutter, Config, Detector, Dynamic, Executor, LnSum, MeasurementModel, Noise, Place, Pose, PositionOf, Probe, Real,
    ScalarOf, ScanError, ScanReport, ScanRoom, Sensor, Static,
};

/// A scan update in progress: what its stages read and write, and the results of the stages so far.
///
/// [`ScPhd::scan`](crate::ScPhd::scan) calls the stages in the order of the methods below. A GPU calls them in one launch each, and
/// keeps this value in its memory between launches. Methods that take `&self` may be called by several threads at once.
pub struct Scanning<'a, 's, X: MeasurementModel> {
    pub(crate) context: ScanContext<'a, X>,
    pub(crate) memory: &'a mut Memory<'s, X::Pose>,
    pub(crate) noise: Noise,
    /// Counts of the births that the last scan had delayed.
    pub(crate) delayed_births: Tally<ScalarOf<X::Pose>>,
    /// Number of particles whose proposal had too little working memory.
    pub(crate) crowded: usize,
    pub(crate) layout: ParticleLayout,
    pub(crate) weighing: Weighing<ScalarOf<X::Pose>>,
    pub(crate) selection: Selection,
    pub(crate) update_context: UpdateContext<ScalarOf<X::Pose>>,
    /// Counts of the map updates.
    pub(crate) tally: Tally<ScalarOf<X::Pose>>,
}

/// A scan update with scratch for η, and for |V| of every worker.
pub(crate) type Begun<'a, 's, X> =
    (Scanning<'a, 's, X>, &'a mut [LnSum<ScalarOf<<X as MeasurementModel>::Pose>>], &'a mut [u16]);

/// The pages of all static maps, and of all moving ones.
pub type AllPages<'s, D> = (&'s mut [Page<Static<D>>], &'s mut [Page<Dynamic<D>>]);

impl<X: MeasurementModel> core::fmt::Debug for Scanning<'_, '_, X> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Scanning").field("layout", &self.layout).finish_non_exhaustive()
    }
}

impl<'a, 's, T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P> + 'a> Scanning<'a, 's, X> {
    /// Begins the update: sorts the measurements, which the caller has checked.
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
        let context = ScanContext {
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
            context,
            layout: ParticleLayout::of(config, memory.cursor),
            memory,
            noise,
            delayed_births: Tally::new(),
            crowded: 0,
            weighing: Weighing::NONE,
            selection: Selection::NONE,
            update_context: UpdateContext::NONE,
            tally: Tally::new(),
        };
        Ok((scanning, eta, most_in_view))
    }

    /// Adds the births that the last scan delayed to the maps, if this scan may have detected them; the others are missed
    /// detections.
    pub fn enter(&mut self) {
        let ScanContext { config, scan, .. } = &self.context;
        enter(config, &self.context.views(), scan, self.memory, &mut self.delayed_births);
    }

    /// Predicts the moving features (5.14), in one step over the time since the last scan.
    pub(crate) fn predict_moving(&mut self) {
        predict_moving(&mut self.memory.moving_maps.pool, self.context.config, self.memory.cursor.waited_s);
    }

    /// [`predict_moving`](Self::predict_moving) in one job for each worker.
    pub(crate) fn predict_moving_on(&mut self, (executor, workers): (&impl Executor, usize)) {
        let pool = &mut self.memory.moving_maps.pool;
        predict_moving_on(pool, self.context.config, self.memory.cursor.waited_s, (executor, workers));
    }

    /// [`predict_moving`](Self::predict_moving) for one page, which was [lent](Self::lend_pages).
    pub fn drift_page(&self, index: usize, page: &mut Page<Dynamic<PositionOf<P>>>) {
        let waited_s = self.memory.cursor.waited_s;
        if waited_s > T::ZERO && self.memory.moving_maps.pool.is_held(index) {
            predict_page(self.context.config, waited_s)(page);
        }
    }

    /// Hands over all pages, so that several threads can write them. Until they are [given back](Self::give_pages_back) all maps
    /// are empty.
    pub fn lend_pages(&mut self) -> AllPages<'s, PositionOf<P>> {
        (self.memory.static_maps.pool.lend_pages(), self.memory.moving_maps.pool.lend_pages())
    }

    /// Takes the pages back.
    pub fn give_pages_back(&mut self, (of_static, of_moving): AllPages<'s, PositionOf<P>>) {
        self.memory.static_maps.pool.give_pages_back(of_static);
        self.memory.moving_maps.pool.give_pages_back(of_moving);
    }

    /// Prepares the candidate poses: those of the prediction, or samples of a proposal that uses this scan (informed proposal).
    pub fn propose(&mut self, eta: &mut [LnSum<T>]) {
        let ScanContext { config, scan, .. } = &self.context;
        self.crowded = propose(config, &self.context.views(), scan, self.memory, eta, &mut self.noise);
        self.layout = ParticleLayout::of(config, self.memory.cursor);
    }

    /// Number of candidates.
    pub fn candidates(&self) -> usize {
        self.layout.candidates()
    }

    /// Whether there is only one candidate, whose likelihood the update computes.
    pub(crate) fn has_single_candidate(&self) -> bool {
        self.layout.single_candidate
    }

    /// Adds ln of the likelihood of the scan for the candidate with this index, given its predicted map (4.52), to its ln L. Returns
    /// |V|.
    pub fn weigh(&self, index: usize, candidate: &Candidate<P>, ln_likelihood: &mut T, eta: &mut [LnSum<T>]) -> usize {
        let Memory { static_maps, moving_maps, waiting, .. } = &*self.memory;
        let parent = self.layout.parent_of(index);
        let missed = waiting.missed.get(parent).copied().unwrap_or(T::ZERO);
        let view = View { missed, ..self.context.views().from(&candidate.pose) };
        let weighed = weigh(&view, parent, (static_maps, moving_maps), &self.context.scan, eta);
        *ln_likelihood = finite_ln_likelihood(*ln_likelihood + weighed.ln_likelihood);
        weighed.in_view
    }

    /// Computes the likelihoods of all candidates, a part of them by each worker.
    pub(crate) fn weigh_all(&mut self, eta: &mut [LnSum<T>], most_in_view: &mut [u16], executor: &impl Executor) {
        let ln_likelihoods = self.lend_ln_likelihoods();
        let in_question = if self.layout.single_candidate { 0 } else { self.candidates() };
        let of_candidates = ln_likelihoods.get_mut(..in_question).unwrap_or(&mut []);
        most_in_view.fill(0);
        executor.run(shares(of_candidates, eta, most_in_view), |share| {
            let candidates = self.memory.candidates.get(share.first..).unwrap_or(&[]);
            let each = (share.first..).zip(candidates.iter().zip(share.ln_likelihoods));
            let in_view = each.map(|(index, (candidate, ln_l))| self.weigh(index, candidate, ln_l, share.eta)).max();
            *share.most_in_view = in_view.unwrap_or(0).min(usize::from(u16::MAX)) as u16;
        });
        let in_view = most_in_view.iter().copied().max().map_or(0, usize::from);
        self.weighed(ln_likelihoods, in_view);
    }

    /// Hands over the array of ln L. Every element has the correction for the candidate's proposal density.
    pub fn lend_ln_likelihoods(&mut self) -> &'s mut [T] {
        core::mem::take(&mut self.memory.ln_likelihoods)
    }

    /// Takes the complete ln L back, and multiplies the candidates' weights by them (5.23). `in_view` is the greatest |V|.
    pub fn weighed(&mut self, ln_likelihoods: &'s mut [T], in_view: usize) {
        self.memory.ln_likelihoods = ln_likelihoods;
        let Memory { candidates, ln_likelihoods, .. } = &mut *self.memory;
        let candidates = candidates.get_mut(..self.layout.candidates()).unwrap_or(&mut []);
        let ln_evidence = reweigh(candidates, ln_likelihoods);
        self.weighing = Weighing { ln_evidence, n_eff: effective_number(candidates), in_view };
    }

    /// Selects one candidate for each particle (resampling, 5.2.2). The selected candidates are called survivors.
    pub fn select(&mut self) {
        let Memory { candidates, survivors, selected, .. } = &mut *self.memory;
        let ParticleLayout { particles, children, .. } = self.layout;
        let candidates = candidates.get(..self.layout.candidates()).unwrap_or(&[]);
        let weighed = Weighed { candidates, particles, children, n_eff: self.weighing.n_eff };
        self.selection = select(&weighed, self.context.config, &mut self.noise, survivors, selected);
    }

    /// Begins the update of the survivors' maps (5.17–5.22): assigns labels to the measurements, and frees the maps of particles
    /// without a survivor.
    pub fn begin_update(&mut self) {
        let all = self.memory.survivors.get(..self.layout.particles).unwrap_or(&[]);
        self.open_update(runs(all).count());
        self.free_unneeded();
    }

    /// Assigns labels to the measurements, and sets the context of the update. `distinct` is the number of different survivors.
    pub(crate) fn open_update(&mut self, distinct: usize) {
        self.tally.survivors = distinct;
        let ScanContext { config, births, scan, .. } = &self.context;
        let Memory { cursor, waiting, .. } = &mut *self.memory;
        let first_label = cursor.next_label;
        self.update_context = UpdateContext {
            first_label,
            most_births: 0,
            known_below: cursor.watch.known_below,
            ln_confirmed: config.confirmed_weight.ln(),
            births_wait: waiting.await_scan(config, births, scan, first_label),
        };
        let measurements = scan.len();
        let first_look = self.memory.survivors.first().and_then(|&survivor| self.survivor_views().view(survivor));
        let (most_births, more) = first_look.map_or((0, false), |view| view.count_births());
        self.update_context.most_births = most_births;
        self.tally.lost += usize::from(more);
        self.memory.cursor.next_label = first_label.wrapping_add((measurements + most_births) as u32);
    }

    /// Frees the maps of particles without a survivor.
    pub(crate) fn free_unneeded(&mut self) {
        let layout = self.layout;
        let survivors = core::mem::take(&mut self.memory.survivors);
        let all = survivors.get(..layout.particles).unwrap_or(&[]);
        let alive = all.iter().map(|&survivor| layout.parent_of(usize::from(survivor)));
        self.parts().1.begin(layout.particles, alive);
        self.memory.survivors = survivors;
    }

    /// The measurement contexts of the survivors.
    fn survivor_views(&self) -> SurvivorViews<'_, 'a, X> {
        let Memory { candidates, pose_covariances, waiting, .. } = &*self.memory;
        SurvivorViews {
            context: &self.context,
            views: self.context.views(),
            layout: self.layout,
            update_context: self.update_context,
            candidates,
            pose_covariances,
            missed: waiting.missed,
        }
    }

    /// The measurement contexts of the survivors, and the maps that the update writes.
    fn parts(&mut self) -> (SurvivorViews<'_, 'a, X>, Update<'_, 's, PositionOf<P>>) {
        let Memory { cursor, candidates, pose_covariances, static_maps, moving_maps, waiting, .. } = &mut *self.memory;
        let survivor_views = SurvivorViews {
            context: &self.context,
            views: self.context.views(),
            layout: self.layout,
            update_context: self.update_context,
            candidates,
            pose_covariances,
            missed: waiting.missed,
        };
        let update = Update {
            static_maps,
            moving_maps,
            weighs: self.layout.single_candidate,
            next_label: &mut cursor.next_label,
            noted: waiting.noted.reborrow(),
            tally: &mut self.tally,
        };
        (survivor_views, update)
    }

    /// Number of pages kept free: one for each distinct survivor, for its delayed births.
    pub(crate) fn reserved(&self) -> usize {
        if self.update_context.births_wait > 0 { self.tally.survivors } else { 0 }
    }

    /// One task for each different survivor.
    fn tasks<'t>(&self, survivors: &'t [u16]) -> impl Iterator<Item = Task> + 't {
        let (layout, reserved) = (self.layout, self.reserved());
        let survivors = survivors.get(..layout.particles).unwrap_or(&[]);
        tasks(survivors, self.tally.survivors, reserved, move |survivor| layout.parent_of(usize::from(survivor)))
    }

    /// Updates the maps of all survivors, one after the other.
    pub(crate) fn update(&mut self, eta: &mut [LnSum<T>], probe: &mut impl Probe) {
        let survivors = core::mem::take(&mut self.memory.survivors);
        let tasks = self.tasks(survivors);
        let (survivor_views, mut update) = self.parts();
        for task in tasks {
            if let Some(scan_view) = survivor_views.of(task.survivor) {
                update.one(&task, &scan_view, eta, probe);
            }
            update.share(&task);
        }
        self.memory.survivors = survivors;
    }

    /// Updates the maps of all survivors, several at a time: each worker computes updated maps into drafts, which are then stored
    /// in order, with the same result as [`update`](Self::update).
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

    /// Assigns a survivor to each draft, while there are both. Returns the number of assigned drafts.
    pub fn assign(&self, drafts: &mut [Draft<'_, PositionOf<P>>]) -> usize {
        assign(&mut self.tasks(self.memory.survivors), drafts)
    }

    /// Updates the maps of a draft's survivor, reading those of its parent.
    pub fn make(&self, draft: &mut Draft<'_, PositionOf<P>>, eta: &mut [LnSum<T>]) {
        let maps = (&self.memory.static_maps, &self.memory.moving_maps);
        if draft.fits(maps)
            && let Some(scan_view) = self.survivor_views().of(draft.task.survivor)
        {
            draft.make(&scan_view, maps, eta, self.memory.cursor.next_label);
        }
    }

    /// The first free label, with which the labels of the next drafts begin.
    pub fn next_label(&self) -> u32 {
        self.memory.cursor.next_label
    }

    /// Stores the next draft in order, except the [contents](Draft::fill) of its pages. Its new labels begin with `first_fresh`.
    ///
    /// If the draft is incomplete, because it had no room for its terms or was not made, the map is updated here instead.
    pub fn store(
        &mut self,
        draft: &mut Draft<'_, PositionOf<P>>,
        first_fresh: u32,
        eta: &mut [LnSum<T>],
        probe: &mut impl Probe,
    ) {
        let task = draft.task;
        let (survivor_views, mut update) = self.parts();
        if draft.is_whole {
            update.store_draft(draft, first_fresh);
        } else if let Some(scan_view) = survivor_views.of(task.survivor) {
            update.one(&task, &scan_view, eta, probe);
        }
        update.share(&task);
    }

    /// Ends the update: the maps are those of the survivors, and the positions of delayed births are stored.
    pub fn end_update(&mut self) {
        let particles = self.layout.particles;
        self.parts().1.finish(particles);
        self.tally.add_delayed_births(&self.delayed_births);
        if self.update_context.births_wait == 0 {
            return;
        }
        let Memory { candidates, survivors, pose_covariances, waiting, .. } = &mut *self.memory;
        let survivors = survivors.get(..particles).unwrap_or(&[]);
        for (particle, &survivor) in survivors.iter().enumerate() {
            if let Some(candidate) = candidates.get(usize::from(survivor)) {
                waiting.place(particle, candidate.pose);
            }
        }
        let Some(&reference) = survivors.get(self.selection.heaviest) else { return waiting.forget() };
        let Some(candidate) = candidates.get(usize::from(reference)) else { return waiting.forget() };
        let pose_covariance = pose_covariances.get(self.layout.parent_of(usize::from(reference)));
        let pose_covariance = pose_covariance.filter(|_| self.layout.has_pose_covariances);
        let view = self.context.views().from(&candidate.pose);
        let tally = &mut self.tally;
        waiting.complete(
            self.context.config,
            &self.context.scan,
            candidate.pose,
            |measured| Newborn::of(&view, pose_covariance, measured),
            |particle, kinds| {
                let before = particle.checked_sub(1).and_then(|before| survivors.get(before));
                // Copies of a survivor have one map.
                if survivors.get(particle) != before {
                    tally.births = tally.births.saturating_sub(kinds);
                    tally.no_birth += 1;
                }
            },
        );
    }

    /// Ends the scan: the survivors become the particles.
    pub fn finish(self) -> ScanReport<T> {
        take_selected(&self.layout, self.memory);
        self.finish_adopted()
    }

    /// [`finish`](Self::finish) after the caller has moved the survivors to the indices of the particles.
    pub fn finish_adopted(self) -> ScanReport<T> {
        let Self { context, memory, noise, crowded, layout, weighing, selection, tally, .. } = self;
        let weighing = weighing.completed(&layout, &tally, memory.ln_likelihoods);
        let cursor = &mut *memory.cursor;
        let watched = cursor.watch.scanned(
            &tally.recognised(),
            (context.measured, context.clutter_per_scan),
            cursor.waited_s,
            cursor.next_label,
        );
        let refused = adopt(&layout, &selection, memory.cursor, noise);
        let outcome = Outcome { layout, weighing, selection, tally, crowded, refused, watched };
        report::<P, X::Measurement>(&outcome, memory, context.measured)
    }
}

/// Assigns a task to each draft, while there are both. Returns the number of assigned drafts.
fn assign<D: Place>(tasks: &mut impl Iterator<Item = Task>, drafts: &mut [Draft<'_, D>]) -> usize {
    let mut assigned = 0;
    for (draft, task) in drafts.iter_mut().zip(tasks) {
        draft.begin(task);
        assigned += 1;
    }
    assigned
}
