//! Stages of a scan update: their inputs and results.

use crate::detection::scan::Scan;
use crate::detection::view::Views;
use crate::filter::state::Memory;
use crate::filter::tally::Tally;
use crate::particles::cursor::Cursor;
use crate::particles::propose::Proposer;
use crate::particles::select::Selection;
use crate::{
    Config, Health, Informed, LnSum, MeasurementModel, Noise, Pose, Proposal, Real, ScalarOf, ScanReport, Symmetric,
    Vector,
};

/// Numbers of particles and candidates of a scan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ParticleLayout {
    pub(crate) particles: usize,
    /// Candidates of each particle.
    pub(crate) children: usize,
    /// Whether each particle's pose has a covariance, which is added to that of the predicted measurements.
    pub(crate) has_pose_covariances: bool,
    /// Whether there is only one candidate, which survives with any weight. The update then computes its likelihood, so that the map is
    /// evaluated only once.
    pub(crate) single_candidate: bool,
}

impl ParticleLayout {
    pub(crate) fn of<T: Real>(config: &Config<T>, cursor: &Cursor<T>) -> Self {
        let (particles, children) = (cursor.particles, cursor.children);
        let has_pose_covariances =
            matches!(config.proposal, Proposal::Informed(informed) if informed.sampled_fraction < T::ONE);
        let single_candidate = particles * children == 1 && !has_pose_covariances;
        Self { particles, children, has_pose_covariances, single_candidate }
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

/// Samples the candidates of an informed proposal, and sets the term of ln L that corrects for the proposal density. For a blind
/// proposal the prediction has sampled the candidates, and this term is zero. Returns the number of particles for which the
/// workspace was too small.
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
    let Some(informed) = informed(config, cursor.predicted) else { return 0 };
    let proposer = Proposer {
        informed,
        ln_floor: config.prune_weight.ln(),
        views,
        of_static: (&static_maps.table, &static_maps.pool),
        of_moving: (&moving_maps.table, &moving_maps.pool),
        scan,
    };
    let scratch = (&mut static_maps.workspace, &mut moving_maps.workspace, eta);
    proposer.all(scratch, config.samples, cursor, (candidates, ln_likelihoods), pose_covariances, noise)
}

/// The informed proposal, if it samples candidates at a scan, which follows predictions or not.
pub(crate) fn informed<T: Real>(config: &Config<T>, predicted: bool) -> Option<Informed<T>> {
    match config.proposal {
        Proposal::Informed(informed) if predicted || informed.sampled_fraction < T::ONE => Some(informed),
        _ => None,
    }
}

/// Results of the weighting.
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
    /// The placeholder before the weighting.
    pub(crate) const NONE: Self = Self { ln_evidence: T::ZERO, n_eff: T::ZERO, in_view: 0 };

    /// Adds the results of the map update for a single candidate, whose likelihood is computed there.
    pub(crate) fn completed(self, layout: &ParticleLayout, tally: &Tally<T>, ln_likelihoods: &mut [T]) -> Self {
        match ln_likelihoods.first_mut() {
            Some(ln_likelihood) if layout.single_candidate => {
                *ln_likelihood = finite_ln_likelihood(*ln_likelihood + tally.last.ln_likelihood);
                Self { ln_evidence: *ln_likelihood, in_view: tally.last.in_view, ..self }
            }
            _ => self,
        }
    }
}

/// Copies the selected candidates and their covariances to the particles.
pub(crate) fn take_selected<T: Real, P: Pose<Scalar = T>>(layout: &ParticleLayout, memory: &mut Memory<'_, P>) {
    let Memory { pose_covariances, selected_covariances, candidates, selected, survivors, .. } = memory;
    candidates.iter_mut().zip(selected.iter()).take(layout.particles).for_each(|(slot, chosen)| *slot = *chosen);
    for (slot, &survivor) in selected_covariances.iter_mut().zip(survivors.iter()).take(layout.particles) {
        let parent = layout.parent_of(usize::from(survivor));
        *slot = pose_covariances.get(parent).copied().unwrap_or(Symmetric::ZERO);
    }
    let chosen = selected_covariances.iter().take(layout.particles);
    pose_covariances.iter_mut().zip(chosen).for_each(|(slot, chosen)| *slot = *chosen);
}

/// Prepares the next prediction. Returns the number of predictions that were refused since the last scan.
pub(crate) fn adopt<T: Real>(
    layout: &ParticleLayout,
    selection: &Selection,
    cursor: &mut Cursor<T>,
    noise: Noise,
) -> usize {
    cursor.noise = Some(noise);
    cursor.children = 1;
    cursor.predicted = false;
    cursor.waited_s = T::ZERO;
    cursor.weighed = layout.candidates();
    cursor.heaviest = selection.heaviest;
    usize::from(core::mem::take(&mut cursor.refused))
}

/// Results of all stages.
#[derive(Debug)]
pub(crate) struct Outcome<T> {
    pub(crate) layout: ParticleLayout,
    pub(crate) weighing: Weighing<T>,
    pub(crate) selection: Selection,
    pub(crate) tally: Tally<T>,
    /// Number of particles whose proposal had too little working memory.
    pub(crate) crowded: usize,
    /// Number of predictions refused since the last scan.
    pub(crate) refused: usize,
    /// Result of the divergence monitor.
    pub(crate) watched: Health,
}

/// The report for the caller.
pub(crate) fn report<P: Pose, Z: Vector>(
    outcome: &Outcome<ScalarOf<P>>,
    memory: &Memory<'_, P>,
    measured: usize,
) -> ScanReport<ScalarOf<P>> {
    let real = ScalarOf::<P>::from_f64;
    let Outcome { layout, weighing, selection, tally, crowded, refused, watched } = outcome;
    let Weighing { ln_evidence, n_eff, in_view } = *weighing;
    let innovation = tally.mean_innovation(Z::DIMENSION);
    let [expected_detections, detections] = tally.mean_detections();
    let tightened = tally.tightened + crowded;
    let health = Health::UNEXPLAINED_SCAN.when(!ln_evidence.is_finite())
        | Health::DEGENERATE.when(layout.particles > 1 && n_eff < real(1.5))
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
        candidates: layout.candidates(),
        in_view,
        ln_evidence,
        n_eff,
        resampled: selection.resampled,
        particles: layout.particles,
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

/// ln L, or −∞ if it is not finite because of the models.
pub(crate) fn finite_ln_likelihood<T: Real>(ln_likelihood: T) -> T {
    if ln_likelihood.is_finite() { ln_likelihood } else { T::NEG_INFINITY }
}
