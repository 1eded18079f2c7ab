//! Fixes that a filter rejects, over whole drives.

use crate::session;
use scphd_filters::ekf::Association;
use scphd_filters::settings::Settings;
use scphd_filters::slam::{Filter, Precision};
use scphd_log::dimensions::Planar;
use scphd_log::log::{Fix, FixNoise, PoseFix};
use scphd_worlds::scenario;

/// A drive with a position every second and a wrong initial heading in its head.
#[test]
fn a_wrong_initial_heading_is_corrected_by_positions() {
    for error_rad in [0.5, 1.0, 2.0, std::f64::consts::PI] {
        let mut log = scenario::by_name("worlds", 12).unwrap();
        log.scans.retain(|scan| scan.t_s < 100.0);
        log.odometry.retain(|row| row.t_s < 100.0);
        log.initial_pose[2] = scphd_log::angle::wrap(log.initial_pose[2] + error_rad);
        let mut next_s = 0.0;
        for row in &log.truth {
            if row.t_s >= next_s {
                log.fixes.push(Fix { t_s: row.t_s, measured: PoseFix::Position(row.position) });
                next_s = row.t_s + 1.0;
            }
        }
        log.fixes.retain(|fix| fix.t_s < 100.0);
        log.fix_noise = FixNoise { position_sigma_m: Some(1.0), ..FixNoise::default() };
        for filter in
            [Filter::Joint(Precision::F32), Filter::Core(Precision::F32), Filter::Ekf(Association::NearestNeighbour)]
        {
            let mut settings = Settings::for_log(&log);
            settings.filter.particles = 2;
            let session = session::run::<Planar>(&log, &settings, filter, 1, &mut |_| ()).unwrap();
            let late = session.record.scans.iter().filter(|scan| scan.t_s > 60.0);
            let errors = late.filter_map(|scan| {
                let [x, y] = scan.true_position?;
                Some(libm::hypot(scan.pose[0] - x, scan.pose[1] - y))
            });
            let worst = errors.fold(0.0, f64::max);
            assert!(worst < 2.5, "{filter:?}, {error_rad} rad: {worst} m");
            assert!(session.summary.fix_relocations > 0, "{filter:?}, {error_rad} rad");
        }
    }
}
