//! Drives far from the origin of their coordinates.

use super::{Filter, run};
use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::dimensions::Planar;
use scphd_worlds::scenario;

/// A drive with large map coordinates has the same errors as at the origin, to the millimetre, and the same map.
#[test]
fn a_drive_far_from_the_origin_is_as_accurate() {
    let mut log = scenario::by_name("survey", 3).unwrap();
    log.scans.truncate(60);
    let settings = Settings::for_scenario("survey", &log);
    let [east, north] = [500_000.0, 5_500_000.0];
    let mut far = log.clone();
    (far.initial_pose[0], far.initial_pose[1]) = (far.initial_pose[0] + east, far.initial_pose[1] + north);
    for row in &mut far.truth {
        row.position = [row.position[0] + east, row.position[1] + north];
    }
    far.landmarks.iter_mut().for_each(|place| *place = [place[0] + east, place[1] + north]);
    for filter in [Filter::Core(Precision::F32), Filter::Joint(Precision::F32)] {
        let of = |log| run::<Planar>(log, &settings, filter, 1, &mut |_| ()).unwrap().record;
        let (near, far) = (of(&log), of(&far));
        let (end, far_end) = (near.scans.last().unwrap(), far.scans.last().unwrap());
        assert!((end.pose[0] + east - far_end.pose[0]).abs() < 1e-3, "{filter:?}");
        assert!((end.pose[1] + north - far_end.pose[1]).abs() < 1e-3, "{filter:?}");
        assert!(near.map.len() > 5 && near.map.len() == far.map.len(), "{filter:?}");
        let error = |record: &scphd_score::record::ScanRecord| record.position_error_m().unwrap();
        assert!((error(end) - error(far_end)).abs() < 1e-3, "{filter:?}");
    }
}
