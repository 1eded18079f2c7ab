//! The map update of one survivor: components in view, correction, births and reduction (5.17–5.22).

use crate::detection::confirmed::is_confirmed;
use crate::detection::normalise::Normalisers;
use crate::detection::scan::Scan;
use crate::detection::seen::Seen;
use crate::detection::view::View;
use crate::filter::newborn::Newborn;
use crate::filter::tally::Tally;
use crate::filter::waiting::memory::Noted;
use crate::map::Page;
use crate::map::reduce::{heavier, merge_and_cap};
use crate::map::workspace::{Entry, Origin, Workspace};
use crate::models::noise_at;
use crate::numerics::work;
use crate::report::watch::is_known;
use crate::{
    Births, Bounds, Component, Config, CovarianceOf, Dynamic, Feature, LnSum, MeasurementModel, Place, Pose,
    PositionOf, Probe, Real, ScalarOf, Stage, Static, Vector,
};

/// The scan from the pose of one survivor.
pub(crate) struct ScanView<'a, X: MeasurementModel> {
    pub(crate) view: View<'a, X>,
    /// Covariance of the pose, if it has one: added to that of the predicted measurements.
    pub(crate) pose_covariance: Option<CovarianceOf<X::Pose>>,
    /// The bounding box of the view.
    pub(crate) bounds: Bounds<PositionOf<X::Pose>>,
    pub(crate) scan: &'a Scan<'a, X::Measurement>,
    pub(crate) config: &'a Config<ScalarOf<X::Pose>>,
    pub(crate) births: &'a Births<ScalarOf<X::Pose>>,
    /// ln of [`Config::confirmed_weight`].
    pub(crate) ln_confirmed: ScalarOf<X::Pose>,
    /// The label of the scan's first measurement; those behind the last measurement are for the births that do not depend on
    /// measurements.
    pub(crate) first_label: u32,
    /// Landmarks with labels from this one on are not [known](is_known).
    pub(crate) known_below: u32,
    /// Number of measurements whose unexplained births are [delayed](crate::filter::waiting) until the next scan.
    pub(crate) births_wait: usize,
}

impl<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>> ScanView<'_, X> {
    /// Whether a component is confirmed, and is therefore kept. A component that cannot be measured from here is kept too. Not
    /// inlined, because it is rarely called and its code is large.
    #[inline(never)]
    fn confirms<N: Vector<Scalar = T>>(&self, component: &Component<N>) -> bool {
        let detections = self.config.confirming_detections;
        is_confirmed(self.view.sensor, &self.view.frame, self.pose_covariance.as_ref(), component, detections)
            .unwrap_or(true)
    }

    /// ln of the weight that a confirmed component in view keeps if misses would leave less; `None` otherwise.
    #[inline]
    fn ln_remembered<F: Feature<Position = PositionOf<X::Pose>>>(
        &self,
        component: &Component<F::State>,
        ln_missed: T,
    ) -> Option<T> {
        let ln_least = self.ln_confirmed.at_most(component.ln_weight);
        // A moving feature may have left.
        let falls_below = !F::MOVES && ln_missed < ln_least;
        (falls_below && self.confirms(component)).then_some(ln_least)
    }
}

/// The measurements that give birth in a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Measured {
    /// Measurements that features explain at least in part: their births are reduced together with the features.
    Explained,
    /// All others. A component near enough to be merged with their births would have explained them, so they need no reduction
    /// and can be delayed until the next scan.
    Unexplained,
}

/// Working memory for one survivor's maps of both kinds.
#[derive(Debug)]
pub(crate) struct Workspaces<'a, 'w, D: Place> {
    pub(crate) of_static: &'a mut Workspace<'w, D>,
    pub(crate) of_moving: &'a mut Workspace<'w, D::Moving>,
}

impl<T: Real, D: Place<Scalar = T>> Workspaces<'_, '_, D> {
    /// Adds the updated births that the sensor expects independent of measurements.
    #[inline]
    pub(crate) fn add_expected_births<X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>>>(
        &mut self,
        scan_view: &ScanView<'_, X>,
        eta: &mut [LnSum<T>],
        seen: &mut Seen<T>,
        tally: &mut Tally<T>,
    ) {
        let first_birth = scan_view.first_label.wrapping_add(scan_view.scan.len() as u32);
        for (index, birth) in scan_view.view.expected_births() {
            let birth = Component { label: first_birth.wrapping_add(index as u32), ..birth };
            if let Some((probability, _)) =
                self.of_static.update_component::<Static<D>, X>(&birth, scan_view, eta, tally)
            {
                seen.add(probability, birth.ln_weight.exp());
            }
        }
    }

    /// Completes the updated map: normalises, prunes, adds births, and reduces.
    #[inline]
    pub(crate) fn complete<X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>>>(
        &mut self,
        scan_view: &ScanView<'_, X>,
        normalisers: &Normalisers<'_, T>,
        next_label: &mut u32,
        noted: &mut Noted<T>,
        tally: &mut Tally<T>,
        probe: &mut impl Probe,
    ) {
        let (config, known) = (scan_view.config, (scan_view.known_below, scan_view.first_label));
        self.of_static.weigh_detections::<Static<D>>(normalisers, known, tally);
        self.of_moving.weigh_detections::<Dynamic<D>>(normalisers, known, tally);
        *noted = Noted::NOTHING;
        self.give_birth(scan_view, normalisers, Measured::Explained, noted, tally);
        probe.enter(Stage::Reduce);
        self.note_components(tally);
        self.of_static.reduce(config, next_label, tally);
        self.of_moving.reduce(config, next_label, tally);
        probe.leave(Stage::Reduce);
        self.give_birth(scan_view, normalisers, Measured::Unexplained, noted, tally);
        self.note_components(tally);
    }

    /// Stores the largest number of components in the workspaces.
    fn note_components(&self, tally: &mut Tally<T>) {
        let held = [self.of_static.len(), self.of_moving.len()];
        tally.peaks.iter_mut().zip(held).for_each(|(peak, held)| peak.in_view = peak.in_view.max(held));
    }

    /// Adds a static and a moving component of weight w_b/η_z at h⁻¹(z, x) for each of the selected measurements (5.9, 5.10,
    /// 5.17), or notes them as delayed births.
    fn give_birth<X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>>>(
        &mut self,
        scan_view: &ScanView<'_, X>,
        normalisers: &Normalisers<'_, T>,
        births_on: Measured,
        noted: &mut Noted<T>,
        tally: &mut Tally<T>,
    ) {
        let ScanView { view, pose_covariance, scan, config, births, first_label, births_wait, .. } = scan_view;
        let (of_static, of_moving) = (&mut *self.of_static, &mut *self.of_moving);
        let (ln_static, ln_moving) = (births.of_static.ln(), births.of_moving.ln());
        let waiting = if births_on == Measured::Unexplained { *births_wait } else { 0 };
        let mut last = [(T::NEG_INFINITY, T::ZERO); 2];
        for (index, (ln_normaliser, measurement)) in normalisers.each_ln().zip(scan.iter()).enumerate() {
            let ln_eta = measurement.ln_reference() - ln_normaliser;
            if measurement.is_explained(ln_eta) != (births_on == Measured::Explained) {
                continue;
            }
            let ln_static = Some(ln_static - ln_eta).filter(|&ln_weight| ln_weight >= of_static.ln_floor());
            let ln_moving = Some(ln_moving - ln_eta).filter(|&ln_weight| ln_weight >= of_moving.ln_floor());
            if ln_static.is_none() && ln_moving.is_none() {
                continue;
            }
            if index < waiting && noted.note(index, [ln_static, ln_moving], &mut last) {
                tally.births += usize::from(ln_static.is_some()) + usize::from(ln_moving.is_some());
                continue;
            }
            let Some(newborn) = Newborn::of(view, pose_covariance.as_ref(), &measurement.z) else {
                tally.no_birth += 1;
                continue;
            };
            tally.repaired += usize::from(newborn.repaired);
            let label = first_label.wrapping_add(index as u32);
            if let Some(ln_weight) = ln_static {
                of_static.push(&newborn.still(label, ln_weight), Origin::Born);
                tally.births += 1;
            }
            if let Some(ln_weight) = ln_moving {
                of_moving.push(&newborn.moving(label, ln_weight, config.moving.velocity_sigma_mps), Origin::Born);
                tally.births += 1;
            }
        }
    }
}

impl<T: Real, N: Vector<Scalar = T>> Workspace<'_, N> {
    /// Adds a component after a miss and after each of its detections, and its terms to η_z. Returns p_D and ln of w (1 − p_D);
    /// `None` if it is out of view.
    pub(crate) fn update_component<
        F: Feature<State = N, Position = PositionOf<X::Pose>>,
        X: MeasurementModel<Pose: Pose<Scalar = T>>,
    >(
        &mut self,
        component: &Component<N>,
        scan_view: &ScanView<'_, X>,
        eta: &mut [LnSum<T>],
        tally: &mut Tally<T>,
    ) -> Option<(T, T)> {
        let ScanView { view, pose_covariance, scan, .. } = scan_view;
        let mut expectation = view.expect(component)?;
        let mut noise = noise_at(view.sensor, &expectation.expected().measurement);
        if let Some(pose_covariance) = pose_covariance {
            let blur =
                view.blur(pose_covariance, &component.position::<PositionOf<X::Pose>>(), &expectation.expected());
            expectation.blur(&blur);
            noise = noise.plus(&blur);
        }
        let ln_missed = component.ln_weight + expectation.detection.ln_missed;
        let (ln_weight, origin) = match scan_view.ln_remembered::<F>(component, ln_missed) {
            // At most this weight: its detections are subtracted later.
            Some(ln_least) => (ln_least, Origin::Remembered { ln_missed }),
            None => (ln_missed, Origin::Missed),
        };
        if let Some(slot) = self.place(ln_weight) {
            *slot = Entry { component: Component { ln_weight, ..*component }, origin };
        }
        let mut correction = None;
        view.matches(&expectation, scan, |found| {
            if let Some(eta) = eta.get_mut(found.index) {
                eta.add(found.ln_term);
            }
            // η_z is not complete yet; its value without features gives an upper bound of the weight.
            let ln_bound = found.ln_term - found.ln_reference;
            if ln_bound >= self.ln_floor() {
                let correction = correction.get_or_insert_with(|| {
                    let correction = expectation.correction(component, &noise, found.factor);
                    tally.repaired += usize::from(correction.repaired());
                    correction
                });
                if let Some(slot) = self.place(ln_bound) {
                    let origin = Origin::Detected { measurement: found.index as u16, distance: found.distance };
                    *slot = Entry { component: correction.apply(component, &found.innovation, ln_bound), origin };
                }
            }
        });
        Some((expectation.detection.probability, ln_missed))
    }

    /// Adds the updated components of a page, and its components out of view unchanged. Returns whether any is in view, so that
    /// the page must be rewritten.
    #[inline(always)]
    pub(crate) fn update_page<
        F: Feature<State = N, Position = PositionOf<X::Pose>>,
        X: MeasurementModel<Pose: Pose<Scalar = T>>,
    >(
        &mut self,
        page: &Page<F>,
        scan_view: &ScanView<'_, X>,
        ln_unconfirmed: T,
        eta: &mut [LnSum<T>],
        seen: &mut Seen<T>,
        tally: &mut Tally<T>,
    ) -> bool {
        let bounds = &scan_view.bounds;
        let outside = self.outside();
        // A page without components is not kept.
        let mut in_view = page.components().is_empty();
        if page.bounds().meets(bounds) {
            let within = bounds.covers(page.bounds());
            for (component, weight) in page.weighted() {
                let near = within || bounds.holds(&component.position());
                if near
                    && let Some((probability, ln_missed)) =
                        self.update_component::<F, X>(component, scan_view, eta, tally)
                {
                    seen.add(probability, weight);
                    if !F::MOVES && is_known(component.label, scan_view.known_below, scan_view.first_label) {
                        tally.known(weight, probability * weight, ln_missed.exp());
                    }
                    in_view = true;
                } else {
                    self.push_outside(component);
                }
            }
        }
        if in_view {
            self.retain_outside(outside, |component| {
                component.ln_weight >= ln_unconfirmed || scan_view.confirms(component)
            });
        } else {
            self.forget_outside(outside);
        }
        in_view
    }

    /// Subtracts the weights of the detections of a confirmed component, except detections that will be pruned, from the weight
    /// that it keeps, but leaves at least w (1 − p_D). Adds the difference for known landmarks to the counts.
    fn settle_remembered(
        &mut self,
        normalisers: &Normalisers<'_, T>,
        (known_below, first_label): (u32, u32),
        tally: &mut Tally<T>,
    ) {
        let ln_floor = self.ln_floor();
        let mut rest = self.in_view_mut();
        while let Some((entry, after)) = rest.split_first_mut() {
            work::round();
            rest = after;
            let Origin::Remembered { ln_missed } = entry.origin else { continue };
            entry.origin = Origin::Missed;
            let label = entry.component.label;
            let mut detected = T::ZERO;
            for Entry { component, origin } in rest.iter() {
                match *origin {
                    Origin::Detected { measurement, .. } if component.label == label => {
                        let ln_weight = component.ln_weight + normalisers.ln(usize::from(measurement));
                        if ln_weight >= ln_floor {
                            detected += ln_weight.exp();
                        }
                    }
                    _ => break,
                }
            }
            let (least, missed) = (entry.component.ln_weight.exp(), ln_missed.exp());
            let mut left = least;
            // A component without detections keeps its weight to the last bit.
            if detected > T::ZERO {
                left = (least - detected).at_least(missed);
                entry.component.ln_weight = if left > missed { left.ln() } else { ln_missed };
            }
            if is_known(label, known_below, first_label) {
                tally.known(T::ZERO, T::ZERO, left - missed);
            }
        }
    }

    /// Normalises the detections, which divides them by η_z, and prunes (5.18).
    fn weigh_detections<F: Feature<State = N>>(
        &mut self,
        normalisers: &Normalisers<'_, T>,
        known: (u32, u32),
        tally: &mut Tally<T>,
    ) {
        self.settle_remembered(normalisers, known, tally);
        let (known_below, first_label) = known;
        self.prune(|Entry { component, origin }| {
            let Origin::Detected { measurement, distance } = *origin else { return None };
            component.ln_weight += normalisers.ln(usize::from(measurement));
            let is_known = !F::MOVES && is_known(component.label, known_below, first_label);
            let weight = component.ln_weight.exp();
            tally.detected(weight, distance, is_known);
            Some(weight)
        });
    }

    /// Merges and caps the components in view, and makes their labels unique.
    fn reduce(&mut self, config: &Config<T>, next_label: &mut u32, tally: &mut Tally<T>) {
        tally.merged += merge_and_cap(self, config.merge_distance, config.max_components);
        self.make_labels_unique(next_label);
    }

    /// Adds the components that the workspace removed, for their weight or for lack of room, to the counts of the scan.
    pub(crate) fn count(&self, tally: &mut Tally<T>) {
        tally.tightened += usize::from(self.tightened());
        tally.lost += self.lost();
        tally.pruned_mass += self.pruned_mass();
    }

    /// Makes labels unique: the copies of a component, missed and detected, that have not been merged have the same label and are
    /// adjacent. The heaviest keeps the label, the others get new ones.
    fn make_labels_unique(&mut self, next_label: &mut u32) {
        let mut rest = self.in_view_mut();
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
}
