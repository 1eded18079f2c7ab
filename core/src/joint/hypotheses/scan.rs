//! The update of all hypotheses with one scan.

use super::super::associate::ln_lambda;
use super::super::filter::JointSlam;
use super::super::movers::Movers;
use super::super::report::{JointReport, Tally};
use super::super::scan::advance;
use super::MOST;
use super::causes::start;
use super::filter::MultiHypothesisSlam;
use super::gated::Gated;
use crate::{Detector, Health, LnSum, MeasurementModel, Motion, Pose, Real, ScanError, Vector};

/// A hypothesis during a scan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Branch<T> {
    pub(super) alive: bool,
    /// ln of its weight, not normalised.
    pub(super) ln_weight: T,
    /// Features in view.
    pub(super) in_view: usize,
    pub(super) tally: Tally<T>,
    /// The measurements in its gates; `None` after a correction.
    pub(super) gated: Option<Gated>,
}

impl<T: Real> Branch<T> {
    const NONE: Self =
        Self { alive: false, ln_weight: T::NEG_INFINITY, in_view: 0, tally: Tally::NOTHING, gated: None };
}

/// All places during a scan.
pub(super) struct Branches<T> {
    pub(super) list: [Branch<T>; MOST],
    pub(super) joined: usize,
    pub(super) saturated: usize,
}

impl<T: Real> Branches<T> {
    pub(super) const NONE: Self = Self { list: [Branch::NONE; MOST], joined: 0, saturated: 0 };

    pub(super) fn at(&self, place: usize) -> Option<&Branch<T>> {
        self.list.get(place).filter(|branch| branch.alive)
    }

    /// The places in use, with ln of their weights.
    pub(super) fn alive(&self) -> impl Iterator<Item = (usize, T)> + '_ {
        let branches = self.list.iter().enumerate().filter(|(_, branch)| branch.alive);
        branches.map(|(place, branch)| (place, branch.ln_weight))
    }

    pub(super) fn ln_all(&self) -> T {
        let mut sum = LnSum::EMPTY;
        self.alive().for_each(|(_, ln_weight)| sum.add(ln_weight));
        sum.ln()
    }

    /// The place of the likeliest; of equal ones the first.
    pub(super) fn likeliest(&self) -> usize {
        let mut likeliest = (0, T::NEG_INFINITY);
        for (place, ln_weight) in self.alive() {
            if ln_weight > likeliest.1 {
                likeliest = (place, ln_weight);
            }
        }
        likeliest.0
    }
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    MultiHypothesisSlam<'s, M, Z, V, OTHERS>
{
    /// Updates all hypotheses with one scan of one of the vehicle's sensors, as [`JointSlam::scan`] does with one.
    ///
    /// # Errors
    /// As for [`JointSlam::scan`]; the state is unchanged.
    pub fn scan<X: MeasurementModel<Pose = M::Pose>, R>(
        &mut self,
        detector: &Detector<X, R>,
        measurements: &[X::Measurement],
    ) -> Result<JointReport<T>, ScanError> {
        if self.places() == 1 {
            let report = self.slam.scan(detector, measurements)?;
            self.drop_others();
            return Ok(report);
        }
        let models = self.slam.checked(detector, measurements)?;
        let births = &detector.births;
        self.drop_unsound();
        let ln_before = self.ln_all();
        let mut branches = Branches::NONE;
        for (place, branch) in branches.list.iter_mut().enumerate().take(self.places()) {
            if !self.is_alive(place) {
                continue;
            }
            let (in_view, ln_missed) = self.with(place, |slam| {
                let JointSlam { config, memory, movers, .. } = slam;
                memory.clamp();
                advance(config, memory, movers);
                start(&models, config.occlusion_factor, memory, movers, measurements)
            });
            let ln_weight = self.ln_weight(place) + ln_missed;
            *branch = Branch { alive: true, ln_weight, in_view, ..Branch::NONE };
        }
        // λ is the same for all hypotheses.
        let (ln_birth, are_tracked) = (births.of_static.ln(), self.slam.movers.are_tracked());
        for (row, z) in self.slam.memory.association_table.iter_mut().zip(measurements) {
            row.start(ln_lambda(&models, ln_birth, births, are_tracked, z));
        }
        for index in 0..measurements.len() {
            self.branch(&models, measurements, index, &mut branches);
        }
        let likeliest = branches.likeliest();
        let mut report = None;
        for place in 0..self.places() {
            let Some(&Branch { tally, in_view, .. }) = branches.at(place) else { continue };
            let finished = self.with(place, |slam| slam.finish(&models, births, measurements, tally));
            if place == likeliest {
                report = Some((finished, in_view));
            }
        }
        let ln_evidence = branches.ln_all() - ln_before;
        self.settle(&branches);
        let (report, in_view) = report.ok_or(ScanError::NotStarted)?;
        Ok(JointReport {
            in_view,
            ln_evidence,
            hypotheses: self.hypotheses(),
            share: self.share(),
            joined: branches.joined,
            saturated: branches.saturated,
            health: report.health | Health::UNEXPLAINED_SCAN.when(!ln_evidence.is_finite()),
            ..report
        })
    }

    pub(super) fn is_alive(&self, place: usize) -> bool {
        place.checked_sub(1).is_none_or(|index| self.others.get(index).is_some_and(|other| other.weight.alive))
    }
}
