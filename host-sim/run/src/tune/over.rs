//! A run over a log, observed step by step.

use crate::session::SessionError;
use scphd_filters::kind::Kind;
use scphd_filters::slam::Slam;
use scphd_log::dimensions::Covariance;
use scphd_log::events::Event;
use scphd_log::log::Scan;
use scphd_score::record::MapFeature;

pub(super) enum Step<'a, K: Kind> {
    /// A motion that the filter did not reject.
    Moved { scan: usize, control: &'a K::Control, dt_s: f64 },
    /// A processed scan.
    Seen {
        /// Its index in the log.
        scan: usize,
        taken: &'a Scan<K>,
        before: (K::Pose, Covariance<K::Pose>),
        after: K::Pose,
        /// The estimated map after; empty unless asked for.
        map: Vec<MapFeature<K>>,
    },
}

/// Processes the first `scans` scans of a log with a filter, and passes on each step.
pub(super) fn over<K: Kind>(
    slam: &mut dyn Slam<K>,
    log: &K::Log,
    settings: &K::Settings,
    scans: usize,
    with_maps: bool,
    mut tell: impl FnMut(Step<'_, K>),
) -> Result<(), SessionError> {
    let mut watch = K::fix_watch(settings).map_err(SessionError::Start)?;
    let (all, mut scan) = (K::scans(log), 0);
    for event in K::events(log, settings).map_err(SessionError::Start)? {
        if scan >= scans {
            break;
        }
        let refused = |step| move |refusal| SessionError::Step { scan, t_s: all[scan].t_s, step, refusal };
        match event {
            Event::Predict { control, dt_s, .. } => {
                watch.wait(dt_s);
                if slam.predict(control, dt_s).map_err(refused("the prediction"))?.is_none() {
                    tell(Step::Moved { scan, control: &control, dt_s });
                }
            }
            Event::Fix { fix } => {
                watch.show(slam, &fix).map_err(refused("the fix"))?;
            }
            Event::Scan { index } => {
                let before = slam.pose().map_err(refused("the pose"))?;
                slam.scan(all[index].sensor, &all[index].detections).map_err(refused("the scan"))?;
                let (after, _) = slam.pose().map_err(refused("the pose"))?;
                let map = if with_maps { slam.map().map_err(refused("the map"))?.1 } else { Vec::new() };
                tell(Step::Seen { scan: index, taken: &all[index], before, after, map });
                scan = index + 1;
            }
        }
    }
    Ok(())
}
