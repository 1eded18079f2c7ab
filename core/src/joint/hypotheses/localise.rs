//! Localisation of all hypotheses, each in its own map, which is not changed.

use super::super::movers::Movers;
use super::super::report::JointReport;
use super::MOST;
use super::filter::MultiHypothesisSlam;
use super::scan::{Branch, Branches};
use crate::{Detector, MeasurementModel, Motion, Pose, Real, ScanError, Vector};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    MultiHypothesisSlam<'_, M, Z, V, OTHERS>
{
    /// [`JointSlam::localise`](crate::JointSlam::localise) of every hypothesis, whose weight is multiplied by the likelihood
    /// of the scan.
    ///
    /// # Errors
    /// As there; the state is unchanged.
    pub fn localise<X: MeasurementModel<Pose = M::Pose>, R>(
        &mut self,
        detector: &Detector<X, R>,
        measurements: &[X::Measurement],
    ) -> Result<JointReport<T>, ScanError> {
        self.slam.checked(detector, measurements)?;
        self.drop_unsound();
        let ln_before = self.ln_all();
        let mut reports = [None; MOST];
        let mut branches = Branches::<T>::NONE;
        for (place, (report, branch)) in reports.iter_mut().zip(&mut branches.list).enumerate().take(self.places()) {
            if !self.is_alive(place) {
                continue;
            }
            let localised = self.with(place, |slam| slam.localise(detector, measurements))?;
            *branch = Branch { alive: true, ln_weight: self.ln_weight(place) + localised.ln_evidence, ..*branch };
            *report = Some(localised);
        }
        let report = reports.get(branches.likeliest()).copied().flatten().ok_or(ScanError::NotStarted)?;
        let ln_evidence = branches.ln_all() - ln_before;
        self.settle(&branches);
        Ok(JointReport { ln_evidence, hypotheses: self.hypotheses(), share: self.share(), ..report })
    }
}
