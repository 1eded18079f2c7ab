//! Mixture reduction: merge and cap (Vo & Ma 2006, table II), after pruning.

use crate::map::neighbours::{Cells, list};
use crate::map::workspace::{Entry, InView, Origin, Ranked, Workspace};
use crate::numerics::links::{Linked, NONE};
use crate::numerics::sort::shell_sort;
use crate::{Component, Factor, Real, Vector};
use core::borrow::Borrow;

/// Merges and caps the components in view, which have been pruned. Returns the number of components removed by merging.
pub(crate) fn merge_and_cap<T: Real, N: Vector<Scalar = T>>(
    workspace: &mut Workspace<'_, N>,
    merge_distance: T,
    max_components: usize,
) -> usize {
    let before = workspace.in_view().len();
    let InView { entries, ranking, links } = workspace.orders_mut();
    merge_near(entries, ranking, links, merge_distance);
    workspace.retain(|entry| entry.origin != Origin::Gone);
    let merged = before - workspace.in_view().len();
    keep_heaviest(workspace, max_components, |_| 0);
    merged
}

/// Keeps the first `limit` components in view in the order of their classes, and the heaviest first within a class.
pub(crate) fn keep_heaviest<T: Real, N: Vector<Scalar = T>>(
    workspace: &mut Workspace<'_, N>,
    limit: usize,
    class: impl Fn(&Entry<N>) -> u32,
) {
    if workspace.in_view().len() <= limit {
        return;
    }
    let InView { entries, ranking, .. } = workspace.orders_mut();
    rank_heaviest_first(entries, ranking, class);
    for ranked in ranking.iter().skip(limit) {
        if let Some(entry) = entries.get_mut(usize::from(ranked.entry)) {
            entry.origin = Origin::Gone;
        }
    }
    workspace.retain(|entry| entry.origin != Origin::Gone);
}

/// Resolution of the sorting key, steps per unit of ln w.
const STEPS_PER_UNIT: f64 = 65_536.0;

/// Sorting key, heaviest first: ln w in steps of 2⁻¹⁶ in the lower 28 bits, so that the order does not depend on the last bit of
/// a sum, and the class above them.
fn heaviest_first<T: Real>(ln_weight: T, class: u32) -> u32 {
    const MIDDLE: i32 = 1 << 27;
    let scaled = ln_weight * T::from_f64(STEPS_PER_UNIT) + T::from_f64(0.5);
    let towards_zero = scaled.to_i32();
    let steps = if scaled < T::from_i32(towards_zero) { towards_zero.saturating_sub(1) } else { towards_zero };
    let place = MIDDLE - steps.clamp(1 - MIDDLE, MIDDLE - 1);
    (class << 28) | place.unsigned_abs()
}

/// Whether one component comes before another: heaviest first, then by position.
pub(crate) fn heavier<T: Real, N: Vector<Scalar = T>>(a: &Component<N>, b: &Component<N>) -> bool {
    let (a_key, b_key) = (heaviest_first(a.ln_weight, 0), heaviest_first(b.ln_weight, 0));
    if a_key == b_key { lies_before(&a.mean, &b.mean).unwrap_or(false) } else { a_key < b_key }
}

/// The same order for components in a list; equal components are in the order of the list.
fn comes_before<T: Real, N: Vector<Scalar = T>>(a: (usize, &Component<N>), b: (usize, &Component<N>)) -> bool {
    heavier(a.1, b.1) || (a.0 < b.0 && !heavier(b.1, a.1))
}

/// Whether `a` is before `b` in lexicographic order; `None` if they are equal.
fn lies_before<T: Real, N: Vector<Scalar = T>>(a: &N, b: &N) -> Option<bool> {
    a.as_slice().iter().zip(b.as_slice()).find(|(a, b)| a != b).map(|(a, b)| a < b)
}

/// Orders all entries by class, then heaviest first, then by position.
fn rank_heaviest_first<T: Real, N: Vector<Scalar = T>>(
    entries: &[Entry<N>],
    ranking: &mut [Ranked],
    class: impl Fn(&Entry<N>) -> u32,
) {
    for (index, (ranked, entry)) in ranking.iter_mut().zip(entries).enumerate() {
        *ranked = Ranked { key: heaviest_first(entry.component.ln_weight, class(entry)), entry: index as u16 };
    }
    sort_heaviest_first(entries, ranking);
}

/// Orders some entries by their keys, then by position.
fn sort_heaviest_first<T: Real, N: Vector<Scalar = T>>(entries: &[Entry<N>], ranking: &mut [Ranked]) {
    let mean = |ranked: &Ranked| entries.get(usize::from(ranked.entry)).map(|entry| &entry.component.mean);
    shell_sort(ranking, |a, b| {
        if a.key != b.key {
            return a.key < b.key;
        }
        let by_position = mean(a).zip(mean(b)).and_then(|(a, b)| lies_before(a, b));
        by_position.unwrap_or(a.entry < b.entry)
    });
}

/// Vo & Ma 2006, table II: repeatedly, the heaviest remaining component h absorbs all remaining components i with (m_i − m_h)ᵀ
/// P_i⁻¹ (m_i − m_h) ≤ `merge_distance`. Absorbed components are marked as gone.
///
/// Implemented from the other side: every component joins the first head before it in the order within that distance, and is a
/// head itself if there is none. So the order matters only among neighbours: most components have no neighbour before them, and
/// most of the others join one of those.
fn merge_near<T: Real, N: Vector<Scalar = T>>(
    entries: &mut [Entry<N>],
    ranking: &mut [Ranked],
    links: &mut [Linked],
    merge_distance: T,
) {
    let mut cells = Cells::empty();
    cells.fill(entries, links);
    for index in 0..entries.len() {
        let leader = leader(index, entries, links, &cells, merge_distance);
        if let Some(link) = links.get_mut(index) {
            link.head = leader;
        }
    }
    let leader_of = |place: u16| links.get(usize::from(place)).map_or(NONE, |link| link.head);
    let mut doubtful = 0;
    for (index, entry) in entries.iter_mut().enumerate() {
        let leader = leader_of(index as u16);
        if leader == NONE {
            continue;
        }
        if leader_of(leader) == NONE {
            entry.origin = Origin::Gone;
        } else if let Some(slot) = ranking.get_mut(doubtful) {
            *slot = Ranked { key: heaviest_first(entry.component.ln_weight, 0), entry: index as u16 };
            doubtful += 1;
        }
    }
    // Components whose leader itself has a leader must be processed in order.
    let doubtful = ranking.get_mut(..doubtful).unwrap_or(&mut []);
    sort_heaviest_first(entries, doubtful);
    for ranked in doubtful.iter() {
        let index = usize::from(ranked.entry);
        let head = leader(index, entries, links, &cells, merge_distance);
        if let Some((entry, link)) = entries.get_mut(index).zip(links.get_mut(index)) {
            link.head = head;
            if head != NONE {
                entry.origin = Origin::Gone;
            }
        }
    }
    // The lists of the cells are no longer needed; their memory now holds the lists of members of every head.
    for index in 0..entries.len() {
        let Some(&Linked { head, .. }) = links.get(index) else { break };
        let Some(first) = links.get_mut(usize::from(head)) else { continue };
        let next = core::mem::replace(&mut first.first_member, index as u16);
        if let Some(link) = links.get_mut(index) {
            link.next = next;
        }
    }
    for index in 0..entries.len() {
        let Some(&Linked { first_member, .. }) = links.get(index) else { break };
        let Some(&Entry { component: head, .. }) = entries.get(index).filter(|_| first_member != NONE) else {
            continue;
        };
        let members = list(first_member, links).filter_map(|member| entries.get(member)).map(|entry| &entry.component);
        let merged = moment_match(&head, members);
        if let Some(entry) = entries.get_mut(index) {
            entry.component = merged;
        }
    }
}

/// The first component in the order, before this one and not gone, within `merge_distance` of it.
fn leader<T: Real, N: Vector<Scalar = T>>(
    index: usize,
    entries: &[Entry<N>],
    links: &[Linked],
    cells: &Cells<T>,
    merge_distance: T,
) -> u16 {
    let Some(Entry { component, .. }) = entries.get(index) else { return NONE };
    let mut near = Near::of(component, merge_distance);
    let mut first = (index, component);
    cells.reached_by(component, merge_distance, links, |place| {
        if let Some(Entry { component: other, origin }) = entries.get(place)
            && !clearly_lighter(other, first.1)
            && *origin != Origin::Gone
            && place != index
            && near.holds(&other.mean)
            && (clearly_lighter(first.1, other) || comes_before((place, other), first))
        {
            first = (place, other);
        }
    });
    if first.0 == index { NONE } else { first.0 as u16 }
}

/// Whether a component is lighter by more than one step of the sorting key, which decides most pairs in dense areas.
#[inline]
fn clearly_lighter<T: Real, N: Vector<Scalar = T>>(a: &Component<N>, b: &Component<N>) -> bool {
    a.ln_weight + T::from_f64(2.0 / STEPS_PER_UNIT) < b.ln_weight
}

/// The region within a squared Mahalanobis distance of a component.
pub(crate) struct Near<'c, N: Vector> {
    component: &'c Component<N>,
    /// The Cholesky factor of the covariance, computed when it is first needed.
    factor: Option<Option<Factor<N>>>,
    distance: N::Scalar,
}

impl<'c, T: Real, N: Vector<Scalar = T>> Near<'c, N> {
    pub(crate) fn of(component: &'c Component<N>, distance: T) -> Self {
        Self { component, factor: None, distance }
    }

    /// Whether `mean` is in the region.
    #[inline]
    pub(crate) fn holds(&mut self, mean: &N) -> bool {
        let Self { component, distance, .. } = *self;
        let difference = component.mean - *mean;
        // d² ≥ δ_k² / P_kk for every coordinate k, which decides nearly all pairs without a factorisation.
        let mut deltas = difference.as_slice().iter().enumerate();
        deltas.all(|(k, &delta)| delta * delta <= distance * component.covariance.get(k, k)) && {
            let factor = self.factor.get_or_insert_with(|| component.covariance.factor());
            factor.as_ref().is_some_and(|factor| factor.mahalanobis(&difference) <= distance)
        }
    }
}

/// One Gaussian with the mass, mean and covariance of `head` and the others together. If the result is beyond the range of the
/// scalar, mean and covariance are those of `head`.
pub(crate) fn moment_match<T: Real, N: Vector<Scalar = T>>(
    head: &Component<N>,
    others: impl Iterator<Item = impl Borrow<Component<N>>>,
) -> Component<N> {
    // Weights and means relative to the head avoid rounding errors in single precision far from the origin.
    let mut mass = T::ONE;
    let mut offset = N::ZERO;
    let mut second_moment = head.covariance;
    for other in others {
        let other = other.borrow();
        let weight = (other.ln_weight - head.ln_weight).exp();
        let difference = other.mean - head.mean;
        mass += weight;
        offset += difference * weight;
        second_moment = second_moment.plus(&other.covariance.scaled(weight));
        second_moment.add_outer(weight, &difference);
    }
    let share = T::ONE / mass;
    offset = offset * share;
    let mut covariance = second_moment.scaled(share);
    covariance.add_outer(-T::ONE, &offset);
    let ln_weight = head.ln_weight + mass.ln();
    match covariance.kept_positive_definite() {
        Some((covariance, _)) => Component { label: head.label, ln_weight, mean: head.mean + offset, covariance },
        None => Component { ln_weight, ..*head },
    }
}

#[cfg(test)]
mod tests {
    use super::merge_and_cap;
    use crate::map::workspace::{Origin, WorkspaceMemory};
    use crate::{Component, Symmetric};
    use nalgebra::{Matrix2, Vector2};
    use std::boxed::Box;
    use std::vec::Vec;

    fn component(weight: f64, x: f64, y: f64) -> Component<Vector2<f64>> {
        let covariance = Symmetric::from_fn(|row, column| if row == column { 0.4 } else { 0.1 });
        Component { label: (100.0 * weight) as u32, ln_weight: weight.ln(), mean: Vector2::new(x, y), covariance }
    }

    fn reduced(mixture: &[Component<Vector2<f64>>], merge_distance: f64, cap: usize) -> Vec<Component<Vector2<f64>>> {
        let mut memory = Box::new(WorkspaceMemory::<Vector2<f64>, 32>::ZERO);
        let mut workspace = memory.view();
        workspace.clear(1e-6_f64.ln());
        mixture.iter().for_each(|component| workspace.push(component, Origin::Missed));
        let merged = merge_and_cap(&mut workspace, merge_distance, cap);
        let left: Vec<_> = workspace.in_view().iter().map(|entry| entry.component).collect();
        assert!(merged + left.len() <= mixture.len());
        left
    }

    /// Mass, mean and second moment of a mixture.
    fn moments(mixture: &[Component<Vector2<f64>>]) -> (f64, Vector2<f64>, Matrix2<f64>) {
        let mass: f64 = mixture.iter().map(|c| c.ln_weight.exp()).sum();
        let weighted = || mixture.iter().map(|c| (c.ln_weight.exp() / mass, c));
        let mean = weighted().fold(Vector2::zeros(), |sum, (w, c)| sum + c.mean * w);
        let second = weighted()
            .fold(Matrix2::zeros(), |sum, (w, c)| sum + (c.covariance.to_matrix() + c.mean * c.mean.transpose()) * w);
        (mass, mean, second)
    }

    const CLUSTERS: [(f64, f64, f64); 7] = [
        (0.9, 0.0, 0.0),
        (0.2, 0.3, 0.1),
        (0.05, -0.6, 0.4),
        (0.5, 6.0, 1.0),
        (0.4, 6.4, 1.3),
        (0.3, -5.0, 4.0),
        (0.01, 0.1, -0.2),
    ];

    #[test]
    fn merging_keeps_mass_mean_and_covariance() {
        let mixture: Vec<_> = CLUSTERS.iter().map(|&(w, x, y)| component(w, x, y)).collect();
        let before = moments(&mixture);
        let left = reduced(&mixture, 4.0, usize::MAX);
        assert_eq!(left.len(), 3, "{left:?}");
        let after = moments(&left);
        assert!((after.0 - before.0).abs() < 1e-14);
        assert!((after.1 - before.1).norm() < 1e-13);
        assert!((after.2 - before.2).norm() < 1e-12);
        // The label is that of the heaviest component.
        let mut labels: Vec<u32> = left.iter().map(|c| c.label).collect();
        labels.sort_unstable();
        assert_eq!(labels, [30, 50, 90]);
    }

    #[test]
    fn the_cap_keeps_the_heaviest() {
        let mixture: Vec<_> = CLUSTERS.iter().map(|&(w, x, y)| component(w, x, y)).collect();
        let weights: Vec<f64> = reduced(&mixture, 0.0, 3).iter().map(|c| c.ln_weight.exp()).collect();
        assert_eq!(weights.len(), 3);
        assert!(weights.iter().all(|&w| w > 0.399), "{weights:?}");
    }
}
