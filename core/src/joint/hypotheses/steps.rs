//! All steps except scans of a filter with several hypotheses.

use super::super::movers::Movers;
use super::config::HypothesesConfig;
use super::filter::MultiHypothesisSlam;
use super::scan::{Branch, Branches};
use crate::numerics::fnv::Fnv;
use crate::snapshot::visit::Walk;
use crate::{
    Component, ConfigError, CovarianceOf, Fix, FixReport, JointConfig, LoadMapError, ModelError, Motion, ObserveError,
    Pose, PositionOf, PredictError, PredictReport, Real, ResetError, Vector,
};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    MultiHypothesisSlam<'_, M, Z, V, OTHERS>
{
    /// [`JointSlam::reset`](crate::JointSlam::reset), with one hypothesis.
    ///
    /// # Errors
    /// As there; the state is unchanged.
    pub fn reset(&mut self, pose: M::Pose) -> Result<(), ResetError> {
        self.slam.reset(pose)?;
        self.drop_others();
        Ok(())
    }

    /// [`JointSlam::reset_within`](crate::JointSlam::reset_within), with one hypothesis.
    ///
    /// # Errors
    /// As there; the state is unchanged.
    pub fn reset_within(&mut self, pose: M::Pose, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
        self.slam.reset_within(pose, covariance)?;
        self.drop_others();
        Ok(())
    }

    /// [`JointSlam::relocate`](crate::JointSlam::relocate) in the map of the likeliest hypothesis; the others are dropped.
    ///
    /// # Errors
    /// As there; the state is unchanged.
    pub fn relocate(&mut self, pose: M::Pose, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
        self.slam.relocate(pose, covariance)?;
        self.drop_others();
        Ok(())
    }

    /// [`JointSlam::load_map`](crate::JointSlam::load_map), with one hypothesis.
    ///
    /// # Errors
    /// As there; the state is unchanged.
    pub fn load_map(&mut self, features: &[Component<PositionOf<M::Pose>>]) -> Result<(), LoadMapError> {
        self.slam.load_map(features)?;
        self.drop_others();
        Ok(())
    }

    /// [`JointSlam::scatter`](crate::JointSlam::scatter) of every hypothesis.
    ///
    /// # Errors
    /// As there; the state is unchanged.
    pub fn scatter(&mut self, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
        self.slam.scatter(covariance)?;
        self.of_others(|slam| slam.scatter(covariance).is_ok());
        Ok(())
    }

    /// [`JointSlam::retune`](crate::JointSlam::retune) of all hypotheses.
    ///
    /// # Errors
    /// As there.
    pub fn retune(&mut self, motion: M) -> Result<(), ModelError> {
        self.slam.retune(motion)
    }

    /// [`JointSlam::configure`](crate::JointSlam::configure) of all hypotheses.
    ///
    /// # Errors
    /// As there.
    pub fn configure(&mut self, config: JointConfig<T>) -> Result<(), ConfigError> {
        self.slam.configure(config)
    }

    /// Replaces the tuning of the hypotheses.
    ///
    /// # Errors
    /// The tuning is out of range; the filter keeps the previous one.
    pub fn configure_hypotheses(&mut self, config: HypothesesConfig<T>) -> Result<(), ConfigError> {
        config.check()?;
        self.config = config;
        Ok(())
    }

    /// [`JointSlam::predict`](crate::JointSlam::predict) of every hypothesis. The report is that of the likeliest.
    ///
    /// # Errors
    /// As there.
    pub fn predict(&mut self, control: &M::Control, dt: T) -> Result<PredictReport, PredictError> {
        let predicted = self.slam.predict(control, dt);
        self.of_others(|slam| {
            // The likeliest hypothesis refuses it too, or the next report of this hypothesis counts it.
            let _refused = slam.predict(control, dt);
            true
        });
        predicted
    }

    /// [`JointSlam::observe`](crate::JointSlam::observe) of every hypothesis, whose weight is multiplied by the likelihood of
    /// the fix. The report is that of the hypothesis that was the likeliest before; it is `accepted` if any hypothesis has
    /// used the fix. The weight of a hypothesis that has not used it follows from its distance if another one has.
    ///
    /// # Errors
    /// As there; the state is unchanged.
    pub fn observe<F: Fix<Pose = M::Pose>>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<T>, ObserveError> {
        let mut report = self.slam.observe(fix, measured)?;
        if self.hypotheses() == 1 {
            return Ok(report);
        }
        self.drop_unsound();
        let mut reports = [None; super::MOST];
        for (place, slot) in reports.iter_mut().enumerate() {
            if place == 0 {
                *slot = Some(report);
            } else if self.is_alive(place) {
                *slot = self.with(place, |slam| slam.observe(fix, measured)).ok();
            }
        }
        let half = T::from_f64(0.5);
        // ln of the peak of the density, of a hypothesis that has used the fix.
        let peaks = reports.iter().flatten().filter(|report| report.accepted);
        let ln_peak = peaks.map(|report| report.ln_evidence + report.distance * half).reduce(|a, b| a.at_least(b));
        let Some(ln_peak) = ln_peak else { return Ok(report) };
        let ln_before = self.ln_all();
        let mut branches = Branches::<T>::NONE;
        for (place, (branch, of_fix)) in branches.list.iter_mut().zip(&reports).enumerate() {
            let Some(of_fix) = of_fix else { continue };
            let ln = if of_fix.accepted { of_fix.ln_evidence } else { ln_peak - of_fix.distance * half };
            *branch = Branch { alive: true, ln_weight: self.ln_weight(place) + ln, ..*branch };
        }
        report.accepted = true;
        report.ln_evidence = branches.ln_all() - ln_before;
        self.settle(&branches);
        Ok(report)
    }

    /// A hash of the complete filter state: equal on every machine that processed the same inputs. With one hypothesis it is
    /// that of the [`JointSlam`](crate::JointSlam).
    pub fn digest(&self) -> u64 {
        let mut hash = Fnv::EMPTY;
        self.walk(&mut hash);
        hash.value()
    }

    /// Calls `work` with the filter over each other hypothesis, and drops those for which it returns false.
    pub(super) fn of_others(
        &mut self,
        mut work: impl FnMut(&mut crate::JointSlam<'_, M, Z, crate::storage::NoArchive, V>) -> bool,
    ) {
        for place in 1..=OTHERS {
            if self.is_alive(place) && !self.with(place, |slam| work(slam)) {
                self.drop_at(place);
            }
        }
    }
}
