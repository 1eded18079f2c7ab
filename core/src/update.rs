//! The update of the survivors' maps (5.17–5.22), after their weights are known.

use crate::map::{MapTable, PAGE_LEN, Pool};
use crate::reduce::{keep_heaviest, merge_and_cap};
use crate::scan::Scan;
use crate::sort::heap_sort;
use crate::view::View;
use crate::weigh::reset_eta;
use crate::workspace::{Entry, Origin, Workspace};
use crate::{Bounds, Config, Dim, FieldOfView, Gaussian, LnSum, Packed, Real, Sensor};

/// What the updates of one scan did, over all maps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tally<T> {
    /// Maps written.
    pub(crate) updated: usize,
    /// Mass of the components dropped for their weight.
    pub(crate) pruned_mass: T,
    /// Components merged into another.
    pub(crate) merged: usize,
    /// Components born that outlived pruning, before merging.
    pub(crate) births: usize,
    /// Maps for which pruning had to be tightened, by any lack of room.
    pub(crate) tightened: usize,
    /// Components that found no room at all.
    pub(crate) lost: usize,
    /// Maps left as predicted because their confirmed components would not have fitted.
    pub(crate) kept: usize,
    /// Corrected covariances that had to be repaired.
    pub(crate) repaired: usize,
    /// Measurements that could not give birth: without an inverse, or with one out of view.
    pub(crate) no_birth: usize,
    /// Σ w d² and Σ w over the detections kept: the normalised innovation squared and its weight.
    pub(crate) innovation: (T, T),
}

impl<T: Real> Tally<T> {
    pub(crate) fn new() -> Self {
        Self {
            updated: 0,
            pruned_mass: T::ZERO,
            merged: 0,
            births: 0,
            tightened: 0,
            lost: 0,
            kept: 0,
            repaired: 0,
            no_birth: 0,
            innovation: (T::ZERO, T::ZERO),
        }
    }

    /// Mean squared innovation per dimension of the measurement; 0 where nothing was detected.
    pub(crate) fn mean_innovation(&self, dimension: usize) -> T {
        let (sum, weight) = self.innovation;
        if weight > T::ZERO { sum / (weight * T::from_usize(dimension)) } else { T::ZERO }
    }
}

/// The maps before and after the update, and the scratch between them.
#[derive(Debug)]
pub(crate) struct Maps<'a, 's, T: Real, const N: usize, const D: usize>
where
    Dim<N>: Packed,
{
    pub(crate) predicted: &'a mut MapTable<'s>,
    pub(crate) updated: &'a mut MapTable<'s>,
    pub(crate) pool: &'a mut Pool<'s, T, N, D>,
    pub(crate) workspace: &'a mut Workspace<'s, T, N>,
    pub(crate) eta: &'a mut [LnSum<T>],
}

/// Which map to update, where to put it, and what share of the pool it may take.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Task {
    /// The particle whose predicted map is updated.
    pub(crate) parent: usize,
    /// The particle that gets the updated map.
    pub(crate) particle: usize,
    /// No later survivor needs the parent's map.
    pub(crate) last_child: bool,
    /// Maps still to be updated, this one included.
    pub(crate) remaining: usize,
}

impl<T: Real, const N: usize, const D: usize> Maps<'_, '_, T, N, D>
where
    Dim<N>: Packed,
    Dim<D>: Packed,
{
    /// Gives every particle the updated map of the survivor it continues, and frees the predicted maps.
    ///
    /// Survivors come in ascending order of parents. Copies of one survivor share its map. A parent's pages are let go
    /// before its last child's map is written, so that without a resampling every map is rewritten in its own place.
    pub(crate) fn update_all<'v, S, V, F, const Z: usize>(
        mut self,
        survivors: &[u16],
        children: usize,
        look: impl Fn(usize) -> Option<View<'v, T, S, V, F>>,
        scan: &Scan<'_, T, Z>,
        config: &Config<T>,
        birth: impl Fn(&Gaussian<T, D>) -> Gaussian<T, N>,
    ) -> Tally<T>
    where
        S: Sensor<T, D, Z, Frame = F> + 'v,
        V: FieldOfView<T, F, D, Z> + 'v,
        Dim<Z>: Packed,
    {
        let mut tally = Tally::new();
        let parent_of = |survivor: u16| usize::from(survivor) / children;
        let mut alive = survivors.iter().map(|&survivor| parent_of(survivor)).peekable();
        for parent in 0..survivors.len() {
            if alive.next_if_eq(&parent).is_none() {
                self.predicted.release(parent, self.pool);
            }
            while alive.next_if_eq(&parent).is_some() {}
        }
        let mut remaining = survivors.chunk_by(|a, b| a == b).count();
        let mut particle = 0;
        let mut copies = survivors.chunk_by(|a, b| a == b).peekable();
        while let Some(copy) = copies.next() {
            let Some(&survivor) = copy.first() else { continue };
            let parent = parent_of(survivor);
            let last_child = copies.peek().and_then(|next| next.first()).is_none_or(|&next| parent_of(next) != parent);
            if let Some(view) = look(usize::from(survivor)) {
                let task = Task { parent, particle, last_child, remaining };
                self.update(task, &view, scan, config, &birth, &mut tally);
            }
            for twin in 1..copy.len() {
                self.updated.share_within(particle, particle + twin, self.pool);
            }
            particle += copy.len();
            remaining -= 1;
        }
        self.predicted.take_over(self.updated, survivors.len());
        tally
    }

    /// Updates one survivor's map as seen from its pose, reduces it and writes it to fresh pages. Pages out of view
    /// are shared with the parent.
    fn update<S, V, F, const Z: usize>(
        &mut self,
        task: Task,
        view: &View<'_, T, S, V, F>,
        scan: &Scan<'_, T, Z>,
        config: &Config<T>,
        birth: impl Fn(&Gaussian<T, D>) -> Gaussian<T, N>,
        tally: &mut Tally<T>,
    ) where
        S: Sensor<T, D, Z, Frame = F>,
        V: FieldOfView<T, F, D, Z>,
        Dim<Z>: Packed,
    {
        let bounds = view.bounds();
        self.workspace.clear(config.prune_weight);
        reset_eta(self.eta, scan);
        let regained = self.collect(task, view, scan, &bounds, tally);
        self.weigh_detections(scan, tally);
        self.give_birth(view, scan, config, birth, tally);
        tally.merged += merge_and_cap(self.workspace, config.merge_distance, config.max_components);
        tally.tightened += usize::from(self.workspace.tightened());
        tally.lost += self.workspace.lost();
        tally.pruned_mass += self.workspace.pruned_mass();

        let share = self.pool.free() / task.remaining.max(1) + regained;
        let room = self.updated.map_pages().saturating_sub(self.updated.pages(task.particle).len()).min(share);
        if self.fit(room, tally) {
            if task.last_child {
                self.predicted.release(task.parent, self.pool);
            }
            self.write(task.particle, &bounds, tally);
            tally.updated += 1;
        } else {
            self.keep_prediction(task);
            tally.kept += 1;
        }
    }

    /// Fills the workspace with what becomes of the components in view, and η_z with their terms. Returns how many of
    /// the parent's pages become free when it lets go of them.
    fn collect<S, V, F, const Z: usize>(
        &mut self,
        task: Task,
        view: &View<'_, T, S, V, F>,
        scan: &Scan<'_, T, Z>,
        bounds: &Bounds<T, D>,
        tally: &mut Tally<T>,
    ) -> usize
    where
        S: Sensor<T, D, Z, Frame = F>,
        V: FieldOfView<T, F, D, Z>,
        Dim<Z>: Packed,
    {
        let mut regained = 0;
        for &id in self.predicted.pages(task.parent) {
            let Some(page) = self.pool.get(id) else { continue };
            let outside = self.workspace.outside();
            let mut seen = false;
            if page.bounds().meets(bounds) {
                for component in page.components() {
                    match view.expect(component) {
                        None => self.workspace.push_outside(*component),
                        Some(expectation) => {
                            seen = true;
                            let missed = (T::ONE - expectation.detection_probability).ln();
                            let ln_weight = component.ln_weight + missed;
                            self.workspace.push(Gaussian { ln_weight, ..*component }, Origin::Missed);
                            let mut correction = None;
                            view.matches(&expectation, scan, |found| {
                                if let Some(eta) = self.eta.get_mut(found.index) {
                                    eta.add(found.ln_term);
                                }
                                // η_z is not complete yet; what it is without features bounds the weight from above.
                                let ln_bound = found.ln_term - found.ln_reference;
                                if ln_bound >= self.workspace.ln_floor() {
                                    let correction = correction.get_or_insert_with(|| {
                                        let correction = expectation.correction(component, view.sensor.noise());
                                        tally.repaired += usize::from(correction.repaired());
                                        correction
                                    });
                                    let measurement = found.index as u16;
                                    let origin = Origin::Detected { measurement, distance: found.distance };
                                    let detected = correction.apply(&component.mean, &found.innovation, ln_bound);
                                    self.workspace.push(detected, origin);
                                }
                            });
                        }
                    }
                }
            }
            if seen {
                let only_holder = self.pool.references(id) == 1;
                regained += usize::from(task.last_child && only_holder);
            } else {
                self.workspace.forget_outside(outside);
                self.pool.share(id);
                if !self.updated.push(task.particle, id) {
                    self.pool.release(id);
                }
            }
        }
        regained
    }

    /// Divides the detections by the completed η_z and prunes (5.18).
    fn weigh_detections<const Z: usize>(&mut self, scan: &Scan<'_, T, Z>, tally: &mut Tally<T>) {
        for (eta, measurement) in self.eta.iter_mut().zip(scan.iter()) {
            // From here on: by how much features lower the weight of whatever explains the measurement.
            *eta = LnSum::of(measurement.ln_reference() - eta.ln());
        }
        let eta = &*self.eta;
        self.workspace.retain(|Entry { component, origin }| {
            if let Origin::Detected { measurement, distance } = *origin {
                component.ln_weight += eta.get(usize::from(measurement)).map_or(T::NEG_INFINITY, LnSum::ln);
                let weight = component.ln_weight.exp();
                tally.innovation.0 += weight * distance;
                tally.innovation.1 += weight;
            }
            true
        });
        self.workspace.prune();
    }

    /// Adds a component of weight w_b/η_z at h⁻¹(z, x) for every measurement (5.9, 5.10, 5.17).
    fn give_birth<S, V, F, const Z: usize>(
        &mut self,
        view: &View<'_, T, S, V, F>,
        scan: &Scan<'_, T, Z>,
        config: &Config<T>,
        birth: impl Fn(&Gaussian<T, D>) -> Gaussian<T, N>,
        tally: &mut Tally<T>,
    ) where
        S: Sensor<T, D, Z, Frame = F>,
        V: FieldOfView<T, F, D, Z>,
        Dim<Z>: Packed,
    {
        let ln_birth = config.birth_intensity.ln();
        for (eta, measurement) in self.eta.iter().zip(scan.iter()) {
            let ln_weight = ln_birth - measurement.ln_reference() + eta.ln();
            if !(ln_weight >= self.workspace.ln_floor()) {
                continue;
            }
            // A feature out of view cannot have caused the measurement; born there, it would never be missed and stay.
            let inverse = view.sensor.invert(&view.frame, &measurement.z);
            let Some(inverse) = inverse.filter(|inverse| view.sees(&inverse.feature)) else {
                tally.no_birth += 1;
                continue;
            };
            let (covariance, repaired) = view.sensor.noise().congruence(&inverse.jacobian).kept_positive_definite();
            tally.repaired += usize::from(repaired);
            let born = birth(&Gaussian { ln_weight, mean: inverse.feature, covariance });
            self.workspace.push(born, Origin::Born);
            tally.births += 1;
        }
    }

    /// Makes the updated components fit into `room` pages: the lightest go first, down from half a feature; then
    /// births. `false` where not even the confirmed components fit.
    fn fit(&mut self, room: usize, tally: &mut Tally<T>) -> bool {
        let slots = room * PAGE_LEN;
        if self.workspace.len() <= slots {
            return true;
        }
        let Some(limit) = slots.checked_sub(self.workspace.outside()) else { return false };
        let ln_half = T::from_f64(0.5).ln();
        let confirmed = |entry: &Entry<T, N>| entry.component.ln_weight >= ln_half;
        let class = |entry: &Entry<T, N>| match entry.origin {
            Origin::Born if confirmed(entry) => 1,
            _ if confirmed(entry) => 0,
            _ => 2,
        };
        if self.workspace.in_view().iter().filter(|entry| class(entry) == 0).count() > limit {
            return false;
        }
        tally.tightened += 1;
        keep_heaviest(self.workspace, limit, class);
        true
    }

    /// Writes the workspace to fresh pages, in spatial order, so that the pages' boxes stay small.
    fn write(&mut self, particle: usize, bounds: &Bounds<T, D>, tally: &mut Tally<T>) {
        let (entries, ranking) = self.workspace.rank_all(|component| morton(&component.position(), bounds));
        heap_sort(ranking, |a, b| (a.key, a.entry) < (b.key, b.entry));
        for chunk in ranking.chunks(PAGE_LEN) {
            let Some((id, page)) = self.pool.take() else {
                tally.lost += chunk.len();
                continue;
            };
            let components = chunk.iter().filter_map(|ranked| entries.get(usize::from(ranked.entry)));
            page.fill(components.map(|entry| &entry.component));
            if !self.updated.push(particle, id) {
                self.pool.release(id);
                tally.lost += chunk.len();
            }
        }
    }

    /// Gives the particle its parent's predicted map as it is.
    fn keep_prediction(&mut self, task: Task) {
        self.updated.release(task.particle, self.pool);
        for &id in self.predicted.pages(task.parent) {
            self.pool.share(id);
            if !self.updated.push(task.particle, id) {
                self.pool.release(id);
            }
        }
        if task.last_child {
            self.predicted.release(task.parent, self.pool);
        }
    }
}

/// Place of a position along a Morton curve over `bounds`, 16 cells to a side.
fn morton<T: Real, const D: usize>(position: &nalgebra::SVector<T, D>, bounds: &Bounds<T, D>) -> u32 {
    const BITS: usize = 4;
    let mut key = 0;
    for (axis, ((&x, &low), &high)) in position.iter().zip(bounds.low.iter()).zip(bounds.high.iter()).enumerate() {
        let cells = T::from_usize(1 << BITS);
        let cell = ((x - low) / (high - low) * cells).to_i32().clamp(0, (1 << BITS) - 1).unsigned_abs();
        for bit in 0..BITS {
            key |= (cell >> bit & 1) << (bit * D + axis);
        }
    }
    key
}
