//! One scan, from top to bottom: predict, propose, weigh, select, learn, update, adopt, report.

use crate::detection::scan::Scan;
use crate::detection::view::{View, Views};
use crate::filter::drift::{drift, drift_on};
use crate::filter::stages::{Grounds, Outcome, adopt, learn, propose, report, weigh_all};
use crate::filter::tally::Tally;
use crate::filter::update::{Survivors, Update};
use crate::filter::waiting::enter::enter;
use crate::models::OnVehicle;
use crate::particles::select::{Weighed, select};
use crate::settings::config::ADAPTIVE;
use crate::{
    Clutter, Detector, Draft, Executor, MeasurementModel, Motion, Pose, PositionOf, Probe, Real, ScPhd, ScanError,
    ScanReport, ScanRoom, Sensor, Stage, Symmetric,
};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// The scan update, of measurements that have been checked.
    ///
    /// With `DRAFTS`, maps are updated several at a time; without, there is no code for that.
    pub(crate) fn step<X: MeasurementModel<Pose = M::Pose>, const DRAFTS: bool>(
        &mut self,
        detector: &mut Detector<X, ScanRoom<'_, X::Measurement>>,
        measured: &[X::Measurement],
        executor: &impl Executor,
        drafts: &mut [Draft<'_, PositionOf<M::Pose>>],
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, ScanError> {
        let Self { config, memory, .. } = self;
        let Detector { sensing, mounting, births, online, room } = detector;
        let ScanRoom { learnt, measurements, eta, most_in_view } = room;
        let Some(mut noise) = memory.cursor.noise.clone() else { return Err(ScanError::NotStarted) };
        let on_vehicle = OnVehicle::of(sensing, *mounting);
        let Some(noise_factor) = on_vehicle.sensor.noise().factor() else { return Err(ScanError::SensorNoise) };
        let clutter_scale = learnt.clutter_scale(online);
        let scan = Scan::sort::<X::Sensor>(measurements, measured, sensing.clutter(), clutter_scale, births.total());
        let views = Views::<OnVehicle<'_, X>> {
            sensor: &on_vehicle.sensor,
            field_of_view: &on_vehicle.field_of_view,
            detection_scale: learnt.detection_scale(online),
            ln_negligible: config.negligible.ln(),
            ln_sharpest: noise_factor.ln_peak(),
            most_births: memory.static_maps.workspace.capacity(),
        };

        // What the scan before has left waiting enters the maps, or is missed.
        probe.enter(Stage::Predict);
        let mut entering = Tally::new();
        enter(config, births, &views, &scan, memory, &mut entering);
        // What moves has moved (5.14), once for all the steps since the last scan.
        let (pool, waited_s) = (&mut memory.moving_maps.pool, memory.cursor.waited_s);
        if DRAFTS {
            drift_on(pool, config, waited_s, (executor, most_in_view.len()));
        } else {
            drift(pool, config, waited_s);
        }
        probe.leave(Stage::Predict);

        // Candidates: those of the prediction, or drawn now, from poses that the scan has been taken into.
        probe.enter(Stage::Weigh);
        let crowded = propose(config, &views, &scan, memory, eta, &mut noise);
        // Their weights (4.52); the maps are those of the prediction.
        let grounds = Grounds::of(config, memory.cursor);
        let weighing = weigh_all(config, &grounds, &views, &scan, memory, eta, most_in_view, executor);
        probe.leave(Stage::Weigh);

        // Back to one candidate a particle (5.2.2).
        probe.enter(Stage::Resample);
        let candidates = memory.candidates.get(..grounds.candidates()).unwrap_or(&[]);
        let weighed =
            Weighed { candidates, particles: grounds.particles, children: grounds.children, n_eff: weighing.n_eff };
        let selection = select(&weighed, config, &mut noise, memory.survivors, memory.selected);
        probe.leave(Stage::Resample);

        probe.enter(Stage::Update);
        // How often features are detected, and how much clutter there is, as the heaviest particle sees it.
        if ADAPTIVE
            && online.learns()
            && let Some(shown) = learn(config, &grounds, &views, &scan, memory, selection.heaviest, eta)
        {
            learnt.learn(&shown, sensing.clutter().per_scan(), online);
        }
        // The survivors' maps (5.17–5.22).
        let next_label = memory.cursor.next_label;
        let births_wait = memory.waiting.await_scan::<X>(config, views.sensor, &scan, next_label);
        let parent_of = |survivor: u16| grounds.parent_of(usize::from(survivor));
        let look = |survivor: u16| {
            let pose_covariance =
                if grounds.blurs { memory.pose_covariances.get(parent_of(survivor)).copied() } else { None };
            let missed = memory.waiting.missed.get(parent_of(survivor)).copied().unwrap_or(T::ZERO);
            let candidate = candidates.get(usize::from(survivor))?;
            Some((View { missed, ..views.from(&candidate.pose) }, pose_covariance))
        };
        let survivors = memory.survivors.get(..grounds.particles).unwrap_or(&[]);
        let survivors = Survivors { all: survivors, parents: grounds.particles, parent_of, look };
        let workers = most_in_view.len();
        let update = Update {
            static_maps: &mut memory.static_maps,
            moving_maps: &mut memory.moving_maps,
            eta,
            births,
            config,
            weighs: grounds.lone,
            next_label: &mut memory.cursor.next_label,
            known_below: memory.cursor.watch.known_below,
            noted: memory.waiting.noted,
            births_wait,
        };
        let mut tally = if DRAFTS && drafts.len() > 1 && !grounds.lone {
            update.all_on(&survivors, &scan, (executor, workers), drafts, probe)
        } else {
            update.all(&survivors, &scan, probe)
        };
        tally.entered(&entering);
        if births_wait {
            for (particle, &survivor) in survivors.all.iter().enumerate() {
                let pose_covariance = memory.pose_covariances.get(parent_of(survivor)).filter(|_| grounds.blurs);
                if let Some(candidate) = candidates.get(usize::from(survivor)) {
                    let pose_covariance = pose_covariance.copied().unwrap_or(Symmetric::ZERO);
                    memory.waiting.place(particle, candidate.pose, pose_covariance);
                }
            }
        }
        probe.leave(Stage::Update);

        // The selected candidates are the particles.
        let weighing = weighing.completed(&grounds, &tally, memory.ln_likelihoods);
        let cursor = &mut *memory.cursor;
        let watched = cursor.watch.scanned(&tally.recognised(), measured.len(), cursor.waited_s, cursor.next_label);
        let refused = adopt(&grounds, &selection, memory, noise);
        let scales = [learnt.detection_scale(online), learnt.clutter_scale(online)];
        Ok(report(
            &Outcome { grounds, weighing, selection, tally, crowded, refused, watched, scales },
            memory,
            measured,
        ))
    }
}
