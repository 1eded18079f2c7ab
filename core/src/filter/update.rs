//! The update of the survivors' maps (5.17–5.22), after their weights are known.

use crate::detection::explain::ln_likelihood;
use crate::detection::normalise::Normalisers;
use crate::detection::seen::{Seen, Weighed, reset_eta};
use crate::filter::draft::{Draft, Renaming};
use crate::filter::store::store;
use crate::filter::survivor::{ScanView, Workspaces};
use crate::filter::tally::Tally;
use crate::filter::task::Task;
use crate::filter::waiting::memory::{Noted, Notes};
use crate::map::{Maps, PageId};
use crate::numerics::work;
use crate::{Bounds, Dynamic, Feature, LnSum, MeasurementModel, Place, Pose, Probe, Real, Static};

/// All maps of both kinds, and the other data that updates change.
#[derive(Debug)]
pub(crate) struct Update<'a, 's, D: Place> {
    pub(crate) static_maps: &'a mut Maps<'s, Static<D>>,
    pub(crate) moving_maps: &'a mut Maps<'s, Dynamic<D>>,
    /// Whether the likelihood of the scan for the last survivor is computed too.
    pub(crate) weighs: bool,
    /// The first free label.
    pub(crate) next_label: &'a mut u32,
    /// Delayed births.
    pub(crate) noted: Notes<'a, D::Scalar>,
    pub(crate) tally: &'a mut Tally<D::Scalar>,
}

/// Map updates: every particle gets the updated map of the survivor it continues; maps without a survivor are freed.
///
/// Copies of one survivor share its map. The last child of a parent reuses the parent's map, so that without resampling every map
/// is updated in place, and components out of view are not copied.
impl<T: Real, D: Place<Scalar = T>> Update<'_, '_, D> {
    /// Frees the maps of `parents` that are not in `alive`, which is in ascending order.
    pub(crate) fn begin(&mut self, parents: usize, alive: impl Iterator<Item = usize>) {
        let pages = [self.static_maps.pages_used(), self.moving_maps.pages_used()];
        for (peak, pages) in self.tally.peaks.iter_mut().zip(pages) {
            peak.pages = pages;
        }
        self.static_maps.table.begin(parents);
        self.moving_maps.table.begin(parents);
        let mut alive = alive.peekable();
        for parent in 0..parents {
            if alive.next_if_eq(&parent).is_none() {
                self.static_maps.table.let_go(parent, &mut self.static_maps.pool);
                self.moving_maps.table.let_go(parent, &mut self.moving_maps.pool);
            }
            while alive.next_if_eq(&parent).is_some() {
                work::round();
            }
        }
    }

    /// Makes the copies of a survivor share its map.
    pub(crate) fn share(&mut self, task: &Task) {
        for twin in 1..task.copies {
            let Self { static_maps, moving_maps, .. } = self;
            self.noted.copy(task.particle, task.particle + twin);
            static_maps.table.share_updated(task.particle, task.particle + twin, &mut static_maps.pool);
            moving_maps.table.share_updated(task.particle, task.particle + twin, &mut moving_maps.pool);
        }
    }

    /// Makes the updated maps those of the particles.
    pub(crate) fn finish(&mut self, particles: usize) {
        self.static_maps.table.finish(particles);
        self.moving_maps.table.finish(particles);
    }

    /// Updates one survivor's map as seen from its pose, reduces it and writes it to new pages. Pages out of view are shared with
    /// the parent.
    pub(crate) fn one<X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>>>(
        &mut self,
        task: &Task,
        scan_view: &ScanView<'_, X>,
        eta: &mut [LnSum<T>],
        probe: &mut impl Probe,
    ) {
        let Self { static_maps, moving_maps, .. } = self;
        let mut own = Tally::new();
        let tally = &mut own;
        reset_eta(eta, scan_view.scan);
        let mut seen = Seen::with_missed(scan_view.view.missed);
        let regained_static = static_maps.collect(task, scan_view, eta, &mut seen, tally);
        let mut both = Workspaces { of_static: &mut static_maps.workspace, of_moving: &mut moving_maps.workspace };
        both.add_expected_births(scan_view, eta, &mut seen, tally);
        let regained_moving = moving_maps.collect(task, scan_view, eta, &mut seen, tally);
        tally.expected_detections += seen.expected_detections;
        if self.weighs {
            let ln_likelihood = ln_likelihood(&seen, scan_view.scan, eta);
            self.tally.last = Weighed { ln_likelihood, in_view: seen.in_view };
        }
        let normalisers = Normalisers::of(eta, scan_view.scan);
        let mut both = Workspaces { of_static: &mut static_maps.workspace, of_moving: &mut moving_maps.workspace };
        let mut noted = Noted::NOTHING;
        both.complete(scan_view, &normalisers, self.next_label, &mut noted, tally, probe);
        static_maps.workspace.count(tally);
        moving_maps.workspace.count(tally);
        let tally = &mut *self.tally;
        tally.add(&own);
        let bounds = &scan_view.bounds;
        let Maps { table, pool, workspace } = &mut **static_maps;
        let static_stored = store((table, pool), workspace, task, regained_static, bounds, tally);
        let Maps { table, pool, workspace } = &mut **moving_maps;
        let moving_stored = store((table, pool), workspace, task, regained_moving, bounds, tally);
        self.note_stored(task.particle, &noted, static_stored && moving_stored);
    }

    /// Stores a complete draft, as [`one`](Self::one) stores the workspaces. Its new labels begin with `first_fresh`.
    pub(crate) fn store_draft(&mut self, draft: &mut Draft<'_, D>, first_fresh: u32) {
        let Self { static_maps, moving_maps, next_label, tally, .. } = self;
        let tally = &mut **tally;
        tally.add(&draft.tally);
        // Previous drafts have used this number of new labels.
        draft.renaming =
            Renaming { first_fresh, fresh: draft.labels, label_offset: next_label.wrapping_sub(first_fresh) };
        **next_label = next_label.wrapping_add(draft.labels);
        let Draft { of_static, of_moving, task, bounds, renaming, .. } = draft;
        let regained_static = static_maps.mark_replaced(task, bounds, of_static.replaced());
        let regained_moving = moving_maps.mark_replaced(task, bounds, of_moving.replaced());
        let Maps { table, pool, .. } = &mut **static_maps;
        let static_stored = of_static.place((table, pool), task, regained_static, bounds, renaming, tally);
        let Maps { table, pool, .. } = &mut **moving_maps;
        let moving_stored = of_moving.place((table, pool), task, regained_moving, bounds, renaming, tally);
        self.note_stored(task.particle, &draft.noted, static_stored && moving_stored);
    }

    /// Stores delayed births, counts a particle's maps as stored or left as predicted, and updates the peaks of the capacities.
    fn note_stored(&mut self, particle: usize, noted: &Noted<T>, stored: bool) {
        self.noted.set(particle, noted);
        let taken = [self.static_maps.taken(particle), self.moving_maps.taken(particle)];
        for (peak, (pages, map_pages)) in self.tally.peaks.iter_mut().zip(taken) {
            (peak.pages, peak.map_pages) = (peak.pages.max(pages), peak.map_pages.max(map_pages));
        }
        if stored {
            self.tally.updated += 1;
        } else {
            self.tally.kept += 1;
        }
    }
}

/// The steps of one map's update, for features of either kind.
impl<T: Real, F: Feature<Position: Place<Scalar = T>>> Maps<'_, F> {
    /// Makes the parent's map that of the particle, fills the workspace with its updated components in view, adds their terms to
    /// η_z, and marks their pages as replaced. Returns the number of these pages that no other map holds.
    fn collect<X: MeasurementModel<Pose: Pose<Scalar = T, Position = F::Position>>>(
        &mut self,
        task: &Task,
        scan_view: &ScanView<'_, X>,
        eta: &mut [LnSum<T>],
        seen: &mut Seen<T>,
        tally: &mut Tally<T>,
    ) -> usize {
        self.inherit(task, &scan_view.bounds);
        let Maps { table, pool, workspace } = self;
        workspace.clear(scan_view.config.prune_weight.ln());
        let ln_unconfirmed = scan_view.config.unconfirmed_weight.ln();
        let mut regained = 0;
        table.retain_near(task.particle, |id| {
            let Some(page) = pool.get(id) else { return true };
            let in_view = workspace.update_page::<F, X>(page, scan_view, ln_unconfirmed, eta, seen, tally);
            if in_view {
                regained += usize::from(pool.references(id) == 1);
            }
            !in_view
        });
        regained
    }

    /// As [`collect`](Self::collect), with known pages to replace.
    fn mark_replaced(&mut self, task: &Task, bounds: &Bounds<F::Position>, replaced: &[PageId]) -> usize {
        self.inherit(task, bounds);
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

    /// Makes the parent's map that of the particle, and sorts pages far from the view to the front.
    fn inherit(&mut self, task: &Task, bounds: &Bounds<F::Position>) {
        let Maps { table, pool, .. } = self;
        table.inherit(task.parent, task.particle, task.last_child, pool);
        // Pages of moving features would not stay out of view.
        if !F::MOVES {
            table.sort_out(task.particle, bounds, pool);
        }
    }

    /// Number of pages in use in the pool, and in the particle's updated map.
    fn taken(&self, particle: usize) -> (usize, usize) {
        let map_pages = self.table.map_pages().saturating_sub(self.table.room(particle));
        (self.pages_used(), map_pages)
    }
}
