//! Fixes and true poses of messages.

use super::sight::frame;
use super::told::Told;
use crate::import::ImportError;
use crate::mcap::UNKNOWN;
use scphd_log::angle::wrap;
use scphd_log::log::{Fix, FixNoise, PoseFix, TruePose};
use scphd_log::vehicle::FASTEST_MPS;
use scphd_ros::Time;
use scphd_ros::messages::{NavSatFix, Odometry, Pose, PoseStamped, PoseWithCovarianceStamped, Quaternion};

/// Semi-major axis, m, and flattening of the WGS 84 ellipsoid (NGA.STND.0036).
const AXIS_M: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Least standard deviations of a fix in a log, m and rad.
const LEAST: [f64; 2] = [1e-3, 1e-4];

/// Distance from latitude and longitude 0° below which a position means "unknown", degrees: a tenth of a metre in the Gulf of
/// Guinea.
const ZERO_DEG: f64 = 1e-6;
/// Least distance from the other fixes at which one is an outlier, m.
const NEAR_M: f64 = 50_000.0;
/// Greatest distance of the first fix from the initial pose, in standard deviations, plus a share of the distance driven.
const FAR_SIGMAS: f64 = 5.0;
const FAR_SHARE: f64 = 0.1;
/// Trajectories agree if their median distance is below this number of standard deviations; for right ones it is 1.2,
const NEAR_SIGMAS: f64 = 2.5;
/// plus this share of a distance by odometry.
const WAY_SHARE: f64 = 0.03;
/// A trajectory determines its direction to a twentieth of a radian from this length on, m, or in standard deviations of a fix,
/// and with this number of fixes.
const LONG_M: f64 = 5.0;
const LONG_SIGMAS: f64 = 20.0;
const FIXES: usize = 5;

/// True poses.
#[derive(Debug, Default)]
pub(super) struct True {
    rows: Vec<(u64, [f64; 2], Option<f64>)>,
    world: Option<String>,
}

impl True {
    pub(super) fn take(&mut self, told: &Told) -> Result<Time, ImportError> {
        let (header, pose) = match told.channel.kind.as_str() {
            "geometry_msgs/msg/PoseStamped" => {
                let message: PoseStamped = told.decode()?;
                (message.header, message.pose)
            }
            "nav_msgs/msg/Odometry" => {
                let message: Odometry = told.decode()?;
                (message.header, message.pose.pose)
            }
            _ => {
                let message: PoseWithCovarianceStamped = told.decode()?;
                (message.header, message.pose.pose)
            }
        };
        self.world.get_or_insert_with(|| frame(&header.frame_id).to_owned());
        let place = [told.finite("x", pose.position.x)?, told.finite("y", pose.position.y)?];
        // The identity is written for an unknown orientation.
        let turn = Some(pose.orientation).filter(|turn| *turn != Quaternion::default());
        self.rows.push((0, place, turn.and_then(|turn| turn.unit()).map(|turn| turn.yaw_rad())));
        Ok(header.stamp)
    }

    pub(super) fn at(&mut self, ns: u64) {
        self.rows.iter_mut().last().into_iter().for_each(|(at, ..)| *at = ns);
    }

    /// Keeps some of the messages, by index, in order of time.
    pub(super) fn keep(&mut self, kept: impl Fn(usize) -> bool) {
        let mut place = 0..;
        self.rows.retain(|_| place.next().is_some_and(&kept));
        self.rows.sort_by_key(|(ns, ..)| *ns);
    }

    /// Their frame.
    pub(super) fn world(&self) -> Option<&str> {
        self.world.as_deref()
    }

    /// The rows; if any has a heading, rows without one have the heading 0.
    pub(super) fn rows(&self, seconds: &dyn Fn(u64) -> f64) -> Vec<TruePose> {
        let known = self.rows.iter().any(|(.., turn)| turn.is_some());
        let row = |&(ns, position, turn): &(u64, _, Option<f64>)| TruePose {
            t_s: seconds(ns),
            position,
            heading_rad: known.then(|| turn.unwrap_or(0.0)),
        };
        self.rows.iter().map(row).collect()
    }
}

/// Fixes in the order of the recording.
#[derive(Debug, Default)]
pub(super) struct Fixes {
    found: Vec<Found>,
    /// Numbers of messages of a receiver without a position, and with 0°, 0° instead.
    without: usize,
    at_zero: usize,
    /// The last known height, m.
    altitude: f64,
}

/// A position, m or on the ellipsoid, and its variance, m², if known.
type Place = (Where, Option<f64>);
/// A heading, rad, and its variance, rad², if known.
type Heading = (f64, Option<f64>);

#[derive(Debug, Clone, Copy)]
enum Where {
    Plane([f64; 2]),
    /// Latitude, rad, longitude, rad, height, m.
    Earth([f64; 3]),
}

/// A message: its number and its measurement.
#[derive(Debug)]
struct Found {
    ns: u64,
    number: usize,
    place: Option<Place>,
    heading: Option<Heading>,
}

/// Data of the vehicle to which the frame of fixes is aligned.
pub(super) struct Known<'k> {
    /// Noise of fixes and initial pose, as a head states them.
    pub(super) stated: Option<(FixNoise, [f64; 3])>,
    /// The true position at a time, s.
    pub(super) truth: &'k dyn Fn(f64) -> Option<[f64; 2]>,
    /// Dead reckoning from the stated initial pose, or else from 0: position and distance driven at a time, s.
    pub(super) reckoned: &'k dyn Fn(f64) -> ([f64; 2], f64),
}

#[derive(Debug, Default)]
pub(super) struct OfFixes {
    pub(super) fixes: Vec<Fix>,
    pub(super) noise: FixNoise,
    /// The initial pose in their frame, if dead reckoning determines it.
    pub(super) start: Option<[f64; 3]>,
    pub(super) told: Vec<String>,
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
        self.found.push(Found { ns: 0, number: told.number, place, heading });
        Ok(stamp)
    }

    fn satellite(&mut self, told: &Told, fix: &NavSatFix) -> Result<Option<Place>, ImportError> {
        if fix.status.status < 0 || fix.latitude.is_nan() || fix.longitude.is_nan() {
            self.without += 1;
            return Ok(None);
        }
        if fix.latitude.abs() < ZERO_DEG && fix.longitude.abs() < ZERO_DEG {
            self.at_zero += 1;
            return Ok(None);
        }
        if !(fix.latitude.abs() <= 90.0 && fix.longitude.abs() <= 360.0) {
            let what = format!("latitude {}° and longitude {}° are nowhere on earth", fix.latitude, fix.longitude);
            return Err(told.error(what));
        }
        if fix.altitude.is_finite() {
            self.altitude = fix.altitude;
        }
        let here = [fix.latitude.to_radians(), fix.longitude.to_radians(), self.altitude];
        let variance = 0.5 * (fix.position_covariance[0] + fix.position_covariance[4]);
        let known = fix.position_covariance_type > 0 && variance > 0.0 && variance.is_finite();
        Ok(Some((Where::Earth(here), known.then_some(variance))))
    }

    pub(super) fn at(&mut self, ns: u64) {
        self.found.iter_mut().last().into_iter().for_each(|found| found.ns = ns);
    }

    /// Keeps some of the messages, by index, in order of time.
    pub(super) fn keep(&mut self, kept: impl Fn(usize) -> bool) {
        let mut place = 0..;
        self.found.retain(|_| place.next().is_some_and(&kept));
        self.found.sort_by_key(|found| found.ns);
    }

    pub(super) fn rows(mut self, seconds: &dyn Fn(u64) -> f64, known: &Known) -> Result<OfFixes, String> {
        let mut told = Vec::new();
        if self.without > 0 {
            told.push(format!("{} fixes without a place are left out", self.without));
        }
        if self.at_zero > 0 {
            told.push(format!(
                "{} fixes at 0°, 0° are left out: so receivers say that they do not know where they are",
                self.at_zero
            ));
        }
        self.leave_far(&mut told);
        let origin = self.found.iter().find_map(|found| match found.place {
            Some((Where::Earth(place), _)) => Some(place),
            _ => None,
        });
        let mut fixes = Vec::new();
        for found in &self.found {
            let t_s = seconds(found.ns);
            let place = found.place.map(|(place, _)| match place {
                Where::Plane(place) => place,
                Where::Earth(place) => east_north(origin.unwrap_or(place), place),
            });
            let heading = found.heading.map(|(heading_rad, _)| PoseFix::Heading(heading_rad));
            let measured = place.map(PoseFix::Position).into_iter().chain(heading);
            fixes.extend(measured.map(|measured| Fix { t_s, measured }));
        }
        let stated = known.stated.map(|(noise, _)| noise).unwrap_or_default();
        let places = self.found.iter().filter_map(|found| found.place.map(|(_, variance)| variance));
        let headings = self.found.iter().filter_map(|found| found.heading.map(|(_, variance)| variance));
        let position_sigma_m = sigma("position_sigma_m", places.collect(), stated.position_sigma_m, LEAST[0])?;
        let heading_sigma_rad = sigma("heading_sigma_rad", headings.collect(), stated.heading_sigma_rad, LEAST[1])?;
        let noise = FixNoise { position_sigma_m, heading_sigma_rad, ..stated };
        let mut of = OfFixes { fixes, noise, start: None, told };
        if let Some(origin) = origin {
            let [latitude, longitude, _] = origin;
            of.told.push(format!(
                "the frame of the fixes has x to the east and y to the north of {:.9}°, {:.9}°, the first of them",
                latitude.to_degrees(),
                longitude.to_degrees()
            ));
            of.fit(known);
        }
        Ok(of)
    }

    /// Removes positions that are farther from most others than the vehicle can have driven.
    fn leave_far(&mut self, told: &mut Vec<String>) {
        let earth = |found: &Found| match found.place {
            Some((Where::Earth(place), _)) => Some(place),
            _ => None,
        };
        let places: Vec<[f64; 3]> = self.found.iter().filter_map(earth).collect();
        let [Some(first), Some(last)] = [self.found.first(), self.found.last()] else { return };
        let lasts_s = last.ns.saturating_sub(first.ns) as f64 / 1e9;
        let reach_m = NEAR_M.max(FASTEST_MPS * lasts_s);
        // The median position. A single coordinate may be of an outlier.
        let middle = |of: usize| median(places.iter().map(|place| place[of]).collect());
        let [Some(latitude), Some(longitude), Some(height)] = [0, 1, 2].map(middle) else { return };
        let middle = cartesian([latitude, longitude, height]);
        let apart = |place: [f64; 3]| (0..3).map(|k| (cartesian(place)[k] - middle[k]).powi(2)).sum::<f64>().sqrt();
        let (mut count, mut worst) = (0, None);
        for found in &mut self.found {
            let Some(far_m) = earth(found).map(apart).filter(|far_m| *far_m > reach_m) else { continue };
            found.place = None;
            count += 1;
            worst.get_or_insert((found.number, far_m));
        }
        if let Some((number, far_m)) = worst {
            told.push(format!(
                "{count} fixes are left out that are farther from the others than the vehicle can have come: the first is message {number}, by {:.0} km",
                far_m / 1e3
            ));
        }
    }
}

impl OfFixes {
    /// Aligns the frame of satellite fixes with that of the vehicle.
    fn fit(&mut self, known: &Known) {
        let sigma_m = self.noise.position_sigma_m.unwrap_or(1.0);
        let places: Vec<(f64, [f64; 2])> = self
            .fixes
            .iter()
            .filter_map(|fix| match fix.measured {
                PoseFix::Position(place) => Some((fix.t_s, place)),
                PoseFix::Heading(_) => None,
            })
            .collect();
        if let Some((_, [x, y, _])) = known.stated {
            let Some((t_s, place)) = places.first() else { return };
            let (reckoned, way_m) = (known.reckoned)(*t_s);
            let off_m = (place[0] - reckoned[0]).hypot(place[1] - reckoned[1]);
            if off_m > FAR_SIGMAS * sigma_m + FAR_SHARE * way_m {
                self.told.push(format!(
                    "warning: by odometry, from the initial pose at {x:.2} m, {y:.2} m, the vehicle is {off_m:.2} m beside the first fix: the initial pose has to be in the frame of the fixes"
                ));
            }
            return;
        }
        let beside: Vec<[[f64; 2]; 2]> =
            places.iter().filter_map(|(t_s, place)| Some([*place, (known.truth)(*t_s)?])).collect();
        if !beside.is_empty() {
            self.fit_truth(&beside, sigma_m);
            return;
        }
        // The beginning of the trajectory: long enough to determine its direction, short enough for little drift of the odometry.
        let least_m = LONG_M.max(LONG_SIGMAS * sigma_m);
        let mut begin = Vec::new();
        let mut long_m = 0.0;
        for (t_s, place) in &places {
            let (reckoned, way_m) = (known.reckoned)(*t_s);
            begin.push([reckoned, *place]);
            long_m = way_m;
            let far = |pair: &[[f64; 2]; 2]| (pair[0][0] - reckoned[0]).hypot(pair[0][1] - reckoned[1]) > least_m;
            if begin.len() >= FIXES && begin.iter().any(far) {
                let laid = Laid::of(&begin);
                if laid.residual(&begin) <= NEAR_SIGMAS * sigma_m + WAY_SHARE * long_m {
                    let [x, y] = laid.place([0.0; 2]);
                    self.start = Some([x, y, laid.turn_rad]);
                    self.told.push(format!(
                        "the vehicle starts at {x:.2} m, {y:.2} m and {:.3} rad: there its way by odometry lies on the first {} fixes",
                        laid.turn_rad,
                        begin.len()
                    ));
                    return;
                }
                break;
            }
        }
        self.told.push(format!(
            "warning: where the vehicle starts in the frame of the fixes, and in which direction, is not known ({long_m:.1} m of odometry do not tell it): say initial_pose in log.toml"
        ));
    }

    fn fit_truth(&mut self, beside: &[[[f64; 2]; 2]], sigma_m: f64) {
        let shift = Laid::shift(beside);
        let (with_turn, enough) = (Laid::of(beside), NEAR_SIGMAS * sigma_m);
        let (laid, turned) = match [shift, with_turn].map(|laid| laid.residual(beside) <= enough) {
            [true, _] => (shift, String::new()),
            [_, true] => (with_turn, format!("turned by {:.4} rad and ", with_turn.turn_rad)),
            _ => {
                self.told.push(format!(
                    "warning: fixes and true positions do not fit together: laid on each other they are {:.2} m apart in the median",
                    with_turn.residual(beside)
                ));
                return;
            }
        };
        for fix in &mut self.fixes {
            fix.measured = match fix.measured {
                PoseFix::Position(place) => PoseFix::Position(laid.place(place)),
                PoseFix::Heading(heading_rad) => PoseFix::Heading(wrap(heading_rad + laid.turn_rad)),
            };
        }
        let [x, y] = laid.place([0.0; 2]);
        self.told.push(format!(
            "the fixes are {turned}shifted by {x:.2} m, {y:.2} m: so they lie on the true positions, whose frame counts"
        ));
    }
}

/// An alignment: a rotation, rad, and a shift, m.
#[derive(Debug, Clone, Copy)]
struct Laid {
    turn_rad: f64,
    shift: [f64; 2],
}

impl Laid {
    /// Aligns the first positions of the pairs with the second ones, by least squares.
    fn of(pairs: &[[[f64; 2]; 2]]) -> Self {
        let mean = |of: usize, k: usize| pairs.iter().map(|pair| pair[of][k]).sum::<f64>() / pairs.len() as f64;
        let (from, to) = ([mean(0, 0), mean(0, 1)], [mean(1, 0), mean(1, 1)]);
        let (mut along, mut across) = (0.0, 0.0);
        for [a, b] in pairs {
            let (a, b) = ([a[0] - from[0], a[1] - from[1]], [b[0] - to[0], b[1] - to[1]]);
            along += a[0] * b[0] + a[1] * b[1];
            across += a[0] * b[1] - a[1] * b[0];
        }
        let turned = Self { turn_rad: across.atan2(along), shift: [0.0; 2] };
        let [x, y] = turned.place(from);
        Self { shift: [to[0] - x, to[1] - y], ..turned }
    }

    /// A shift without rotation, by medians.
    fn shift(pairs: &[[[f64; 2]; 2]]) -> Self {
        let shift = [0, 1].map(|k| median(pairs.iter().map(|[a, b]| b[k] - a[k]).collect()).unwrap_or(0.0));
        Self { turn_rad: 0.0, shift }
    }

    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (s, c) = self.turn_rad.sin_cos();
        [c * x - s * y + self.shift[0], s * x + c * y + self.shift[1]]
    }

    fn residual(&self, pairs: &[[[f64; 2]; 2]]) -> f64 {
        let apart = pairs.iter().map(|[a, b]| {
            let [x, y] = self.place(*a);
            (x - b[0]).hypot(y - b[1])
        });
        median(apart.collect()).unwrap_or(f64::INFINITY)
    }
}

fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

/// The measurements of a pose with covariance: quantities with a variance below [`UNKNOWN`]; 0 means that the variance is not
/// known.
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
        place = Some((Where::Plane(at), variance(of_place)));
    }
    if covariance[5][5] < UNKNOWN {
        let turn = pose.orientation.unit().ok_or_else(|| told.error("the turn is no quaternion"))?;
        heading = Some((turn.yaw_rad(), variance(covariance[5][5])));
    }
    Ok((place, heading))
}

/// The stated standard deviation, or else that of the median variance of the messages.
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
pub fn east_north(origin: [f64; 3], place: [f64; 3]) -> [f64; 2] {
    let (from, to) = (cartesian(origin), cartesian(place));
    let [x, y, z] = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    let ((sl, cl), (so, co)) = (origin[0].sin_cos(), origin[1].sin_cos());
    [co * y - so * x, cl * z - sl * (co * x + so * y)]
}

/// Position relative to the centre of the earth, m.
fn cartesian([latitude, longitude, height]: [f64; 3]) -> [f64; 3] {
    let square = FLATTENING * (2.0 - FLATTENING);
    let across = AXIS_M / (1.0 - square * latitude.sin().powi(2)).sqrt();
    let level = (across + height) * latitude.cos();
    [level * longitude.cos(), level * longitude.sin(), (across * (1.0 - square) + height) * latitude.sin()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_degrees_agree_with_tables() {
        // Snyder, Map Projections (USGS 1395), table 6, of its ellipsoids to 5 digits: a degree of latitude is 110.574 km at the
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
    fn sigma_is_from_the_median_variance_and_an_unknown_one_is_an_error() {
        assert_eq!(sigma("s", vec![Some(4.0), None, Some(9.0), Some(1.0)], None, 1e-3), Ok(Some(2.0)));
        assert_eq!(sigma("s", vec![Some(1e-12)], None, 1e-3), Ok(Some(1e-3)));
        assert_eq!(sigma("s", vec![None], Some(0.5), 1e-3), Ok(Some(0.5)));
        assert_eq!(sigma("s", vec![], None, 1e-3), Ok(None));
        assert!(sigma("position_sigma_m", vec![None], None, 1e-3).unwrap_err().contains("position_sigma_m"));
    }
}
