//! The end of a scan in one hypothesis, when the causes of all measurements are known: existence, tracks, new landmarks, map management.

use super::super::archive::NoArchive;
use super::super::associations::{AssociationRow, detected};
use super::super::correct::update_existence;
use super::super::filter::JointSlam;
use super::super::map_management::{drop_degenerate, drop_unlikely, initiate, merge};
use super::super::movers::Movers;
use super::super::position_update::correct_position;
use super::super::report::{JointReport, Tally};
use super::super::track::{moving_hypothesis, of_cause};
use super::causes::fill;
use crate::models::OnVehicle;
use crate::{Births, Clutter, Health, MeasurementModel, Motion, Pose, Real, Serial, Vector};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, NoArchive, V>
{
    pub(super) fn finish<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        models: &OnVehicle<'_, X>,
        births: &Births<T>,
        measurements: &[X::Measurement],
        mut tally: Tally<T>,
    ) -> JointReport<T> {
        let Self { config, memory, movers, .. } = self;
        let sensor = models.sensor();
        memory.association_table.iter_mut().take(measurements.len()).for_each(AssociationRow::clear);
        fill(memory, movers);
        for index in 0..memory.header.len {
            let Some(landmark) = memory.landmarks.get(index) else { break };
            let detection = landmark.detection;
            let mover = movers.kept().iter().find(|mover| usize::from(mover.static_index) == index);
            let (table, own) = of_cause(memory.association_table, measurements, Some(landmark), mover);
            let moving = moving_hypothesis::<T, M::Pose, V, _>(movers, index, table, own);
            if !(detection + moving.expected > T::ZERO) {
                continue;
            }
            let detected = detected(table, index, own);
            let position_factor = update_existence(memory, index, detected, &moving, &mut tally);
            if let Some(times) = position_factor.filter(|_| movers.are_tracked()) {
                let reset = memory.is_moved(index);
                correct_position(sensor, memory, index, measurements, detected, (times, reset), config.gate, &Serial);
            }
        }
        let merged_tracks = movers.tracks().map_or(0, |mut tracks| {
            let landmarks = memory.landmarks.get(..memory.header.len);
            tracks.correct(sensor, memory.header, memory.association_table, measurements, landmarks);
            tracks.merge_and_prune(config)
        });
        memory.reset_error_frame(&Serial);
        let first_label = memory.header.next_label;
        let initiated = initiate(models, births, config, memory, movers, measurements);
        let merged = merge(sensor, config, memory);
        let degenerate = drop_degenerate(memory);
        let dropped = drop_unlikely(config, memory, first_label);
        let report =
            tally.report(memory.header, (measurements.len(), models.clutter().per_scan()), X::Measurement::DIMENSION);
        JointReport {
            births: initiated.births,
            no_birth: initiated.no_birth,
            dropped,
            merged: merged + merged_tracks,
            lost: initiated.lost,
            degenerate: report.degenerate + degenerate,
            movers: movers.kept().len(),
            health: report.health
                | Health::COMPONENTS_LOST.when(initiated.lost > 0)
                | Health::COVARIANCE_REPAIRED.when(degenerate > 0),
            ..report
        }
    }
}
