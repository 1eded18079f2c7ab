//! A described filter of a vehicle in the plane: the functions are the same for all filters.

use crate::map;
use crate::pointer::{Handed, In, Out, tell};
use crate::reason::Reason;
use crate::running::{observe, on, scphd_slam, serve};
use crate::{
    scphd_description, scphd_feature, scphd_fix_report, scphd_map, scphd_mover, scphd_odometry, scphd_plane_pose,
    scphd_predict_report, scphd_range_bearing, scphd_reason, scphd_scan_report, scphd_status,
};
use nalgebra::{Vector2, Vector3};
use scphd::Component;
use scphd::models::PlanarPose;
use scphd::numerics::Symmetric;
use scphd::snapshot::{SliceEnd, from_slice};
use scphd_vehicle::{Control, Measurements};

/// Replaces the description by one with the same parts, at any time between other calls; the settings of movers, archive and
/// hypotheses of a joint map must not change. The monitoring of rejected fixes starts again. The reason may be null. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_configure(
    slam: Handed<scphd_slam>,
    mut description: Handed<scphd_description>,
    mut reason: Out<scphd_reason>,
) -> scphd_status {
    serve(slam, |slam| {
        let mut reason = Reason::of(&mut reason)?;
        slam.configure(&*description.enter()?).map_err(|error| reason.start(error))
    })
}

/// Starts the filter, or starts it again, with an empty map, and the pose and standard deviations of the description.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_reset(
    slam: Handed<scphd_slam>,
    mut description: Handed<scphd_description>,
) -> scphd_status {
    on(slam, |slam| Ok(slam.reset(&description.enter()?.start)?))
}

fn covariance(position_sigma_m: f32, heading_sigma_rad: f32) -> Symmetric<Vector3<f32>> {
    let [place, heading] = [position_sigma_m, heading_sigma_rad].map(|sigma| sigma * sigma);
    Symmetric::from_diagonal([place, place, heading])
}

/// Sets the pose and its standard deviations, and keeps the map. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_relocate(
    slam: Handed<scphd_slam>,
    x_m: f32,
    y_m: f32,
    heading_rad: f32,
    position_sigma_m: f32,
    heading_sigma_rad: f32,
) -> scphd_status {
    let pose = PlanarPose::new(x_m, y_m, heading_rad);
    serve(slam, |slam| Ok(slam.relocate(pose, &covariance(position_sigma_m, heading_sigma_rad))?))
}

/// Adds these standard deviations, in quadrature, to the uncertainty of the pose; the map is kept. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_scatter(
    slam: Handed<scphd_slam>,
    position_sigma_m: f32,
    heading_sigma_rad: f32,
) -> scphd_status {
    serve(slam, |slam| Ok(slam.scatter(&covariance(position_sigma_m, heading_sigma_rad))?))
}

/// Maximum number of features in a loaded map.
const LOADED: usize = 128;

/// Replaces the map by this one, of at most 128 features. An archive is emptied: the map must fit the window. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_load_map(
    slam: Handed<scphd_slam>,
    features: In<scphd_feature>,
    count: usize,
) -> scphd_status {
    serve(slam, |slam| {
        let features = features.array(count)?;
        let mut components = [Component::<Vector2<f32>>::ZERO; LOADED];
        let room = components.get_mut(..features.len()).ok_or(scphd_status::ArrayTooLong)?;
        room.iter_mut().zip(features).for_each(|(place, feature)| *place = feature.component());
        Ok(slam.load_map(room)?)
    })
}

/// Predicts the pose after `dt_s` seconds. Speed ahead; speed to the left, 0 unless the vehicle can move sideways; turn rate to
/// the left, rad/s, or steering angle of a car, rad. The report may be null. If the control is refused, the time of the filter
/// advances nevertheless, and the next report counts the refusal.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_predict(
    slam: Handed<scphd_slam>,
    speed_mps: f32,
    left_mps: f32,
    turn: f32,
    dt_s: f32,
    mut report: Out<scphd_predict_report>,
) -> scphd_status {
    on(slam, |slam| {
        let report = report.wanted()?;
        tell(report, slam.predict(Control { speed_mps, left_mps, turn }, dt_s)?);
        Ok(())
    })
}

/// Updates the filter with a scan of ranges and bearings of the sensor with this index in the description. The report may be
/// null, and so may the measurements if `count` is 0.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_scan_range_bearing(
    slam: Handed<scphd_slam>,
    sensor: usize,
    measurements: In<scphd_range_bearing>,
    count: usize,
    mut report: Out<scphd_scan_report>,
) -> scphd_status {
    on(slam, |slam| {
        let (scan, report) = (Measurements::RangeBearing(measurements.vectors(count)?), report.wanted()?);
        tell(report, slam.scan(sensor, scan)?);
        Ok(())
    })
}

/// Updates the filter with a scan of bearings, rad, 0 ahead, positive to the left. As `scphd_slam_scan_range_bearing`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_scan_bearing(
    slam: Handed<scphd_slam>,
    sensor: usize,
    bearings_rad: In<f32>,
    count: usize,
    mut report: Out<scphd_scan_report>,
) -> scphd_status {
    on(slam, |slam| {
        let (scan, report) = (Measurements::Bearing(bearings_rad.vectors(count)?), report.wanted()?);
        tell(report, slam.scan(sensor, scan)?);
        Ok(())
    })
}

/// Updates only the pose with a scan of ranges and bearings; the map does not change. For joint maps. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_localise(
    slam: Handed<scphd_slam>,
    sensor: usize,
    measurements: In<scphd_range_bearing>,
    count: usize,
    mut report: Out<scphd_scan_report>,
) -> scphd_status {
    serve(slam, |slam| {
        let (scan, report) = (Measurements::RangeBearing(measurements.vectors(count)?), report.wanted()?);
        tell(report, slam.localise(sensor, scan)?);
        Ok(())
    })
}

/// Updates the filter with a measured position, at any time between other calls. Its monitoring is a service. The report may be
/// null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_observe_position(
    slam: Handed<scphd_slam>,
    x_m: f32,
    y_m: f32,
    report: Out<scphd_fix_report>,
) -> scphd_status {
    observe(slam, report, |slam| slam.observe_position(x_m, y_m), |services| services.watch_position(x_m, y_m))
}

/// Updates the filter with a measured heading, from the x axis towards the y axis. As `scphd_slam_observe_position`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_observe_heading(
    slam: Handed<scphd_slam>,
    heading_rad: f32,
    report: Out<scphd_fix_report>,
) -> scphd_status {
    observe(slam, report, |slam| slam.observe_heading(heading_rad), |services| services.watch_heading(heading_rad))
}

/// Writes the pose estimate.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_estimate_pose(slam: Handed<scphd_slam>, mut pose: Out<scphd_plane_pose>) -> scphd_status {
    on(slam, |slam| {
        *pose.get()? = slam.pose().ok_or(scphd_status::NotReset)?.into();
        Ok(())
    })
}

/// Writes the estimated odometry error, of a filter that estimates it.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_estimate_odometry(
    slam: Handed<scphd_slam>,
    mut odometry: Out<scphd_odometry>,
) -> scphd_status {
    on(slam, |slam| {
        *odometry.get()? = slam.odometry().ok_or(scphd_status::NotPossible)?.into();
        Ok(())
    })
}

/// Writes static features to an array of `capacity` elements, and counts those that do not fit. If `capacity` is 0 the array may
/// be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_estimate_map(
    slam: Handed<scphd_slam>,
    mut features: Out<scphd_feature>,
    capacity: usize,
    mut map: Out<scphd_map>,
) -> scphd_status {
    on(slam, |slam| map::write(&mut features, capacity, &mut map, |room| slam.features(room)))
}

/// Writes moving features to an array of `capacity` elements, and counts those that do not fit. If `capacity` is 0 the array may
/// be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_estimate_movers(
    slam: Handed<scphd_slam>,
    mut movers: Out<scphd_mover>,
    capacity: usize,
    mut map: Out<scphd_map>,
) -> scphd_status {
    on(slam, |slam| map::write(&mut movers, capacity, &mut map, |room| slam.movers(room)))
}

/// Writes a snapshot to `room`, from which a filter with the same description and set continues bit for bit, except for the
/// monitoring of fixes. `kind` is a number of the vehicle type. `written` is set to the size of the snapshot, bytes. If the
/// capacity is 0, `room` may be null and nothing is written to it. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_save(
    slam: Handed<scphd_slam>,
    kind: u32,
    mut room: Out<u8>,
    capacity: usize,
    mut written: Out<usize>,
) -> scphd_status {
    serve(slam, |slam| {
        let (written, room) = (written.place()?, room.room(capacity)?);
        let counts_alone = room.is_empty();
        let mut slots = room.iter_mut();
        let mut sink = |part: &[u8]| {
            if counts_alone {
                return Ok(());
            }
            part.iter().try_for_each(|byte| slots.next().ok_or(SliceEnd).map(|slot| _ = slot.write(*byte)))
        };
        written.write(slam.save(kind, &mut sink)?);
        Ok(())
    })
}

/// Restores a snapshot. If its contents are refused, the filter has to be reset. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_restore(
    slam: Handed<scphd_slam>,
    kind: u32,
    snapshot: In<u8>,
    size_bytes: usize,
) -> scphd_status {
    serve(slam, |slam| {
        slam.restore(kind, &mut from_slice(snapshot.array(size_bytes)?))?;
        Ok(())
    })
}

/// Writes a hash of the whole state: the same inputs give the same hash on every machine. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_digest(slam: Handed<scphd_slam>, mut digest: Out<u64>) -> scphd_status {
    serve(slam, |slam| {
        digest.place()?.write(slam.digest());
        Ok(())
    })
}

/// Checks the whole state. Returns `SCPHD_STATUS_DAMAGED` if memory was damaged. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_audit(slam: Handed<scphd_slam>) -> scphd_status {
    serve(slam, |slam| slam.audit().map_err(|_| scphd_status::Damaged))
}
