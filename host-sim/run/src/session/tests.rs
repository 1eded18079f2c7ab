use super::*;
use scphd_filters::settings::Settings;
use scphd_filters::slam::{PoseAndCovariance, Precision, ScanOutcome};
use scphd_log::log::Log;
use scphd_worlds::scenario;

#[test]
fn conditions_have_distinct_names() {
    let names: Vec<String> = Health::all().map(condition_name).collect();
    assert_eq!(names[1], "DEGENERATE");
    for (k, name) in names.iter().enumerate() {
        assert!(!name.is_empty() && !names[..k].contains(name));
    }
}

/// A filter that returns the truth and refuses the scan number `refuse`.
struct Oracle {
    log: Log,
    scans: usize,
    refuse: usize,
}

impl Slam for Oracle {
    fn predict(&mut self, _: [f64; 3], _: f64) -> Result<Option<Implausible>, Refusal> {
        Ok(None)
    }

    fn scan(&mut self, _: usize, _: &[[f64; 2]]) -> Result<ScanOutcome, Refusal> {
        if self.scans == self.refuse {
            return Err(Refusal("no".into()));
        }
        self.scans += 1;
        let health = if self.scans == 2 { Health::DEGENERATE } else { Health::GOOD };
        Ok(ScanOutcome { health, ..ScanOutcome::SILENT })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance, Refusal> {
        let truth = self.log.truth[self.scans - 1];
        Ok(([truth.position[0] + 1.0, truth.position[1], truth.heading_rad.unwrap()], [[0.0; 3]; 3]))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal> {
        let features =
            self.log.landmarks.iter().map(|&mean| MapFeature { id: 0, weight: 1.0, mean, covariance: [[0.0; 2]; 2] });
        Ok((self.scans as f64, features.collect()))
    }

    fn digest(&mut self) -> Option<u64> {
        Some(7)
    }
}

fn short_log() -> Log {
    let mut log = scenario::survey(1);
    log.scans.truncate(20);
    log
}

#[test]
fn the_error_of_an_oracle_is_the_added_one() {
    let log = short_log();
    let mut oracle = Oracle { log: log.clone(), scans: 0, refuse: usize::MAX };
    let mut told = Vec::new();
    let run =
        process_log::<Planar>(&log, &Settings::for_log(&log), &mut oracle, None, false, &mut |done| told.push(done))
            .unwrap();
    assert_eq!(told, (1..=20).collect::<Vec<_>>());
    assert_eq!(run.health, [(Health::DEGENERATE, 1)]);
    let summary = summary(&log, &Settings::for_log(&log), Filter::Reference, 3, &run, &mut oracle);
    assert!((summary.position_rmse_m.unwrap() - 1.0).abs() < 1e-12);
    assert_eq!((summary.heading_rmse_deg, summary.ospa_m, summary.gospa_m), (Some(0.0), Some(0.0), Some(0.0)));
    assert_eq!((summary.features_estimated, summary.digest, summary.scans), (Some(20.0), Some(7), 20));
}

#[test]
fn an_implausible_row_is_left_out_and_reported() {
    let log = short_log();
    let settings = Settings::for_log(&log);
    let with = |row: usize, speed| {
        let mut log = log.clone();
        log.odometry[row].control[0] = speed;
        run::<Planar>(&log, &settings, Filter::Core(Precision::F32), 1, &mut |_| ()).unwrap()
    };
    let whole = with(20, log.odometry[20].control[0]);
    let spoilt = with(20, 1e18);
    assert!(whole.left_out.is_empty());
    let t_s = log.odometry[20].t_s;
    assert_eq!(spoilt.left_out, [LeftOut { row: 20, t_s, what: Implausible::Speed }]);
    assert!(spoilt.health.contains(&(Health::PREDICTION_REFUSED, 1)), "{:?}", spoilt.health);
    // The error is at most that of one missing row.
    let [whole, spoilt] = [whole, spoilt].map(|session| session.summary.position_rmse_m.unwrap());
    assert!(spoilt < whole + 0.5, "{spoilt} m, and {whole} m without");
}

#[test]
fn a_refusal_has_scan_and_time() {
    let log = short_log();
    let mut oracle = Oracle { log: log.clone(), scans: 0, refuse: 5 };
    let error = process_log::<Planar>(&log, &Settings::for_log(&log), &mut oracle, None, false, &mut |_| ())
        .err()
        .unwrap()
        .to_string();
    assert_eq!(error, "scan 5 at 0.5 s: the scan refused: no");
}

#[test]
fn settings_beyond_the_capacity_are_refused_at_the_start() {
    let log = short_log();
    let mut settings = Settings::for_log(&log);
    settings.filter.particles = 5000;
    let error = run::<Planar>(&log, &settings, Filter::Core(Precision::F32), 1, &mut |_| ()).unwrap_err();
    assert!(matches!(error, SessionError::Start(_)), "{error}");
    assert!(error.to_string().contains("5000 particles"), "{error}");
}
