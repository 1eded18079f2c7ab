//! Unlikely hypotheses are dropped, and the likeliest one gets the place in the filter's state.

use super::super::movers::Movers;
use super::filter::MultiHypothesisSlam;
use super::scan::Branches;
use super::slot::Weight;
use crate::{Motion, Pose, Real, Vector};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    MultiHypothesisSlam<'_, M, Z, V, OTHERS>
{
    /// Stores the weights after a scan or a fix, relative to the likeliest hypothesis.
    pub(super) fn settle(&mut self, branches: &Branches<T>) {
        let likeliest = branches.likeliest();
        let Some(most) = branches.at(likeliest).map(|branch| branch.ln_weight) else { return };
        let least = (branches.ln_all() - most) + self.config.least_share.ln();
        for (index, other) in self.others.iter_mut().enumerate() {
            // The likeliest hypothesis is exchanged with that of place 0 below.
            let place = if index + 1 == likeliest { 0 } else { index + 1 };
            let ln = branches.at(place).map(|branch| branch.ln_weight - most).filter(|&ln| ln >= least);
            *other.weight = ln.map_or(Weight::NONE, |ln| Weight { alive: true, ln });
        }
        let Self { slam, others, .. } = self;
        if let Some(other) = likeliest.checked_sub(1).and_then(|index| others.get_mut(index)) {
            other.exchange_data(&mut slam.memory, &mut slam.movers);
        }
    }
}
