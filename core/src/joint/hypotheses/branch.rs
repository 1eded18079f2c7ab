//! One measurement: every hypothesis has children, of which the likeliest are kept.

use super::super::correct::move_by;
use super::super::filter::JointSlam;
use super::super::innovation_statistics::LEAST_DETECTED;
use super::super::movers::{Movers, NONE};
use super::causes::{Cause, causes_of};
use super::children::{Child, Children};
use super::filter::MultiHypothesisSlam;
use super::scan::{Branch, Branches};
use super::{MOST, joining};
use crate::models::OnVehicle;
use crate::{LnSum, MeasurementModel, Motion, Pose, Real, Serial, Vector};

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    MultiHypothesisSlam<'s, M, Z, V, OTHERS>
{
    /// Updates all hypotheses with one measurement of the scan. At most as many children are kept as there are places.
    pub(super) fn branch<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        models: &OnVehicle<'_, X>,
        measurements: &[X::Measurement],
        index: usize,
        branches: &mut Branches<T>,
    ) {
        let Some(z) = measurements.get(index) else { return };
        let ln_new = self.slam.memory.association_table.get(index).map_or(T::NEG_INFINITY, |row| row.ln_lambda);
        let mut children = Children::new(self.places());
        for (place, ln_weight) in branches.alive() {
            children.add(Child { place, cause: Cause::NEW }, ln_weight + ln_new);
            let causes = self.with(place, |slam| causes_of(models, &slam.config, &slam.memory, &slam.movers, z));
            for &(cause, ln_odds) in causes.all() {
                children.add(Child { place, cause }, ln_weight + ln_odds);
            }
        }
        branches.saturated += usize::from(children.prune(self.config.least_ratio));
        if children.all().is_empty() {
            // No hypothesis explains the measurement.
            return;
        }
        self.place(&mut children, branches);
        let mut kept: [Option<usize>; MOST] = [None; MOST];
        for (&(Child { place, cause }, ln_weight), number) in children.all().iter().zip(0..) {
            let Some(branch) = branches.list.get_mut(place) else { continue };
            branch.ln_weight = ln_weight;
            let tally = &mut branch.tally;
            self.with(place, |slam| {
                cause.store(index, &mut slam.memory, &mut slam.movers);
                slam.correct_by(cause, models, measurements.get(index..=index).unwrap_or(&[]), tally);
            });
            let earlier = kept.iter().flatten().copied();
            let alike = self.estimate_of(place).and_then(|estimate| {
                let mut earlier = earlier.filter_map(|other| Some((other, self.estimate_of(other)?)));
                earlier.find(|(_, other)| joining::are_alike(other, &estimate, self.config.joined_sigmas))
            });
            match alike {
                // The earlier child is the likelier one.
                Some((other, _)) => branches.join(place, other),
                None => {
                    if let Some(slot) = kept.get_mut(number) {
                        *slot = Some(place);
                    }
                }
            }
        }
    }

    /// Gives every child a place. The likeliest child of each parent gets the place of the parent; for each of the
    /// others the parent is copied to a free place.
    fn place(&mut self, children: &mut Children<T>, branches: &mut Branches<T>) {
        let places = self.places();
        let mut used = [false; MOST];
        let mark = |used: &mut [bool; MOST], place: usize| {
            used.get_mut(place).is_some_and(|used| core::mem::replace(used, true))
        };
        for (child, _) in children.all() {
            mark(&mut used, child.place);
        }
        let mut claimed = [false; MOST];
        for child in children.all_mut() {
            if !mark(&mut claimed, child.place) {
                continue;
            }
            let Some(free) = used.iter().take(places).position(|&used| !used) else { continue };
            mark(&mut used, free);
            self.copy(child.place, free);
            if let Some(&parent) = branches.list.get(child.place)
                && let Some(branch) = branches.list.get_mut(free)
            {
                *branch = parent;
            }
            child.place = free;
        }
        for (branch, used) in branches.list.iter_mut().zip(used) {
            branch.alive = used;
        }
    }
}

impl<T: Real> Branches<T> {
    /// Drops a hypothesis, and adds its weight to another one.
    fn join(&mut self, place: usize, other: usize) {
        self.joined += 1;
        let Some(branch) = self.list.get_mut(place) else { return };
        let Branch { ln_weight, .. } = *branch;
        branch.alive = false;
        if let Some(other) = self.list.get_mut(other) {
            let mut sum = LnSum::of(other.ln_weight);
            sum.add(ln_weight);
            other.ln_weight = sum.ln();
        }
    }
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, super::super::archive::NoArchive, V>
{
    /// Corrects pose and landmarks with one measurement of known cause.
    fn correct_by<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        cause: Cause<T>,
        models: &OnVehicle<'_, X>,
        measurement: &[X::Measurement],
        tally: &mut super::super::report::Tally<T>,
    ) {
        if cause.landmark == NONE || !(cause.share >= T::from_f64(LEAST_DETECTED)) {
            return;
        }
        let Self { config, memory, .. } = self;
        if let Some(row) = memory.association_table.first_mut() {
            row.clear();
            row.add_certain(cause.landmark, cause.share);
        }
        move_by(models.sensor(), memory, usize::from(cause.landmark), measurement, config.gate, tally, &Serial);
        memory.reset_error_frame(&Serial);
    }
}
