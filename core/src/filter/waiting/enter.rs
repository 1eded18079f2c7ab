//! Delayed births that the scan may have detected enter the maps; the others are missed detections.

use crate::detection::scan::Scan;
use crate::detection::view::Views;
use crate::filter::newborn::Newborn;
use crate::filter::predict_moving::predict_component;
use crate::filter::state::Memory;
use crate::filter::tally::Tally;
use crate::filter::waiting::meet::{Step, compare};
use crate::filter::waiting::memory::{Awaiting, Met, PER_WORD, Waiting, of_sensor};
use crate::map::{Maps, PAGE_LEN, Page, PageId};
use crate::numerics::work;
use crate::{Births, Component, Config, Feature, MeasurementModel, Place, Pose, PositionOf, Real, Symmetric, Vector};

/// Adds the delayed births of the last scan that this scan may have detected to the maps of their particles, with the weights that they
/// would have there. For every particle, sums Σ p_D w of the others, which this scan missed. Afterwards no birth is delayed.
#[inline(never)]
pub(crate) fn enter<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>>(
    config: &Config<T>,
    births: &Births<T>,
    views: &Views<'_, X>,
    scan: &Scan<'_, X::Measurement>,
    memory: &mut Memory<'_, P>,
    tally: &mut Tally<T>,
) {
    memory.waiting.missed.iter_mut().take(memory.cursor.particles).for_each(|missed| *missed = T::ZERO);
    let Awaiting { len, first_label, sensor, .. } = *memory.waiting.awaiting;
    let Some(first) = memory.waiting.awaited.first().filter(|_| len > 0) else { return };
    if of_sensor(views.sensor, &first.measurement()) != Some(sensor) {
        memory.waiting.awaiting.several = true;
        memory.waiting.forget();
        return;
    }
    let intensities = [births.of_static, births.of_moving].map(Real::ln);
    meet_all(config, intensities, views, scan, memory);
    let Memory { cursor, static_maps, moving_maps, waiting, .. } = memory;
    let Waiting { awaited, noted, birthplaces, missed, met, .. } = waiting;
    let awaited = awaited.get(..usize::from(len)).unwrap_or(&[]);
    let ln_floor = config.prune_weight.ln();
    let particles = birthplaces.iter().zip(missed.iter_mut());
    for (particle, (birthplace, missed)) in particles.take(cursor.particles).enumerate() {
        let view = views.from(&birthplace.pose);
        let mut static_map = Entry::new(static_maps, particle);
        let mut moving_map = Entry::new(moving_maps, particle);
        // A word at a time: the index of a bit is then simple.
        let words = noted.births(particle).iter().zip(met.words(particle));
        for (place, ((&births, met), awaited)) in words.zip(awaited.chunks(PER_WORD)).enumerate() {
            for (within, awaited) in awaited.iter().enumerate() {
                work::round();
                let bit = 1 << within;
                if births & bit == 0 {
                    continue;
                }
                let is_met = met.map(|met| met & bit != 0);
                let index = place * PER_WORD + within;
                for (&missed_of, _) in awaited.missed.iter().zip(is_met).filter(|&(_, is_met)| !is_met) {
                    *missed += missed_of;
                }
                if is_met == [false; 2] {
                    continue;
                }
                let mut ln_weights = intensities.map(|ln_intensity| awaited.ln_weight(ln_intensity, ln_floor));
                for (ln_weight, is_met) in ln_weights.iter_mut().zip(is_met) {
                    *ln_weight = ln_weight.filter(|_| is_met);
                }
                let [ln_still, ln_moving] = ln_weights;
                if ln_still.is_none() && ln_moving.is_none() {
                    continue;
                }
                let newborn =
                    Newborn::of(&view, uncertain(&birthplace.covariance), &awaited.measurement::<X::Measurement>());
                let Some(newborn) = newborn else {
                    tally.no_birth += 1;
                    continue;
                };
                tally.repaired += usize::from(newborn.repaired);
                let label = first_label.wrapping_add(index as u32);
                if let Some(ln_weight) = ln_still {
                    tally.lost += usize::from(!static_map.push(&newborn.still(label, ln_weight)));
                }
                if let Some(ln_weight) = ln_moving {
                    let component = newborn.moving(label, ln_weight, config.moving.velocity_sigma_mps);
                    tally.lost += usize::from(!moving_map.push(&component));
                }
            }
        }
    }
    waiting.forget();
}

/// Associates delayed births with the scan: marks for each particle the births that it may have detected again, and sets p_D w of
/// the others for each measurement.
fn meet_all<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>>(
    config: &Config<T>,
    intensities: [T; 2],
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
    let birth_view = views.from(&birthplace.pose);
    let ln_floor = config.prune_weight.ln();
    for (index, awaited) in awaited.iter_mut().take(usize::from(awaiting.len)).enumerate() {
        work::round();
        awaited.missed = [T::ZERO; 2];
        if !noted.is_anywhere(index) {
            continue;
        }
        let (place, bit) = (index / PER_WORD, 1 << (index % PER_WORD));
        let newborn =
            Newborn::of(&birth_view, uncertain(&birthplace.covariance), &awaited.measurement::<X::Measurement>());
        let [ln_still, ln_moving] = intensities.map(|ln_intensity| awaited.ln_weight(ln_intensity, ln_floor));
        let everybody =
            |met: &mut Met<'_>, kind| (0..cursor.particles).for_each(|particle| met.mark(particle, kind, place, bit));
        let Some(newborn) = newborn else {
            // The heaviest particle has no such feature in view, but others may.
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

/// The end of a particle's map: its last page, and new pages behind it.
struct Entry<'a, 's, F: Feature> {
    maps: &'a mut Maps<'s, F>,
    particle: usize,
    /// The last page, once no other map holds it.
    own: Option<PageId>,
}

impl<'a, 's, T: Real, F: Feature<Position: Place<Scalar = T>>> Entry<'a, 's, F> {
    fn new(maps: &'a mut Maps<'s, F>, particle: usize) -> Self {
        Self { maps, particle, own: None }
    }

    /// Adds a component; `false` if there is no room.
    fn push(&mut self, component: &Component<F::State>) -> bool {
        let has_room = |page: &Page<F>| page.components().len() < PAGE_LEN;
        let own = self.own.filter(|&id| self.maps.pool.get(id).is_some_and(has_room));
        self.own = own.or_else(|| self.open());
        let Some(page) = self.own.and_then(|id| self.maps.pool.held(id.index())) else { return false };
        page.push(component);
        true
    }

    /// A page with room at the end of the map that no other map holds.
    #[inline(never)]
    fn open(&mut self) -> Option<PageId> {
        let Maps { table, pool, .. } = &mut *self.maps;
        let (far, _) = table.far(self.particle);
        // Pages that are known to be out of view are not changed.
        let near = table.pages(self.particle).get(far..).unwrap_or(&[]);
        let has_room = |id: PageId| pool.get(id).is_some_and(|page| page.components().len() < PAGE_LEN);
        match near.last().copied().filter(|&last| has_room(last)) {
            Some(last) if pool.references(last) == 1 => Some(last),
            Some(last) => {
                let id = pool.take_copy(last)?;
                table.replace_last(self.particle, id);
                pool.release(last);
                Some(id)
            }
            None => {
                let (id, page) = pool.take()?;
                page.fill(core::iter::empty());
                if table.push(self.particle, id) {
                    return Some(id);
                }
                pool.release(id);
                None
            }
        }
    }
}
