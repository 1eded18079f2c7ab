//! The update of the survivors' maps (5.17–5.22), after their weights are known.

use crate::detection::confirmed::is_confirmed;
use crate::detection::explain::ln_likelihood;
use crate::detection::normalise::Normalisers;
use crate::detection::scan::Scan;
use crate::detection::seen::{Seen, Weighed, reset_eta};
use crate::detection::view::View;
use crate::filter::tally::Tally;
use crate::map::reduce::{heavier, keep_heaviest, merge_and_cap};
use crate::map::workspace::{Entry, Origin, Workspace};
use crate::map::{Maps, PAGE_LEN};
use crate::numerics::range::is_within_range;
use crate::numerics::sort::BUCKETS;
use crate::numerics::work;
use crate::{
    Births, Bounds, Component, Config, Dynamic, Feature, InverseOf, Likelihood, LnSum, MeasurementModel, Place, Pose,
    PositionOf, Probe, Real, ScalarOf, Sensor, Stage, Static, Symmetric, TangentOf, Vector,
};

/// Which map to update, where to put it, and what share of the pool it may take.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Task {
    /// The particle whose predicted map is updated.
    parent: usize,
    /// The particle that gets the updated map.
    particle: usize,
    /// No later survivor needs the parent's map.
    last_child: bool,
    /// Maps still to be updated, this one included.
    remaining: usize,
}

/// The scan as one survivor's pose sees it.
struct ScanView<'a, X: MeasurementModel> {
    view: View<'a, X>,
    /// Covariance of the pose, where it is not certain: it blurs what is expected.
    pose_covariance: Option<Symmetric<TangentOf<X::Pose>>>,
    /// Outside nothing is in view.
    bounds: Bounds<PositionOf<X::Pose>>,
    scan: &'a Scan<'a, X::Measurement>,
    config: &'a Config<ScalarOf<X::Pose>>,
    /// ln of [`Config::confirmed_weight`].
    ln_confirmed: ScalarOf<X::Pose>,
    /// The label of the scan's first measurement; after the last one come the births that did not wait for one.
    first_label: u32,
    /// Landmarks with lesser labels are known.
    known_below: u32,
}

impl<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>> ScanView<'_, X> {
    /// Whether a component is better known than from the few measurements that confirm it. Seldom asked, and not small.
    #[inline(never)]
    fn confirms<N: Vector<Scalar = T>>(&self, component: &Component<N>) -> bool {
        let detections = self.config.confirming_detections;
        is_confirmed(self.view.sensor, &self.view.frame, self.pose_covariance.as_ref(), component, detections)
    }

    /// ln of the weight of a component in view that was not detected.
    #[inline]
    fn ln_missed<F: Feature<Position = PositionOf<X::Pose>>>(
        &self,
        component: &Component<F::State>,
        ln_missed: T,
    ) -> T {
        let ln_weight = component.ln_weight + ln_missed;
        // What moves may have gone.
        if F::MOVES {
            return ln_weight;
        }
        let ln_least = self.ln_confirmed.at_most(component.ln_weight);
        if ln_weight < ln_least && self.confirms(component) { ln_least } else { ln_weight }
    }
}

/// Which of a scan's births.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Newborn {
    /// On measurements that features explain, at least in part: to be reduced together with them.
    Explained,
    /// On all other measurements. Whatever they could be merged with would have explained those; so they wait for the next scan.
    Unexplained,
}

/// All maps of both kinds, and the scratch that they share.
#[derive(Debug)]
pub(crate) struct Update<'a, 's, D: Place> {
    pub(crate) static_maps: &'a mut Maps<'s, Static<D>>,
    pub(crate) moving_maps: &'a mut Maps<'s, Dynamic<D>>,
    /// Scratch: η_z of one survivor after the other, then their normalisers.
    pub(crate) eta: &'a mut [LnSum<D::Scalar>],
    pub(crate) births: &'a Births<D::Scalar>,
    pub(crate) config: &'a Config<D::Scalar>,
    /// Whether the tally is to tell how well the last of the survivors explains the scan.
    pub(crate) weighs: bool,
    /// The label of the scan's first measurement; afterwards the first that has not been given away.
    pub(crate) next_label: &'a mut u32,
    /// Landmarks with lesser labels are known.
    pub(crate) known_below: u32,
}

impl<T: Real, D: Place<Scalar = T>> Update<'_, '_, D> {
    /// Gives every particle the updated map of the survivor it continues, and frees the maps without one.
    ///
    /// There were `parents` particles before. Survivors come in ascending order of parents; `parent_of` tells a survivor's,
    /// `look` its view. Copies of one survivor share its map. A parent's last child takes its map over, so that without a
    /// resampling every map is rewritten in its own place, and what it does not see is not touched.
    pub(crate) fn all<'v, X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>> + 'v>(
        mut self,
        survivors: &[u16],
        parents: usize,
        parent_of: impl Fn(u16) -> usize,
        look: impl Fn(u16) -> Option<(View<'v, X>, Option<Symmetric<TangentOf<X::Pose>>>)>,
        scan: &Scan<'_, X::Measurement>,
        probe: &mut impl Probe,
    ) -> Tally<T> {
        let mut tally = Tally::new();
        let eta = core::mem::take(&mut self.eta);
        let ln_confirmed = self.config.confirmed_weight.ln();
        let first_label = *self.next_label;
        let first_look = survivors.first().and_then(|&survivor| look(survivor));
        let (most_births, more) = first_look.map_or((0, false), |(view, _)| view.count_births());
        tally.lost += usize::from(more);
        *self.next_label = first_label.wrapping_add((scan.len() + most_births) as u32);
        for (peak, pages) in tally.peaks.iter_mut().zip([self.static_maps.pages_used(), self.moving_maps.pages_used()])
        {
            peak.pages = pages;
        }
        self.static_maps.table.begin(parents);
        self.moving_maps.table.begin(parents);
        let mut alive = survivors.iter().map(|&survivor| parent_of(survivor)).peekable();
        for parent in 0..parents {
            if alive.next_if_eq(&parent).is_none() {
                self.static_maps.table.let_go(parent, &mut self.static_maps.pool);
                self.moving_maps.table.let_go(parent, &mut self.moving_maps.pool);
            }
            while alive.next_if_eq(&parent).is_some() {
                work::round();
            }
        }
        tally.survivors = runs(survivors).count();
        let mut remaining = tally.survivors;
        let mut particle = 0;
        let mut copies = runs(survivors).peekable();
        while let Some(copy) = copies.next() {
            work::round();
            let Some(&survivor) = copy.first() else { continue };
            let parent = parent_of(survivor);
            let last_child = copies.peek().and_then(|next| next.first()).is_none_or(|&next| parent_of(next) != parent);
            if let Some((view, pose_covariance)) = look(survivor) {
                // As many as there are labels for.
                let view = View { most_births, ..view };
                let task = Task { parent, particle, last_child, remaining };
                let bounds = view.bounds();
                let (config, known_below) = (self.config, self.known_below);
                let scan_view =
                    ScanView { view, pose_covariance, bounds, scan, config, ln_confirmed, first_label, known_below };
                self.one(task, &scan_view, eta, &mut tally, probe);
            }
            for twin in 1..copy.len() {
                self.static_maps.table.share_updated(particle, particle + twin, &mut self.static_maps.pool);
                self.moving_maps.table.share_updated(particle, particle + twin, &mut self.moving_maps.pool);
            }
            particle += copy.len();
            remaining -= 1;
        }
        self.static_maps.table.finish(survivors.len());
        self.moving_maps.table.finish(survivors.len());
        tally
    }

    /// Updates one survivor's map as seen from its pose, reduces it and writes it to fresh pages. Pages out of view
    /// are shared with the parent.
    fn one<X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>>>(
        &mut self,
        task: Task,
        scan_view: &ScanView<'_, X>,
        eta: &mut [LnSum<T>],
        tally: &mut Tally<T>,
        probe: &mut impl Probe,
    ) {
        reset_eta(eta, scan_view.scan);
        let mut seen = Seen::NOTHING;
        let regained_static = self.static_maps.collect(task, self.config, scan_view, eta, &mut seen, tally);
        let first_birth = scan_view.first_label.wrapping_add(scan_view.scan.len() as u32);
        for (index, birth) in scan_view.view.expected_births() {
            let birth = Component { label: first_birth.wrapping_add(index as u32), ..birth };
            if let Some((probability, _)) =
                self.static_maps.workspace.look_at::<Static<D>, X>(&birth, scan_view, eta, tally)
            {
                seen.add(probability, birth.ln_weight.exp());
            }
        }
        let regained_moving = self.moving_maps.collect(task, self.config, scan_view, eta, &mut seen, tally);
        tally.expected_detections += seen.expected_detections;
        if self.weighs {
            let ln_likelihood = ln_likelihood(Likelihood::SingleCluster, &scan_view.view, &seen, scan_view.scan, eta);
            tally.last = Weighed { ln_likelihood, in_view: seen.in_view };
        }
        let normalisers = Normalisers::of(eta, scan_view.scan);
        self.static_maps.weigh_detections(&normalisers, self.known_below, tally);
        self.moving_maps.weigh_detections(&normalisers, self.known_below, tally);
        self.give_birth(scan_view, &normalisers, Newborn::Explained, tally);
        probe.enter(Stage::Reduce);
        self.note_components(tally);
        self.static_maps.reduce(self.config, self.next_label, tally);
        self.moving_maps.reduce(self.config, self.next_label, tally);
        probe.leave(Stage::Reduce);
        self.give_birth(scan_view, &normalisers, Newborn::Unexplained, tally);
        self.note_components(tally);
        self.static_maps.count(tally);
        self.moving_maps.count(tally);
        let static_stored = self.static_maps.store(task, regained_static, &scan_view.bounds, tally);
        let moving_stored = self.moving_maps.store(task, regained_moving, &scan_view.bounds, tally);
        let taken = [self.static_maps.taken(task.particle), self.moving_maps.taken(task.particle)];
        for (peak, (pages, map_pages)) in tally.peaks.iter_mut().zip(taken) {
            (peak.pages, peak.map_pages) = (peak.pages.max(pages), peak.map_pages.max(map_pages));
        }
        if static_stored && moving_stored {
            tally.updated += 1;
        } else {
            tally.kept += 1;
        }
    }

    /// How many components the workspaces hold.
    fn note_components(&self, tally: &mut Tally<T>) {
        let held = [self.static_maps.workspace.len(), self.moving_maps.workspace.len()];
        tally.peaks.iter_mut().zip(held).for_each(|(peak, held)| peak.in_view = peak.in_view.max(held));
    }

    /// Adds components of weight w_b/η_z at h⁻¹(z, x) for the measurements of which the births are asked for, a static and a moving
    /// one each (5.9, 5.10, 5.17).
    fn give_birth<X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>>>(
        &mut self,
        scan_view: &ScanView<'_, X>,
        normalisers: &Normalisers<'_, T>,
        births: Newborn,
        tally: &mut Tally<T>,
    ) {
        let ScanView { view, pose_covariance, scan, first_label, .. } = scan_view;
        let (of_static, of_moving) = (&mut self.static_maps.workspace, &mut self.moving_maps.workspace);
        let (ln_static, ln_moving) = (self.births.of_static.ln(), self.births.of_moving.ln());
        let velocity_variance = self.config.moving.velocity_sigma_mps * self.config.moving.velocity_sigma_mps;
        for (index, (ln_normaliser, measurement)) in normalisers.each_ln().zip(scan.iter()).enumerate() {
            let ln_eta = measurement.ln_reference() - ln_normaliser;
            if measurement.is_explained(ln_eta) != (births == Newborn::Explained) {
                continue;
            }
            let ln_static = Some(ln_static - ln_eta).filter(|&ln_weight| ln_weight >= of_static.ln_floor());
            let ln_moving = Some(ln_moving - ln_eta).filter(|&ln_weight| ln_weight >= of_moving.ln_floor());
            if ln_static.is_none() && ln_moving.is_none() {
                continue;
            }
            // A feature out of view cannot have caused the measurement; born there, it would never be missed and stay.
            let inverse = view.sensor.invert(&view.frame, &measurement.z);
            let in_view = |inverse: &InverseOf<X::Sensor>| {
                view.sees(&inverse.feature, &measurement.z) && inverse.feature.as_slice().iter().all(|x| x.is_finite())
            };
            let Some(inverse) = inverse.filter(in_view) else {
                tally.no_birth += 1;
                continue;
            };
            let mut noise = *view.sensor.noise();
            if let Some(pose_covariance) = pose_covariance
                && let Some(expected) = view.sensor.expect(&view.frame, &inverse.feature)
            {
                noise = noise.plus(&view.blur(pose_covariance, &inverse.feature, &expected));
            }
            // Nor does anything come of one that is uncertain beyond the range of the scalar.
            let place = noise.congruence::<D>(&inverse.jacobian).kept_positive_definite();
            let Some((place, repaired)) = place.filter(|_| is_within_range(&inverse.feature)) else {
                tally.no_birth += 1;
                continue;
            };
            tally.repaired += usize::from(repaired);
            let label = first_label.wrapping_add(index as u32);
            if let Some(ln_weight) = ln_static {
                of_static.push(Component { label, ln_weight, mean: inverse.feature, covariance: place }, Origin::Born);
                tally.births += 1;
            }
            if let Some(ln_weight) = ln_moving {
                let mean = D::Moving::with(|row| inverse.feature.at(row));
                let covariance = Symmetric::from_fn(|row, column| {
                    let velocity = if row == column { velocity_variance } else { T::ZERO };
                    if row < D::DIMENSION { place.get(row, column) } else { velocity }
                });
                of_moving.push(Component { label, ln_weight, mean, covariance }, Origin::Born);
                tally.births += 1;
            }
        }
    }
}

impl<T: Real, N: Vector<Scalar = T>> Workspace<'_, N> {
    /// Adds what becomes of one component, and its terms to η_z. Returns p_D and ln of the weight that is left of a miss; `None`
    /// where it is out of view.
    fn look_at<F, X>(
        &mut self,
        component: &Component<N>,
        scan_view: &ScanView<'_, X>,
        eta: &mut [LnSum<T>],
        tally: &mut Tally<T>,
    ) -> Option<(T, T)>
    where
        F: Feature<State = N, Position = PositionOf<X::Pose>>,
        X: MeasurementModel<Pose: Pose<Scalar = T>>,
    {
        let ScanView { view, pose_covariance, scan, .. } = scan_view;
        let mut expectation = view.expect(component)?;
        let mut noise = *view.sensor.noise();
        if let Some(pose_covariance) = pose_covariance {
            let blur =
                view.blur(pose_covariance, &component.position::<PositionOf<X::Pose>>(), &expectation.expected());
            expectation = expectation.blurred(&blur);
            noise = noise.plus(&blur);
        }
        let ln_weight = scan_view.ln_missed::<F>(component, expectation.detection.ln_missed);
        self.push(Component { ln_weight, ..*component }, Origin::Missed);
        let mut correction = None;
        view.matches(&expectation, scan, |found| {
            if let Some(eta) = eta.get_mut(found.index) {
                eta.add(found.ln_term);
            }
            // η_z is not complete yet; what it is without features bounds the weight from above.
            let ln_bound = found.ln_term - found.ln_reference;
            if ln_bound >= self.ln_floor() {
                let correction = correction.get_or_insert_with(|| {
                    let correction = expectation.correction(component, &noise, found.factor);
                    tally.repaired += usize::from(correction.repaired());
                    correction
                });
                let origin = Origin::Detected { measurement: found.index as u16, distance: found.distance };
                self.push(correction.apply(component, &found.innovation, ln_bound), origin);
            }
        });
        Some((expectation.detection.probability, ln_weight))
    }
}

/// The steps of one map's update, for features of either kind.
impl<T: Real, F: Feature<Position: Place<Scalar = T>>> Maps<'_, F> {
    /// Makes the parent's map the particle's, fills the workspace with what becomes of the components in view, η_z with their
    /// terms, and puts their pages aside. Returns how many of those nobody else holds.
    fn collect<X: MeasurementModel<Pose: Pose<Scalar = T, Position = F::Position>>>(
        &mut self,
        task: Task,
        config: &Config<T>,
        scan_view: &ScanView<'_, X>,
        eta: &mut [LnSum<T>],
        seen: &mut Seen<F::Position>,
        tally: &mut Tally<T>,
    ) -> usize {
        let Maps { table, pool, workspace } = self;
        let bounds = &scan_view.bounds;
        table.take_on(task.parent, task.particle, task.last_child, pool);
        // What moves does not stay where it was sorted out.
        if !F::MOVES {
            table.sort_out(task.particle, bounds, pool);
        }
        workspace.clear(config.prune_weight.ln());
        let ln_unconfirmed = config.unconfirmed_weight.ln();
        let mut regained = 0;
        table.retain_near(task.particle, |id| {
            let Some(page) = pool.get(id) else { return true };
            let outside = workspace.outside();
            // A page whose last component was dropped is not carried on.
            let mut in_view = page.components().is_empty();
            if page.bounds().meets(bounds) {
                let within = bounds.covers(page.bounds());
                for (component, weight) in page.weighted() {
                    let near = within || bounds.holds(&component.position());
                    if near
                        && let Some((probability, ln_missed)) =
                            workspace.look_at::<F, X>(component, scan_view, eta, tally)
                    {
                        seen.add(probability, weight);
                        if !F::MOVES && component.label < scan_view.known_below {
                            tally.known.weight += weight;
                            tally.known.expected += probability * weight;
                            tally.known.missed += ln_missed.exp();
                        }
                        in_view = true;
                    } else {
                        workspace.push_outside(*component);
                    }
                }
            }
            if in_view {
                workspace.retain_outside(outside, |component| {
                    component.ln_weight >= ln_unconfirmed || scan_view.confirms(component)
                });
                regained += usize::from(pool.references(id) == 1);
            } else {
                workspace.forget_outside(outside);
            }
            !in_view
        });
        regained
    }

    /// Normalises the detections, which divides them by η_z, and prunes (5.18).
    fn weigh_detections(&mut self, normalisers: &Normalisers<'_, T>, known_below: u32, tally: &mut Tally<T>) {
        self.workspace.retain(|Entry { component, origin }| {
            if let Origin::Detected { measurement, distance } = *origin {
                component.ln_weight += normalisers.ln(usize::from(measurement));
                let weight = component.ln_weight.exp();
                tally.innovation.0 += weight * distance;
                tally.innovation.1 += weight;
                if !F::MOVES && component.label < known_below {
                    tally.known.detected += weight;
                }
            }
            true
        });
        self.workspace.prune();
    }

    /// Merges, caps and names what is in view.
    fn reduce(&mut self, config: &Config<T>, next_label: &mut u32, tally: &mut Tally<T>) {
        tally.merged += merge_and_cap(&mut self.workspace, config.merge_distance, config.max_components);
        self.tell_apart(next_label);
    }

    /// Adds what the workspace dropped, for its weight or for want of room, to the counts of the scan.
    fn count(&self, tally: &mut Tally<T>) {
        tally.tightened += usize::from(self.workspace.tightened());
        tally.lost += self.workspace.lost();
        tally.pruned_mass += self.workspace.pruned_mass();
    }

    /// What one component has become, missed or detected, and has not been merged since, bears one label, and stands side
    /// by side: the heaviest keeps the label, the others get fresh ones.
    fn tell_apart(&mut self, next_label: &mut u32) {
        let mut rest = self.workspace.in_view_mut();
        while let Some(label) = rest.first().map(|entry| entry.component.label) {
            work::round();
            let len = rest.iter().take_while(|entry| entry.component.label == label).count();
            let Some((copies, after)) = rest.split_at_mut_checked(len) else { break };
            rest = after;
            if copies.len() < 2 {
                continue;
            }
            let mut keeper = 0;
            for (place, copy) in copies.iter().enumerate() {
                if copies.get(keeper).is_some_and(|held| heavier(&copy.component, &held.component)) {
                    keeper = place;
                }
            }
            for (_, copy) in copies.iter_mut().enumerate().filter(|&(place, _)| place != keeper) {
                copy.component.label = *next_label;
                *next_label = next_label.wrapping_add(1);
            }
        }
    }

    /// Writes the updated map, or leaves the predicted one, `false`, where not even its confirmed components find room.
    fn store(&mut self, task: Task, regained: usize, bounds: &Bounds<F::Position>, tally: &mut Tally<T>) -> bool {
        let share = self.pool.free().checked_div(task.remaining).unwrap_or(0) + regained;
        let fits = self.fit(self.table.room(task.particle).min(share), tally);
        if fits {
            self.table.drop_aside(&mut self.pool);
            self.write(task.particle, bounds, tally);
        } else {
            self.table.take_back(task.particle);
        }
        fits
    }

    /// Pages of the pool, and those of the particle's updated map, while the scan goes on.
    fn taken(&self, particle: usize) -> (usize, usize) {
        let map_pages = self.table.map_pages().saturating_sub(self.table.room(particle));
        (self.pages_used(), map_pages)
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
        let confirmed = |entry: &Entry<F::State>| entry.component.ln_weight >= ln_half;
        let class = |entry: &Entry<F::State>| match entry.origin {
            Origin::Born if confirmed(entry) => 1,
            _ if confirmed(entry) => 0,
            _ => 2,
        };
        if self.workspace.in_view().iter().filter(|entry| class(entry) == 0).count() > limit {
            return false;
        }
        tally.tightened += 1;
        keep_heaviest(&mut self.workspace, limit, class);
        true
    }

    /// Writes the workspace to fresh pages, in spatial order, so that the pages' boxes stay small.
    fn write(&mut self, particle: usize, bounds: &Bounds<F::Position>, tally: &mut Tally<T>) {
        let cells = morton_cells(bounds);
        let (entries, order) = self.workspace.in_order(|component| morton(&component.position(), bounds, &cells));
        for chunk in order.chunks(PAGE_LEN) {
            let Some((id, page)) = self.pool.take() else {
                tally.lost += chunk.len();
                continue;
            };
            let components = chunk.iter().filter_map(|ranked| entries.get(usize::from(ranked.entry)));
            page.fill(components.map(|entry| &entry.component));
            if !self.table.push_updated(particle, id) {
                self.pool.release(id);
                tally.lost += chunk.len();
            }
        }
    }
}

/// Bits of each coordinate along the Morton curve.
const fn morton_bits<D: Vector>() -> u32 {
    // Four at most, for the table of the spaced cells.
    let bits = BUCKETS.ilog2() / D::DIMENSION as u32;
    if bits > 4 { 4 } else { bits }
}

/// Cells of the Morton curve per unit of each coordinate.
fn morton_cells<T: Real, D: Vector<Scalar = T>>(bounds: &Bounds<D>) -> D {
    let cells = T::from_usize(1 << const { morton_bits::<D>() });
    let extent = bounds.high - bounds.low;
    D::with(|k| cells / extent.at(k))
}

/// Place of a position along a Morton curve over `bounds`, as a [bucket](BUCKETS).
#[inline]
fn morton<T: Real, D: Vector<Scalar = T>>(position: &D, bounds: &Bounds<D>, per_unit: &D) -> usize {
    let offset = *position - bounds.low;
    let places = D::with(|k| offset.at(k) * per_unit.at(k));
    let mut key = 0;
    for (axis, place) in places.as_slice().iter().enumerate() {
        let cell = place.to_i32().clamp(0, (1 << const { morton_bits::<D>() }) - 1).unsigned_abs();
        let spaced = const { spaced::<D>() };
        key |= usize::from(spaced.get(cell as usize).copied().unwrap_or(0)) << axis;
    }
    key
}

/// The bits of every cell along an axis, D apart.
#[expect(clippy::indexing_slicing, reason = "evaluated by the compiler alone")]
const fn spaced<D: Vector>() -> [u8; 16] {
    let mut spaced = [0; 16];
    let mut cell = 0;
    while cell < spaced.len() {
        let mut bit = 0;
        while bit < morton_bits::<D>() {
            spaced[cell] |= ((cell >> bit & 1) << (bit * D::DIMENSION as u32)) as u8;
            bit += 1;
        }
        cell += 1;
    }
    spaced
}

/// The survivors in runs of equal ones. The standard library's `chunk_by` has a panic that the compiler cannot see to
/// be out of reach.
fn runs(mut survivors: &[u16]) -> impl Iterator<Item = &[u16]> {
    core::iter::from_fn(move || {
        let first = survivors.first()?;
        let len = survivors.iter().take_while(|&survivor| survivor == first).count();
        let (run, rest) = survivors.split_at_checked(len)?;
        survivors = rest;
        Some(run)
    })
}
