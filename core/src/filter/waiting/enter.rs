//! Delayed births that the scan may have detected enter the maps; the others are missed detections.

use crate::detection::scan::Scan;
use crate::detection::view::Views;
use crate::filter::newborn::Carried;
use crate::filter::predict_moving::predict_component;
use crate::filter::state::Memory;
use crate::filter::tally::Tally;
use crate::filter::waiting::meet::{Step, compare};
use crate::filter::waiting::memory::{Awaiting, Met, PER_WORD, Waiting, bit};
use crate::map::{Maps, PAGE_LEN, Page, PageId};
use crate::numerics::work;
use crate::{Component, Config, Feature, MeasurementModel, Place, Pose, PositionOf, Real, Symmetric, Vector};
use core::ops::Range;

/// Adds the delayed births of the last scan that this scan may have detected to the maps of their particles, with the weights that they
/// would have there. For every particle, sums Σ p_D w of the others, which this scan missed. Afterwards no birth is delayed.
///
/// The scan may be of another sensor than the last one: where births are does not depend on it.
#[inline(never)]
pub(crate) fn enter<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>>(
    config: &Config<T>,
    views: &Views<'_, X>,
    scan: &Scan<'_, X::Measurement>,
    memory: &mut Memory<'_, P>,
    tally: &mut Tally<T>,
) {
    memory.waiting.missed.iter_mut().take(memory.cursor.particles).for_each(|missed| *missed = T::ZERO);
    if memory.waiting.awaiting.len == 0 {
        return;
    }
    meet_all(config, views, scan, memory);
    let particles = memory.cursor.particles;
    let mut remaining = 0;
    let mut first = 0;
    while first < particles {
        first = family(memory, first).end;
        remaining += 1;
    }
    first = 0;
    while first < particles {
        let family = family(memory, first);
        first = family.end;
        enter_maps(config, family, remaining, memory, tally);
        // In damaged memory there may be more families now.
        remaining = remaining.saturating_sub(1);
    }
    memory.waiting.forget();
}

/// The particles from `first` on that have its delayed births, its pose at their births and the last page of its maps: the copies of
/// one survivor. They share the pages of the births, too.
fn family<T: Real, P: Pose<Scalar = T>>(memory: &Memory<'_, P>, first: usize) -> Range<usize> {
    let Memory { cursor, static_maps, moving_maps, waiting, .. } = memory;
    let twin = |&other: &usize| {
        work::round();
        waiting.birthplaces.get(other) == waiting.birthplaces.get(first)
            && waiting.noted.births(other).iter().eq(waiting.noted.births(first))
            && static_maps.end_alike(first, other)
            && moving_maps.end_alike(first, other)
    };
    let twins = (first + 1..cursor.particles).take_while(twin).count();
    first..first + 1 + twins
}

impl<T: Real, F: Feature<Position: Place<Scalar = T>>> Maps<'_, F> {
    /// Whether two maps have the same last page, and as many pages within and out of view.
    fn end_alike(&self, one: usize, other: usize) -> bool {
        let end = |map: usize| {
            let pages = self.table.pages(map);
            (pages.len(), pages.last(), self.table.far(map).0)
        };
        end(one) == end(other)
    }
}

/// Adds the births that any of these equal particles may have detected to the map that they share. Of `remaining` such families,
/// each may take the same part of the free pages.
fn enter_maps<T: Real, P: Pose<Scalar = T>>(
    config: &Config<T>,
    family: Range<usize>,
    remaining: usize,
    memory: &mut Memory<'_, P>,
    tally: &mut Tally<T>,
) {
    let Memory { static_maps, moving_maps, waiting, .. } = memory;
    let Waiting { awaiting, awaited, noted, birthplaces, missed, met, .. } = waiting;
    let &mut Awaiting { len, first_label, ln_births, ref origin } = *awaiting;
    let Some(birthplace) = birthplaces.get(family.start) else { return };
    let carried = Carried::between(origin, birthplace);
    let ln_floor = config.prune_weight.ln();
    let mut static_map = Entry::new(static_maps, family.clone(), remaining);
    let mut moving_map = Entry::new(moving_maps, family.clone(), remaining);
    let mut of_family = T::ZERO;
    let awaited = awaited.get(..usize::from(len)).unwrap_or(&[]);
    // A word at a time: the index of a bit is then simple.
    for (place, (&births, awaited)) in noted.births(family.start).iter().zip(awaited.chunks(PER_WORD)).enumerate() {
        let met = met.word(family.clone(), place);
        for (within, awaited) in awaited.iter().enumerate() {
            work::round();
            let bit = 1 << within;
            if births & bit == 0 {
                continue;
            }
            let is_met = met.map(|met| met & bit != 0);
            for (&missed_of, _) in awaited.missed.iter().zip(is_met).filter(|&(_, is_met)| !is_met) {
                of_family += missed_of;
            }
            if is_met == [false; 2] {
                continue;
            }
            let mut ln_weights = ln_births.map(|ln_intensity| awaited.ln_weight(ln_intensity, ln_floor));
            for (ln_weight, is_met) in ln_weights.iter_mut().zip(is_met) {
                *ln_weight = ln_weight.filter(|_| is_met);
            }
            let [ln_still, ln_moving] = ln_weights;
            if ln_still.is_none() && ln_moving.is_none() {
                continue;
            }
            let Some(newborn) = awaited.newborn(&carried) else {
                tally.no_birth += 1;
                continue;
            };
            tally.repaired += usize::from(newborn.repaired);
            let label = first_label.wrapping_add((place * PER_WORD + within) as u32);
            if let Some(ln_weight) = ln_still {
                static_map.push(&newborn.still(label, ln_weight));
            }
            if let Some(ln_weight) = ln_moving {
                moving_map.push(&newborn.moving(label, ln_weight, config.moving.velocity_sigma_mps));
            }
        }
    }
    tally.tightened += usize::from(static_map.is_full) + usize::from(moving_map.is_full);
    missed.get_mut(family).unwrap_or(&mut []).fill(of_family);
}

/// Associates delayed births with the scan: marks for each particle the births that it may have detected again, and sets p_D w of
/// the others for each measurement.
fn meet_all<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>>(
    config: &Config<T>,
    views: &Views<'_, X>,
    scan: &Scan<'_, X::Measurement>,
    memory: &mut Memory<'_, P>,
) {
    let Memory { cursor, pose_covariances, candidates, waiting, .. } = memory;
    let Waiting { awaiting, awaited, noted, birthplaces, met, steps, .. } = waiting;
    let (own, children) = (cursor.heaviest, cursor.children.max(1));
    let particle_of = |candidate: usize| candidate.checked_div(children).unwrap_or(0);
    let candidates = candidates.get(..cursor.candidates()).unwrap_or(&[]);
    let birthplaces = birthplaces.get(..cursor.particles).unwrap_or(&[]);
    met.clear();
    let Some((birthplace, candidate)) = birthplaces.get(own).zip(candidates.get(own.saturating_mul(children))) else {
        return;
    };
    let spread = compare(own, birthplaces, candidates, children, steps);
    let step = Step {
        view: views.from(&candidate.pose),
        pose_covariance: pose_covariances.get(own).and_then(uncertain),
        steps: steps.get(..candidates.len()).unwrap_or(&[]),
        spread,
    };
    let carried = Carried::between(&awaiting.origin, birthplace);
    let ln_floor = config.prune_weight.ln();
    let mut anywhere = 0;
    for (index, awaited) in awaited.iter_mut().take(usize::from(awaiting.len)).enumerate() {
        work::round();
        let (place, bit) = (index / PER_WORD, bit(index));
        if index % PER_WORD == 0 {
            anywhere = noted.anywhere(place);
        }
        awaited.missed = [T::ZERO; 2];
        if anywhere & bit == 0 {
            continue;
        }
        let [ln_still, ln_moving] = awaiting.ln_births.map(|ln_intensity| awaited.ln_weight(ln_intensity, ln_floor));
        let everybody =
            |met: &mut Met<'_>, kind| (0..cursor.particles).for_each(|particle| met.mark(particle, kind, place, bit));
        let Some(newborn) = awaited.newborn(&carried) else {
            // Beyond the range of the scalar from here.
            (0..2).for_each(|kind| everybody(met, kind));
            continue;
        };
        let still = ln_still.map(|ln_weight| newborn.still(0, ln_weight));
        // A moving feature whose predicted weight is too small, or whose position is too uncertain, does not even count as
        // missed. For the others the position is sufficient.
        let moving = ln_moving.and_then(|ln_weight| {
            let born = newborn.moving(0, ln_weight, config.moving.velocity_sigma_mps);
            let waited_s = cursor.waited_s;
            let moving = if waited_s > T::ZERO {
                predict_component::<T, PositionOf<P>>(config, ln_floor, waited_s, &born)?
            } else {
                born
            };
            let covariance = moving.covariance.leading();
            Some(Component { label: 0, ln_weight: moving.ln_weight, mean: moving.position(), covariance })
        });
        for (kind, (birth, slot)) in [still, moving].iter().zip(&mut awaited.missed).enumerate() {
            let Some(birth) = birth else { continue };
            match step.meet(birth, scan, ln_floor, |candidate| met.mark(particle_of(candidate), kind, place, bit)) {
                Some(missed) => *slot = missed,
                None => everybody(met, kind),
            }
        }
    }
}

/// The covariance of a pose; `None` if it is zero.
fn uncertain<K: Vector>(covariance: &Symmetric<K>) -> Option<&Symmetric<K>> {
    Some(covariance).filter(|&covariance| *covariance != Symmetric::ZERO)
}

/// The end of the map that a family of particles shares: its last page, and new pages behind it.
struct Entry<'a, 's, F: Feature> {
    maps: &'a mut Maps<'s, F>,
    family: Range<usize>,
    /// Number of pages that may be taken.
    room: usize,
    /// The last page, once no other map holds it.
    own: Option<PageId>,
    /// Whether a component had no room.
    is_full: bool,
}

impl<'a, 's, T: Real, F: Feature<Position: Place<Scalar = T>>> Entry<'a, 's, F> {
    fn new(maps: &'a mut Maps<'s, F>, family: Range<usize>, remaining: usize) -> Self {
        let room = maps.pool.free().checked_div(remaining).unwrap_or(0);
        Self { maps, family, room, own: None, is_full: false }
    }

    /// Adds a component if there is room.
    fn push(&mut self, component: &Component<F::State>) {
        let has_room = |page: &Page<F>| page.components().len() < PAGE_LEN;
        let own = self.own.filter(|&id| self.maps.pool.get(id).is_some_and(has_room));
        self.own = own.or_else(|| self.open());
        match self.own.and_then(|id| self.maps.pool.held(id.index())) {
            Some(page) => page.push(component),
            None => self.is_full = true,
        }
    }

    /// A page with room at the end of the map that no map of another family holds.
    #[inline(never)]
    fn open(&mut self) -> Option<PageId> {
        let Self { maps: Maps { table, pool, .. }, family, room, .. } = self;
        let (far, _) = table.far(family.start);
        // Pages that are known to be out of view are not changed.
        let pages = table.pages(family.start);
        let near = pages.get(far..).unwrap_or(&[]);
        let has_room = |id: PageId| pool.get(id).is_some_and(|page| page.components().len() < PAGE_LEN);
        let last = near.last().copied().filter(|&last| has_room(last));
        if let Some(last) = last
            && usize::from(pool.references(last)) == family.len()
        {
            return Some(last);
        }
        if last.is_none() && pages.len() >= table.map_pages() {
            return None;
        }
        *room = room.checked_sub(1)?;
        let id = match last {
            Some(last) => pool.take_copy(last)?,
            None => {
                let (id, page) = pool.take()?;
                page.fill(core::iter::empty());
                id
            }
        };
        for particle in family.clone() {
            if particle != family.start {
                pool.share(id);
            }
            match last {
                Some(last) => {
                    table.replace_last(particle, id);
                    pool.release(last);
                }
                // The map has room for it, as checked above.
                None => _ = table.push(particle, id),
            }
        }
        Some(id)
    }
}
