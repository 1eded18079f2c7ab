//! The default capacities on a host are sufficient: on recorded logs the filter never prunes because of too little memory. The
//! accuracy on them is tested in `host-sim/tests/claims.rs`.

use scphd::Health;
use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::dimensions::Planar;
use scphd_log::log_folder;
use scphd_run::session::{self, Filter};
use scphd_tests::data_folder;

const SEED: u64 = 1;

#[test]
fn capacities_are_sufficient() {
    for name in ["car_park", "mrclam_ds6_robot1", "phd_slam3_a04"] {
        let Some(folder) = data_folder(name) else { continue };
        let log = log_folder::read(&folder).expect("a readable log");
        let filter = Filter::Core(Precision::F32);
        let session =
            session::run::<Planar>(&log, &Settings::for_log(&log), filter, SEED, &mut |_| ()).expect("a whole run");
        assert_eq!(session.record.scans.len(), log.scans.len());
        for flag in [Health::PRUNING_TIGHTENED, Health::MAP_NOT_UPDATED, Health::COMPONENTS_LOST] {
            let count = session.health.iter().find(|(health, _)| *health == flag).map_or(0, |(_, count)| *count);
            assert_eq!(count, 0, "{name}: scans with {flag:?}");
        }
    }
}
