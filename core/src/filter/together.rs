//! The sequential parts of a scan, divided among any number of threads: for a GPU.
//!
//! Each thread writes its own elements of the [lent](Scanning::lend_particles) arrays, and reads the others. All sums have the
//! order of [`ScPhd::scan`](crate::ScPhd::scan), so that the results have the same bits.

use crate::filter::context::ScanContext;
use crate::filter::draft::{Draft, Renaming};
use crate::filter::scanning::Scanning;
use crate::filter::stages::{ParticleLayout, Weighing, informed};
use crate::filter::state::Memory;
use crate::filter::task::Task;
use crate::map::{Lists, Row};
use crate::numerics::ln_sum::ln_sum;
use crate::numerics::work;
use crate::particles::candidate::{Candidate, PartSums, ln_products, ln_rest, multiply, sum_up};
use crate::particles::predict::child_of;
use crate::particles::propose::{Family, Proposer};
use crate::particles::resample::{one_child, position};
use crate::{
    CovarianceOf, Dynamic, LnSum, MeasurementModel, Noise, Page, PageId, Place, Pose, PositionOf, Real, ScalarOf,
    Static, Vector,
};

/// The arrays of all candidates and particles.
#[derive(Debug)]
pub struct Lent<'s, P: Pose> {
    /// The candidates.
    pub candidates: &'s mut [Candidate<P>],
    /// Their ln L.
    pub ln_likelihoods: &'s mut [ScalarOf<P>],
    /// The selected candidates, one for each particle.
    pub selected: &'s mut [Candidate<P>],
    /// Their indices.
    pub survivors: &'s mut [u16],
    /// The covariance of every particle's pose.
    pub pose_covariances: &'s mut [CovarianceOf<P>],
    /// The covariances of the selected candidates.
    pub selected_covariances: &'s mut [CovarianceOf<P>],
}

/// The lists of the pages of all static maps, and of all moving ones.
pub type AllLists<'s, D> = (Lists<'s, Static<D>>, Lists<'s, Dynamic<D>>);

/// Pages that were allocated, and their content.
pub type Placed<'d, F> = (&'d [PageId], &'d [Page<F>]);

/// Number of sums over a map update.
pub const TERMS: usize = 8;
/// Number of counts of a map update.
pub const COUNTS: usize = 6;

impl<'a, 's, T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P> + 'a> Scanning<'a, 's, X> {
    /// Hands over the arrays of candidates and particles.
    pub fn lend_particles(&mut self) -> Lent<'s, P> {
        use core::mem::take;
        let memory = &mut *self.memory;
        Lent {
            candidates: take(&mut memory.candidates),
            ln_likelihoods: take(&mut memory.ln_likelihoods),
            selected: take(&mut memory.selected),
            survivors: take(&mut memory.survivors),
            pose_covariances: take(&mut memory.pose_covariances),
            selected_covariances: take(&mut memory.selected_covariances),
        }
    }

    /// Takes the arrays back.
    pub fn give_particles_back(&mut self, lent: Lent<'s, P>) {
        let memory = &mut *self.memory;
        memory.candidates = lent.candidates;
        memory.ln_likelihoods = lent.ln_likelihoods;
        memory.selected = lent.selected;
        memory.survivors = lent.survivors;
        memory.pose_covariances = lent.pose_covariances;
        memory.selected_covariances = lent.selected_covariances;
    }

    /// Number of particles, and number of candidates of each.
    pub fn particles(&self) -> [usize; 2] {
        [self.layout.particles, self.layout.children]
    }

    /// Begins the informed proposal, whose candidates [`propose_one`](Self::propose_one) samples. Returns how many random numbers those
    /// of a particle take; 0 if there is no such proposal.
    pub fn begin_proposal(&mut self) -> usize {
        let config = self.context.config;
        if informed(config, self.memory.cursor.predicted).is_none() {
            return 0;
        }
        self.memory.cursor.children = config.samples;
        self.layout = ParticleLayout::of(config, self.memory.cursor);
        config.samples * P::Tangent::DIMENSION
    }

    /// Samples the candidates of one particle, and sets the term of each ln L that corrects for the proposal density, which is zero
    /// before. `noise` is the random stream at their numbers. Returns whether the draft's memory was too small.
    pub fn propose_one(
        &self,
        particle: &Candidate<P>,
        family: Family<'_, P>,
        draft: &mut Draft<'_, PositionOf<P>>,
        eta: &mut [LnSum<T>],
        noise: &mut Noise,
    ) -> bool {
        let ScanContext { config, scan, .. } = &self.context;
        let Memory { cursor, static_maps, moving_maps, .. } = &*self.memory;
        let Some(informed) = informed(config, cursor.predicted) else { return false };
        family.candidates.fill(child_of(particle, T::from_usize(config.samples).ln()));
        let proposer = Proposer {
            informed,
            ln_floor: config.prune_weight.ln(),
            views: &self.context.views(),
            of_static: (&static_maps.table, &static_maps.pool),
            of_moving: (&moving_maps.table, &moving_maps.pool),
            scan,
        };
        proposer.one(family, (&mut draft.of_static.workspace, &mut draft.of_moving.workspace, eta), noise)
    }

    /// Stores the number of particles whose proposal had too little memory.
    pub fn proposed(&mut self, crowded: usize) {
        self.crowded = crowded;
    }

    /// ln Σ ζ L over a range of candidates with these ln L.
    #[must_use]
    pub fn ln_products(&self, candidates: &[Candidate<P>], ln_likelihoods: &[T]) -> T {
        ln_products(candidates, ln_likelihoods)
    }

    /// Stores the evidence, the sum over all parts (5.23), and the greatest |V| of all candidates.
    pub fn weigh_up(&mut self, ln_parts: impl Iterator<Item = T>, in_view: usize) {
        let total = ln_sum(ln_parts);
        let ln_evidence = if total.is_finite() { total } else { T::NEG_INFINITY };
        self.weighing = Weighing { ln_evidence, in_view, ..Weighing::NONE };
    }

    /// Multiplies the weights of a range of candidates by their likelihoods. Returns ln Σ ζ over the range.
    pub fn multiply(&self, candidates: &mut [Candidate<P>], ln_likelihoods: &[T]) -> T {
        let ln_evidence = self.weighing.ln_evidence;
        if ln_evidence.is_finite() { multiply(candidates, ln_likelihoods, ln_evidence) } else { T::ZERO }
    }

    /// ln of the remaining normalisation constant of all weights.
    pub fn rest(&self, ln_parts: impl Iterator<Item = T>) -> T {
        let rest = if self.weighing.ln_evidence.is_finite() { ln_rest(ln_parts) } else { None };
        rest.unwrap_or(T::ZERO)
    }

    /// Divides the weights of a range of candidates by `rest`, and writes their cumulative sums.
    pub fn sum_up(&self, candidates: &mut [Candidate<P>], rest: T, cumulated: &mut [T]) -> PartSums<T> {
        sum_up(candidates, rest, cumulated)
    }

    /// Decides from Σ ζ² of all parts whether to resample. Returns the uniform random number of the systematic resampling if so.
    pub fn decide(&mut self, squares: impl Iterator<Item = T>) -> Option<T> {
        let n_eff = T::ONE / squares.fold(T::ZERO, |sum, of_part| sum + of_part);
        self.weighing.n_eff = n_eff;
        self.selection.resampled =
            n_eff < self.context.config.resample_threshold * T::from_usize(self.layout.candidates());
        self.selection.resampled.then(|| self.noise.uniform())
    }

    /// The random stream.
    pub fn noise(&mut self) -> &mut Noise {
        &mut self.noise
    }

    /// The candidate that a particle continues after resampling: the first whose cumulative weight, `reached`, exceeds the position
    /// of the particle, or the last with a weight above 0.
    pub fn draw(
        &self,
        place: usize,
        uniform: T,
        candidates: &[Candidate<P>],
        reached: impl Fn(usize) -> T,
        last: usize,
    ) -> Option<(u16, Candidate<P>)> {
        let particles = T::from_usize(self.layout.particles);
        let position = position(place, uniform, particles);
        let (mut low, mut high) = (0, self.layout.candidates());
        while low < high {
            work::round();
            let middle = low + (high - low) / 2;
            if reached(middle) > position {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        let index = if low < self.layout.candidates() { low } else { last };
        let candidate = *candidates.get(index)?;
        Some((index as u16, Candidate { ln_weight: -particles.ln(), ..candidate }))
    }

    /// The candidate that a particle continues without resampling: one of its own, drawn with the next random number if it has
    /// several.
    pub fn draw_own(
        &self,
        place: usize,
        candidates: &[Candidate<P>],
        noise: Option<&mut Noise>,
    ) -> Option<(u16, Candidate<P>)> {
        let first = place * self.layout.children;
        let members = candidates.get(first..first + self.layout.children)?;
        let (child, ln_weight) = match (members, noise) {
            ([only], _) => (0, only.ln_weight),
            (_, noise) => one_child(members, noise?.uniform()),
        };
        let index = first + child;
        Some((index as u16, Candidate { ln_weight, ..*candidates.get(index)? }))
    }

    /// The particle that a candidate comes from.
    #[must_use]
    pub fn parent_of(&self, candidate: usize) -> usize {
        self.layout.parent_of(candidate)
    }

    /// The indices of the candidates that the particles continue.
    pub fn survivors(&self) -> &[u16] {
        self.memory.survivors.get(..self.layout.particles).unwrap_or(&[])
    }

    /// Begins the update after the selection, with the heaviest of the selected candidates and the number of distinct ones. Maps
    /// without a survivor are not freed yet.
    pub fn selected(&mut self, heaviest: usize, distinct: usize) {
        self.selection.heaviest = heaviest;
        self.open_update(distinct);
    }

    /// Assigns to a draft the task of the distinct survivor `number`, whose first copy is `particle`.
    pub fn assign_one(&self, draft: &mut Draft<'_, PositionOf<P>>, (number, particle): (usize, usize)) {
        let mut alike =
            self.memory.survivors.iter().skip(particle).take(self.layout.particles.saturating_sub(particle));
        let Some(&survivor) = alike.next() else { return };
        let parent = self.layout.parent_of(usize::from(survivor));
        let (mut copies, mut last_child) = (1, true);
        for &other in alike {
            work::round();
            if other != survivor {
                last_child = self.layout.parent_of(usize::from(other)) != parent;
                break;
            }
            copies += 1;
        }
        let remaining = self.tally.survivors.saturating_sub(number);
        let reserved = self.reserved();
        draft.begin(Task { survivor, parent, particle, copies, last_child, remaining, reserved });
    }

    /// Finds the pages that the updated maps of a [made](Self::make) draft keep.
    pub fn line_up(&self, draft: &mut Draft<'_, PositionOf<P>>) {
        let Draft { of_static, of_moving, task, bounds, .. } = draft;
        let only_child = task.last_child && self.is_first_child(task);
        let Memory { static_maps, moving_maps, .. } = &*self.memory;
        of_static.line_up((&static_maps.table, &static_maps.pool), task.parent, only_child, bounds);
        of_moving.line_up((&moving_maps.table, &moving_maps.pool), task.parent, only_child, bounds);
    }

    /// Whether no earlier survivor has the same parent.
    fn is_first_child(&self, task: &Task) -> bool {
        let before = task.particle.checked_sub(1).and_then(|before| self.memory.survivors.get(before));
        before.is_none_or(|&before| self.layout.parent_of(usize::from(before)) != task.parent)
    }

    /// Free pages of either kind.
    pub fn free_pages(&self) -> [usize; 2] {
        [self.memory.static_maps.pool.free(), self.memory.moving_maps.pool.free()]
    }

    /// Whether drafts can be stored in parallel.
    pub fn stores_together(&self) -> bool {
        self.update_context.births_wait == 0 && !self.layout.single_candidate
    }

    /// Stores all drafts one after the other, and [ends](Self::end_update) the update.
    pub fn store_in_turn(&mut self, drafts: &mut [Draft<'_, PositionOf<P>>], eta: &mut [LnSum<T>]) {
        self.free_unneeded();
        let first_fresh = self.next_label();
        for draft in drafts {
            self.store(draft, first_fresh, eta, &mut ());
        }
        self.end_update();
    }

    /// Hands over the page lists of all maps, and the lists of free pages.
    pub fn lend_lists(&mut self) -> AllLists<'s, PositionOf<P>> {
        (self.memory.static_maps.lend_lists(), self.memory.moving_maps.lend_lists())
    }

    /// Takes the lists back, with the number of free pages of either kind.
    pub fn give_lists_back(
        &mut self,
        (of_static, of_moving): AllLists<'s, PositionOf<P>>,
        [free, free_moving]: [usize; 2],
    ) {
        self.memory.static_maps.give_lists_back(of_static, free);
        self.memory.moving_maps.give_lists_back(of_moving, free_moving);
    }

    /// Adds the sums, counts and peaks of all drafts: for each kind of maps components in view and pages; and the number of new
    /// labels.
    pub fn count(&mut self, terms: [T; TERMS], counts: [usize; COUNTS], peaks: [[usize; 2]; 2], labels: u32) {
        let [pruned, innovation, weight, expected, known, known_expected, missed, detected] = terms;
        let tally = &mut self.tally;
        tally.pruned_mass = pruned;
        tally.innovation = (innovation, weight);
        tally.expected_detections = expected;
        (tally.known.weight, tally.known.expected) = (known, known_expected);
        (tally.known.missed, tally.known.detected) = (missed, detected);
        let [merged, births, repaired, no_birth, tightened, lost] = counts;
        (tally.merged, tally.births, tally.repaired, tally.no_birth) = (merged, births, repaired, no_birth);
        tally.tightened += tightened;
        tally.lost += lost;
        tally.updated = tally.survivors;
        let used = [self.memory.static_maps.pages_used(), self.memory.moving_maps.pages_used()];
        for ((peak, [in_view, map_pages]), used) in tally.peaks.iter_mut().zip(peaks).zip(used) {
            (peak.in_view, peak.map_pages, peak.pages) = (in_view, map_pages, used);
        }
        tally.add_delayed_births(&self.delayed_births);
        let next = &mut self.memory.cursor.next_label;
        *next = next.wrapping_add(labels);
    }
}

impl<T: Real, D: Place<Scalar = T>> Draft<'_, D> {
    /// The particle that gets the updated maps, and the number of particles that share them.
    pub fn particles(&self) -> [usize; 2] {
        [self.task.particle, self.task.copies]
    }

    /// The sums over the components, in the order of [`Scanning::count`].
    pub fn terms(&self) -> [T; TERMS] {
        let tally = &self.tally;
        let ((innovation, weight), known) = (tally.innovation, tally.known);
        [
            tally.pruned_mass, innovation, weight, tally.expected_detections, known.weight, known.expected,
            known.missed, known.detected,
        ]
    }

    /// The counts, and the most components in view of either kind of maps.
    #[must_use]
    pub fn counts(&self) -> ([usize; COUNTS], [usize; 2]) {
        let tally = &self.tally;
        let counts = [tally.merged, tally.births, tally.repaired, tally.no_birth, tally.tightened, tally.lost];
        (counts, tally.peaks.map(|peak| peak.in_view))
    }

    /// Number of new labels.
    pub fn labels(&self) -> u32 {
        self.labels
    }

    /// For either map, the number of pages it allocates, and of pages it frees as their only owner.
    pub fn pages(&self) -> [[usize; 2]; 2] {
        [[self.of_static.pages_len, self.of_static.regained], [self.of_moving.pages_len, self.of_moving.regained]]
    }

    /// The pages of the updated maps.
    pub fn map_pages(&self) -> [usize; 2] {
        [self.of_static.row_len, self.of_moving.row_len]
    }

    /// Number of maps that are still to be updated at this one.
    pub fn remaining(&self) -> usize {
        self.task.remaining
    }

    /// Whether the update is complete and fits into a map, if there are enough pages.
    pub fn is_ready(&self) -> bool {
        self.is_whole && self.of_static.fits_row() && self.of_moving.fits_row()
    }

    /// Pages that the maps reuse.
    pub fn kept(&self) -> (&[PageId], &[PageId]) {
        (self.of_static.row(), self.of_moving.row())
    }

    /// Allocates pages for the updated maps, and sets where their new labels begin: `label_offset` new labels of previous drafts
    /// come first.
    pub fn take(
        &mut self,
        first_fresh: u32,
        label_offset: u32,
        take_static: impl FnMut(usize) -> Option<PageId>,
        take_moving: impl FnMut(usize) -> Option<PageId>,
    ) {
        self.renaming = Renaming { first_fresh, fresh: self.labels, label_offset };
        self.of_static.take(take_static);
        self.of_moving.take(take_moving);
    }

    /// Assigns the final values to the new labels.
    pub fn rename(&mut self) {
        self.of_static.rename(&self.renaming);
        self.of_moving.rename(&self.renaming);
    }

    /// The allocated pages, and their content.
    #[must_use]
    pub fn placed(&self) -> (Placed<'_, Static<D>>, Placed<'_, Dynamic<D>>) {
        (self.of_static.placed(), self.of_moving.placed())
    }

    /// Writes the page lists of the updated maps.
    pub fn write_rows(
        &self,
        (ids, head): (&mut [PageId], &mut Row<D>),
        (moving_ids, moving_head): (&mut [PageId], &mut Row<D>),
    ) {
        self.of_static.write_row(ids, head);
        self.of_moving.write_row(moving_ids, moving_head);
    }
}
