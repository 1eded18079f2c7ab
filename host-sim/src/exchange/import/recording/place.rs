//! Fixes and true poses of messages.

use super::told::Told;
use crate::exchange::import::ImportError;
use crate::exchange::mcap::UNKNOWN;
use crate::log::{Fix, FixNoise, PoseFix, TruePose};
use scphd_ros::Time;
use scphd_ros::messages::{NavSatFix, Odometry, Pose, PoseStamped, PoseWithCovarianceStamped, Quaternion};

/// Semi-major axis, m, and flattening of the WGS 84 ellipsoid (NGA.STND.0036).
const AXIS_M: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Least standard deviations of a fix that a log may state.
const LEAST: [f64; 2] = [1e-3, 1e-4];

/// True poses.
#[derive(Debug, Default)]
pub(super) struct True(Vec<(u64, [f64; 2], Option<f64>)>);

impl True {
    pub(super) fn take(&mut self, told: &Told) -> Result<Time, ImportError> {
        let (stamp, pose) = match told.channel.kind.as_str() {
            "geometry_msgs/msg/PoseStamped" => {
                let message: PoseStamped = told.decode()?;
                (message.header.stamp, message.pose)
            }
            "nav_msgs/msg/Odometry" => {
                let message: Odometry = told.decode()?;
                (message.header.stamp, message.pose.pose)
            }
            _ => {
                let message: PoseWithCovarianceStamped = told.decode()?;
                (message.header.stamp, message.pose.pose)
            }
        };
        let place = [told.finite("x", pose.position.x)?, told.finite("y", pose.position.y)?];
        // No turn at all is what is written where it is not known.
        let turn = Some(pose.orientation).filter(|turn| *turn != Quaternion::default());
        self.0.push((0, place, turn.and_then(|turn| turn.unit()).map(|turn| turn.yaw_rad())));
        Ok(stamp)
    }

    pub(super) fn at(&mut self, ns: u64) {
        self.0.iter_mut().last().into_iter().for_each(|(at, ..)| *at = ns);
    }

    /// The rows; where any has a turn, those without one have the heading 0.
    pub(super) fn rows(&self, seconds: &dyn Fn(u64) -> f64) -> Vec<TruePose> {
        let known = self.0.iter().any(|(.., turn)| turn.is_some());
        let row = |&(ns, position, turn): &(u64, _, Option<f64>)| TruePose {
            t_s: seconds(ns),
            position,
            heading_rad: known.then(|| turn.unwrap_or(0.0)),
        };
        self.0.iter().map(row).collect()
    }
}

/// Fixes as they come.
#[derive(Debug, Default)]
pub(super) struct Fixes {
    found: Vec<Found>,
    /// Messages of a receiver that did not know where it was.
    without: usize,
    origin: Option<[f64; 3]>,
}

/// A place, m, and its variance, m², where that is known.
type Place = ([f64; 2], Option<f64>);
/// A heading, rad, and its variance, rad², likewise.
type Heading = (f64, Option<f64>);

/// A message: what it measures.
#[derive(Debug)]
struct Found {
    ns: u64,
    place: Option<Place>,
    heading: Option<Heading>,
}

impl Fixes {
    pub(super) fn take(&mut self, told: &Told) -> Result<Time, ImportError> {
        let (stamp, place, heading) = if told.channel.kind == "sensor_msgs/msg/NavSatFix" {
            let message: NavSatFix = told.decode()?;
            (message.header.stamp, self.satellite(told, &message)?, None)
        } else {
            let message: PoseWithCovarianceStamped = told.decode()?;
            let (place, heading) = measured(told, &message.pose.pose, &message.pose.covariance)?;
            (message.header.stamp, place, heading)
        };
        self.found.push(Found { ns: 0, place, heading });
        Ok(stamp)
    }

    /// East and north of the first place, m.
    fn satellite(&mut self, told: &Told, fix: &NavSatFix) -> Result<Option<Place>, ImportError> {
        if fix.status.status < 0 || fix.latitude.is_nan() || fix.longitude.is_nan() {
            self.without += 1;
            return Ok(None);
        }
        if !(fix.latitude.abs() <= 90.0 && fix.longitude.abs() <= 360.0) {
            let what = format!("latitude {}° and longitude {}° are nowhere on earth", fix.latitude, fix.longitude);
            return Err(told.error(what));
        }
        let altitude =
            if fix.altitude.is_finite() { fix.altitude } else { self.origin.map_or(0.0, |origin| origin[2]) };
        let here = [fix.latitude.to_radians(), fix.longitude.to_radians(), altitude];
        let origin = *self.origin.get_or_insert(here);
        let [east, north] = east_north(origin, here);
        let variance = 0.5 * (fix.position_covariance[0] + fix.position_covariance[4]);
        let known = fix.position_covariance_type > 0 && variance > 0.0 && variance.is_finite();
        Ok(Some(([east, north], known.then_some(variance))))
    }

    pub(super) fn at(&mut self, ns: u64) {
        self.found.iter_mut().last().into_iter().for_each(|found| found.ns = ns);
    }

    /// The fixes, how good they are, and what has to be told; `stated` is what the head says of them.
    pub(super) fn rows(
        &self,
        seconds: &dyn Fn(u64) -> f64,
        stated: Option<FixNoise>,
    ) -> Result<(Vec<Fix>, FixNoise, Vec<String>), String> {
        let mut fixes = Vec::new();
        for found in &self.found {
            let t_s = seconds(found.ns);
            let place = found.place.map(|(place, _)| PoseFix::Position(place));
            let heading = found.heading.map(|(heading_rad, _)| PoseFix::Heading(heading_rad));
            fixes.extend(place.into_iter().chain(heading).map(|measured| Fix { t_s, measured }));
        }
        let mut told = Vec::new();
        if self.without > 0 {
            told.push(format!("{} fixes without a place are left out", self.without));
        }
        if let Some([latitude, longitude, _]) = self.origin {
            told.push(format!(
                "the frame of the fixes has x to the east and y to the north of {:.9}°, {:.9}°; the initial pose has to be in it",
                latitude.to_degrees(),
                longitude.to_degrees()
            ));
        }
        let stated = stated.unwrap_or_default();
        let places = self.found.iter().filter_map(|found| found.place.map(|(_, variance)| variance));
        let headings = self.found.iter().filter_map(|found| found.heading.map(|(_, variance)| variance));
        let position_sigma_m = sigma("position_sigma_m", places.collect(), stated.position_sigma_m, LEAST[0])?;
        let heading_sigma_rad = sigma("heading_sigma_rad", headings.collect(), stated.heading_sigma_rad, LEAST[1])?;
        Ok((fixes, FixNoise { position_sigma_m, heading_sigma_rad, ..stated }, told))
    }
}

/// A pose with covariance measures what has a variance of less than [`UNKNOWN`]; 0 says that the variance is not known.
fn measured(
    told: &Told,
    pose: &Pose,
    covariance: &[[f64; 6]; 6],
) -> Result<(Option<Place>, Option<Heading>), ImportError> {
    let variance = |number: f64| (number > 0.0).then_some(number);
    let (mut place, mut heading) = (None, None);
    let of_place = 0.5 * (covariance[0][0] + covariance[1][1]);
    if of_place < UNKNOWN {
        let at = [told.finite("x", pose.position.x)?, told.finite("y", pose.position.y)?];
        place = Some((at, variance(of_place)));
    }
    if covariance[5][5] < UNKNOWN {
        let turn = pose.orientation.unit().ok_or_else(|| told.error("the turn is no quaternion"))?;
        heading = Some((turn.yaw_rad(), variance(covariance[5][5])));
    }
    Ok((place, heading))
}

/// What is stated, or the median of what the messages say.
fn sigma(name: &str, variances: Vec<Option<f64>>, stated: Option<f64>, least: f64) -> Result<Option<f64>, String> {
    if variances.is_empty() || stated.is_some() {
        return Ok(stated);
    }
    let mut known: Vec<f64> = variances.into_iter().flatten().collect();
    known.sort_by(f64::total_cmp);
    match known.get(known.len() / 2) {
        Some(variance) => Ok(Some(variance.sqrt().max(least))),
        None => Err(format!(
            "fixes do not say how good they are: say {name} under [fixes] in the file of --head, or --fixes none"
        )),
    }
}

/// East and north of `origin`, m, in its tangent plane; latitude rad, longitude rad, height m.
fn east_north(origin: [f64; 3], place: [f64; 3]) -> [f64; 2] {
    let cartesian = |[latitude, longitude, height]: [f64; 3]| {
        let square = FLATTENING * (2.0 - FLATTENING);
        let across = AXIS_M / (1.0 - square * latitude.sin().powi(2)).sqrt();
        let level = (across + height) * latitude.cos();
        [level * longitude.cos(), level * longitude.sin(), (across * (1.0 - square) + height) * latitude.sin()]
    };
    let (from, to) = (cartesian(origin), cartesian(place));
    let [x, y, z] = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    let ((sl, cl), (so, co)) = (origin[0].sin_cos(), origin[1].sin_cos());
    [co * y - so * x, cl * z - sl * (co * x + so * y)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_are_as_long_as_tables_say() {
        // Snyder, Map Projections (USGS 1395), table 6, in its ellipsoids to 5 digits: a degree of latitude is 110.574 km at the
        // equator and 111.694 km at the poles, a degree of longitude 111.320 km at the equator and 78.847 km at 45°.
        let small = 1e-4_f64.to_radians();
        let degree = |latitude: f64, to: [f64; 2]| {
            let origin = [latitude.to_radians(), 0.3, 0.0];
            east_north(origin, [origin[0] + to[0] * small, origin[1] + to[1] * small, 0.0]).map(|m| m / 1e-4 / 1e3)
        };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-3, "{a} {b}");
        close(degree(0.0, [1.0, 0.0])[1], 110.574);
        close(degree(89.9999, [1.0, 0.0])[1], 111.694);
        close(degree(0.0, [0.0, 1.0])[0], 111.320);
        close(degree(45.0, [0.0, 1.0])[0], 78.847);
    }

    #[test]
    fn the_median_counts_and_what_is_not_known_is_asked_for() {
        assert_eq!(sigma("s", vec![Some(4.0), None, Some(9.0), Some(1.0)], None, 1e-3), Ok(Some(2.0)));
        assert_eq!(sigma("s", vec![Some(1e-12)], None, 1e-3), Ok(Some(1e-3)));
        assert_eq!(sigma("s", vec![None], Some(0.5), 1e-3), Ok(Some(0.5)));
        assert_eq!(sigma("s", vec![], None, 1e-3), Ok(None));
        assert!(sigma("position_sigma_m", vec![None], None, 1e-3).unwrap_err().contains("position_sigma_m"));
    }
}
