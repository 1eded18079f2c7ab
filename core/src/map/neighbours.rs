//! Neighbour search among the components in view: a grid over the first two axes, with a list of components for each cell.

use crate::map::workspace::Entry;
use crate::numerics::links::{Linked, NONE};
use crate::numerics::work;
use crate::{Component, Real, Vector};

/// Number of cells along each axis.
const CELLS: usize = 16;
/// Up to this number of components the first axis is not divided: it takes less time to compare with a few more components than to
/// search a second axis.
const FEW: usize = 80;

/// A grid that covers all components.
#[derive(Debug)]
pub(crate) struct Cells<T> {
    /// The first component of each cell in the first row.
    first: [u16; CELLS],
    /// The other rows, if the first axis is divided.
    more: Option<[[u16; CELLS]; CELLS - 1]>,
    axes: [Axis<T>; 2],
}

/// The cells along one axis.
#[derive(Debug, Clone, Copy)]
struct Axis<T> {
    low: T,
    per_unit: T,
}

impl<T: Real> Axis<T> {
    /// Cells from the minimum to the maximum of these coordinates.
    fn over(coordinates: impl Iterator<Item = T>) -> Self {
        let (mut low, mut high) = (T::INFINITY, T::NEG_INFINITY);
        for x in coordinates {
            (low, high) = (x.at_most(low), x.at_least(high));
        }
        let per_unit = if high > low { T::from_usize(CELLS) / (high - low) } else { T::ZERO };
        Self { low, per_unit }
    }

    /// The cell of a coordinate; the outer cells are unbounded.
    #[inline]
    fn cell(&self, x: T) -> usize {
        ((x - self.low) * self.per_unit).to_index(CELLS as u8 - 1)
    }
}

impl<T: Real> Cells<T> {
    /// An empty grid.
    pub(crate) fn empty() -> Self {
        Self { first: [NONE; CELLS], more: None, axes: [Axis { low: T::ZERO, per_unit: T::ZERO }; 2] }
    }

    /// Adds all components to the lists of their cells, in `links`, which must be as long as `entries`. The grid must be empty.
    pub(crate) fn fill<N: Vector<Scalar = T>>(&mut self, entries: &[Entry<N>], links: &mut [Linked]) {
        let coordinates = |axis| entries.iter().map(move |entry| along(&entry.component, axis));
        if entries.len() > FEW {
            self.axes[0] = Axis::over(coordinates(0));
            self.more = Some([[NONE; CELLS]; CELLS - 1]);
        }
        self.axes[1] = Axis::over(coordinates(1));
        for (index, (entry, link)) in entries.iter().zip(links).enumerate() {
            *link = Linked { next: NONE, head: NONE, first_member: NONE };
            let [row, column] = [0, 1].map(|axis| self.axis(axis).cell(along(&entry.component, axis)));
            let row = match row.checked_sub(1) {
                None => Some(&mut self.first),
                Some(row) => self.more.as_mut().and_then(|rows| rows.get_mut(row)),
            };
            if let Some(first) = row.and_then(|row| row.get_mut(column)) {
                link.next = *first;
                *first = index as u16;
            }
        }
    }

    #[inline]
    fn axis(&self, axis: usize) -> Axis<T> {
        let [first, second] = self.axes;
        if axis == 0 { first } else { second }
    }

    /// Calls `visit` with the indices of all components whose squared Mahalanobis distance, with the covariance of `component`,
    /// may be at most `distance`, including itself. That distance is at least δ²/P on any axis.
    #[inline]
    pub(crate) fn reached_by<N: Vector<Scalar = T>>(
        &self,
        component: &Component<N>,
        distance: T,
        links: &[Linked],
        mut visit: impl FnMut(usize),
    ) {
        // The distance is increased by more than the rounding errors.
        let widened = distance * (T::ONE + T::from_f64(16.0) * T::EPSILON);
        let reached = |axis| {
            if self.axis(axis).per_unit == T::ZERO {
                return 0..1;
            }
            let (x, reach) = (along(component, axis), (widened * component.covariance.get(axis, axis)).sqrt_above());
            self.axis(axis).cell(x - reach)..self.axis(axis).cell(x + reach) + 1
        };
        let (rows, columns) = (reached(0), reached(1));
        for row in rows {
            let of_row = match row.checked_sub(1) {
                None => Some(&self.first),
                Some(row) => self.more.as_ref().and_then(|rows| rows.get(row)),
            };
            for column in columns.clone() {
                let first = of_row.and_then(|row| row.get(column));
                let mut place = first.map_or(links.len(), |&first| usize::from(first));
                while let Some(link) = links.get(place) {
                    work::round();
                    visit(place);
                    place = usize::from(link.next);
                }
            }
        }
    }
}

/// The indices in a list.
pub(crate) fn list(first: u16, links: &[Linked]) -> impl Iterator<Item = usize> {
    let mut next = first;
    core::iter::from_fn(move || {
        let place = usize::from(next);
        next = links.get(place)?.next;
        work::round();
        Some(place)
    })
}

/// A coordinate of the mean; 0 if the mean has fewer dimensions.
#[inline]
fn along<T: Real, N: Vector<Scalar = T>>(component: &Component<N>, axis: usize) -> T {
    component.mean.at(axis)
}

#[cfg(test)]
mod tests {
    use super::{Cells, Linked};
    use crate::map::workspace::{Entry, Origin};
    use crate::{Component, Noise, Symmetric};
    use nalgebra::Vector2;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn all_components_within_the_distance_are_visited() {
        let mut noise = Noise::seeded(3);
        for (count, extent) in [(0, 1.0), (1, 1.0), (7, 0.0), (200, 30.0), (200, 1e-6)] {
            let entries: Vec<Entry<Vector2<f64>>> = (0..count)
                .map(|_| {
                    let mean = Vector2::from_fn(|_, _| extent * noise.uniform::<f64>() - 5.0);
                    let covariance =
                        Symmetric::from_diagonal([(); 2].map(|()| 10.0_f64.powf(4.0 * noise.uniform::<f64>() - 3.0)));
                    Entry { component: Component { mean, covariance, ..Component::ZERO }, origin: Origin::Missed }
                })
                .collect();
            let mut links = vec![Linked { next: 0, head: 0, first_member: 0 }; count];
            let mut cells = Cells::empty();
            cells.fill(&entries, &mut links);
            for Entry { component, .. } in &entries {
                let mut reached = Vec::new();
                cells.reached_by(component, 4.0, &links, |place| reached.push(place));
                for (index, other) in entries.iter().enumerate() {
                    let offset = other.component.mean - component.mean;
                    let within = component.covariance.factor().unwrap().mahalanobis(&offset) <= 4.0;
                    assert!(!within || reached.iter().filter(|&&place| place == index).count() == 1);
                }
            }
        }
    }
}
