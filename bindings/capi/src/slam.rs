//! A filter of a vehicle in the plane, as it is described: the same calls, whatever it is.

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

/// Goes on by another description with the same parts, between any two steps; the numbers of movers and archive of a joint map stay. The watches begin
/// anew. The reason may be null. A service.
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

/// Starts, or starts again, where the description says and as certain of it, with an empty map.
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

/// Puts the vehicle to this pose, known to these standard deviations; the map stays. A service.
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

/// Makes the pose uncertain by further standard deviations; the map stays. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_scatter(
    slam: Handed<scphd_slam>,
    position_sigma_m: f32,
    heading_sigma_rad: f32,
) -> scphd_status {
    serve(slam, |slam| Ok(slam.scatter(&covariance(position_sigma_m, heading_sigma_rad))?))
}

/// Features that a map may be loaded of.
const LOADED: usize = 128;

/// Puts this map, at most 128 features, in the place of the one that there is. Not where there is an archive. A service.
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

/// Moves the vehicle for `dt_s` seconds: speed ahead; speed to the left of a vehicle that moves sideways too, else 0; turn rate to the left,
/// rad/s, or a car's steering angle, rad. The report may be null. Where the control is refused, its time has passed all the same, and the next
/// report says so.
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

/// Takes in a scan of range and bearing of the sensor with this index in the description. The report may be null; so may the measurements, where
/// there are none.
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

/// Takes in a scan of bearings, rad, 0 ahead, growing to the left. As `scphd_slam_scan_range_bearing`.
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

/// Takes in a scan of range and bearing for the pose alone: the map stays as it is. For joint maps without an archive. A service.
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

/// Takes in a measured position, between any two steps. A watch over it is a service. The report may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_observe_position(
    slam: Handed<scphd_slam>,
    x_m: f32,
    y_m: f32,
    report: Out<scphd_fix_report>,
) -> scphd_status {
    observe(slam, report, |slam| slam.observe_position(x_m, y_m), |services| services.watch_position(x_m, y_m))
}

/// Takes in a measured heading, from the x axis towards the y axis. As `scphd_slam_observe_position`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_observe_heading(
    slam: Handed<scphd_slam>,
    heading_rad: f32,
    report: Out<scphd_fix_report>,
) -> scphd_status {
    observe(slam, report, |slam| slam.observe_heading(heading_rad), |services| services.watch_heading(heading_rad))
}

/// Where the vehicle is.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_estimate_pose(slam: Handed<scphd_slam>, mut pose: Out<scphd_plane_pose>) -> scphd_status {
    on(slam, |slam| {
        *pose.get()? = slam.pose().ok_or(scphd_status::NotReset)?.into();
        Ok(())
    })
}

/// What the odometry is off by, of a filter that learns it.
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

/// Writes the features that stand still to an array of so many; what does not fit is counted. An array of none may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_estimate_map(
    slam: Handed<scphd_slam>,
    mut features: Out<scphd_feature>,
    capacity: usize,
    mut map: Out<scphd_map>,
) -> scphd_status {
    on(slam, |slam| map::write(&mut features, capacity, &mut map, |room| slam.features(room)))
}

/// Writes the features that move to an array of so many; what does not fit is counted. An array of none may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_estimate_movers(
    slam: Handed<scphd_slam>,
    mut movers: Out<scphd_mover>,
    capacity: usize,
    mut map: Out<scphd_map>,
) -> scphd_status {
    on(slam, |slam| map::write(&mut movers, capacity, &mut map, |room| slam.movers(room)))
}

/// Writes a snapshot to so many bytes of room, by which a filter of the same description and set goes on to the bit, but for its watches. `kind`
/// tells vehicles apart. `written` is how many bytes it takes. A room of none may be null, and nothing is written then. A service.
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

/// Goes on from a snapshot of so many bytes. Where one is refused for what is in it, the filter has to be reset. A service.
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

/// A hash of all that the filter knows, to the last bit: the same inputs give the same on every machine. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_digest(slam: Handed<scphd_slam>, mut digest: Out<u64>) -> scphd_status {
    serve(slam, |slam| {
        digest.place()?.write(slam.digest());
        Ok(())
    })
}

/// Looks over all that the filter knows: `SCPHD_STATUS_DAMAGED` where memory was damaged. A service.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_slam_audit(slam: Handed<scphd_slam>) -> scphd_status {
    serve(slam, |slam| slam.audit().map_err(|_| scphd_status::Damaged))
}
