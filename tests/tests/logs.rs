//! Accuracy on the published logs, with the settings that a log gets by default.
//!
//! One seed a log, to keep the tests short; the bounds leave room for what another seed changes, and none for a filter
//! that has lost its way.

use scphd::Health;
use scphd_sim::log_folder;
use scphd_sim::session::{self, Filter, Session};
use scphd_sim::settings::Settings;
use scphd_sim::slam::Precision;
use scphd_tests::data_folder;

/// Greatest mean position RMSE of a group of logs.
enum Bound {
    /// m.
    Metres(f64),
    /// As a share of the mean RMSE of odometry alone.
    OfDeadReckoning(f64),
}

struct Group {
    logs: &'static [&'static str],
    bound: Bound,
}

const CAR_PARK: Group = Group { logs: &["car_park"], bound: Bound::Metres(0.15) };
const MRCLAM: Group =
    Group { logs: &["mrclam_ds6_robot1", "mrclam_ds6_robot2", "mrclam_ds6_robot3"], bound: Bound::Metres(2.0) };
const THESIS: Group = Group {
    logs: &["thesis_cmp_a00", "thesis_cmp_a01", "thesis_cmp_a02", "thesis_cmp_a03", "thesis_cmp_a04"],
    bound: Bound::OfDeadReckoning(0.35),
};
const PHD_SLAM: Group = Group { logs: &["phd_slam3_a00", "phd_slam3_a01", "phd_slam3_a02"], bound: Bound::Metres(6.0) };
const VICTORIA_PARK: Group = Group { logs: &["victoria_park"], bound: Bound::Metres(80.0) };

const SEED: u64 = 1;

/// Runs every log of the group and checks the mean; `None` where a log is absent.
fn check(group: &Group) -> Option<Vec<Session>> {
    let folders: Vec<_> = group.logs.iter().map(|name| data_folder(name)).collect::<Option<_>>()?;
    let mut sessions = Vec::new();
    for folder in folders {
        let log = log_folder::read(&folder).expect("a readable log");
        let settings = Settings::for_log(&log);
        let filter = Filter::Core(Precision::F32);
        let session = session::run(&log, &settings, filter, SEED, &mut |_| ()).expect("a whole run");
        assert_eq!(session.record.scans.len(), log.scans.len());
        sessions.push(session);
    }
    let mean = |rmse: fn(&Session) -> Option<f64>| {
        sessions.iter().map(|session| rmse(session).expect("the log has a truth")).sum::<f64>() / sessions.len() as f64
    };
    let estimate = mean(|session| session.summary.position_rmse_m);
    let dead_reckoning = mean(|session| session.summary.dead_reckoning_rmse_m);
    let bound_m = match group.bound {
        Bound::Metres(bound) => bound,
        Bound::OfDeadReckoning(share) => share * dead_reckoning,
    };
    let text =
        format!("{:?}: RMSE {estimate:.3} m of {bound_m:.3} m, odometry alone {dead_reckoning:.3} m", group.logs);
    println!("{text}");
    assert!(estimate <= bound_m, "{text}");
    Some(sessions)
}

#[test]
fn car_park() {
    let Some(sessions) = check(&CAR_PARK) else { return };
    for session in &sessions {
        for flag in [Health::PRUNING_TIGHTENED, Health::MAP_NOT_UPDATED, Health::COMPONENTS_LOST] {
            let count = session.health.iter().find(|(health, _)| *health == flag).map_or(0, |(_, count)| *count);
            assert_eq!(count, 0, "{}: scans with {flag:?}", session.summary.log);
        }
    }
}

#[test]
fn mrclam() {
    check(&MRCLAM);
}

#[test]
fn thesis() {
    check(&THESIS);
}

#[test]
fn phd_slam() {
    check(&PHD_SLAM);
}

#[test]
fn victoria_park() {
    check(&VICTORIA_PARK);
}
