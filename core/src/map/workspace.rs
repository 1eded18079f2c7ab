//! Working memory for the update of one map: the components in view after the update, before they are stored.

use crate::numerics::links::{Linked, NONE};
use crate::numerics::sort::Buckets;
use crate::numerics::work;
use crate::{Component, Real, Symmetric, Vector};

/// Where a component of the updated map comes from (5.17).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Origin<T> {
    /// Not in view, but on a page with components in view: kept unchanged.
    Outside,
    /// In view and missed.
    Missed,
    /// As `Missed`, for a confirmed component: the weight that it keeps depends on its detections, which follow. ln of w (1 − p_D).
    Remembered { ln_missed: T },
    /// Detected by the measurement with this index, at this squared Mahalanobis distance.
    Detected { measurement: u16, distance: T },
    /// Born from a measurement.
    Born,
    /// Merged into another component or removed.
    Gone,
}

/// One component of the updated map.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry<N: Vector> {
    pub(crate) component: Component<N>,
    pub(crate) origin: Origin<N::Scalar>,
}

impl<T: Real, N: Vector<Scalar = T>> Entry<N> {
    /// Copies an entry element by element: for small processors, compilers would call a function for the whole.
    #[inline]
    fn copy_from(&mut self, other: &Self) {
        let Component { label, ln_weight, mean, covariance } = &other.component;
        self.component = Component {
            label: *label,
            ln_weight: *ln_weight,
            mean: N::with(|row| mean.at(row)),
            covariance: Symmetric::from_fn(|row, column| covariance.get(row, column)),
        };
        self.origin = other.origin;
    }
}

/// An entry in a sorted list.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ranked {
    /// The sorting key.
    pub(crate) key: u32,
    /// Index of the entry.
    pub(crate) entry: u16,
}

/// The components in view, with the memory that their reduction needs, at least as long.
#[derive(Debug)]
pub(crate) struct InView<'w, N: Vector> {
    pub(crate) entries: &'w mut [Entry<N>],
    pub(crate) ranking: &'w mut [Ranked],
    pub(crate) links: &'w mut [Linked],
}

/// Memory of a workspace for VIEW components.
#[derive(Debug)]
pub struct WorkspaceMemory<N: Vector, const VIEW: usize> {
    entries: [Entry<N>; VIEW],
    ranking: [Ranked; VIEW],
    links: [Linked; VIEW],
}

impl<T: Real, N: Vector<Scalar = T>, const VIEW: usize> WorkspaceMemory<N, VIEW> {
    pub(crate) const ZERO: Self = Self {
        entries: [Entry { component: Component::ZERO, origin: Origin::Outside }; VIEW],
        ranking: [Ranked { key: 0, entry: 0 }; VIEW],
        links: [Linked { next: 0, head: 0, first_member: 0 }; VIEW],
    };

    pub(crate) fn view(&mut self) -> Workspace<'_, N> {
        Workspace {
            entries: &mut self.entries,
            ranking: &mut self.ranking,
            links: &mut self.links,
            in_view: 0,
            outside: 0,
            ln_floor: T::NEG_INFINITY,
            tightened: false,
            lost: 0,
            pruned_mass: T::ZERO,
        }
    }
}

/// Components in view are stored from the front of the memory, components out of view from its back.
#[derive(Debug)]
pub(crate) struct Workspace<'s, N: Vector> {
    entries: &'s mut [Entry<N>],
    ranking: &'s mut [Ranked],
    links: &'s mut [Linked],
    in_view: usize,
    outside: usize,
    ln_floor: N::Scalar,
    tightened: bool,
    lost: usize,
    pruned_mass: N::Scalar,
}

/// Factor by which the pruning threshold is raised at a time; least and greatest raised threshold, the latter half a feature.
const TIGHTEN: f64 = 4.0;
const TIGHTEN_FROM: f64 = 1e-12;
const TIGHTEN_UP_TO: f64 = 0.5;
/// Maximum number of raises: 4²⁰ times 10⁻¹² is more than a half, and one further iteration detects that.
const TIGHTENINGS: usize = 21;

impl<T: Real, N: Vector<Scalar = T>> Workspace<'_, N> {
    /// A workspace without memory.
    pub(crate) fn none() -> Self {
        Self {
            entries: &mut [],
            ranking: &mut [],
            links: &mut [],
            in_view: 0,
            outside: 0,
            ln_floor: T::NEG_INFINITY,
            tightened: false,
            lost: 0,
            pruned_mass: T::ZERO,
        }
    }

    /// Empties the workspace for the next map, and sets ln of the pruning threshold.
    pub(crate) fn clear(&mut self, ln_floor: T) {
        self.in_view = 0;
        self.outside = 0;
        self.ln_floor = ln_floor;
        self.tightened = false;
        self.lost = 0;
        self.pruned_mass = T::ZERO;
    }

    /// ln of the pruning threshold, which may have been raised.
    pub(crate) fn ln_floor(&self) -> T {
        self.ln_floor
    }

    /// Whether the pruning threshold was raised for lack of room.
    pub(crate) fn tightened(&self) -> bool {
        self.tightened
    }

    /// Number of components without room at the greatest pruning threshold.
    pub(crate) fn lost(&self) -> usize {
        self.lost
    }

    /// Whether room was lacking.
    pub(crate) fn is_short(&self) -> bool {
        self.tightened || self.lost > 0
    }

    /// Mass of the pruned components.
    pub(crate) fn pruned_mass(&self) -> T {
        self.pruned_mass
    }

    /// Components in view.
    pub(crate) fn in_view(&self) -> &[Entry<N>] {
        self.entries.get(..self.in_view).unwrap_or(&[])
    }

    /// Components in view, mutable.
    pub(crate) fn in_view_mut(&mut self) -> &mut [Entry<N>] {
        self.entries.get_mut(..self.in_view).unwrap_or(&mut [])
    }

    /// Components in view, mutable, with the memory for sorting.
    pub(crate) fn orders_mut(&mut self) -> InView<'_, N> {
        InView {
            entries: self.entries.get_mut(..self.in_view).unwrap_or(&mut []),
            ranking: self.ranking.get_mut(..self.in_view).unwrap_or(&mut []),
            links: self.links.get_mut(..self.in_view).unwrap_or(&mut []),
        }
    }

    /// All labels, of components in view and out of view.
    pub(crate) fn labels(&self) -> impl Iterator<Item = u32> {
        let outside = self.entries.get(self.entries.len().saturating_sub(self.outside)..).unwrap_or(&[]);
        self.in_view().iter().chain(outside).map(|entry| entry.component.label)
    }

    /// Capacity in components.
    pub(crate) fn capacity(&self) -> usize {
        self.entries.len()
    }

    /// Number of components in view and out of view.
    pub(crate) fn len(&self) -> usize {
        self.in_view + self.outside
    }

    /// Number of components out of view.
    pub(crate) fn outside(&self) -> usize {
        self.outside
    }

    /// Removes the components out of view that were added since there were `outside` of them.
    pub(crate) fn forget_outside(&mut self, outside: usize) {
        self.outside = outside;
    }

    /// Removes the components out of view, added since there were `outside` of them, that do not satisfy `keep`.
    pub(crate) fn retain_outside(&mut self, outside: usize, keep: impl Fn(&Component<N>) -> bool) {
        let capacity = self.entries.len();
        let mut kept = outside;
        for place in outside..self.outside {
            // Entries kept before are stored behind it.
            let Some((ahead, behind)) = self.entries.split_at_mut_checked(capacity.saturating_sub(place)) else {
                break;
            };
            let Some(entry) = ahead.last() else { break };
            if keep(&entry.component) {
                if let Some(slot) = (place - kept).checked_sub(1).and_then(|after| behind.get_mut(after)) {
                    slot.copy_from(entry);
                }
                kept += 1;
            } else {
                self.pruned_mass += entry.component.ln_weight.exp();
            }
        }
        self.outside = kept;
    }

    /// A slot for a component in view with this weight; `None` if it is below the threshold, or has no room.
    #[inline(never)]
    pub(crate) fn place(&mut self, ln_weight: T) -> Option<&mut Entry<N>> {
        if !(ln_weight >= self.ln_floor) {
            self.pruned_mass += ln_weight.exp();
            return None;
        }
        if self.is_full() && !self.make_room(ln_weight) {
            return None;
        }
        let slot = self.entries.get_mut(self.in_view)?;
        self.in_view += 1;
        Some(slot)
    }

    /// Adds a component in view, unless it is below the threshold.
    #[inline]
    pub(crate) fn push(&mut self, component: &Component<N>, origin: Origin<T>) {
        if let Some(slot) = self.place(component.ln_weight) {
            *slot = Entry { component: *component, origin };
        }
    }

    /// Adds a component that is not in view.
    pub(crate) fn push_outside(&mut self, component: &Component<N>) {
        if self.is_full() && !self.make_room(T::INFINITY) {
            return;
        }
        let from_back = self.outside + 1;
        let index = self.entries.len().checked_sub(from_back);
        if let Some(slot) = index.and_then(|index| self.entries.get_mut(index)) {
            *slot = Entry { component: *component, origin: Origin::Outside };
            self.outside = from_back;
        }
    }

    #[inline]
    fn is_full(&self) -> bool {
        self.len() >= self.entries.len()
    }

    /// Makes room for a component with this weight by raising the pruning threshold; `false` if that does not help, or the
    /// component itself is below the new threshold.
    #[inline(never)]
    fn make_room(&mut self, ln_weight: T) -> bool {
        for _ in 0..TIGHTENINGS {
            if !self.is_full() {
                return ln_weight >= self.ln_floor;
            }
            work::round();
            // From no threshold, or a very small one, it would take many iterations until anything is pruned.
            let ln_raised = (self.ln_floor + T::from_f64(TIGHTEN).ln()).at_least(T::from_f64(TIGHTEN_FROM).ln());
            if !(ln_raised <= T::from_f64(TIGHTEN_UP_TO).ln()) {
                break;
            }
            self.ln_floor = ln_raised;
            self.tightened = true;
            self.prune(|_| None);
        }
        self.lost += 1;
        false
    }

    /// Removes the components in view below the threshold, each after a `change`, which returns its weight if it has computed it.
    #[inline]
    pub(crate) fn prune(&mut self, mut change: impl FnMut(&mut Entry<N>) -> Option<T>) {
        let ln_floor = self.ln_floor;
        let mut pruned_mass = self.pruned_mass;
        self.retain(|entry| {
            let weight = change(entry);
            let keep = entry.component.ln_weight >= ln_floor;
            if !keep {
                pruned_mass += weight.unwrap_or_else(|| entry.component.ln_weight.exp());
            }
            keep
        });
        self.pruned_mass = pruned_mass;
    }

    /// Keeps the components in view that satisfy `keep`, in order.
    pub(crate) fn retain(&mut self, mut keep: impl FnMut(&mut Entry<N>) -> bool) {
        let mut kept = 0;
        for index in 0..self.in_view {
            let Some((before, rest)) = self.entries.split_at_mut_checked(index) else { break };
            let Some(entry) = rest.first_mut() else { break };
            if !keep(entry) {
                continue;
            }
            if let Some(slot) = before.get_mut(kept) {
                slot.copy_from(entry);
            }
            kept += 1;
        }
        self.in_view = kept;
    }

    /// All components, and their indices sorted by bucket, below [`BUCKETS`](crate::numerics::sort::BUCKETS). The keys are not set.
    #[inline(never)]
    pub(crate) fn in_order(&mut self, bucket: impl Fn(&Component<N>) -> usize) -> (&[Entry<N>], &[Ranked]) {
        let capacity = self.entries.len();
        let places = (0..self.in_view).chain(capacity.saturating_sub(self.outside)..capacity);
        // The lists of the reduction are no longer needed; their memory now holds those of the buckets. Insertion in reverse
        // order keeps the order within a bucket.
        let mut buckets = Buckets::empty();
        for place in places.rev() {
            if let Some((entry, link)) = self.entries.get(place).zip(self.links.get_mut(place)) {
                link.next = buckets.push(bucket(&entry.component), place as u16).unwrap_or(NONE);
            }
        }
        let mut len = 0;
        buckets.heads(|first| {
            let mut place = first;
            while let Some(link) = self.links.get(usize::from(place)) {
                work::round();
                if let Some(slot) = self.ranking.get_mut(len) {
                    slot.entry = place;
                    len += 1;
                }
                place = link.next;
            }
        });
        (self.entries, self.ranking.get(..len).unwrap_or(&[]))
    }
}
