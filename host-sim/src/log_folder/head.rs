//! `log.toml`.

use super::error::{LogError, Place, Problem};
use super::table::text;
use crate::log::{Nominal, Sensor, Vehicle};
use std::path::Path;
use toml::{Table, Value};

/// What `log.toml` says.
pub(super) struct Head {
    pub(super) name: String,
    pub(super) simulated: bool,
    pub(super) initial_pose: [f64; 3],
    pub(super) vehicle: Vehicle,
    pub(super) sensor: Sensor,
    pub(super) nominal: Nominal,
}

/// Names of a vehicle's two control columns in `odometry.csv`.
pub(super) fn control_columns(vehicle: &Vehicle) -> [&'static str; 2] {
    match vehicle {
        Vehicle::Ackermann { .. } => ["speed_mps", "steering_rad"],
        Vehicle::Unicycle | Vehicle::UnicycleArc => ["v_mps", "omega_radps"],
    }
}

/// A section of the file; errors carry its name.
pub(super) struct Section<'a> {
    pub(super) name: &'static str,
    pub(super) table: &'a Table,
}

impl Head {
    pub(super) fn read(dir: &Path) -> Result<Self, LogError> {
        let file = "log.toml";
        let text = text(dir, file)?.ok_or_else(|| Place::File(file).error(Problem::Missing))?;
        let table: Table = text.parse().map_err(|error| syntax(&text, &error))?;
        let top = Section { name: "", table: &table };
        // The sensor first: logs of other sensors lack other things as well, which is not what to report.
        if table.contains_key("camera") && !table.contains_key("sensor") {
            let found = String::from("camera");
            return Err(top.key("camera").error(Problem::Unsupported { found, supported: SENSORS }));
        }
        let sensor = top.section("sensor")?;
        let vehicle = top.section("vehicle")?;
        let (sensor_model, vehicle_model) = (self::sensor(&sensor)?, self::vehicle(&vehicle)?);
        // Only then: sections of other models have other keys.
        sensor.has_only(&SENSOR_KEYS)?;
        vehicle.has_only(&VEHICLE_KEYS)?;
        Ok(Self {
            sensor: sensor_model,
            vehicle: vehicle_model,
            name: top.string("name")?.to_owned(),
            simulated: match table.get("kind") {
                Some(_) => top.string("kind")?.starts_with("simulated"),
                None => false,
            },
            initial_pose: top.pose("initial_pose")?,
            nominal: Nominal {
                range_sigma_m: sensor.sigma("range_sigma_m")?,
                bearing_sigma_rad: sensor.sigma("bearing_sigma_rad")?,
                speed_sigma_mps: vehicle.sigma("speed_sigma_mps")?,
                rate_sigma_radps: vehicle.sigma("rate_sigma_radps")?,
                steering_sigma_rad: vehicle.sigma("steering_sigma_rad")?,
                detection_probability: sensor
                    .limited("detection_probability", "0 to 1", |p| (0.0..=1.0).contains(&p))?,
                clutter_per_scan: sensor.sigma("clutter_per_scan")?,
            },
        })
    }

    /// Names of the two control columns in `odometry.csv`.
    pub(super) fn control_columns(&self) -> [&'static str; 2] {
        control_columns(&self.vehicle)
    }
}

const SENSOR_KEYS: [&str; 9] = [
    "model",
    "range_min_m",
    "range_max_m",
    "bearing_min_rad",
    "bearing_max_rad",
    "range_sigma_m",
    "bearing_sigma_rad",
    "detection_probability",
    "clutter_per_scan",
];
const VEHICLE_KEYS: [&str; 8] = [
    "model",
    "wheelbase_m",
    "encoder_offset_m",
    "sensor_forward_m",
    "sensor_left_m",
    "speed_sigma_mps",
    "rate_sigma_radps",
    "steering_sigma_rad",
];
const SENSORS: &str = "range_bearing";
const VEHICLES: &str = "ackermann, unicycle and unicycle_arc";

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
    };
    section.check("range_max_m", sensor.range_max_m, "more than the least range", |r| r > range_min_m)?;
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
        other => {
            let found = other.to_owned();
            Err(section.key("model").error(Problem::Unsupported { found, supported: VEHICLES }))
        }
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
        Ok(Section { name, table })
    }

    fn has_only(&self, known: &'static [&'static str]) -> Result<(), LogError> {
        let stranger = self.table.keys().find(|key| !known.contains(&key.as_str()));
        stranger.map_or(Ok(()), |key| Err(self.key(key).error(Problem::Unknown { known })))
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
