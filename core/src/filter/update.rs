//! The update of the survivors' maps (5.17–5.22), after their weights are known.

use crate::detection::explain::ln_likelihood;
use crate::detection::normalise::Normalisers;
use crate::detection::scan::Scan;
use crate::detection::seen::{Seen, Weighed, reset_eta};
use crate::detection::view::View;
use crate::filter::draft::Draft;
use crate::filter::store::store;
use crate::filter::survivor::{ScanView, Workspaces};
use crate::filter::tally::Tally;
use crate::filter::task::{Task, runs, tasks};
use crate::filter::waiting::memory::Noted;
use crate::map::{Maps, PageId};
use crate::numerics::work;
use crate::{
    Births, Bounds, Config, Dynamic, Executor, Feature, Likelihood, LnSum, MeasurementModel, Place, Pose, Probe, Real,
    ScalarOf, Static, Symmetric, TangentOf,
};

/// A survivor's view, and the covariance of its pose where that is not certain.
pub(crate) type Look<'v, X> = Option<(View<'v, X>, Option<Symmetric<TangentOf<<X as MeasurementModel>::Pose>>>)>;

/// The survivors of a scan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Survivors<'a, F, L> {
    /// In ascending order of their parents; copies of one stand side by side.
    pub(crate) all: &'a [u16],
    /// Particles before the scan.
    pub(crate) parents: usize,
    /// Tells a survivor's parent.
    pub(crate) parent_of: F,
    /// Tells a survivor's [view](Look).
    pub(crate) look: L,
}

/// What every survivor sees.
struct Sights<'b, X: MeasurementModel, L> {
    look: &'b L,
    scan: &'b Scan<'b, X::Measurement>,
    config: &'b Config<ScalarOf<X::Pose>>,
    births: &'b Births<ScalarOf<X::Pose>>,
    ln_confirmed: ScalarOf<X::Pose>,
    first_label: u32,
    /// Births that the sensor expects of any survivor: as many as there are labels for.
    most_births: usize,
    known_below: u32,
    births_wait: bool,
}

impl<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>, L> Sights<'_, X, L> {
    #[inline]
    fn of<'b, 'v: 'b>(&'b self, survivor: u16) -> Option<ScanView<'b, X>>
    where
        X: 'v,
        L: Fn(u16) -> Look<'v, X>,
    {
        let &Self { scan, config, births, ln_confirmed, first_label, most_births, known_below, births_wait, .. } = self;
        let (view, pose_covariance) = (self.look)(survivor)?;
        let view = View { most_births, ..view };
        let bounds = view.bounds();
        Some(ScanView {
            view,
            pose_covariance,
            bounds,
            scan,
            config,
            births,
            ln_confirmed,
            first_label,
            known_below,
            births_wait,
        })
    }
}

/// All maps of both kinds, and the scratch that they share.
#[derive(Debug)]
pub(crate) struct Update<'a, 's, D: Place> {
    pub(crate) static_maps: &'a mut Maps<'s, Static<D>>,
    pub(crate) moving_maps: &'a mut Maps<'s, Dynamic<D>>,
    /// Scratch: η_z of one survivor after the other, then their normalisers.
    pub(crate) eta: &'a mut [LnSum<D::Scalar>],
    pub(crate) births: &'a Births<D::Scalar>,
    pub(crate) config: &'a Config<D::Scalar>,
    /// Whether the tally is to tell how well the last of the survivors explains the scan.
    pub(crate) weighs: bool,
    /// The label of the scan's first measurement; afterwards the first that has not been given away.
    pub(crate) next_label: &'a mut u32,
    /// Landmarks with lesser labels are known.
    pub(crate) known_below: u32,
    /// Where births are noted that are to wait, if they are.
    pub(crate) noted: &'a mut [Noted<D::Scalar>],
    pub(crate) births_wait: bool,
}

impl<'a, T: Real, D: Place<Scalar = T>> Update<'a, '_, D> {
    /// Gives every particle the updated map of the survivor it continues, and frees the maps without one.
    ///
    /// Copies of one survivor share its map. A parent's last child takes its map over, so that without a
    /// resampling every map is rewritten in its own place, and what it does not see is not touched.
    pub(crate) fn all<'v, X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>> + 'v>(
        mut self,
        survivors: &Survivors<'_, impl Fn(u16) -> usize, impl Fn(u16) -> Look<'v, X>>,
        scan: &Scan<'_, X::Measurement>,
        probe: &mut impl Probe,
    ) -> Tally<T> {
        let mut tally = Tally::new();
        let eta = core::mem::take(&mut self.eta);
        let sights = self.begin(survivors, scan, &mut tally);
        for task in tasks(survivors.all, tally.survivors, self.reserved(survivors.all), &survivors.parent_of) {
            if let Some(scan_view) = sights.of(task.survivor) {
                self.one(&task, &scan_view, eta, &mut tally, probe);
            }
            self.share(&task);
        }
        self.finish(survivors.all.len());
        tally
    }

    /// The same, with as many survivors at a time as there are drafts, in one job for each of the workers: their maps are read and
    /// updated in drafts, which are stored in order as if one had been updated after the other.
    ///
    /// What a draft cannot tell, for want of room for its terms or because a job was left out, is done again in its turn.
    pub(crate) fn all_on<'v, X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>> + 'v>(
        mut self,
        survivors: &Survivors<'_, impl Fn(u16) -> usize, impl Fn(u16) -> Look<'v, X> + Sync>,
        scan: &Scan<'_, X::Measurement>,
        (executor, workers): (&impl Executor, usize),
        drafts: &mut [Draft<'_, D>],
        probe: &mut impl Probe,
    ) -> Tally<T> {
        let mut tally = Tally::new();
        let eta = core::mem::take(&mut self.eta);
        let sights = self.begin(survivors, scan, &mut tally);
        let mut tasks = tasks(survivors.all, tally.survivors, self.reserved(survivors.all), &survivors.parent_of);
        let each = drafts.len().div_ceil(workers.max(1)).max(1);
        let scratch = (eta.len() / workers.max(1)).max(1);
        // A round takes a task for every draft.
        for _ in 0..tally.survivors.div_ceil(drafts.len().max(1)) {
            let mut begun = 0;
            for (draft, task) in drafts.iter_mut().zip(&mut tasks) {
                draft.begin(task);
                begun += 1;
            }
            let drafts = drafts.get_mut(..begun).unwrap_or(&mut []);
            let first_fresh = *self.next_label;
            let maps = (&*self.static_maps, &*self.moving_maps);
            executor.run(drafts.chunks_mut(each).zip(eta.chunks_mut(scratch)), |(drafts, eta)| {
                for draft in drafts.iter_mut().filter(|draft| draft.fits(maps)) {
                    if let Some(scan_view) = sights.of(draft.task.survivor) {
                        draft.make(&scan_view, maps, eta, first_fresh);
                    }
                }
            });
            for draft in drafts {
                let task = draft.task;
                if draft.is_whole {
                    self.store_draft(draft, first_fresh, &mut tally);
                } else if let Some(scan_view) = sights.of(task.survivor) {
                    self.one(&task, &scan_view, eta, &mut tally, probe);
                }
                self.share(&task);
            }
        }
        self.finish(survivors.all.len());
        tally
    }

    /// Gives labels to the scan, frees the maps without a survivor, and finds out what all survivors see.
    fn begin<'b, 'v, X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>> + 'v, L: Fn(u16) -> Look<'v, X>>(
        &mut self,
        survivors: &'b Survivors<'_, impl Fn(u16) -> usize, L>,
        scan: &'b Scan<'b, X::Measurement>,
        tally: &mut Tally<T>,
    ) -> Sights<'b, X, L>
    where
        'a: 'b,
    {
        let &Survivors { all, parents, ref parent_of, ref look } = survivors;
        let first_label = *self.next_label;
        let first_look = all.first().and_then(|&survivor| look(survivor));
        let (most_births, more) = first_look.map_or((0, false), |(view, _)| view.count_births());
        tally.lost += usize::from(more);
        *self.next_label = first_label.wrapping_add((scan.len() + most_births) as u32);
        for (peak, pages) in tally.peaks.iter_mut().zip([self.static_maps.pages_used(), self.moving_maps.pages_used()])
        {
            peak.pages = pages;
        }
        self.static_maps.table.begin(parents);
        self.moving_maps.table.begin(parents);
        let mut alive = all.iter().map(|&survivor| parent_of(survivor)).peekable();
        for parent in 0..parents {
            if alive.next_if_eq(&parent).is_none() {
                self.static_maps.table.let_go(parent, &mut self.static_maps.pool);
                self.moving_maps.table.let_go(parent, &mut self.moving_maps.pool);
            }
            while alive.next_if_eq(&parent).is_some() {
                work::round();
            }
        }
        tally.survivors = runs(all).count();
        Sights {
            look,
            scan,
            config: self.config,
            births: self.births,
            ln_confirmed: self.config.confirmed_weight.ln(),
            first_label,
            most_births,
            known_below: self.known_below,
            births_wait: self.births_wait,
        }
    }

    /// Pages to be left free: one for every particle that its births may enter by.
    fn reserved(&self, survivors: &[u16]) -> usize {
        if self.births_wait { survivors.len() } else { 0 }
    }

    /// Makes a survivor's map that of all its copies.
    fn share(&mut self, task: &Task) {
        for twin in 1..task.copies {
            let Self { static_maps, moving_maps, .. } = self;
            if let Some(&noted) = self.noted.get(task.particle)
                && let Some(slot) = self.noted.get_mut(task.particle + twin)
            {
                *slot = noted;
            }
            static_maps.table.share_updated(task.particle, task.particle + twin, &mut static_maps.pool);
            moving_maps.table.share_updated(task.particle, task.particle + twin, &mut moving_maps.pool);
        }
    }

    fn finish(&mut self, particles: usize) {
        self.static_maps.table.finish(particles);
        self.moving_maps.table.finish(particles);
    }

    /// Updates one survivor's map as seen from its pose, reduces it and writes it to fresh pages. Pages out of view
    /// are shared with the parent.
    fn one<X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>>>(
        &mut self,
        task: &Task,
        scan_view: &ScanView<'_, X>,
        eta: &mut [LnSum<T>],
        tally: &mut Tally<T>,
        probe: &mut impl Probe,
    ) {
        let Self { static_maps, moving_maps, .. } = self;
        reset_eta(eta, scan_view.scan);
        let mut seen = Seen::beside(scan_view.view.missed);
        let regained_static = static_maps.collect(task, scan_view, eta, &mut seen, tally);
        let mut both = Workspaces { of_static: &mut static_maps.workspace, of_moving: &mut moving_maps.workspace };
        both.look_at_births(scan_view, eta, &mut seen, tally);
        let regained_moving = moving_maps.collect(task, scan_view, eta, &mut seen, tally);
        tally.expected_detections += seen.expected_detections;
        if self.weighs {
            let ln_likelihood = ln_likelihood(Likelihood::SingleCluster, &scan_view.view, &seen, scan_view.scan, eta);
            tally.last = Weighed { ln_likelihood, in_view: seen.in_view };
        }
        let normalisers = Normalisers::of(eta, scan_view.scan);
        let mut both = Workspaces { of_static: &mut static_maps.workspace, of_moving: &mut moving_maps.workspace };
        let mut noted = Noted::NOTHING;
        both.complete(scan_view, &normalisers, self.next_label, &mut noted, tally, probe);
        static_maps.workspace.count(tally);
        moving_maps.workspace.count(tally);
        let bounds = &scan_view.bounds;
        let Maps { table, pool, workspace } = &mut **static_maps;
        let static_stored = store((table, pool), workspace, task, regained_static, bounds, tally);
        let Maps { table, pool, workspace } = &mut **moving_maps;
        let moving_stored = store((table, pool), workspace, task, regained_moving, bounds, tally);
        self.note_stored(task.particle, noted, static_stored && moving_stored, tally);
    }

    /// Stores a whole draft as [`one`](Self::one) stores what is in the workspaces of the maps. Its fresh labels begin with `first_fresh`.
    fn store_draft(&mut self, draft: &mut Draft<'_, D>, first_fresh: u32, tally: &mut Tally<T>) {
        let Self { static_maps, moving_maps, next_label, .. } = self;
        draft.settle(tally);
        let Draft { of_static, of_moving, task, bounds, labels, .. } = draft;
        // As many fresh labels have been given away before, that the draft knew nothing of.
        let (fresh, given) = (*labels, next_label.wrapping_sub(first_fresh));
        **next_label = next_label.wrapping_add(fresh);
        let rename = |label: &mut u32| {
            if label.wrapping_sub(first_fresh) < fresh {
                *label = label.wrapping_add(given);
            }
        };
        let regained_static = static_maps.put_aside(task, bounds, of_static.aside());
        let regained_moving = moving_maps.put_aside(task, bounds, of_moving.aside());
        of_static.workspace.count(tally);
        of_moving.workspace.count(tally);
        let Maps { table, pool, .. } = &mut **static_maps;
        let static_stored = of_static.store((table, pool), task, regained_static, bounds, rename, tally);
        let Maps { table, pool, .. } = &mut **moving_maps;
        let moving_stored = of_moving.store((table, pool), task, regained_moving, bounds, rename, tally);
        self.note_stored(task.particle, draft.noted, static_stored && moving_stored, tally);
    }

    /// Notes the births that wait, counts a particle's maps as stored or left as predicted, and what has been taken of the capacities.
    fn note_stored(&mut self, particle: usize, noted: Noted<T>, stored: bool, tally: &mut Tally<T>) {
        if let Some(slot) = self.noted.get_mut(particle) {
            *slot = noted;
        }
        let taken = [self.static_maps.taken(particle), self.moving_maps.taken(particle)];
        for (peak, (pages, map_pages)) in tally.peaks.iter_mut().zip(taken) {
            (peak.pages, peak.map_pages) = (peak.pages.max(pages), peak.map_pages.max(map_pages));
        }
        if stored {
            tally.updated += 1;
        } else {
            tally.kept += 1;
        }
    }
}

/// The steps of one map's update, for features of either kind.
impl<T: Real, F: Feature<Position: Place<Scalar = T>>> Maps<'_, F> {
    /// Makes the parent's map the particle's, fills the workspace with what becomes of the components in view, η_z with their
    /// terms, and puts their pages aside. Returns how many of those nobody else holds.
    fn collect<X: MeasurementModel<Pose: Pose<Scalar = T, Position = F::Position>>>(
        &mut self,
        task: &Task,
        scan_view: &ScanView<'_, X>,
        eta: &mut [LnSum<T>],
        seen: &mut Seen<F::Position>,
        tally: &mut Tally<T>,
    ) -> usize {
        self.take_on(task, &scan_view.bounds);
        let Maps { table, pool, workspace } = self;
        workspace.clear(scan_view.config.prune_weight.ln());
        let ln_unconfirmed = scan_view.config.unconfirmed_weight.ln();
        let mut regained = 0;
        table.retain_near(task.particle, |id| {
            let Some(page) = pool.get(id) else { return true };
            let in_view = workspace.look_at_page::<F, X>(page, scan_view, ln_unconfirmed, eta, seen, tally);
            if in_view {
                regained += usize::from(pool.references(id) == 1);
            }
            !in_view
        });
        regained
    }

    /// The same where it is known already which pages are replaced.
    fn put_aside(&mut self, task: &Task, bounds: &Bounds<F::Position>, replaced: &[PageId]) -> usize {
        self.take_on(task, bounds);
        let Maps { table, pool, .. } = self;
        let mut regained = 0;
        let mut replaced = replaced.iter().peekable();
        table.retain_near(task.particle, |id| {
            let is_replaced = replaced.next_if_eq(&&id).is_some();
            if is_replaced {
                regained += usize::from(pool.references(id) == 1);
            }
            !is_replaced
        });
        regained
    }

    /// Makes the parent's map the particle's, and sorts out what is far from its view.
    fn take_on(&mut self, task: &Task, bounds: &Bounds<F::Position>) {
        let Maps { table, pool, .. } = self;
        table.take_on(task.parent, task.particle, task.last_child, pool);
        // What moves does not stay where it was sorted out.
        if !F::MOVES {
            table.sort_out(task.particle, bounds, pool);
        }
    }

    /// Pages of the pool, and those of the particle's updated map, while the scan goes on.
    fn taken(&self, particle: usize) -> (usize, usize) {
        let map_pages = self.table.map_pages().saturating_sub(self.table.room(particle));
        (self.pages_used(), map_pages)
    }
}
