//! The update of the joint map with one scan: prediction of existence, data association, correction of the Gaussian,
//! map management.

use super::archive::Archive;
use super::archiving::{Archiving, archive_distant, mark_anchors};
use super::associate::{Associated, associate};
use super::config::JointConfig;
use super::correct::correct;
use super::filter::JointSlam;
use super::loop_closure::close_loop;
use super::map_management::{drop_degenerate, drop_unlikely, initiate, merge};
use super::movers::Movers;
use super::reactivation::propose;
use super::report::JointReport;
use super::rows::RowExecutor;
use super::state::Memory;
use crate::models::OnVehicle;
use crate::{Clutter, Detector, Health, MeasurementModel, Motion, Pose, Real, ScanError, Sensor, Serial, Vector};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, A, V>
{
    /// Updates pose and map with one scan of one of the vehicle's sensors. Its measurements may have at most as many dimensions as
    /// the state's `Z`. Moving objects are tracked only [with movers](Self::with_movers); otherwise all landmarks are static.
    ///
    /// # Errors
    /// A measurement is not finite, there are more measurements than the state has room for, the covariance of the
    /// sensor's noise is not positive definite, or the filter has not been reset. The state is then unchanged.
    pub fn scan<X: MeasurementModel<Pose = M::Pose>, R>(
        &mut self,
        detector: &Detector<X, R>,
        measurements: &[X::Measurement],
    ) -> Result<JointReport<T>, ScanError> {
        self.scan_on(detector, measurements, &Serial)
    }

    /// [`scan`](Self::scan) with this execution of the loops over the covariance.
    #[doc(hidden)]
    pub fn scan_on<X: MeasurementModel<Pose = M::Pose>, R>(
        &mut self,
        detector: &Detector<X, R>,
        measurements: &[X::Measurement],
        rows: &impl RowExecutor<M::Pose, Z>,
    ) -> Result<JointReport<T>, ScanError> {
        let models = self.checked(detector, measurements)?;
        let sensor = models.sensor();
        let births = &detector.births;
        let Self { config, memory, archive, movers, .. } = self;
        memory.clamp();
        advance(config, memory, movers);
        let mut view = archive.view();
        let window = memory.header.len;
        let mut candidates = view.as_mut().map(|view| {
            view.pass(memory.header.waited_s);
            propose(view, &config.persistence, memory)
        });
        let mut associated = associate(&models, births, config, memory, movers, measurements, window);
        let (reactivated, rejected) = match (&mut candidates, &mut view) {
            (Some(candidates), Some(view)) => candidates.accept(view, memory, measurements.len()),
            _ => (0, false),
        };
        if rejected {
            // The scan is associated again without the landmarks of the submaps that were not confirmed.
            associated = associate(&models, births, config, memory, movers, measurements, window);
        }
        let Associated { in_view, weak, expected_of_weak, ln_evidence } = associated;
        let mut tally = correct(sensor, memory, movers, measurements, config.gate, rows);
        tally.expected_of_weak = expected_of_weak;
        let merged_tracks = movers.tracks().map_or(0, |mut tracks| {
            tracks.correct(sensor, memory.header, memory.association_table, measurements, None);
            tracks.merge_and_prune(config)
        });
        memory.reset_error_frame(rows);
        let first_label = memory.header.next_label;
        let initiated = initiate(&models, births, config, memory, movers, measurements);
        let mut merged = merge(sensor, config, memory);
        if weak > 0 {
            merged += close_loop(config, memory);
        }
        let degenerate = drop_degenerate(memory);
        let dropped = drop_unlikely(config, memory, first_label);
        let archiving = view.as_mut().map_or_else(Archiving::default, |view| {
            let archiving = archive_distant(view, memory);
            if reactivated + archiving.archived > 0 {
                mark_anchors(view, memory);
            }
            archiving
        });
        let report =
            tally.report(memory.header, (measurements.len(), models.clutter().per_scan()), X::Measurement::DIMENSION);
        Ok(JointReport {
            in_view,
            ln_evidence,
            births: initiated.births,
            no_birth: initiated.no_birth,
            dropped: dropped + archiving.dropped,
            merged: merged + merged_tracks,
            lost: initiated.lost,
            degenerate: report.degenerate + degenerate + archiving.degenerate,
            archived: archiving.archived,
            reactivated,
            evicted: archiving.evicted,
            movers: movers.kept().len(),
            health: report.health
                | Health::UNEXPLAINED_SCAN.when(!ln_evidence.is_finite())
                | Health::COMPONENTS_LOST.when(initiated.lost + archiving.evicted > 0)
                | Health::COVARIANCE_REPAIRED.when(degenerate + archiving.degenerate > 0),
            ..report
        })
    }

    /// Checks the filter, the detector and the measurements, and returns the detector's models on the vehicle.
    pub(super) fn checked<'d, X: MeasurementModel<Pose = M::Pose>, R>(
        &self,
        detector: &'d Detector<X, R>,
        measurements: &[X::Measurement],
    ) -> Result<OnVehicle<'d, X>, ScanError> {
        const {
            assert!(
                X::Measurement::DIMENSION <= Z::DIMENSION,
                "the state has no room for measurements of this dimension"
            )
        };
        if !self.memory.header.started {
            return Err(ScanError::NotStarted);
        }
        ScanError::check(measurements, self.memory.association_table.len())?;
        let models = detector.on_vehicle();
        if models.sensor().noise().factor().is_none() {
            return Err(ScanError::SensorNoise);
        }
        Ok(models)
    }
}

/// Predicts tracks and existence to the time of the scan.
#[inline]
pub(super) fn advance<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>, V: Movers<P>>(
    config: &JointConfig<T>,
    memory: &mut Memory<'_, P, Z>,
    movers: &mut V,
) {
    if let Some(mut tracks) = movers.tracks() {
        tracks.advance(memory.header.waited_s, config.least_existence);
    }
    let passage = config.persistence.over(memory.header.waited_s);
    memory
        .landmarks
        .iter_mut()
        .take(memory.header.len)
        .for_each(|landmark| landmark.existence = landmark.existence.after(&passage));
}
