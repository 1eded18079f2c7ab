use super::tune;
use crate::log::Log;
use crate::scenario;
use crate::settings::Settings;

/// Settings with every noise wrong by a factor, up or down.
fn misjudged(log: &Log, factor: f64) -> Settings {
    let mut settings = Settings::for_log(log);
    settings.filter.particles = 8;
    settings.sensor.range_sigma_m *= factor;
    settings.sensor.bearing_sigma_rad *= factor;
    settings.sensor.clutter_per_scan /= factor;
    settings.sensor.detection_near = 0.8;
    settings.sensor.detection_far = 0.8;
    settings.vehicle.speed_sigma_mps *= factor;
    settings.vehicle.turn_sigma *= factor;
    settings
}

fn value(settings: &Settings) -> [f64; 7] {
    let (vehicle, sensor) = (&settings.vehicle, &settings.sensor);
    [
        vehicle.speed_sigma_mps,
        vehicle.turn_sigma,
        sensor.range_sigma_m,
        sensor.bearing_sigma_rad,
        sensor.detection_near,
        sensor.detection_far,
        sensor.clutter_per_scan,
    ]
}

#[test]
fn a_simulations_noise_is_found_from_either_side() {
    let log = scenario::survey(3);
    let truth = value(&Settings::for_log(&log));
    let tolerance = [0.15, 0.15, 0.1, 0.1, 0.05, 0.05, 0.1];
    for factor in [0.5, 2.0] {
        let mut scans = 0;
        let tuned = tune(&log, &misjudged(&log, factor), 1, 3, &mut |done| scans = done).unwrap();
        assert_eq!(scans, 3 * log.scans.len());
        for ((found, truth), tolerance) in value(&tuned.settings).into_iter().zip(truth).zip(tolerance) {
            let off = found / truth - 1.0;
            assert!(off.abs() < tolerance, "from {factor}: {:#?}", tuned.proposed);
        }
        assert!(tuned.proposed.iter().all(|proposed| proposed.observations > 500), "{:#?}", tuned.proposed);
    }
}

#[test]
fn too_short_a_log_changes_nothing() {
    let mut log = scenario::survey(3);
    log.scans.truncate(2);
    let settings = Settings::for_log(&log);
    let mut expected = settings.clone();
    let tuned = tune(&log, &settings, 1, 1, &mut |_| ()).unwrap();
    // 60 detections are enough for the clutter, and nothing else.
    expected.sensor.clutter_per_scan = tuned.settings.sensor.clutter_per_scan;
    expected.filter.birth_intensity = tuned.settings.filter.birth_intensity;
    assert_eq!(tuned.settings, expected);
}
