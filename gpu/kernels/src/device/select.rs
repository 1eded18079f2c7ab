//! The stages from the weighed candidates to the drafts of their maps. Sums are computed in parts, and one thread adds the parts
//! up. Lent data is either written by the single thread at its place, or only read.

use super::group::{Group, part, whole};
use super::room::Lending;
use crate::memory::Particles;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::Ordering;
use scphd::storage::{PART, PartSums};

/// Safety: the ln L are only read.
pub(super) unsafe fn products<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    if let Some(part) = part(place, between.scanning.candidates()) {
        let ln_likelihoods = between.lent.ln_likelihoods.some(part.clone());
        (*group.parts.add(place)).ln = between.scanning.ln_products(between.lent.candidates.some(part), ln_likelihoods);
    }
}

/// Computes the evidence. Safety: no other thread runs.
pub(super) unsafe fn evidence<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some(between) = group.alone() else { return };
    let in_view = (*group.room).in_view.load(Ordering::Relaxed);
    let scanning = &mut between.scanning;
    let all = group.all_parts(scanning.candidates());
    scanning.proposed(whole(between.short.load(Ordering::Relaxed)));
    scanning.weigh_up(all.iter().map(|part| part.ln), whole(in_view));
}

/// Safety: only this thread uses the candidates of the part.
pub(super) unsafe fn multiply<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    if let Some(part) = part(place, between.scanning.candidates()) {
        let ln_likelihoods = between.lent.ln_likelihoods.some(part.clone());
        (*group.parts.add(place)).ln = between.scanning.multiply(between.lent.candidates.some(part), ln_likelihoods);
    }
}

/// Safety: no other thread runs.
pub(super) unsafe fn rest<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some(between) = group.alone() else { return };
    let all = group.all_parts(between.scanning.candidates());
    between.rest = between.scanning.rest(all.iter().map(|part| part.ln));
}

/// Safety: only this thread uses the candidates and the cumulative sums of the part.
pub(super) unsafe fn cumulate<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    if let Some(part) = part(place, between.scanning.candidates()) {
        let first = part.start;
        let cumulated = from_raw_parts_mut(group.cumulated.add(first), part.len());
        let of_part = between.lent.candidates.some(part);
        let PartSums { squares, weight, last } = between.scanning.sum_up(of_part, between.rest, cumulated);
        let part = &mut *group.parts.add(place);
        (part.squares, part.weight) = (squares, weight);
        part.last = last.map_or(0, |last| (first + last) as u32 + 1);
    }
}

/// Decides whether to resample. Safety: no other thread runs.
pub(super) unsafe fn decide<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some(between) = group.alone() else { return };
    let scanning = &mut between.scanning;
    let all = group.all_parts(scanning.candidates());
    let (mut before, mut last) = (0.0, 0);
    for part in all.iter_mut() {
        part.before = before;
        before += part.weight;
        last = last.max(part.last);
    }
    between.last = whole(last.saturating_sub(1));
    between.uniform = scanning.decide(all.iter().map(|part| part.squares));
    let [particles, children] = scanning.particles();
    if between.uniform.is_none() && children > 1 {
        between.noise = Some(scanning.noise().clone());
        scanning.noise().skip(particles);
    }
}

/// Safety: candidates are only read; each thread writes the selection at its place.
pub(super) unsafe fn draw<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between().filter(|between| place < between.scanning.particles()[0]) else { return };
    let (scanning, [_, children]) = (&between.scanning, between.scanning.particles());
    let candidates = between.lent.candidates.all();
    let drawn = if let Some(uniform) = between.uniform {
        let cumulated = from_raw_parts(group.cumulated, scanning.candidates());
        let all = group.all_parts(scanning.candidates());
        let reached = |candidate: usize| {
            let before = all.get(candidate / PART).map_or(0.0, |part| part.before);
            before + cumulated.get(candidate).copied().unwrap_or(0.0)
        };
        scanning.draw(place, uniform, candidates, reached, between.last)
    } else {
        let mut noise = between.noise.clone().filter(|_| children > 1);
        noise.iter_mut().for_each(|noise| noise.skip(place));
        scanning.draw_own(place, candidates, noise.as_mut())
    };
    let lent = &between.lent;
    if let Some((survivor, candidate)) = drawn
        && let Some(slot) = lent.survivors.one(place)
        && let Some(selected) = lent.selected.one(place)
    {
        (*slot, *selected) = (survivor, candidate);
        let parent = scanning.parent_of(usize::from(survivor));
        if let Some(selected) = lent.selected_covariances.one(place)
            && let Some(covariance) = lent.pose_covariances.all().get(parent)
        {
            *selected = *covariance;
        }
    }
}

/// Counts the survivors of a part that differ from the preceding one, and finds the heaviest. Safety: everything except the part
/// itself is only read.
pub(super) unsafe fn runs<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    let [particles, _] = between.scanning.particles();
    let (candidates, survivors) = (between.lent.candidates.all(), between.lent.survivors.all());
    let Some(range) = part(place, particles) else { return };
    let part = &mut *group.parts.add(place);
    (part.heads, part.heaviest, part.heaviest_ln_weight) = (0, 0, f32::NEG_INFINITY);
    let mut before = range.start.checked_sub(1).and_then(|before| survivors.get(before));
    for (particle, survivor) in survivors.iter().enumerate().take(range.end).skip(range.start) {
        part.heads += u32::from(before != Some(survivor));
        before = Some(survivor);
        if let Some(candidate) = candidates.get(usize::from(*survivor))
            && candidate.ln_weight > part.heaviest_ln_weight
        {
            (part.heaviest, part.heaviest_ln_weight) = (particle as u32, candidate.ln_weight);
        }
    }
}

/// Safety: no other thread runs; the arrays that `open` has lent are given back.
pub(super) unsafe fn settle<M: Particles>(_place: usize, group: &Group<'_, M>) {
    let Some(between) = group.alone() else { return };
    let [particles, _] = between.scanning.particles();
    let (mut heaviest, mut ln_weight, mut distinct) = (0, f32::NEG_INFINITY, 0);
    for part in group.all_parts(particles) {
        if part.heaviest_ln_weight > ln_weight {
            (heaviest, ln_weight) = (part.heaviest, part.heaviest_ln_weight);
        }
        (part.heads, distinct) = (distinct, distinct + part.heads);
    }
    between.scanning.give_particles_back(between.lent.back());
    between.lent = Lending::NONE;
    between.scanning.selected(whole(heaviest), whole(distinct));
    between.first_fresh = between.scanning.next_label();
    between.drafts = whole(distinct).min(whole((*group.run).particles));
}

/// Assigns a draft to each different survivor of a part, and stores the draft of every particle. Safety: each draft belongs to one
/// survivor, and each stored index to one particle.
pub(super) unsafe fn assign<M: Particles>(place: usize, group: &Group<'_, M>) {
    let Some(between) = group.between() else { return };
    let survivors = between.scanning.survivors();
    let Some(range) = part(place, survivors.len()) else { return };
    let mut next = whole((*group.parts.add(place)).heads);
    let mut before = range.start.checked_sub(1).and_then(|before| survivors.get(before));
    for (particle, survivor) in survivors.iter().enumerate().take(range.end).skip(range.start) {
        if before != Some(survivor) && next < between.drafts {
            between.scanning.assign_one(group.draft(next), (next, particle));
            next += 1;
        }
        before = Some(survivor);
        *group.wholes.add(particle) = next.saturating_sub(1) as u32;
    }
}
