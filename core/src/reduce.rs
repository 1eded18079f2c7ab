//! Mixture reduction: prune, merge, cap (Vo & Ma 2006, table II).

use crate::sort::heap_sort;
use crate::workspace::{Entry, Origin, Ranked, Workspace};
use crate::{Dim, Gaussian, Packed, Real};
use nalgebra::SVector;

/// Merges and caps the components in view, which are pruned already; returns how many were merged away.
pub(crate) fn merge_and_cap<T: Real, const N: usize>(
    workspace: &mut Workspace<'_, T, N>,
    merge_distance: T,
    max_components: usize,
) -> usize
where
    Dim<N>: Packed,
{
    let before = workspace.in_view().len();
    let (entries, ranking) = workspace.in_view_and_ranking();
    let ranking = rank_heaviest_first(entries, ranking, |_| 0);
    merge(entries, ranking, merge_distance);
    workspace.retain(|entry| entry.origin != Origin::Gone);
    let merged = before - workspace.in_view().len();
    keep_heaviest(workspace, max_components, |_| 0);
    merged
}

/// Keeps the `limit` first components in view by class, then heaviest first.
pub(crate) fn keep_heaviest<T: Real, const N: usize>(
    workspace: &mut Workspace<'_, T, N>,
    limit: usize,
    class: impl Fn(&Entry<T, N>) -> u32,
) where
    Dim<N>: Packed,
{
    if workspace.in_view().len() <= limit {
        return;
    }
    let (entries, ranking) = workspace.in_view_and_ranking();
    let ranking = rank_heaviest_first(entries, ranking, class);
    for ranked in ranking.iter().skip(limit) {
        if let Some(entry) = entries.get_mut(usize::from(ranked.entry)) {
            entry.origin = Origin::Gone;
        }
    }
    workspace.retain(|entry| entry.origin != Origin::Gone);
}

/// Key that puts heavy components first: ln w in steps of 2⁻¹⁶, so that the order does not hang on the last bit of a
/// sum, in the lower 28 bits; the class above them.
fn heaviest_first<T: Real>(ln_weight: T, class: u32) -> u32 {
    const MIDDLE: i32 = 1 << 27;
    let steps = (ln_weight * T::from_f64(65_536.0) + T::from_f64(0.5)).floor().to_i32();
    let place = MIDDLE - steps.clamp(1 - MIDDLE, MIDDLE - 1);
    (class << 28) | place.unsigned_abs()
}

/// Whether one component comes before another: heaviest first, then by position.
pub(crate) fn heavier<T: Real, const N: usize>(a: &Gaussian<T, N>, b: &Gaussian<T, N>) -> bool
where
    Dim<N>: Packed,
{
    let (a_key, b_key) = (heaviest_first(a.ln_weight, 0), heaviest_first(b.ln_weight, 0));
    if a_key == b_key { lies_before(&a.mean, &b.mean).unwrap_or(false) } else { a_key < b_key }
}

/// Whether `a` lies before `b` by x, then by y, …; `None` where they are the same.
fn lies_before<T: Real, const N: usize>(a: &SVector<T, N>, b: &SVector<T, N>) -> Option<bool> {
    a.iter().zip(b.iter()).find(|(a, b)| a != b).map(|(a, b)| a < b)
}

/// The order of all entries: class, then heaviest first, then by position.
fn rank_heaviest_first<'r, T: Real, const N: usize>(
    entries: &[Entry<T, N>],
    ranking: &'r mut [Ranked],
    class: impl Fn(&Entry<T, N>) -> u32,
) -> &'r mut [Ranked]
where
    Dim<N>: Packed,
{
    let ranking = ranking.get_mut(..entries.len()).unwrap_or(&mut []);
    for (index, (ranked, entry)) in ranking.iter_mut().zip(entries).enumerate() {
        let key = heaviest_first(entry.component.ln_weight, class(entry));
        *ranked = Ranked { key, entry: index as u16, group: 0 };
    }
    let mean = |ranked: &Ranked| entries.get(usize::from(ranked.entry)).map(|entry| &entry.component.mean);
    heap_sort(ranking, |a, b| {
        if a.key != b.key {
            return a.key < b.key;
        }
        let by_position = mean(a).zip(mean(b)).and_then(|(a, b)| lies_before(a, b));
        by_position.unwrap_or(a.entry < b.entry)
    });
    ranking
}

/// Vo & Ma 2006, table II: the heaviest component left takes in every component i left with
/// (m_i − m_h)ᵀ P_i⁻¹ (m_i − m_h) ≤ `merge_distance`; repeat. Those taken in are marked as gone.
fn merge<T: Real, const N: usize>(entries: &mut [Entry<T, N>], ranking: &mut [Ranked], merge_distance: T)
where
    Dim<N>: Packed,
{
    for head_place in 0..ranking.len() {
        let Some((head_rank, followers)) = ranking.get_mut(head_place..).and_then(<[_]>::split_first_mut) else {
            return;
        };
        if head_rank.group != 0 {
            continue;
        }
        let group = head_place as u16 + 1;
        let head_index = usize::from(head_rank.entry);
        let Some(head) = entries.get(head_index).map(|entry| entry.component) else { continue };

        let mut members = 0;
        for ranked in followers.iter_mut().filter(|ranked| ranked.group == 0) {
            let Some(entry) = entries.get_mut(usize::from(ranked.entry)) else { continue };
            if is_near(&entry.component, &head.mean, merge_distance) {
                ranked.group = group;
                entry.origin = Origin::Gone;
                members += 1;
            }
        }
        if members == 0 {
            continue;
        }
        let taken = followers.iter().filter(|ranked| ranked.group == group);
        let merged = moment_match(&head, || {
            taken.clone().filter_map(|ranked| entries.get(usize::from(ranked.entry))).map(|entry| &entry.component)
        });
        if let Some(entry) = entries.get_mut(head_index) {
            entry.component = merged;
        }
    }
}

/// Whether `head_mean` lies within the squared Mahalanobis distance of a component.
fn is_near<T: Real, const N: usize>(component: &Gaussian<T, N>, head_mean: &SVector<T, N>, distance: T) -> bool
where
    Dim<N>: Packed,
{
    let difference = component.mean - head_mean;
    // d² ≥ δ_k² / P_kk for every coordinate k, which settles nearly all pairs without a factorisation.
    let near_in_all =
        difference.iter().enumerate().all(|(k, &delta)| delta * delta <= distance * component.covariance.get(k, k));
    near_in_all && component.covariance.factor().is_some_and(|factor| factor.mahalanobis(&difference) <= distance)
}

/// One Gaussian with the mass, the mean and the spread of `head` and the others together.
fn moment_match<'e, T: Real, const N: usize, I>(head: &Gaussian<T, N>, others: impl Fn() -> I) -> Gaussian<T, N>
where
    I: Iterator<Item = &'e Gaussian<T, N>>,
    Dim<N>: Packed + 'e,
{
    // Weights and means relative to the head keep single precision where the map is far from its origin.
    let relative = |component: &Gaussian<T, N>| (component.ln_weight - head.ln_weight).exp();
    let mut mass = T::ONE;
    let mut offset = SVector::<T, N>::zeros();
    for other in others() {
        let weight = relative(other);
        mass += weight;
        offset += (other.mean - head.mean) * weight;
    }
    offset /= mass;
    let mut covariance = head.covariance;
    covariance.add_outer(T::ONE, &offset);
    for other in others() {
        let weight = relative(other);
        covariance = covariance.plus(&other.covariance.scaled(weight));
        covariance.add_outer(weight, &(other.mean - head.mean - offset));
    }
    Gaussian {
        ln_weight: head.ln_weight + mass.ln(),
        mean: head.mean + offset,
        covariance: covariance.scaled(T::ONE / mass).kept_positive_definite().0,
    }
}
