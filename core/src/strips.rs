//! Neighbours among the components in view: strips across the first axis, each with a list of what lies in it.

use crate::workspace::Entry;
use crate::{Component, Dim, Packed, Real};

/// What a component in view is linked to, by their places.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linked {
    /// The next in the list that it is in.
    pub(crate) next: u16,
    /// The component that it is merged into.
    pub(crate) head: u16,
    /// The first of those that are merged into it.
    pub(crate) first_member: u16,
}

/// Past the last of a list.
pub(crate) const NONE: u16 = u16::MAX;

/// Number of strips.
const STRIPS: usize = 64;

/// Strips of the same width that hold every component.
#[derive(Debug)]
pub(crate) struct Strips<T> {
    first: [u16; STRIPS],
    low: T,
    per_unit: T,
}

impl<T: Real> Strips<T> {
    /// Lists the components of all strips in `links`, which must be as long as `entries`.
    pub(crate) fn new<const N: usize>(entries: &[Entry<T, N>], links: &mut [Linked]) -> Self
    where
        Dim<N>: Packed,
    {
        let (mut low, mut high) = (T::INFINITY, T::NEG_INFINITY);
        for Entry { component, .. } in entries {
            (low, high) = (along(component).at_most(low), along(component).at_least(high));
        }
        let per_unit = if high > low { T::from_usize(STRIPS) / (high - low) } else { T::ZERO };
        let mut strips = Self { first: [NONE; STRIPS], low, per_unit };
        for (index, (entry, link)) in entries.iter().zip(links).enumerate() {
            let strip = strips.strip(along(&entry.component));
            *link = Linked { next: NONE, head: NONE, first_member: NONE };
            if let Some(first) = strips.first.get_mut(strip) {
                link.next = *first;
                *first = index as u16;
            }
        }
        strips
    }

    /// The strip that a coordinate falls into; the outer ones go on for ever.
    fn strip(&self, x: T) -> usize {
        usize::try_from(((x - self.low) * self.per_unit).to_i32()).unwrap_or(0).min(STRIPS - 1)
    }

    /// The places of all components whose squared Mahalanobis distance by the covariance of `component` may be as small as
    /// `distance`, its own among them.
    pub(crate) fn reached_by<const N: usize>(
        &self,
        component: &Component<T, N>,
        distance: T,
        links: &[Linked],
    ) -> impl Iterator<Item = usize>
    where
        Dim<N>: Packed,
    {
        let x = along(component);
        // A little more than the distance at which rounding could still decide.
        let reach = (distance * component.covariance.get(0, 0)).sqrt_above() * (T::ONE + T::from_f64(8.0) * T::EPSILON);
        let strips = self.first.get(self.strip(x - reach)..=self.strip(x + reach)).unwrap_or(&[]);
        strips.iter().flat_map(|&first| list(first, links))
    }
}

/// The places in a list.
pub(crate) fn list(first: u16, links: &[Linked]) -> impl Iterator<Item = usize> {
    let mut next = first;
    core::iter::from_fn(move || {
        let place = usize::from(next);
        next = links.get(place)?.next;
        Some(place)
    })
}

fn along<T: Real, const N: usize>(component: &Component<T, N>) -> T
where
    Dim<N>: Packed,
{
    component.mean.get(0).copied().unwrap_or(T::ZERO)
}

#[cfg(test)]
mod tests {
    use super::{Linked, Strips};
    use crate::workspace::{Entry, Origin};
    use crate::{Component, Noise, Symmetric};
    use nalgebra::Vector2;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn nothing_within_reach_is_passed_over() {
        let mut noise = Noise::seeded(3);
        for (count, extent) in [(0, 1.0), (1, 1.0), (7, 0.0), (200, 30.0), (200, 1e-6)] {
            let entries: Vec<Entry<f64, 2>> = (0..count)
                .map(|_| {
                    let mean = Vector2::new(extent * noise.uniform::<f64>() - 5.0, 3.0);
                    let variance = 10.0_f64.powf(4.0 * noise.uniform::<f64>() - 3.0);
                    let covariance = Symmetric::from_diagonal([variance, 1.0]);
                    Entry { component: Component { mean, covariance, ..Component::ZERO }, origin: Origin::Missed }
                })
                .collect();
            let mut links = vec![Linked { next: 0, head: 0, first_member: 0 }; count];
            let strips = Strips::new(&entries, &mut links);
            for Entry { component, .. } in &entries {
                let reached: Vec<usize> = strips.reached_by(component, 4.0, &links).collect();
                for (index, other) in entries.iter().enumerate() {
                    let offset = other.component.mean.x - component.mean.x;
                    let within = offset * offset / component.covariance.get(0, 0) <= 4.0;
                    assert!(!within || reached.iter().filter(|&&place| place == index).count() == 1);
                }
            }
        }
    }
}
