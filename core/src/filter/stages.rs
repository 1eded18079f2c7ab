//! The stages of a scan that are the filter's own: what each is given, and what comes of it.

use crate::detection::scan::Scan;
use crate::detection::view::Views;
use crate::filter::state::Memory;
use crate::filter::tally::Tally;
use crate::particles::cursor::Cursor;
use crate::particles::propose::Proposer;
use crate::particles::select::Selection;
use crate::{
    Config, Health, LnSum, MeasurementModel, Noise, Pose, Proposal, Real, ScalarOf, ScanReport, Symmetric, Vector,
};

/// What holds for a whole scan from the moment its candidates are there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grounds {
    pub(crate) particles: usize,
    /// Candidates of each particle.
    pub(crate) children: usize,
    /// Whether the poses have a covariance of their own, which blurs what is expected.
    pub(crate) blurs: bool,
    /// Whether there is but one candidate, that goes on whatever it weighs: the update tells how well it explains the scan, and the
    /// map is looked at but once.
    pub(crate) lone: bool,
}

impl Grounds {
    pub(crate) fn of<T: Real>(config: &Config<T>, cursor: &Cursor<T>) -> Self {
        let (particles, children) = (cursor.particles, cursor.children);
        let blurs = matches!(config.proposal, Proposal::Informed(informed) if informed.sampled_fraction < T::ONE);
        let lone = particles * children == 1 && !blurs;
        Self { particles, children, blurs, lone }
    }

    /// Number of candidates.
    pub(crate) fn candidates(&self) -> usize {
        self.particles * self.children
    }

    /// The particle that a candidate comes from.
    #[inline]
    pub(crate) fn parent_of(&self, candidate: usize) -> usize {
        candidate.checked_div(self.children).unwrap_or(0)
    }
}

/// Draws the candidates of a proposal that the scan has been taken into, and sets for each the part of ln L that corrects for where it
/// was drawn; zero where the prediction has drawn them already. Returns for how many particles the workspace was too small.
pub(crate) fn propose<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>>(
    config: &Config<T>,
    views: &Views<'_, X>,
    scan: &Scan<'_, X::Measurement>,
    memory: &mut Memory<'_, P>,
    eta: &mut [LnSum<T>],
    noise: &mut Noise,
) -> usize {
    let Memory { cursor, pose_covariances, candidates, ln_likelihoods, static_maps, moving_maps, .. } = memory;
    let most = cursor.particles.saturating_mul(config.samples.max(cursor.children));
    ln_likelihoods.iter_mut().take(most).for_each(|ln_correction| *ln_correction = T::ZERO);
    match config.proposal {
        Proposal::Informed(informed) if cursor.predicted || informed.sampled_fraction < T::ONE => {
            let ln_floor = config.prune_weight.ln();
            let proposer = Proposer { informed, ln_floor, views, static_maps, moving_maps, scan, eta };
            proposer.all(config.samples, cursor, candidates, pose_covariances, ln_likelihoods, noise)
        }
        _ => 0,
    }
}

/// How well the candidates explain the scan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weighing<T> {
    /// ln Σ ζ L.
    pub(crate) ln_evidence: T,
    /// N_eff.
    pub(crate) n_eff: T,
    /// |V|, the most components in view of any candidate.
    pub(crate) in_view: usize,
}

impl<T: Real> Weighing<T> {
    /// Nothing has been weighed.
    pub(crate) const NONE: Self = Self { ln_evidence: T::ZERO, n_eff: T::ZERO, in_view: 0 };

    /// With what the update says of a lone candidate.
    pub(crate) fn completed(self, grounds: &Grounds, tally: &Tally<T>, ln_likelihoods: &mut [T]) -> Self {
        match ln_likelihoods.first_mut() {
            Some(ln_likelihood) if grounds.lone => {
                *ln_likelihood = explained(*ln_likelihood + tally.last.ln_likelihood);
                Self { ln_evidence: *ln_likelihood, in_view: tally.last.in_view, ..self }
            }
            _ => self,
        }
    }
}

/// Makes the selected candidates the particles.
pub(crate) fn take_selected<T: Real, P: Pose<Scalar = T>>(grounds: &Grounds, memory: &mut Memory<'_, P>) {
    let Memory { pose_covariances, selected_covariances, candidates, selected, survivors, .. } = memory;
    candidates.iter_mut().zip(selected.iter()).take(grounds.particles).for_each(|(slot, chosen)| *slot = *chosen);
    for (slot, &survivor) in selected_covariances.iter_mut().zip(survivors.iter()).take(grounds.particles) {
        let parent = grounds.parent_of(usize::from(survivor));
        *slot = pose_covariances.get(parent).copied().unwrap_or(Symmetric::ZERO);
    }
    let chosen = selected_covariances.iter().take(grounds.particles);
    pose_covariances.iter_mut().zip(chosen).for_each(|(slot, chosen)| *slot = *chosen);
}

/// Gets ready for the next prediction. Returns how many predictions were refused before this scan.
pub(crate) fn adopt<T: Real>(grounds: &Grounds, selection: &Selection, cursor: &mut Cursor<T>, noise: Noise) -> usize {
    cursor.noise = Some(noise);
    cursor.children = 1;
    cursor.predicted = false;
    cursor.waited_s = T::ZERO;
    cursor.weighed = grounds.candidates();
    cursor.heaviest = selection.heaviest;
    usize::from(core::mem::take(&mut cursor.refused))
}

/// What came of the stages.
#[derive(Debug)]
pub(crate) struct Outcome<T> {
    pub(crate) grounds: Grounds,
    pub(crate) weighing: Weighing<T>,
    pub(crate) selection: Selection,
    pub(crate) tally: Tally<T>,
    /// Particles for whose proposal the workspace was too small.
    pub(crate) crowded: usize,
    /// Predictions refused since the scan before.
    pub(crate) refused: usize,
    /// Whether the vehicle is where it is taken to be.
    pub(crate) watched: Health,
}

/// What the caller is told.
pub(crate) fn report<P: Pose, Z: Vector>(
    outcome: &Outcome<ScalarOf<P>>,
    memory: &Memory<'_, P>,
    measured: usize,
) -> ScanReport<ScalarOf<P>> {
    let real = ScalarOf::<P>::from_f64;
    let Outcome { grounds, weighing, selection, tally, crowded, refused, watched } = outcome;
    let Weighing { ln_evidence, n_eff, in_view } = *weighing;
    let innovation = tally.mean_innovation(Z::DIMENSION);
    let [expected_detections, detections] = tally.mean_detections();
    let tightened = tally.tightened + crowded;
    let health = Health::UNEXPLAINED_SCAN.when(!ln_evidence.is_finite())
        | Health::DEGENERATE.when(grounds.particles > 1 && n_eff < real(1.5))
        | Health::PRUNING_TIGHTENED.when(tightened > 0)
        | Health::MAP_NOT_UPDATED.when(tally.kept > 0)
        | Health::COMPONENTS_LOST.when(tally.lost > 0)
        | Health::COVARIANCE_REPAIRED.when(tally.repaired > 0)
        | Health::of_innovation(innovation, detections * ScalarOf::<P>::from_usize(Z::DIMENSION))
        | Health::PREDICTION_REFUSED.when(*refused > 0)
        | *watched;
    ScanReport {
        measurements: measured,
        no_birth: tally.no_birth,
        refused: *refused,
        candidates: grounds.candidates(),
        in_view,
        ln_evidence,
        n_eff,
        resampled: selection.resampled,
        particles: grounds.particles,
        survivors: tally.survivors,
        maps_updated: tally.updated,
        births: tally.births,
        merged: tally.merged,
        pruned_mass: tally.pruned_mass,
        tightened,
        not_updated: tally.kept,
        lost: tally.lost,
        repaired: tally.repaired,
        peak: tally.peaks[0],
        moving_peak: tally.peaks[1],
        pages_used: memory.static_maps.pages_used(),
        pages: memory.static_maps.pool.capacity(),
        moving_pages_used: memory.moving_maps.pages_used(),
        moving_pages: memory.moving_maps.pool.capacity(),
        expected_detections,
        detections,
        innovation,
        health,
    }
}

/// ln L, whatever the models have said: −∞, nothing explained, where it is no number or infinite.
pub(crate) fn explained<T: Real>(ln_likelihood: T) -> T {
    if ln_likelihood.is_finite() { ln_likelihood } else { T::NEG_INFINITY }
}
