//! `log.toml`.

use super::error::{Faults, LogError, NAME_CHARS, Place, Problem, SENSOR_NAME_CHARS};
use super::table::text;
use super::units::{self, WHOLE_TURN_RAD};
use crate::log::{FixNoise, Mounting, NamedSensor, Nominal, Sensor, Vehicle};
use std::borrow::Cow;
use std::path::Path;
use toml::{Table, Value};

/// Contents of `log.toml`.
pub(super) struct Head {
    pub(super) name: String,
    pub(super) simulated: bool,
    pub(super) initial_pose: [f64; 3],
    /// 0 if it is not stated.
    pub(super) truth_sigma_m: f64,
    pub(super) vehicle: Vehicle,
    /// In order of their names; an only one in `[sensor]` has no name.
    pub(super) sensors: Vec<NamedSensor>,
    /// For each of them the detections that are left out.
    pub(super) dropped: Vec<Dropped>,
    /// `None` without `[fixes]`.
    pub(super) fix_noise: Option<FixNoise>,
}

/// Detections of a sensor that are left out when a folder is read.
#[derive(Debug, Clone, Default)]
pub(super) struct Dropped {
    /// The range that means "no return", m.
    no_return_m: Option<f64>,
    /// Parts of the view in which the sensor sees its own vehicle.
    zones: Vec<Sensor>,
}

impl Dropped {
    /// Whether this detection is left out.
    pub(super) fn holds(&self, [range_m, bearing_rad]: [f64; 2]) -> bool {
        // Numbers converted to single precision have seven digits.
        let is_none = |none_m: f64| (range_m - none_m).abs() <= 1e-6 * none_m.abs();
        self.no_return_m.is_some_and(is_none) || self.zones.iter().any(|zone| zone.sees(range_m, bearing_rad))
    }

    fn is_empty(&self) -> bool {
        self.no_return_m.is_none() && self.zones.is_empty()
    }
}

/// Names of a vehicle's control columns in `odometry.csv`: those of the first two controls, and of the third if there is one.
pub(super) fn control_columns(vehicle: &Vehicle) -> ([&'static str; 2], Option<&'static str>) {
    match vehicle {
        Vehicle::Ackermann { .. } => (["speed_mps", "steering_rad"], None),
        Vehicle::Unicycle | Vehicle::UnicycleArc => (["v_mps", "omega_radps"], None),
        Vehicle::Holonomic => (["vx_mps", "omega_radps"], Some("vy_mps")),
    }
}

/// A section of the file; errors carry its name.
pub(super) struct Section<'a> {
    pub(super) name: Cow<'static, str>,
    pub(super) table: &'a Table,
}

impl Head {
    pub(super) fn read(dir: &Path) -> Result<Self, Vec<LogError>> {
        let file = "log.toml";
        let missing = || Place::File(file).error(Problem::Missing);
        let text = text(dir, file).and_then(|text| text.ok_or_else(missing)).map_err(|error| vec![error])?;
        Self::of(&text)
    }

    /// The contents of a text, or all its errors.
    pub(super) fn of(text: &str) -> Result<Self, Vec<LogError>> {
        let table: Table = text.parse().map_err(|error| vec![syntax(text, &error)])?;
        let mut faults = Faults::default();
        Self::of_table(&table, &mut faults).filter(|_| faults.0.is_empty()).ok_or(faults.0)
    }

    fn of_table(table: &Table, faults: &mut Faults) -> Option<Self> {
        let top = Section { name: "".into(), table };
        // The sensor is checked first: logs of other sensors lack other keys as well, which need not be reported.
        let several = table.contains_key("sensors");
        if table.contains_key("camera") && !table.contains_key("sensor") && !several {
            let found = String::from("camera");
            let problem = Problem::Unsupported { found, supported: SENSORS };
            return faults.take(Err(top.key("camera").error(problem)));
        }
        let sections =
            if several { top.sensors() } else { top.section("sensor").map(|one| vec![(String::new(), one)]) };
        let sections = faults.take(sections)?;
        let vehicle = faults.take(top.section("vehicle"))?;
        let vehicle_model = faults.take(self::vehicle(&vehicle));
        let mut sensors = Vec::new();
        for (name, section) in &sections {
            let mounting = match &vehicle_model {
                Some(_) if several => faults.take(section.mounting("")),
                Some(model) => faults.take(mounting(&vehicle, model)),
                None => None,
            };
            let sensor = faults.take(sensor(section)).zip(mounting);
            let dropped = faults.take(section.dropped());
            // Sections of unknown models have other keys, which need not be reported.
            let is_known = sensor.is_some();
            let nominal = if is_known { faults.take(section.nominal(&vehicle)) } else { None };
            if is_known {
                faults.take(section.has_only(if several { MOUNTED_SENSOR_KEYS } else { SENSOR_KEYS }));
            }
            if let (Some((mut sensor, mounting)), Some(dropped), Some(nominal)) = (sensor, dropped, nominal) {
                sensor.mounting = mounting;
                dropped.zones.iter().for_each(|zone| narrow(&mut sensor, zone));
                sensors.push((NamedSensor { name: name.clone(), sensor, nominal }, dropped));
            }
        }
        faults.take(top.has_only(&TOP_KEYS));
        if let Some(model) = &vehicle_model {
            faults.take(check_vehicle_keys(&vehicle, model, several));
        }
        let initial_pose = faults.take(top.pose("initial_pose"));
        if let Some(pose) = initial_pose {
            faults.take(units::radians(pose[2], WHOLE_TURN_RAD, || top.key("initial_pose")));
        }
        let truth_sigma_m = faults.take(top.sigma("truth_sigma_m"));
        let (name, simulated) = (faults.take(name(&top)), faults.take(simulated(&top)));
        let fix_noise = if table.contains_key("fixes") {
            faults.take(top.section("fixes").and_then(|section| section.fix_noise())).map(Some)
        } else {
            Some(None)
        };
        sensors.sort_by(|a, b| a.0.name.cmp(&b.0.name));
        let (sensors, dropped) = sensors.into_iter().unzip();
        Some(Self {
            name: name?,
            simulated: simulated?,
            initial_pose: initial_pose?,
            truth_sigma_m: truth_sigma_m?.unwrap_or(0.0),
            vehicle: vehicle_model?,
            sensors,
            dropped,
            fix_noise: fix_noise?,
        })
    }

    /// A key that is used only when a folder is read with its detections.
    pub(super) fn key_of_folders(&self) -> Option<Place> {
        let of = self.sensors.iter().zip(&self.dropped).find(|(_, dropped)| !dropped.is_empty());
        of.map(|(sensor, dropped)| {
            let section = if sensor.name.is_empty() { "sensor".into() } else { format!("sensors.{}", sensor.name) };
            Place::Key(format!("{section}.{}", if dropped.zones.is_empty() { "no_return_m" } else { "exclude" }))
        })
    }

    pub(super) fn control_columns(&self) -> ([&'static str; 2], Option<&'static str>) {
        control_columns(&self.vehicle)
    }
}

/// Keys of an only sensor, whose mounting is in the section of the vehicle.
const SENSOR_KEYS: &[&str] = MOUNTED_SENSOR_KEYS.split_at(12).0;
/// Keys of one of several sensors.
const MOUNTED_SENSOR_KEYS: &[&str] = &[
    "model", "range_min_m", "range_max_m", "bearing_min_rad", "bearing_max_rad", "range_sigma_m", "range_sigma_ratio",
    "bearing_sigma_rad", "detection_probability", "clutter_per_scan", "no_return_m", "exclude", "name", "forward_m",
    "left_m", "yaw_rad",
];
/// Keys of a zone that is left out.
const ZONE_KEYS: [&str; 4] = ["range_min_m", "range_max_m", "bearing_min_rad", "bearing_max_rad"];
const FIX_KEYS: [&str; 6] = ["position_sigma_m", "heading_sigma_rad", "gate", "patience_s", "forward_m", "left_m"];
const ACKERMANN_KEYS: [&str; 8] = [
    "model", "wheelbase_m", "encoder_offset_m", "sensor_forward_m", "sensor_left_m", "sensor_yaw_rad",
    "speed_sigma_mps", "steering_sigma_rad",
];
const UNICYCLE_KEYS: [&str; 6] =
    ["model", "sensor_forward_m", "sensor_left_m", "sensor_yaw_rad", "speed_sigma_mps", "rate_sigma_radps"];
/// The same if `[[sensors]]` have their mountings; the point of an Ackermann vehicle's pose is given by these keys.
const BARE_ACKERMANN_KEYS: [&str; 7] = [
    "model", "wheelbase_m", "encoder_offset_m", "sensor_forward_m", "sensor_left_m", "speed_sigma_mps",
    "steering_sigma_rad",
];
const BARE_UNICYCLE_KEYS: [&str; 3] = ["model", "speed_sigma_mps", "rate_sigma_radps"];
const TOP_KEYS: [&str; 12] = [
    "name", "kind", "simulated", "source", "note", "initial_pose", "truth", "truth_sigma_m", "vehicle", "sensor",
    "sensors", "fixes",
];
const SENSORS: &str = "range_bearing";
const VEHICLES: &str = "ackermann, unicycle, unicycle_arc and holonomic";

fn sensor(section: &Section) -> Result<Sensor, LogError> {
    let model = section.string("model")?;
    if model != "range_bearing" {
        let found = model.to_owned();
        return Err(section.key("model").error(Problem::Unsupported { found, supported: SENSORS }));
    }
    let range_min_m = section.sigma("range_min_m")?.unwrap_or(0.0);
    let sensor = Sensor {
        range_min_m,
        range_max_m: section.number("range_max_m")?,
        bearing_min_rad: section.number("bearing_min_rad")?,
        bearing_max_rad: section.number("bearing_max_rad")?,
        mounting: Mounting::NONE,
    };
    section.check("range_max_m", sensor.range_max_m, "more than the least range", |r| r > range_min_m)?;
    section.check("range_max_m", sensor.range_max_m, "at most 1e6 m", |r| r <= 1e6)?;
    for (key, bearing) in [("bearing_min_rad", sensor.bearing_min_rad), ("bearing_max_rad", sensor.bearing_max_rad)] {
        units::radians(bearing, WHOLE_TURN_RAD, || section.key(key))?;
    }
    section.check("bearing_max_rad", sensor.bearing_max_rad, "more than bearing_min_rad", |b| {
        b > sensor.bearing_min_rad
    })?;
    Ok(sensor)
}

/// Removes a zone from the view if the rest is a view as well: all bearings at the nearest or farthest ranges, or all ranges at
/// an edge.
fn narrow(sensor: &mut Sensor, zone: &Sensor) {
    let all_ranges = zone.range_min_m <= sensor.range_min_m && zone.range_max_m >= sensor.range_max_m;
    let all_bearings = zone.bearing_min_rad <= sensor.bearing_min_rad && zone.bearing_max_rad >= sensor.bearing_max_rad;
    let within = |at: f64, [least, most]: [f64; 2]| at > least && at < most;
    let ranges = [sensor.range_min_m, sensor.range_max_m];
    let bearings = [sensor.bearing_min_rad, sensor.bearing_max_rad];
    if all_bearings && zone.range_min_m <= ranges[0] && within(zone.range_max_m, ranges) {
        sensor.range_min_m = zone.range_max_m;
    } else if all_bearings && zone.range_max_m >= ranges[1] && within(zone.range_min_m, ranges) {
        sensor.range_max_m = zone.range_min_m;
    } else if all_ranges && zone.bearing_min_rad <= bearings[0] && within(zone.bearing_max_rad, bearings) {
        sensor.bearing_min_rad = zone.bearing_max_rad;
    } else if all_ranges && zone.bearing_max_rad >= bearings[1] && within(zone.bearing_min_rad, bearings) {
        sensor.bearing_max_rad = zone.bearing_min_rad;
    }
}

fn vehicle(section: &Section) -> Result<Vehicle, LogError> {
    match section.string("model")? {
        "ackermann" => {
            let wheelbase_m = section.number("wheelbase_m")?;
            section.check("wheelbase_m", wheelbase_m, "more than 0", |l| l > 0.0)?;
            Ok(Vehicle::Ackermann {
                wheelbase_m,
                encoder_offset_m: section.number("encoder_offset_m")?,
                sensor_forward_m: section.number("sensor_forward_m")?,
                sensor_left_m: section.number("sensor_left_m")?,
            })
        }
        "unicycle" => Ok(Vehicle::Unicycle),
        "unicycle_arc" => Ok(Vehicle::UnicycleArc),
        "holonomic" => Ok(Vehicle::Holonomic),
        other => {
            let found = other.to_owned();
            Err(section.key("model").error(Problem::Unsupported { found, supported: VEHICLES }))
        }
    }
}

/// Mounting of the sensor: an Ackermann vehicle's pose is that of the sensor, so that only its angle is used here; for other
/// vehicles it is relative to the centre of rotation.
fn mounting(section: &Section, vehicle: &Vehicle) -> Result<Mounting, LogError> {
    let at_sensor = section.mounting("sensor_")?;
    match vehicle {
        Vehicle::Ackermann { .. } => Ok(Mounting { yaw_rad: at_sensor.yaw_rad, ..Mounting::NONE }),
        Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => Ok(at_sensor),
    }
}

/// Checks for keys without effect in the vehicle's model.
fn check_vehicle_keys(section: &Section, vehicle: &Vehicle, several: bool) -> Result<(), LogError> {
    let (model, known): (_, &'static [&'static str]) = match vehicle {
        Vehicle::Ackermann { .. } if several => ("ackermann", &BARE_ACKERMANN_KEYS),
        Vehicle::Unicycle if several => ("unicycle", &BARE_UNICYCLE_KEYS),
        Vehicle::UnicycleArc if several => ("unicycle_arc", &BARE_UNICYCLE_KEYS),
        Vehicle::Holonomic if several => ("holonomic", &BARE_UNICYCLE_KEYS),
        Vehicle::Ackermann { .. } => ("ackermann", &ACKERMANN_KEYS),
        Vehicle::Unicycle => ("unicycle", &UNICYCLE_KEYS),
        Vehicle::UnicycleArc => ("unicycle_arc", &UNICYCLE_KEYS),
        Vehicle::Holonomic => ("holonomic", &UNICYCLE_KEYS),
    };
    let Some(key) = section.stranger(known) else { return Ok(()) };
    let of_another = ACKERMANN_KEYS.contains(&key) || UNICYCLE_KEYS.contains(&key);
    let problem = if of_another { Problem::Unused { model, known } } else { Problem::Unknown { known } };
    Err(section.key(key).error(problem))
}

/// The name. It is used in plots and in lines of text.
pub(super) fn name(top: &Section) -> Result<String, LogError> {
    let name = top.string("name")?;
    // Two characters that are not valid in XML are not control characters.
    let good = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    if !name.is_empty() && name.chars().count() <= NAME_CHARS && name.chars().all(good) {
        Ok(name.to_owned())
    } else {
        Err(top.key("name").error(Problem::Name))
    }
}

/// Whether the log is simulated: `simulated` or, in logs without this key, the first word of `kind`. Without either it is real.
pub(super) fn simulated(top: &Section) -> Result<bool, LogError> {
    for text in ["kind", "source", "note", "truth"] {
        if top.table.contains_key(text) {
            top.string(text)?;
        }
    }
    if top.table.contains_key("simulated") {
        return top.boolean("simulated");
    }
    let Some(kind) = top.table.get("kind").and_then(Value::as_str) else { return Ok(false) };
    match kind.split(|c: char| !c.is_alphanumeric()).next() {
        Some("simulated") => Ok(true),
        Some("real") => Ok(false),
        _ => Err(top.key("kind").error(Problem::Kind(kind.to_owned()))),
    }
}

pub(super) fn syntax(text: &str, error: &toml::de::Error) -> LogError {
    let what = Problem::Syntax(error.message().split_whitespace().collect::<Vec<_>>().join(" "));
    match error.span().and_then(|span| text.get(..span.start)) {
        Some(before) => Place::Row("log.toml", 1 + before.matches('\n').count() as u64).error(what),
        None => Place::File("log.toml").error(what),
    }
}

impl<'a> Section<'a> {
    pub(super) fn key(&self, key: &str) -> Place {
        Place::Key(if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) })
    }

    pub(super) fn get(&self, key: &str) -> Result<&'a Value, LogError> {
        self.table.get(key).ok_or_else(|| self.key(key).error(Problem::Missing))
    }

    pub(super) fn ill_typed(&self, key: &str, value: &Value, expected: &'static str) -> LogError {
        self.key(key).error(Problem::Type { found: value.to_string(), expected })
    }

    pub(super) fn section(&self, name: &'static str) -> Result<Section<'a>, LogError> {
        let value = self.get(name)?;
        let table = value.as_table().ok_or_else(|| self.ill_typed(name, value, "a section"))?;
        Ok(Section { name: name.into(), table })
    }

    fn sensors(&self) -> Result<Vec<(String, Section<'a>)>, LogError> {
        if self.table.contains_key("sensor") {
            return Err(self.key("sensor").error(Problem::SensorAndSensors));
        }
        let value = self.get("sensors")?;
        let list = value.as_array().filter(|list| !list.is_empty());
        let list = list.ok_or_else(|| self.ill_typed("sensors", value, "a list of sections [[sensors]]"))?;
        let mut found: Vec<(String, Section<'a>)> = Vec::new();
        for (place, value) in list.iter().enumerate() {
            let unnamed = format!("sensors[{}]", place + 1);
            let table = value.as_table().ok_or_else(|| self.ill_typed(&unnamed, value, "a section"))?;
            let section = Section { name: unnamed.into(), table };
            let name = section.string("name")?;
            // The characters of an unquoted key in a settings file.
            let good = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
            if name.is_empty() || name.len() > SENSOR_NAME_CHARS || !name.chars().all(good) {
                return Err(section.key("name").error(Problem::SensorName));
            }
            if found.iter().any(|(other, _)| other == name) {
                return Err(section.key("name").error(Problem::SensorTwice(name.to_owned())));
            }
            found.push((name.to_owned(), Section { name: format!("sensors.{name}").into(), table }));
        }
        Ok(found)
    }

    /// The mounting of a sensor; values that are not stated are 0.
    fn mounting(&self, prefix: &str) -> Result<Mounting, LogError> {
        let offset = |key: &str| {
            Ok(self.limited(&format!("{prefix}{key}"), "-1000 to 1000 m", |m| m.abs() <= 1e3)?.unwrap_or(0.0))
        };
        let yaw = format!("{prefix}yaw_rad");
        let yaw_rad = self.limited(&yaw, "a finite angle", |_| true)?.unwrap_or(0.0);
        units::radians(yaw_rad, WHOLE_TURN_RAD, || self.key(&yaw))?;
        Ok(Mounting { forward_m: offset("forward_m")?, left_m: offset("left_m")?, yaw_rad })
    }

    /// `no_return_m` and `[[sensor.exclude]]`.
    fn dropped(&self) -> Result<Dropped, LogError> {
        let no_return_m = self.limited("no_return_m", "a number of metres", |_| true)?;
        let Some(value) = self.table.get("exclude") else { return Ok(Dropped { no_return_m, zones: Vec::new() }) };
        let list = value.as_array().ok_or_else(|| self.ill_typed("exclude", value, "a list of sections"))?;
        let zone = |(place, value): (usize, &'a Value)| {
            let name = format!("{}.exclude[{}]", self.name, place + 1);
            let table = value.as_table().ok_or_else(|| self.ill_typed("exclude", value, "a list of sections"))?;
            Section { name: name.into(), table }.zone()
        };
        let zones = list.iter().enumerate().map(zone).collect::<Result<_, _>>()?;
        Ok(Dropped { no_return_m, zones })
    }

    /// A zone of a view; an edge that is not stated is that of the view.
    fn zone(&self) -> Result<Sensor, LogError> {
        self.has_only(&ZONE_KEYS)?;
        let edge = |key: &str, unsaid: f64| if self.table.contains_key(key) { self.number(key) } else { Ok(unsaid) };
        let zone = Sensor {
            range_min_m: edge("range_min_m", 0.0)?,
            range_max_m: edge("range_max_m", f64::INFINITY)?,
            bearing_min_rad: edge("bearing_min_rad", -WHOLE_TURN_RAD)?,
            bearing_max_rad: edge("bearing_max_rad", WHOLE_TURN_RAD)?,
            mounting: Mounting::NONE,
        };
        for (key, bearing) in [("bearing_min_rad", zone.bearing_min_rad), ("bearing_max_rad", zone.bearing_max_rad)] {
            units::radians(bearing, WHOLE_TURN_RAD, || self.key(key))?;
        }
        self.check("range_max_m", zone.range_max_m, "more than range_min_m", |r| r > zone.range_min_m)?;
        self.check("bearing_max_rad", zone.bearing_max_rad, "more than bearing_min_rad", |b| b > zone.bearing_min_rad)?;
        Ok(zone)
    }

    /// The stated noise of this section of a sensor, and that of the vehicle.
    fn nominal(&self, vehicle: &Section) -> Result<Nominal, LogError> {
        Ok(Nominal {
            // As in settings: without noise, the density of a measurement would be infinite.
            range_sigma_m: self.limited("range_sigma_m", "1e-6 to 1000 m", |s| (1e-6..=1e3).contains(&s))?,
            range_sigma_ratio: self
                .limited("range_sigma_ratio", "0 to 1", |ratio| (0.0..=1.0).contains(&ratio))?
                .unwrap_or(0.0),
            bearing_sigma_rad: self.limited("bearing_sigma_rad", "1e-6 to 3 rad", |s| (1e-6..=3.0).contains(&s))?,
            speed_sigma_mps: vehicle.limited("speed_sigma_mps", "0 to 1000 m/s", |s| (0.0..=1e3).contains(&s))?,
            rate_sigma_radps: vehicle.limited("rate_sigma_radps", "0 to 100 rad/s", |s| (0.0..=1e2).contains(&s))?,
            steering_sigma_rad: vehicle.limited("steering_sigma_rad", "0 to 3 rad", |s| (0.0..=3.0).contains(&s))?,
            detection_probability: self
                .limited("detection_probability", "more than 0 and at most 1", |p| p > 0.0 && p <= 1.0)?,
            clutter_per_scan: self.limited("clutter_per_scan", "0 to 1e6", |c| (0.0..=1e6).contains(&c))?,
        })
    }

    /// `[fixes]`.
    fn fix_noise(&self) -> Result<FixNoise, LogError> {
        self.has_only(&FIX_KEYS)?;
        let Mounting { forward_m, left_m, .. } = self.mounting("")?;
        Ok(FixNoise {
            position_sigma_m: self.limited("position_sigma_m", "1e-3 to 1000 m", |s| (1e-3..=1e3).contains(&s))?,
            heading_sigma_rad: self.limited("heading_sigma_rad", "1e-4 to 3 rad", |s| (1e-4..=3.0).contains(&s))?,
            gate: self.limited("gate", "more than 0", |gate| gate > 0.0)?,
            patience_s: self.limited("patience_s", "0 or more", |patience_s| patience_s >= 0.0)?,
            forward_m,
            left_m,
        })
    }

    fn stranger(&self, known: &[&str]) -> Option<&'a str> {
        self.table.keys().map(String::as_str).find(|key| !known.contains(key))
    }

    pub(super) fn has_only(&self, known: &'static [&'static str]) -> Result<(), LogError> {
        self.stranger(known).map_or(Ok(()), |key| Err(self.key(key).error(Problem::Unknown { known })))
    }

    fn boolean(&self, key: &str) -> Result<bool, LogError> {
        let value = self.get(key)?;
        value.as_bool().ok_or_else(|| self.ill_typed(key, value, "true or false"))
    }

    pub(super) fn string(&self, key: &str) -> Result<&'a str, LogError> {
        let value = self.get(key)?;
        value.as_str().ok_or_else(|| self.ill_typed(key, value, "a string"))
    }

    pub(super) fn number(&self, key: &str) -> Result<f64, LogError> {
        let value = self.get(key)?;
        finite(value).ok_or_else(|| self.ill_typed(key, value, "a finite number"))
    }

    pub(super) fn numbers<const N: usize>(&self, key: &str, expected: &'static str) -> Result<[f64; N], LogError> {
        let value = self.get(key)?;
        let numbers = value.as_array().and_then(|list| list.iter().map(finite).collect::<Option<Vec<_>>>());
        let numbers = numbers.and_then(|list| <[f64; N]>::try_from(list).ok());
        numbers.ok_or_else(|| self.ill_typed(key, value, expected))
    }

    fn pose(&self, key: &str) -> Result<[f64; 3], LogError> {
        self.numbers(key, "three finite numbers")
    }

    pub(super) fn check(
        &self,
        key: &str,
        found: f64,
        expected: &'static str,
        good: impl Fn(f64) -> bool,
    ) -> Result<(), LogError> {
        if good(found) { Ok(()) } else { Err(self.key(key).error(Problem::Limits { found, expected })) }
    }

    fn limited(&self, key: &str, expected: &'static str, good: impl Fn(f64) -> bool) -> Result<Option<f64>, LogError> {
        if !self.table.contains_key(key) {
            return Ok(None);
        }
        let number = self.number(key)?;
        self.check(key, number, expected, good)?;
        Ok(Some(number))
    }

    /// An optional number of 0 or more.
    fn sigma(&self, key: &str) -> Result<Option<f64>, LogError> {
        self.limited(key, "0 or more", |number| number >= 0.0)
    }
}

/// A finite number; integers are accepted too.
pub(super) fn finite(value: &Value) -> Option<f64> {
    let number = match value {
        Value::Float(number) => *number,
        Value::Integer(number) => *number as f64,
        _ => return None,
    };
    number.is_finite().then_some(number)
}
