//! One scan update of the PHD filter: predict, propose, weight (compute likelihoods), resample, update the maps, report.

use crate::filter::scanning::Scanning;
use crate::{
    Detector, Draft, Executor, LnSum, MeasurementModel, Motion, Pose, PositionOf, Probe, Real, ScPhd, ScanError,
    ScanReport, ScanRoom, Stage,
};

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'s, M> {
    /// The update with a scan whose measurements the caller has checked.
    ///
    /// If `DRAFTS` is true, several maps are updated in parallel; otherwise that code is not linked.
    pub(crate) fn step<X: MeasurementModel<Pose = M::Pose>, const DRAFTS: bool>(
        &mut self,
        detector: &mut Detector<X, ScanRoom<'_, X::Measurement>>,
        measured: &[X::Measurement],
        executor: &impl Executor,
        drafts: &mut [Draft<'_, PositionOf<M::Pose>>],
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, ScanError> {
        let Self { config, memory, .. } = self;
        let (mut scanning, eta, most_in_view) = Scanning::begin(config, memory, detector, measured)?;
        let workers = most_in_view.len();
        probe.enter(Stage::Predict);
        scanning.enter();
        if DRAFTS {
            scanning.predict_moving_on((executor, workers));
        } else {
            scanning.predict_moving();
        }
        probe.leave(Stage::Predict);
        probe.enter(Stage::Weigh);
        scanning.propose(eta);
        scanning.weigh_all(eta, most_in_view, executor);
        probe.leave(Stage::Weigh);
        probe.enter(Stage::Resample);
        scanning.select();
        probe.leave(Stage::Resample);
        probe.enter(Stage::Update);
        scanning.begin_update();
        if DRAFTS && drafts.len() > 1 && !scanning.has_single_candidate() {
            scanning.update_on(eta, (executor, workers), drafts, probe);
        } else {
            scanning.update(eta, probe);
        }
        scanning.end_update();
        probe.leave(Stage::Update);
        Ok(scanning.finish())
    }

    /// Checks the measurements and begins a scan update whose stages the caller runs one after the other. The scratch is
    /// that of one worker.
    ///
    /// # Errors
    /// As for [`scan`](Self::scan).
    #[doc(hidden)]
    pub fn begin_scan<'a, 'm, X: MeasurementModel<Pose = M::Pose>>(
        &'a mut self,
        detector: &'a mut Detector<X, ScanRoom<'m, X::Measurement>>,
        measured: &[X::Measurement],
    ) -> Result<(Scanning<'a, 's, X>, &'a mut [LnSum<T>]), ScanError> {
        self.check_scan(detector, measured)?;
        let Self { config, memory, .. } = self;
        let (scanning, eta, _) = Scanning::begin(config, memory, detector, measured)?;
        Ok((scanning, eta))
    }
}
