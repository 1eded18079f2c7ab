//! `log.toml`.

use super::error::{LogError, NAME_CHARS, Place, Problem, SENSOR_NAME_CHARS};
use super::table::text;
use super::units::{self, WHOLE_TURN_RAD};
use crate::log::{FixNoise, Mounting, NamedSensor, Nominal, Sensor, Vehicle};
use std::borrow::Cow;
use std::path::Path;
use toml::{Table, Value};

/// What `log.toml` says.
pub(super) struct Head {
    pub(super) name: String,
    pub(super) simulated: bool,
    pub(super) initial_pose: [f64; 3],
    /// 0 where nothing is said of it.
    pub(super) truth_sigma_m: f64,
    pub(super) vehicle: Vehicle,
    /// In order of their names; the only one of `[sensor]` has none.
    pub(super) sensors: Vec<NamedSensor>,
    /// `None` where there is no `[fixes]`.
    pub(super) fix_noise: Option<FixNoise>,
}

/// Names of a vehicle's control columns in `odometry.csv`: those of the first two controls, and of the third where it has one.
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
    pub(super) fn read(dir: &Path) -> Result<Self, LogError> {
        let file = "log.toml";
        Self::of(&text(dir, file)?.ok_or_else(|| Place::File(file).error(Problem::Missing))?)
    }

    /// What a text says.
    pub(super) fn of(text: &str) -> Result<Self, LogError> {
        let table: Table = text.parse().map_err(|error| syntax(text, &error))?;
        let top = Section { name: "".into(), table: &table };
        // The sensor first: logs of other sensors lack other things as well, which is not what to report.
        let several = table.contains_key("sensors");
        if table.contains_key("camera") && !table.contains_key("sensor") && !several {
            let found = String::from("camera");
            return Err(top.key("camera").error(Problem::Unsupported { found, supported: SENSORS }));
        }
        let sections = if several { top.sensors()? } else { vec![(String::new(), top.section("sensor")?)] };
        let vehicle = top.section("vehicle")?;
        let vehicle_model = self::vehicle(&vehicle)?;
        let mut sensors = Vec::new();
        for (name, section) in &sections {
            let mounting = if several { section.mounting("")? } else { mounting(&vehicle, &vehicle_model)? };
            let sensor = Sensor { mounting, ..sensor(section)? };
            sensors.push(NamedSensor { name: name.clone(), sensor, nominal: Nominal::default() });
        }
        // Only then: sections of other models have other keys.
        top.has_only(&TOP_KEYS)?;
        for (_, section) in &sections {
            section.has_only(if several { MOUNTED_SENSOR_KEYS } else { SENSOR_KEYS })?;
        }
        check_vehicle_keys(&vehicle, &vehicle_model, several)?;
        let initial_pose = top.pose("initial_pose")?;
        units::radians(initial_pose[2], WHOLE_TURN_RAD, || top.key("initial_pose"))?;
        let truth_sigma_m = top.sigma("truth_sigma_m")?.unwrap_or(0.0);
        let (name, simulated) = (name(&top)?, simulated(&top)?);
        for (sensor, (_, section)) in sensors.iter_mut().zip(&sections) {
            sensor.nominal = section.nominal(&vehicle)?;
        }
        sensors.sort_by(|a, b| a.name.cmp(&b.name));
        let fix_noise = if table.contains_key("fixes") { Some(top.section("fixes")?.fix_noise()?) } else { None };
        Ok(Self { name, simulated, initial_pose, truth_sigma_m, vehicle: vehicle_model, sensors, fix_noise })
    }

    /// Names of the control columns in `odometry.csv`.
    pub(super) fn control_columns(&self) -> ([&'static str; 2], Option<&'static str>) {
        control_columns(&self.vehicle)
    }
}

/// Of the only sensor; where it sits is then a matter of the vehicle.
const SENSOR_KEYS: &[&str] = MOUNTED_SENSOR_KEYS.split_at(9).0;
/// Of one of several sensors.
const MOUNTED_SENSOR_KEYS: &[&str] = &[
    "model",
    "range_min_m",
    "range_max_m",
    "bearing_min_rad",
    "bearing_max_rad",
    "range_sigma_m",
    "bearing_sigma_rad",
    "detection_probability",
    "clutter_per_scan",
    "name",
    "forward_m",
    "left_m",
    "yaw_rad",
];
const FIX_KEYS: [&str; 6] = ["position_sigma_m", "heading_sigma_rad", "gate", "patience_s", "forward_m", "left_m"];
const ACKERMANN_KEYS: [&str; 8] = [
    "model",
    "wheelbase_m",
    "encoder_offset_m",
    "sensor_forward_m",
    "sensor_left_m",
    "sensor_yaw_rad",
    "speed_sigma_mps",
    "steering_sigma_rad",
];
const UNICYCLE_KEYS: [&str; 6] =
    ["model", "sensor_forward_m", "sensor_left_m", "sensor_yaw_rad", "speed_sigma_mps", "rate_sigma_radps"];
/// The same where `[[sensors]]` say where they sit; the pose of an Ackermann vehicle is of a place that these keys name.
const BARE_ACKERMANN_KEYS: [&str; 7] = [
    "model",
    "wheelbase_m",
    "encoder_offset_m",
    "sensor_forward_m",
    "sensor_left_m",
    "speed_sigma_mps",
    "steering_sigma_rad",
];
const BARE_UNICYCLE_KEYS: [&str; 3] = ["model", "speed_sigma_mps", "rate_sigma_radps"];
const TOP_KEYS: [&str; 12] = [
    "name",
    "kind",
    "simulated",
    "source",
    "note",
    "initial_pose",
    "truth",
    "truth_sigma_m",
    "vehicle",
    "sensor",
    "sensors",
    "fixes",
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

/// Where the sensor sits: of an Ackermann vehicle the pose is the sensor's, so that only its angle counts here; of all others it is
/// where the vehicle turns.
fn mounting(section: &Section, vehicle: &Vehicle) -> Result<Mounting, LogError> {
    let at_sensor = section.mounting("sensor_")?;
    match vehicle {
        Vehicle::Ackermann { .. } => Ok(Mounting { yaw_rad: at_sensor.yaw_rad, ..Mounting::NONE }),
        Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => Ok(at_sensor),
    }
}

/// Keys that the vehicle's model has no use for would be numbers left out unseen.
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

/// The name. It is drawn into plots and printed in one line.
pub(super) fn name(top: &Section) -> Result<String, LogError> {
    let name = top.string("name")?;
    // Two of the characters that no XML may hold are not control characters.
    let good = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    if !name.is_empty() && name.chars().count() <= NAME_CHARS && name.chars().all(good) {
        Ok(name.to_owned())
    } else {
        Err(top.key("name").error(Problem::Name))
    }
}

/// Whether the log is of a simulation: `simulated`, or, in logs without that key, the first word of `kind`, up to a comma. Without
/// either it is real.
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
    match kind.split(',').next().map(str::trim) {
        Some("simulated") => Ok(true),
        Some("real") => Ok(false),
        _ => Err(top.key("kind").error(Problem::Kind(kind.to_owned()))),
    }
}

/// A parser's error as one line.
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

    /// `[[sensors]]`, each with its name.
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
            // What a key of a settings file is written of, without quotes.
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

    /// Where a sensor sits; what is not said is 0.
    fn mounting(&self, prefix: &str) -> Result<Mounting, LogError> {
        let offset = |key: &str| {
            Ok(self.limited(&format!("{prefix}{key}"), "-1000 to 1000 m", |m| m.abs() <= 1e3)?.unwrap_or(0.0))
        };
        let yaw = format!("{prefix}yaw_rad");
        let yaw_rad = self.limited(&yaw, "a finite angle", |_| true)?.unwrap_or(0.0);
        units::radians(yaw_rad, WHOLE_TURN_RAD, || self.key(&yaw))?;
        Ok(Mounting { forward_m: offset("forward_m")?, left_m: offset("left_m")?, yaw_rad })
    }

    /// The noise that this section of a sensor states, and that of the vehicle.
    fn nominal(&self, vehicle: &Section) -> Result<Nominal, LogError> {
        Ok(Nominal {
            // As in settings: a measurement without noise has a density that no filter can weigh.
            range_sigma_m: self.limited("range_sigma_m", "1e-6 to 1000 m", |s| (1e-6..=1e3).contains(&s))?,
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

    /// A key that is not one of these.
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

    /// A list of so many finite numbers.
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

    /// A number that may be absent.
    fn limited(&self, key: &str, expected: &'static str, good: impl Fn(f64) -> bool) -> Result<Option<f64>, LogError> {
        if !self.table.contains_key(key) {
            return Ok(None);
        }
        let number = self.number(key)?;
        self.check(key, number, expected, good)?;
        Ok(Some(number))
    }

    /// A number, 0 or more, that may be absent.
    fn sigma(&self, key: &str) -> Result<Option<f64>, LogError> {
        self.limited(key, "0 or more", |number| number >= 0.0)
    }
}

/// A finite number; whole ones may be written without a point.
pub(super) fn finite(value: &Value) -> Option<f64> {
    let number = match value {
        Value::Float(number) => *number,
        Value::Integer(number) => *number as f64,
        _ => return None,
    };
    number.is_finite().then_some(number)
}
