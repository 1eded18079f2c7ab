//! One scan, from top to bottom: drift, propose, weigh, select, update.

use crate::filter::drift::drift;
use crate::filter::executor::shares;
use crate::filter::state::Memory;
use crate::filter::update::Update;
use crate::models::OnVehicle;
use crate::particles::candidate::{effective_number, reweigh};
use crate::particles::propose::Proposer;
use crate::particles::select::{Weighed, select};
use crate::settings::config::ADAPTIVE;
use crate::sight::learn::seen;
use crate::sight::scan::Scan;
use crate::sight::view::{Detection, View};
use crate::sight::weigh::weigh;
use crate::{
    Clutter, Detector, Executor, Health, Likelihood, MeasurementModel, Motion, Pose, Probe, Proposal, Real, ScPhd,
    ScanError, ScanReport, ScanRoom, Sensor, Stage, Symmetric, Vector,
};
use core::cell::Cell;

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// The scan update, of measurements that have been checked.
    pub(crate) fn step<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        detector: &mut Detector<X, ScanRoom<'_, X::Measurement>>,
        measured: &[X::Measurement],
        executor: &impl Executor,
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, ScanError> {
        let Self { config, memory, .. } = self;
        let Detector { sensing, mounting, births, online, room } = detector;
        let ScanRoom { learnt, measurements, eta, most_in_view } = room;
        let Memory {
            cursor,
            spreads,
            selected_spreads,
            candidates,
            ln_likelihoods,
            selected,
            survivors,
            still,
            moving,
        } = memory;
        let Some(mut noise) = cursor.noise.clone() else { return Err(ScanError::NotStarted) };
        let particles = cursor.particles;
        let clutter_scale = learnt.clutter_scale(online);
        let detection_scale = learnt.detection_scale(online);
        let scan = Scan::sort::<X::Sensor>(measurements, measured, sensing.clutter(), clutter_scale, births.total());
        let ln_negligible = config.negligible.ln();
        let on_vehicle = OnVehicle::of(sensing, *mounting);
        let OnVehicle { sensor, field_of_view, .. } = &on_vehicle;
        let Some(noise_factor) = sensor.noise().factor() else { return Err(ScanError::SensorNoise) };
        let (ln_sharpest, most_births) = (noise_factor.ln_peak(), still.workspace.capacity());
        let look = |pose: &M::Pose| View::<OnVehicle<'_, X>> {
            sensor,
            field_of_view,
            frame: sensor.frame(pose),
            detection_scale,
            ln_negligible,
            ln_sharpest,
            most_births,
            last_detection: Cell::new(Detection::of(T::ONE, detection_scale)),
        };
        // Predict what moves (5.14), once for all the steps since the last scan.
        probe.enter(Stage::Predict);
        drift(&mut moving.pool, config, cursor.waited_s);
        probe.leave(Stage::Predict);

        probe.enter(Stage::Weigh);
        // Propose: with poses that the scan has been taken into, the samples are drawn now.
        ln_likelihoods.iter_mut().for_each(|ln_correction| *ln_correction = T::ZERO);
        let mut crowded = 0;
        if let Proposal::Informed(informed) = config.proposal
            && (cursor.predicted || informed.drawn < T::ONE)
        {
            let (still, moving, ln_floor) = (&mut *still, &*moving, config.prune_weight.ln());
            let proposer = Proposer { informed, ln_floor, look, still, moving, scan: &scan, eta };
            crowded = proposer.all(config.samples, cursor, candidates, spreads, ln_likelihoods, &mut noise);
        }
        let children = cursor.children;
        let parent_of = |candidate: usize| candidate.checked_div(children).unwrap_or(0);

        // Weigh (4.52). Only ln L and the scratch η are written; the maps are those of the prediction.
        let candidates = candidates.get_mut(..particles * children).unwrap_or(&mut []);
        let (predicted, likelihood) = ((&*still, &*moving), config.likelihood);
        let blurs = matches!(config.proposal, Proposal::Informed(informed) if informed.drawn < T::ONE);
        // A lone candidate goes on whatever it weighs. The update will say so, and the map is looked at but once.
        let lone = candidates.len() == 1 && likelihood == Likelihood::SingleCluster && !blurs;
        most_in_view.fill(0);
        let in_question = if lone { &[][..] } else { &*candidates };
        executor.run(shares(in_question, ln_likelihoods, eta, most_in_view), |share| {
            let mut most_in_view = 0;
            for (offset, (candidate, ln_likelihood)) in share.candidates.iter().zip(share.ln_likelihoods).enumerate() {
                let (view, parent) = (look(&candidate.pose), parent_of(share.first + offset));
                let weighed = weigh(&view, parent, predicted, &scan, likelihood, share.eta);
                *ln_likelihood = explained(*ln_likelihood + weighed.ln_likelihood);
                most_in_view = weighed.in_view.max(most_in_view);
            }
            *share.most_in_view = most_in_view.min(usize::from(u16::MAX)) as u16;
        });
        let mut in_view = most_in_view.iter().copied().max().map_or(0, usize::from);
        let mut ln_evidence = reweigh(candidates, ln_likelihoods);
        let n_eff = effective_number(candidates);
        probe.leave(Stage::Weigh);

        // Select (5.2.2): back to one candidate a particle.
        probe.enter(Stage::Resample);
        let weighed = Weighed { candidates: &*candidates, particles, children, n_eff };
        let selection = select(&weighed, config, &mut noise, survivors, selected);
        let survivors = survivors.get_mut(..particles).unwrap_or(&mut []);
        let selected = selected.get_mut(..particles).unwrap_or(&mut []);
        probe.leave(Stage::Resample);

        // Update (5.17–5.22): write the survivors' maps.
        probe.enter(Stage::Update);
        let look_again = |survivor| {
            let spread = if blurs { spreads.get(parent_of(usize::from(survivor))).copied() } else { None };
            candidates.get(usize::from(survivor)).map(|candidate| (look(&candidate.pose), spread))
        };
        // Learn from what the heaviest of them sees.
        if ADAPTIVE
            && online.learns()
            && let Some(&survivor) = survivors.get(selection.heaviest)
            && let Some((view, spread)) = look_again(survivor)
        {
            let maps = (&*still, &*moving, parent_of(usize::from(survivor)));
            let seen = seen(&view, spread.as_ref(), maps, &scan, config.confirming_detections, eta);
            learnt.learn(&seen, sensing.clutter().per_scan(), online);
        }
        let update = Update { still, moving, eta, births, config, weighs: lone, next_tag: &mut cursor.next_tag };
        let parent = |survivor| parent_of(usize::from(survivor));
        let tally = update.all(survivors, particles, parent, look_again, &scan, probe);
        if lone && let Some(ln_likelihood) = ln_likelihoods.first_mut() {
            *ln_likelihood = explained(*ln_likelihood + tally.last.ln_likelihood);
            ln_evidence = *ln_likelihood;
            in_view = tally.last.in_view;
        }
        probe.leave(Stage::Update);

        memory.candidates.iter_mut().zip(selected.iter()).for_each(|(slot, chosen)| *slot = *chosen);
        for (slot, &survivor) in selected_spreads.iter_mut().zip(survivors.iter()) {
            *slot = spreads.get(parent_of(usize::from(survivor))).copied().unwrap_or(Symmetric::ZERO);
        }
        spreads.iter_mut().zip(selected_spreads.iter()).for_each(|(slot, chosen)| *slot = *chosen);
        cursor.noise = Some(noise);
        cursor.children = 1;
        cursor.predicted = false;
        cursor.waited_s = T::ZERO;
        let refused = usize::from(core::mem::take(&mut cursor.refused));
        cursor.weighed = particles * children;
        cursor.heaviest = selection.heaviest;

        let innovation = tally.mean_innovation(X::Measurement::DIMENSION);
        let tightened = tally.tightened + crowded;
        let health = Health::UNEXPLAINED_SCAN.when(!ln_evidence.is_finite())
            | Health::DEGENERATE.when(particles > 1 && n_eff < T::from_f64(1.5))
            | Health::PRUNING_TIGHTENED.when(tightened > 0)
            | Health::MAP_NOT_UPDATED.when(tally.kept > 0)
            | Health::COMPONENTS_LOST.when(tally.lost > 0)
            | Health::COVARIANCE_REPAIRED.when(tally.repaired > 0)
            | Health::INNOVATION_HIGH.when(innovation > T::from_f64(2.0))
            | Health::PREDICTION_REFUSED.when(refused > 0);
        Ok(ScanReport {
            measurements: measured.len(),
            no_birth: tally.no_birth,
            refused,
            candidates: particles * children,
            in_view,
            ln_evidence,
            n_eff,
            resampled: selection.resampled,
            particles,
            survivors: tally.survivors,
            maps_updated: tally.updated,
            births: tally.births,
            merged: tally.merged,
            pruned_mass: tally.pruned_mass,
            tightened,
            not_updated: tally.kept,
            lost: tally.lost,
            repaired: tally.repaired,
            pages_used: still.pages_used(),
            pages: still.pool.capacity(),
            moving_pages_used: moving.pages_used(),
            moving_pages: moving.pool.capacity(),
            detection_scale: learnt.detection_scale(online),
            clutter_scale: learnt.clutter_scale(online),
            innovation,
            health,
        })
    }
}

/// ln L, whatever the models have said: −∞, nothing explained, where it is no number or infinite.
fn explained<T: Real>(ln_likelihood: T) -> T {
    if ln_likelihood.is_finite() { ln_likelihood } else { T::NEG_INFINITY }
}
