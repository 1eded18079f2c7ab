//! The update with a scan, stage by stage.

use super::archive::Archive;
use super::archiving::{Archiving, archive_distant, mark_anchors};
use super::associate::{Associated, associate};
use super::correct::correct;
use super::filter::JointSlam;
use super::loop_closure::close_loop;
use super::map_management::{drop_spoilt, drop_unlikely, initiate, merge};
use super::movers::Movers;
use super::reactivation::propose;
use super::report::JointReport;
use crate::models::OnVehicle;
use crate::{Clutter, Detector, Health, MeasurementModel, Motion, Pose, Real, ScanError, Sensor, Vector};

impl<T, M, Z, A, V> JointSlam<'_, M, Z, A, V>
where
    T: Real,
    M: Motion<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
    A: Archive<M::Pose>,
    V: Movers<M::Pose>,
{
    /// Takes in one scan of one of the vehicle's sensors, whose measurements have at most as many dimensions as the state's `Z`.
    /// Of births that move it knows only [with movers](Self::with_movers): without, all features stand still.
    ///
    /// # Errors
    /// A measurement is not finite, there are more than the state holds, the covariance of the sensor's noise is not positive
    /// definite, or the filter has not been reset; the state is as it was.
    pub fn scan<X: MeasurementModel<Pose = M::Pose>, R>(
        &mut self,
        detector: &Detector<X, R>,
        measurements: &[X::Measurement],
    ) -> Result<JointReport<T>, ScanError> {
        let models = self.checked(detector, measurements)?;
        let sensor = models.sensor();
        let births = &detector.births;
        let Self { config, memory, archive, movers, .. } = self;
        memory.clamp();
        if let Some(mut tracks) = movers.tracks() {
            tracks.advance(memory.known.waited_s, config.least_existence);
        }
        let mut view = archive.view();
        let passage = config.persistence.over(memory.known.waited_s);
        memory
            .landmarks
            .iter_mut()
            .take(memory.known.len)
            .for_each(|slot| slot.existence = slot.existence.after(&passage));
        let window = memory.known.len;
        let mut candidates = view.as_mut().map(|view| {
            view.pass(memory.known.waited_s);
            propose(view, &config.persistence, memory)
        });
        let mut associated = associate(&models, births, config, memory, movers, measurements, window);
        let (recalled, refused) = match (&mut candidates, &mut view) {
            (Some(candidates), Some(view)) => candidates.accept(view, memory, measurements.len()),
            _ => (0, false),
        };
        if refused {
            // What the features of a page that was refused have claimed is free for others.
            associated = associate(&models, births, config, memory, movers, measurements, window);
        }
        let Associated { in_view, weak, aside, ln_evidence } = associated;
        let mut tally = correct(sensor, memory, movers, measurements, config.gate);
        tally.aside = aside;
        let united = movers.tracks().map_or(0, |mut tracks| {
            tracks.correct(sensor, memory.known, memory.explained, measurements);
            tracks.tidy(config)
        });
        memory.reset_error_frame();
        let first_label = memory.known.next_label;
        let born = initiate(&models, births, config, memory, movers, measurements);
        let mut merged = merge(sensor, config, memory);
        if weak > 0 {
            merged += close_loop(config, memory);
        }
        let spoilt = drop_spoilt(memory);
        let dropped = drop_unlikely(config, memory, first_label);
        let parked = view.as_mut().map_or_else(Archiving::default, |view| {
            let parked = archive_distant(view, memory);
            if recalled + parked.parked > 0 {
                mark_anchors(view, memory);
            }
            parked
        });
        let report =
            tally.report(memory.known, (measurements.len(), models.clutter().per_scan()), X::Measurement::DIMENSION);
        Ok(JointReport {
            in_view,
            ln_evidence,
            births: born.births,
            no_birth: born.no_birth,
            dropped: dropped + parked.dropped,
            merged: merged + united,
            lost: born.lost,
            spoilt: report.spoilt + spoilt + parked.spoilt,
            parked: parked.parked,
            recalled,
            forgotten: parked.forgotten,
            movers: movers.kept().len(),
            health: report.health
                | Health::UNEXPLAINED_SCAN.when(!ln_evidence.is_finite())
                | Health::COMPONENTS_LOST.when(born.lost + parked.forgotten > 0)
                | Health::COVARIANCE_REPAIRED.when(spoilt + parked.spoilt > 0),
            ..report
        })
    }

    /// The detector's models on the vehicle, if it and the measurements can be taken in.
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
        if !self.memory.known.started {
            return Err(ScanError::NotStarted);
        }
        ScanError::check(measurements, self.memory.explained.len())?;
        let models = detector.on_vehicle();
        if models.sensor().noise().factor().is_none() {
            return Err(ScanError::SensorNoise);
        }
        Ok(models)
    }
}
