//! The fixed-capacity filter in lockstep with the reference, in space: every step of the reference starts from the filter's own
//! state and random numbers, so that what differs afterwards is what that one step computed differently.

use super::log::Log;
use super::session::Pilot;
use super::settings::Settings;
use super::slam::{Snapshot, Transparent, core_filter};
use crate::compare::Differences;
use crate::reference::space::{self, Space};
use crate::reference::{Component, Config, MovingConfig};
use crate::settings::Likelihood;
use crate::slam::{Precision, Refusal, full};
use scphd::{AuvControl, Reading};

fn larger(a: &mut f64, b: f64) {
    // NaN is the largest difference of all.
    if b.is_nan() || b > *a {
        *a = b;
    }
}

/// The reference with the models and tuning that the settings describe.
#[must_use]
pub fn reference_of(log: &Log, settings: &Settings) -> Space {
    let Settings { filter, vehicle, camera } = settings;
    let mut noise = [[0.0; 4]; 4];
    for (row, entries) in noise.iter_mut().enumerate() {
        for (column, entry) in entries.iter_mut().enumerate() {
            let own = if row == column { camera.pixel_sigmas[row].powi(2) } else { 0.0 };
            let common = if row % 2 == column % 2 { camera.common_sigmas[row % 2].powi(2) } else { 0.0 };
            *entry = own + common;
        }
    }
    Space {
        config: Config {
            particles: filter.particles,
            samples: filter.samples,
            birth_intensity: filter.birth_intensity,
            clutter_intensity: settings.clutter_intensity(log),
            resample_threshold: filter.resample_threshold,
            prune_weight: filter.prune_weight,
            merge_distance: filter.merge_distance,
            max_components: filter.max_components,
            extraction_weight: filter.extraction_weight,
            likelihood: filter.likelihood,
            moving: MovingConfig {
                birth_intensity: 0.0,
                velocity_sigma_mps: 1.0,
                acceleration_psd: 0.1,
                lifetime_s: 100.0,
                spread_max_m: 1.0,
                extraction_weight: 0.5,
            },
        },
        yaw_acceleration_sigma: vehicle.yaw_acceleration_sigma_radps2,
        velocity_interval_s: vehicle.velocity_interval_s,
        cameras: log.camera.projections,
        noise,
        epipolar_gate: camera.epipolar_gate,
        image: [log.camera.size_px[0], log.camera.size_px[1], camera.edge_px],
        depth: [camera.near_m, camera.far_m, camera.depth_edge_m],
        detection: camera.detection,
    }
}

/// Runs the filter over the first `frames` frames of a log and repeats each of its steps with the reference; `progress` is told the
/// number of frames done. To be run in a thread [with a roomy stack](crate::session::with_roomy_stack).
///
/// # Errors
/// The filter refuses the settings or a step, and says why; or they ask for what the reference does not have, in space any likelihood but
/// the single-cluster one.
pub fn compare(
    log: &Log,
    settings: &Settings,
    precision: Precision,
    seed: u64,
    frames: usize,
    mut progress: impl FnMut(usize),
) -> Result<Differences, Refusal> {
    settings.filter.check_reference_has_all().map_err(Refusal)?;
    if settings.filter.likelihood != Likelihood::SingleCluster {
        return Err(Refusal("in space the reference has the single-cluster likelihood alone".into()));
    }
    let space = reference_of(log, settings);
    let mut filter = core_filter(log, settings, precision, seed)?;
    let mut pilot = Pilot::new(log, settings)?;
    let mut overall = Differences::default();
    for frame in log.frames.iter().take(frames) {
        let mut predicted = false;
        for (control, dt_s) in pilot.steps_to(frame.t_s)? {
            predict(&space, &mut *filter, predicted, &control, dt_s, &mut overall)?;
            predicted = true;
        }
        scan(&space, &mut *filter, &frame.keypoints, &mut overall)?;
        overall.scans += 1;
        progress(overall.scans);
    }
    Ok(overall)
}

fn predict(
    space: &Space,
    filter: &mut dyn Transparent,
    predicted: bool,
    control: &AuvControl<f64>,
    dt_s: f64,
    overall: &mut Differences,
) -> Result<(), Refusal> {
    let mut before = filter.snapshot()?;
    if filter.predict(control, dt_s)?.is_some() {
        return Ok(());
    }
    let after = filter.snapshot()?;
    let reading = |reading: Reading<f64>| [reading.value, reading.sigma];
    let control = space::Control {
        velocity: control.velocity_mps.into(),
        covariance: full(&control.velocity_covariance),
        tilt: [control.roll_rad, control.pitch_rad],
        yaw_rate: control.yaw_rate_radps.map(reading),
        z: control.z_m.map(reading),
    };
    let samples = if predicted { 1 } else { space.config.samples };
    for (child, candidate) in after.candidates.iter().enumerate() {
        let parent = before.candidates[child / samples].pose;
        let moved = space.moved(&parent, &control, dt_s, &mut *before.draws);
        let ours = candidate.pose;
        let position = (0..3).map(|k| (ours.position[k] - moved.position[k]).abs()).fold(0.0, f64::max);
        let yaw = crate::angle::wrap(ours.yaw - moved.yaw).abs();
        larger(&mut overall.predicted_position_m, position);
        larger(&mut overall.predicted_heading_rad, yaw.max((ours.yaw_rate - moved.yaw_rate).abs()));
    }
    Ok(())
}

fn scan(
    space: &Space,
    filter: &mut dyn Transparent,
    keypoints: &[[f64; 4]],
    overall: &mut Differences,
) -> Result<(), Refusal> {
    let mut before = filter.snapshot()?;
    let outcome = filter.scan(keypoints)?;
    let short_of_room =
        [scphd::Health::PRUNING_TIGHTENED, scphd::Health::MAP_NOT_UPDATED, scphd::Health::COMPONENTS_LOST];
    overall.capacity_events += usize::from(short_of_room.iter().any(|&flag| outcome.health.contains(flag)));
    let after = filter.snapshot()?;
    let particles = before.maps.len();
    let samples = before.candidates.len() / particles;
    let weighing = space.weigh(&before.candidates, samples, &before.maps, keypoints);
    for (ours, theirs) in after.ln_likelihoods.iter().zip(&weighing.ln_likelihoods) {
        larger(&mut overall.ln_likelihood, (ours - theirs).abs() / theirs.abs().max(1.0));
    }
    let selection = space.select(&weighing, particles, &mut *before.draws);
    if selection.survivors != after.survivors {
        overall.other_survivors += 1;
        return Ok(());
    }
    for (ours, theirs) in after.candidates.iter().zip(&selection.ln_weights) {
        larger(&mut overall.particle_weight, (ours.ln_weight - theirs).abs());
    }
    let mut last = None;
    for (particle, &survivor) in selection.survivors.iter().enumerate() {
        if last == Some(survivor) {
            continue;
        }
        last = Some(survivor);
        let map = space.updated(&before.candidates[survivor].pose, &before.maps[survivor / samples], keypoints);
        compare_maps(&after, particle, map, overall);
    }
    Ok(())
}

fn compare_maps(after: &Snapshot, particle: usize, mut theirs: Vec<Component<3>>, overall: &mut Differences) {
    for ours in &after.maps[particle] {
        let distance = |other: &Component<3>| {
            let mean: f64 = (0..3).map(|k| (ours.mean[k] - other.mean[k]).abs()).sum();
            mean + (ours.ln_weight - other.ln_weight).abs()
        };
        let nearest = theirs.iter().map(distance).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((place, _)) = nearest.filter(|&(_, distance)| distance < 1e-2) else {
            overall.unmatched += 1;
            continue;
        };
        let other = theirs.swap_remove(place);
        overall.components += 1;
        larger(&mut overall.component_weight, (ours.ln_weight - other.ln_weight).abs());
        let trace: f64 = (0..3).map(|k| other.covariance[k][k]).sum();
        for row in 0..3 {
            larger(&mut overall.mean, (ours.mean[row] - other.mean[row]).abs() / other.covariance[row][row].sqrt());
            for column in 0..3 {
                let off = (ours.covariance[row][column] - other.covariance[row][column]).abs();
                larger(&mut overall.covariance, off / trace);
            }
        }
    }
    overall.unmatched += theirs.len();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::with_roomy_stack;
    use crate::settings::{FilterSettings, Proposal};
    use crate::underwater::tank::girona_tank;

    fn compared(precision: Precision, change: impl FnOnce(&mut Settings)) -> Differences {
        let log = girona_tank(1);
        let mut settings = Settings::for_log(&log);
        (settings.filter.particles, settings.filter.samples) = (4, 2);
        change(&mut settings);
        with_roomy_stack(|| compare(&log, &settings, precision, 3, 30, |_| ())).unwrap().unwrap()
    }

    #[test]
    fn every_step_agrees_with_the_reference_to_a_thousand_millionth() {
        for velocity_interval_s in [0.0, 0.5] {
            let differences = compared(Precision::F64, |settings| {
                settings.vehicle.velocity_interval_s = velocity_interval_s;
                settings.camera.common_sigmas = [2.0 * velocity_interval_s, 1.0];
            });
            println!("{differences:?}");
            assert_eq!((differences.scans, differences.other_survivors, differences.unmatched), (30, 0, 0));
            assert!(differences.components > 2000, "{differences:?}");
            let d = &differences;
            let poses = [d.predicted_position_m, d.predicted_heading_rad];
            let weights = [d.ln_likelihood, d.particle_weight, d.component_weight];
            for figure in poses.into_iter().chain(weights).chain([d.mean, d.covariance]) {
                assert!(figure < 1e-9, "{differences:?}");
            }
        }
    }

    #[test]
    fn a_model_that_differs_shows() {
        let log = girona_tank(1);
        let mut settings = Settings::for_log(&log);
        (settings.filter.particles, settings.filter.samples) = (2, 1);
        let mut space = reference_of(&log, &settings);
        space.cameras[1][0][3] += 1e-3;
        let overall = with_roomy_stack(|| {
            let mut filter = core_filter(&log, &settings, Precision::F64, 3).unwrap();
            let mut overall = Differences::default();
            for frame in &log.frames[..5] {
                scan(&space, &mut *filter, &frame.keypoints, &mut overall).unwrap();
            }
            overall
        })
        .unwrap();
        assert!(overall.mean > 1e-6 || overall.ln_likelihood > 1e-6, "{overall:?}");
    }

    #[test]
    fn what_the_reference_does_not_have_is_refused() {
        let log = girona_tank(1);
        for change in [
            (|filter| filter.proposal = Proposal::Informed) as fn(&mut FilterSettings),
            |filter| filter.detection_memory = 10.0,
            |filter| filter.likelihood = Likelihood::RbEmpty,
        ] {
            let mut settings = Settings::for_log(&log);
            change(&mut settings.filter);
            assert!(compare(&log, &settings, Precision::F64, 3, 1, |_| ()).is_err());
        }
    }
}
