//! Detections that stand still in the view of a sensor while the vehicle moves: parts of the vehicle, or another vehicle ahead of
//! it.
//!
//! A detection is judged if the odometry moves it far from its place in the view. If a later scan has a detection at the old
//! place, and none at the predicted one, it stood still in the view.

use super::finding::{Findings, percent, quantile, short};
use super::reading::AS_WRITTEN;
use super::sight::Sight;
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Sensor};

/// Least number of pairs of scans.
const PAIRS: usize = 40;
/// Least share of scans with such a detection; fewer do not disturb a filter.
const SHARE: f64 = 0.1;
/// A place is fixed to the vehicle if detections stand still there this many times as often as elsewhere at the same range
/// (chance),
const TIMES: f64 = 5.0;
/// in at least this number of quarters of the log,
const QUARTERS: usize = 3;
/// and beside the place only for less than this share. Parts of the vehicle scatter by noise only, a vehicle ahead scatters more.
const BESIDE: f64 = 0.3;
/// Radius of the ring beside the place, in gates.
const RING: f64 = 2.5;
/// Greatest number of places of a sensor.
const PLACES: usize = 8;
/// A zone has these quantiles of the detections as its edges, extended on each side by half of its width, or at least by this
/// number of standard deviations.
const EDGE: f64 = 0.02;
const MARGIN_SIGMAS: f64 = 1.0;
/// A vehicle ahead is in view in at least this share of the scans, within this angle, rad, and this share of its range,
const ALONG: f64 = 0.25;
const ALONG_RAD: f64 = 0.4;
const ALONG_RANGE: f64 = 0.35;
/// and stands still at least this many times as often as by chance.
const ALONG_TIMES: f64 = 3.0;

/// A detection that stood still in the view, and the index of the pair of scans.
#[derive(Debug, Clone, Copy)]
struct Along {
    pair: usize,
    seen: [f64; 2],
}

/// A part of the view of a sensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Zone {
    range_m: [f64; 2],
    bearing_rad: [f64; 2],
}

impl Zone {
    fn holds(&self, [range_m, bearing_rad]: [f64; 2]) -> bool {
        let middle = 0.5 * (self.bearing_rad[0] + self.bearing_rad[1]);
        (self.range_m[0]..=self.range_m[1]).contains(&range_m)
            && wrap(bearing_rad - middle).abs() <= 0.5 * (self.bearing_rad[1] - self.bearing_rad[0])
    }
}

/// The code of the finding for parts of the vehicle.
pub(super) const CODE: &str = "fixed-in-view";

/// Zones of the view of each sensor.
pub(super) type Zones = Vec<Vec<Zone>>;

/// Removes detections in these zones from the scans. Returns their number.
pub(super) fn leave_out(log: &mut Log, zones: &[Vec<Zone>]) -> usize {
    let mut left_out = 0;
    for scan in &mut log.scans {
        let Some(zones) = zones.get(scan.sensor).filter(|zones| !zones.is_empty()) else { continue };
        let kept: Vec<bool> = scan.detections.iter().map(|one| !zones.iter().any(|zone| zone.holds(*one))).collect();
        left_out += kept.iter().filter(|kept| !**kept).count();
        let mut keep = kept.iter();
        scan.detections.retain(|_| keep.next().is_none_or(|kept| *kept));
        let mut keep = kept.iter();
        scan.labels.retain(|_| keep.next().is_none_or(|kept| *kept));
    }
    left_out
}

/// Reports parts of the vehicle and removes them from the scans, so that the rest can be judged. Returns their zones, and the
/// findings about other vehicles, which do not hold if the odometry is wrong.
pub(super) fn look_over(
    log: &mut Log,
    poses: &[[f64; 3]],
    pairs: &[[usize; 2]],
    findings: &mut Findings,
) -> (Zones, Findings) {
    let mut others = Findings::default();
    let mut all = Zones::new();
    let sensors: Vec<(String, Sensor)> = log.sensors().map(|(name, sensor, _)| (name.to_owned(), *sensor)).collect();
    for (sensor, (name, view)) in sensors.iter().enumerate() {
        let of_sensor: Vec<[usize; 2]> =
            pairs.iter().filter(|[from, _]| log.scans[*from].sensor == sensor).copied().collect();
        all.push(Vec::new());
        if of_sensor.len() < PAIRS {
            continue;
        }
        let section = if name.is_empty() { "sensor".to_owned() } else { format!("sensors, {name}") };
        let mut along = come_along(log, poses, &of_sensor);
        let sight = Sight::of(log, &AS_WRITTEN);
        let mut zones = Vec::new();
        while zones.len() < PLACES {
            let Some((place, share)) = place(&sight, view, &along, of_sensor.len(), sensor) else { break };
            let zone = zone(&sight, &along, place, sensor);
            zones.push((zone, share));
            along.retain(|one| !zone.holds(one.seen));
        }
        all[sensor] = zones.iter().map(|(zone, _)| *zone).collect();
        leave_out(log, &all);
        if !zones.is_empty() {
            tell_fixed(&section, name, &zones, findings);
        }
        tell_along(log, poses, &of_sensor, &along, &mut others);
    }
    (all, others)
}

/// Detections that are seen again at the same place in the view, and not where odometry predicts them.
fn come_along(log: &Log, poses: &[[f64; 3]], pairs: &[[usize; 2]]) -> Vec<Along> {
    let sight = Sight::of(log, &AS_WRITTEN);
    let mut along = Vec::new();
    for (pair, &[from, to]) in pairs.iter().enumerate() {
        let sensor = log.scans[from].sensor;
        for &seen in &log.scans[from].detections {
            let carried = sight.carried(sensor, [poses[from], poses[to]], seen);
            let tells = carried.is_none_or(|carried| sight.are_apart(sensor, seen, carried));
            let stays = tells && sight.meets(&log.scans[to], seen);
            if stays && !carried.is_some_and(|one| sight.meets(&log.scans[to], one)) {
                along.push(Along { pair, seen });
            }
        }
    }
    along
}

/// The place with most such detections and its share of the scans; `None` unless it is fixed to the vehicle.
fn place(sight: &Sight<'_>, view: &Sensor, along: &[Along], pairs: usize, sensor: usize) -> Option<([f64; 2], f64)> {
    let near = |place: [f64; 2]| along.iter().filter(move |one| sight.are_near(sensor, one.seen, place));
    let step = along.len().div_ceil(1000).max(1);
    let first = along.iter().step_by(step).map(|one| one.seen).max_by_key(|place| near(*place).count())?;
    let middle = |place: [f64; 2]| {
        let coordinate = |k: usize| quantile(near(place).map(|one| wrap_near(one.seen, place)[k]).collect(), 0.5);
        Some([coordinate(0)?, wrap(coordinate(1)?)])
    };
    let place = middle(first)?;
    let pairs_of = |place: [f64; 2]| {
        let mut of: Vec<usize> = near(place).map(|one| one.pair).collect();
        of.dedup();
        of
    };
    let here = pairs_of(place);
    let share = here.len() as f64 / pairs as f64;
    let elsewhere = (1..16).filter_map(|k| {
        let other = [place[0], wrap(place[1] + f64::from(k) * std::f64::consts::PI / 8.0)];
        view.sees(other[0], other[1]).then(|| pairs_of(other).len() as f64)
    });
    let chance = quantile(elsewhere.collect(), 0.5).unwrap_or(0.0);
    let quarters = (0..4).filter(|quarter| here.iter().any(|pair| pair * 4 / pairs == *quarter)).count();
    let beside = along
        .iter()
        .filter(|one| !sight.are_near(sensor, one.seen, place) && sight.are_within(sensor, one.seen, place, RING))
        .count() as f64
        - chance * (RING * RING - 1.0);
    let is_fixed = share > SHARE
        && here.len() as f64 > TIMES * chance
        && quarters >= QUARTERS
        && beside < BESIDE * here.len() as f64;
    is_fixed.then_some((place, share))
}

/// Range and bearing, with the bearing wrapped near that of the place.
fn wrap_near([range_m, bearing_rad]: [f64; 2], place: [f64; 2]) -> [f64; 2] {
    [range_m, place[1] + wrap(bearing_rad - place[1])]
}

/// The zone around nearly all such detections at the place, with a margin for noise.
fn zone(sight: &Sight<'_>, along: &[Along], place: [f64; 2], sensor: usize) -> Zone {
    let members = || along.iter().map(|one| one.seen).filter(|seen| sight.are_near(sensor, *seen, place));
    let edges = |k: usize| {
        let of = |share| quantile(members().map(|one| wrap_near(one, place)[k]).collect(), share).unwrap_or(place[k]);
        let [least, most] = [of(EDGE), of(1.0 - EDGE)];
        let margin = (0.5 * (most - least)).max(MARGIN_SIGMAS * sight.sigmas(sensor, place[0])[k]);
        [least - margin, most + margin]
    };
    let [range_m, bearing_rad] = [edges(0), edges(1)];
    Zone { range_m: range_m.map(|edge_m| edge_m.max(0.0)), bearing_rad }
}

fn tell_fixed(section: &str, name: &str, zones: &[(Zone, f64)], findings: &mut Findings) {
    let places: Vec<String> = zones
        .iter()
        .map(|(Zone { range_m, bearing_rad }, share)| {
            let middle = |[least, most]: [f64; 2]| short(0.5 * (least + most));
            format!(
                "range {} m, bearing {} rad, {} of the scans",
                middle(*range_m),
                middle(*bearing_rad),
                percent(*share)
            )
        })
        .collect();
    let key = if name.is_empty() { "sensor.exclude" } else { "sensors.exclude" };
    let sections: Vec<String> = zones
        .iter()
        .map(|(Zone { range_m, bearing_rad }, _)| {
            format!(
                "[[{key}]] range_min_m = {:.3}, range_max_m = {:.3}, bearing_min_rad = {:.4}, bearing_max_rad = {:.4}",
                range_m[0], range_m[1], bearing_rad[0], bearing_rad[1]
            )
        })
        .collect();
    findings.warn(
        CODE,
        &format!("log.toml, section {section}"),
        format!("while the vehicle moves, this stands still in the view: {}", places.join("; ")),
        format!(
            "if the sensor sees its own vehicle there, leave that out (one key a line in log.toml{}): {}",
            if name.is_empty() { "" } else { ", below the section of this sensor" },
            sections.join("; ")
        ),
    );
}

/// Reports another vehicle ahead.
fn tell_along(log: &Log, poses: &[[f64; 3]], pairs: &[[usize; 2]], along: &[Along], findings: &mut Findings) {
    let is_around = |one: &Along, [range_m, bearing_rad]: [f64; 2]| {
        (one.seen[0] - range_m).abs() < ALONG_RANGE * range_m && wrap(one.seen[1] - bearing_rad).abs() < ALONG_RAD
    };
    let pairs_of = |along: &[Along], place: [f64; 2]| {
        let mut of: Vec<usize> = along.iter().filter(|one| is_around(one, place)).map(|one| one.pair).collect();
        of.dedup();
        of.len()
    };
    let step = along.len().div_ceil(300).max(1);
    let places = along.iter().step_by(step).map(|one| one.seen);
    let Some((place, count)) = places.map(|place| (place, pairs_of(along, place))).max_by_key(|one| one.1) else {
        return;
    };
    let share = count as f64 / pairs.len() as f64;
    if share < ALONG {
        return;
    }
    // By chance, detections of unrelated scans match equally often.
    let shuffled: Vec<[usize; 2]> =
        (0..pairs.len()).map(|k| [pairs[k][0], pairs[(k + pairs.len() / 2) % pairs.len()][1]]).collect();
    let by_chance = pairs_of(&come_along(log, poses, &shuffled), place);
    if count as f64 > ALONG_TIMES * by_chance as f64 {
        findings.warn(
            "moves-along",
            "detections.csv",
            format!(
                "something moves along with the vehicle, around {} m and {} rad, in {} of the scans: another vehicle, or what this one carries",
                short(place[0]),
                short(place[1]),
                percent(share)
            ),
            "a joint map tracks it, a mixture with --moving on; or take its detections out",
        );
    }
}
