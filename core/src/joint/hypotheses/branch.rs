//! One measurement: every hypothesis has children, of which the likeliest are kept.

use super::super::correct::move_by;
use super::super::filter::JointSlam;
use super::super::movers::Movers;
use super::MOST;
use super::causes::{Cause, causes_of};
use super::children::{Child, Children};
use super::filter::MultiHypothesisSlam;
use super::gated::Gated;
use super::scan::Branches;
use crate::models::OnVehicle;
use crate::{MeasurementModel, Motion, Pose, Real, Serial, Vector};

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
        for (place, branch) in branches.list.iter_mut().enumerate().filter(|(_, branch)| branch.alive) {
            let ln_weight = branch.ln_weight;
            children.add(Child::new(place, Cause::NEW), ln_weight + ln_new);
            let gated = *branch.gated.get_or_insert_with(|| {
                self.with(place, |JointSlam { config, memory, movers, .. }| {
                    Gated::of(models, config.gate, memory, movers, measurements, index)
                })
            });
            if !gated.has(index) {
                continue;
            }
            let causes =
                self.with(place, |slam| causes_of(models, &slam.config, &slam.memory, &slam.movers, &gated, index, z));
            for &(cause, ln_odds) in causes.all() {
                children.add(Child::new(place, cause), ln_weight + ln_odds);
            }
        }
        branches.saturated += usize::from(children.prune(self.config.least_ratio));
        if children.all().is_empty() {
            // No hypothesis explains the measurement.
            return;
        }
        let measurement = measurements.get(index..=index).unwrap_or(&[]);
        branches.joined += self.join(models, measurement, &mut children);
        self.place(&mut children, branches);
        for &(Child { place, cause, joined }, ln_weight) in children.all() {
            let Some(branch) = branches.list.get_mut(place) else { continue };
            (branch.alive, branch.ln_weight) = (!joined, ln_weight);
            if joined || cause == Cause::NEW {
                continue;
            }
            let tally = &mut branch.tally;
            if cause.corrects() {
                branch.gated = None;
            }
            self.with(place, |slam| {
                cause.store(index, &mut slam.memory, &mut slam.movers);
                slam.correct_by(cause, models, measurement, tally);
            });
        }
    }

    /// Gives every child a place. The likeliest child of each parent gets the place of the parent; for each of the
    /// others the parent is copied to a free place, unless it was joined.
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
            if !child.joined {
                self.copy(child.place, free);
            }
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

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, super::super::archive::NoArchive, V>
{
    /// Corrects pose and landmarks with one measurement of known cause.
    pub(super) fn correct_by<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        cause: Cause<T>,
        models: &OnVehicle<'_, X>,
        measurement: &[X::Measurement],
        tally: &mut super::super::report::Tally<T>,
    ) {
        if !cause.corrects() {
            return;
        }
        let Self { config, memory, .. } = self;
        cause.associate(memory);
        move_by(models.sensor(), memory, usize::from(cause.landmark), measurement, config.gate, tally, &Serial);
        memory.joint.apply(&mut memory.pending, memory.header.len, &Serial);
    }
}
