//! Settings in a TOML file: the sections and fields of [`Settings`], each of which is optional.

use super::Settings;
use super::limits::{FILTER, LIMITS, Limit, OutOfRange};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Why a settings file cannot be used; displays as one line.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct FileError {
    pub path: PathBuf,
    pub problem: FileProblem,
}

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileProblem {
    /// The file cannot be read, or is not UTF-8.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// The file is not TOML.
    #[error("row {row}: {message}")]
    Syntax {
        /// Line of the file, counted from 1.
        row: usize,
        message: String,
    },
    /// A key that is not known, or a value of the wrong type.
    #[error("{0}")]
    Field(String),
    #[error("{0}")]
    OutOfRange(#[from] OutOfRange),
}

impl Settings {
    /// These settings, overridden by the fields in `text`.
    pub fn with_toml(&self, text: &str) -> Result<Self, FileProblem> {
        let over = parsed(text)?;
        check(&over, LIMITS)?;
        self.knows_sensors(&over)?;
        let settings: Self = laid_over(self, over)?;
        settings.check()?;
        Ok(settings)
    }

    /// Checks that the sensors in a file are those of the log.
    fn knows_sensors(&self, over: &Table) -> Result<(), FileProblem> {
        let names: Vec<&str> = std::iter::once(&self.sensor_name)
            .chain(self.others.iter().map(|(name, _)| name))
            .map(String::as_str)
            .collect();
        let several = !self.others.is_empty();
        let named = over.get("sensors").and_then(Value::as_table).into_iter().flat_map(Table::keys);
        let stranger = named.into_iter().find(|name| !several || !names.contains(&name.as_str()));
        match stranger {
            Some(name) if several => Err(FileProblem::Field(format!(
                "sensors.{name}: the log has no such sensor, it has {}",
                names.join(", ")
            ))),
            Some(name) => Err(FileProblem::Field(format!("sensors.{name}: the log has one sensor, [sensor]"))),
            None if several && over.contains_key("sensor") => {
                let sections: Vec<_> = names.iter().map(|name| format!("[sensors.{name}]")).collect();
                Err(FileProblem::Field(format!("sensor: the log has several, {}", sections.join(", "))))
            }
            None => Ok(()),
        }
    }

    /// The settings as TOML; [`Settings::with_toml`] restores them exactly.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }
}

/// Reads settings from the file at `path`.
pub(crate) fn read<S>(path: &Path, with: impl FnOnce(&str) -> Result<S, FileProblem>) -> Result<S, FileError> {
    let error = |problem| FileError { path: path.into(), problem };
    let text = fs::read_to_string(path).map_err(|source| error(FileProblem::Unreadable(source)))?;
    with(&text).map_err(error)
}

/// The key of the list of fields that `tune` has learnt. It documents their origin and has no effect.
pub(crate) const LEARNT: &str = "learnt";

/// The fields in `text`, with the numbers of the recursion checked.
pub(crate) fn parsed(text: &str) -> Result<Table, FileProblem> {
    parsed_with_learnt(text).map(|(over, _)| over)
}

/// The fields in `text`, and the list of learnt fields.
pub(crate) fn parsed_with_learnt(text: &str) -> Result<(Table, Vec<String>), FileProblem> {
    let mut over: Table = text.parse().map_err(|error| syntax(text, &error))?;
    let learnt = match over.remove(LEARNT) {
        None => Vec::new(),
        Some(list) => {
            let names: Vec<String> = list.try_into().map_err(|error| FileProblem::Field(one_line(&error)))?;
            if let Some(stranger) = names.iter().find(|name| lookup(&over, name).is_none()) {
                return Err(FileProblem::Field(format!("{LEARNT}: the file has no {stranger}")));
            }
            names
        }
    };
    check(&over, FILTER)?;
    Ok((over, learnt))
}

/// Checked before serde, which would report only a wrong type for a negative count, not its range.
fn check<S>(over: &Table, limits: &[Limit<S>]) -> Result<(), OutOfRange> {
    for limit in limits {
        if let Some(found) = lookup(over, limit.field).and_then(number) {
            limit.check(found)?;
        }
    }
    Ok(())
}

/// `base`, overridden by `over`.
pub fn laid_over<S: Serialize + DeserializeOwned>(base: &S, over: Table) -> Result<S, FileProblem> {
    let field = |error: &dyn std::fmt::Display| FileProblem::Field(one_line(error));
    let mut table = Table::try_from(base).map_err(|error| field(&error))?;
    lay_over(&mut table, over);
    table.try_into().map_err(|error| field(&error))
}

/// Inserts every value of `over` into `table`, section by section.
fn lay_over(table: &mut Table, over: Table) {
    for (key, value) in over {
        match (table.get_mut(&key), value) {
            (Some(Value::Table(section)), Value::Table(over)) => lay_over(section, over),
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
}

/// The value of `section.key`, or of `section.section.key`.
pub fn lookup<'a>(table: &'a Table, field: &str) -> Option<&'a Value> {
    match field.split_once('.') {
        Some((section, key)) => lookup(table.get(section)?.as_table()?, key),
        None => table.get(field),
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn syntax(text: &str, error: &toml::de::Error) -> FileProblem {
    let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or("");
    FileProblem::Syntax { row: 1 + before.matches('\n').count(), message: one_line(&error.message()) }
}

fn one_line(error: &dyn std::fmt::Display) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_worlds::scenario;

    fn defaults() -> Settings {
        Settings::for_log(&scenario::survey(1))
    }

    #[test]
    fn toml_restores_every_bit() {
        let mut settings = defaults();
        settings.filter.birth_intensity = 0.1 + 0.2;
        settings.sensor.range_edge_m = 1.0 / 3.0;
        let other = defaults();
        assert_eq!(other.with_toml(&settings.to_toml().unwrap()).unwrap(), settings);
    }

    #[test]
    fn missing_fields_are_unchanged() {
        let defaults = defaults();
        assert_eq!(defaults.with_toml("").unwrap(), defaults);
        let settings = defaults.with_toml("[filter]\nparticles = 7\n[sensor]\nrange_sigma_m = 1\n").unwrap();
        let mut expected = defaults;
        expected.filter.particles = 7;
        expected.sensor.range_sigma_m = 1.0;
        assert_eq!(settings, expected);
    }

    #[test]
    fn errors_are_one_line_with_the_field() {
        for (text, parts) in [
            ("[filter]\nparticles = 0", ["filter.particles", "1 to 65536"]),
            ("[filter]\nparticles = -1", ["filter.particles", "1 to 65536"]),
            ("[filter]\nparticles = 2.5", ["filter.particles", "2.5"]),
            ("[filter]\nparticles = '2'", ["filter.particles", "\"2\""]),
            ("[vehicle]\nspeed_sigma_mps = -0.1", ["vehicle.speed_sigma_mps", "0 to 1000 m/s"]),
            ("[sensor]\ndetection_near = nan", ["sensor.detection_near", "0 to 0.9999"]),
            ("[sensor]\nrange_min_m = 20", ["sensor.range_max_m", "more than sensor.range_min_m"]),
            ("[filter]\nparticle = 3", ["`particle`", "`particles`"]),
            ("[filters]\nparticles = 3", ["`filters`", "`filter`"]),
            ("filter = 3", ["filter", "3"]),
            ("learnt = [\"filter.samples\"]\n[filter]\nparticles = 3", ["learnt", "filter.samples"]),
            ("learnt = 3", ["3", "sequence"]),
            ("[filter]\nparticles = ", ["row 2", ""]),
        ] {
            let error = defaults().with_toml(text).unwrap_err().to_string();
            println!("{error}");
            assert!(parts.iter().all(|part| error.contains(part)), "{text}: {error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn an_error_has_the_name_of_the_file() {
        let error = read(Path::new("no/such.toml"), |text| defaults().with_toml(text)).unwrap_err().to_string();
        assert!(error.starts_with("no/such.toml: cannot be read: "), "{error}");
    }

    #[test]
    fn each_of_several_sensors_has_its_section() {
        let log = scenario::two_sensors(1);
        let settings = Settings::for_log(&log);
        let over = "[sensors.radar]\nrange_sigma_m = 1\n[sensors.lidar]\ndetection_far = 0.5\n";
        let tuned = settings.with_toml(over).unwrap();
        assert_eq!((tuned.others[0].1.range_sigma_m, tuned.sensor.detection_far), (1.0, 0.5));
        assert_eq!(settings.with_toml(&tuned.to_toml().unwrap()).unwrap(), tuned);
        // Births of each sensor in proportion to its clutter.
        let factor = settings.others[0].1.birth_factor;
        let density = |sensor: &crate::settings::SensorSettings| sensor.clutter_per_scan / sensor.measure();
        assert!((factor - density(&settings.others[0].1) / density(&settings.sensor)).abs() < 1e-12);
        for (text, expected) in [
            ("[sensor]\nrange_sigma_m = 1", "sensor: the log has several, [sensors.lidar], [sensors.radar]"),
            ("[sensors.sonar]\nrange_sigma_m = 1", "sensors.sonar: the log has no such sensor, it has lidar, radar"),
            ("[sensors.radar]\nrange_sigma_m = -1", "sensors.radar.range_sigma_m = -1, must be 1e-6 to 1000 m"),
            ("[sensors.radar]\nrange_sigma_ratio = 2", "sensors.radar.range_sigma_ratio = 2, must be 0 to 1"),
            ("[sensors.lidar]\nrange_max_m = -1", "sensors.lidar.range_max_m = -1, must be"),
        ] {
            let error = settings.with_toml(text).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
        let error = defaults().with_toml("[sensors.radar]\nrange_sigma_m = 1").unwrap_err().to_string();
        assert_eq!(error, "sensors.radar: the log has one sensor, [sensor]");
        let fixes =
            Settings::for_log(&scenario::survey_fixes(1)).with_toml("[fixes]\nposition_sigma_m = -1").unwrap_err();
        assert_eq!(fixes.to_string(), "fixes.position_sigma_m = -1, must be 1e-6 to 1e6 m");
    }
}
