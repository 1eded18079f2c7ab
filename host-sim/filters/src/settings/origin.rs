//! Origin of each setting.

use super::Settings;
use super::defaults::stated_turn;
use super::file::{self, FileError, FileProblem, LEARNT, lookup};
use super::used::{is_used_by, users_of};
use crate::slam::Filter;
use scphd_log::log::{Log, Mounting};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use toml::{Table, Value};

#[derive(Debug, Clone, PartialEq)]
pub enum Origin {
    /// Stated in `log.toml`, or by the scenario.
    Stated,
    /// Stated in the log, as in a data sheet; the default adds a margin.
    WithMargin(f64),
    /// Default for an unstated value, or derived from other values.
    Scheme,
    /// The experiment of the thesis that the scenario reproduces.
    Experiment,
    File(String),
    CommandLine(&'static str),
    /// Learnt from a log by `tune`.
    Learnt,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stated => f.write_str("stated"),
            Self::WithMargin(stated) => write!(f, "stated {stated}"),
            Self::Scheme => f.write_str("default"),
            Self::Experiment => f.write_str("experiment of the thesis"),
            Self::File(path) => write!(f, "file {path}"),
            Self::CommandLine(option) => write!(f, "command line, {option}"),
            Self::Learnt => f.write_str("learnt"),
        }
    }
}

/// The origin of every field of settings, in the plane or in space.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Origins(BTreeMap<String, Origin>);

impl Origins {
    /// Creates the origins for settings of a log: the fields in `stated` have theirs, the others are defaults.
    pub fn of<S: Serialize>(settings: &S, stated: Vec<(impl AsRef<str>, Origin)>) -> Self {
        let all = table(settings);
        let mut origins = Self(fields(&all).into_iter().map(|(field, _)| (field, Origin::Scheme)).collect());
        stated.into_iter().for_each(|(field, origin)| origins.set(field.as_ref(), origin));
        origins
    }

    /// Creates the origins for the default settings of `log` in the plane.
    pub fn of_log(log: &Log) -> Self {
        Self::of(&Settings::for_log(log), stated(log))
    }

    pub fn set(&mut self, field: &str, origin: Origin) {
        self.0.insert(field.to_owned(), origin);
    }

    /// Sets the origin of the fields that differ between `before` and `then`.
    pub fn set_changed<S: Serialize>(&mut self, before: &S, then: &S, origin: &Origin) {
        changed(before, then).iter().for_each(|field| self.set(field, origin.clone()));
    }

    /// Applies `with` to the settings file at `path`. Sets the origin of its fields to the file, or to "learnt" if the file says
    /// so.
    pub fn with_file<S>(
        &mut self,
        path: &Path,
        with: impl FnOnce(&str) -> Result<S, FileProblem>,
    ) -> Result<S, FileError> {
        // Read only once: it may be a pipe.
        file::read(path, |text| {
            let (over, learnt) = file::parsed_with_learnt(text)?;
            for (field, _) in fields(&over) {
                let origin =
                    if learnt.contains(&field) { Origin::Learnt } else { Origin::File(path.display().to_string()) };
                self.set(&field, origin);
            }
            with(text)
        })
    }

    pub fn get(&self, field: &str) -> Option<&Origin> {
        self.0.get(field)
    }

    /// The settings as a TOML file in which each line has the origin of its value. Reading it restores the settings and the list
    /// of learnt ones. With a given filter, unused settings are marked.
    pub fn annotated<S: Serialize>(&self, settings: &S, filter: Option<Filter>) -> Result<String, toml::ser::Error> {
        self.file(settings, filter, |_| true)
    }

    /// As [`annotated`](Self::annotated), but without defaults and what a log states: other filters have their own defaults.
    pub fn overrides<S: Serialize>(&self, settings: &S) -> Result<String, toml::ser::Error> {
        let is_override = |origin: &Origin| matches!(origin, Origin::File(_) | Origin::CommandLine(_) | Origin::Learnt);
        self.file(settings, None, is_override)
    }

    fn file<S: Serialize>(
        &self,
        settings: &S,
        filter: Option<Filter>,
        is_kept: impl Fn(&Origin) -> bool,
    ) -> Result<String, toml::ser::Error> {
        let plain = toml::to_string(settings)?;
        let mut text = String::new();
        let learnt = self.0.iter().filter(|(_, origin)| **origin == Origin::Learnt).map(|(field, _)| field.clone());
        let learnt: Vec<Value> = learnt.map(Value::String).collect();
        if !learnt.is_empty() {
            text += &format!("{LEARNT} = {}\n", Value::Array(learnt));
        }
        let width = plain.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        let (mut section, mut written) = ("", "");
        for line in plain.lines() {
            section = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')).unwrap_or(section);
            let Some((key, value)) = line.split_once(" = ") else { continue };
            let field = format!("{section}.{key}");
            let origin = self.get(&field);
            if !origin.is_none_or(&is_kept) {
                continue;
            }
            if section != written {
                let gap = if text.is_empty() { "" } else { "\n" };
                text += &format!("{gap}[{section}]\n");
                written = section;
            }
            let Some(origin) = origin else {
                text += &format!("{line}\n");
                continue;
            };
            text += &format!("{line:width$}  # {origin}");
            if let (Origin::WithMargin(stated), Ok(value)) = (origin, value.parse::<f64>()) {
                let factor = (100.0 * value / stated).round() / 100.0;
                if factor != 1.0 {
                    text += &format!(", × {factor} by default");
                }
            }
            if filter.is_some_and(|filter| !is_used_by(filter, &field)) {
                text += &format!("; for --filter {} alone", users_of(&field));
            }
            text.push('\n');
        }
        Ok(text)
    }
}

/// The fields that the default settings in the plane take from statements of the log; see [`super::defaults`].
fn stated(log: &Log) -> Vec<(String, Origin)> {
    let nominal = &log.nominal;
    let mut stated = Vec::new();
    let mut add = |known: bool, section: &str, keys: &[&str]| {
        stated.extend(keys.iter().filter(|_| known).map(|key| (format!("{section}.{key}"), Origin::Stated)));
    };
    let turn = stated_turn(log);
    let speed = nominal.speed_sigma_mps;
    add(speed.is_some(), "vehicle", &["speed_sigma_ratio"]);
    add(turn.is_some(), "vehicle", &["turn_sigma_ratio"]);
    add(log.simulated && speed.is_some() && turn.is_some(), "vehicle", &["noise_interval_s"]);
    let mut noises = vec![("vehicle.speed_sigma_mps".to_owned(), speed), ("vehicle.turn_sigma".to_owned(), turn)];
    for (name, sensor, nominal) in log.sensors() {
        let section = if name.is_empty() { "sensor".to_owned() } else { format!("sensors.{name}") };
        add(true, &section, &["range_max_m", "bearing_min_rad", "bearing_max_rad"]);
        add(sensor.range_min_m > 0.0, &section, &["range_min_m"]);
        add(sensor.mounting != Mounting::NONE, &section, &["forward_m", "left_m", "yaw_rad"]);
        add(nominal.detection_probability.is_some(), &section, &["detection_near", "detection_far"]);
        add(nominal.clutter_per_scan.is_some(), &section, &["clutter_per_scan"]);
        noises.push((format!("{section}.range_sigma_m"), nominal.range_sigma_m));
        let ratio = Some(nominal.range_sigma_ratio).filter(|&ratio| ratio > 0.0);
        noises.push((format!("{section}.range_sigma_ratio"), ratio));
        noises.push((format!("{section}.bearing_sigma_rad"), nominal.bearing_sigma_rad));
    }
    if !log.fixes.is_empty() {
        let noise = &log.fix_noise;
        add(noise.gate.is_some(), "fixes", &["gate"]);
        add(noise.patience_s.is_some(), "fixes", &["patience_s"]);
        add((noise.forward_m, noise.left_m) != (0.0, 0.0), "fixes", &["forward_m", "left_m"]);
        noises.push(("fixes.position_sigma_m".into(), noise.position_sigma_m));
        noises.push(("fixes.heading_sigma_rad".into(), noise.heading_sigma_rad));
    }
    let origin = |sigma| if log.simulated { Origin::Stated } else { Origin::WithMargin(sigma) };
    stated.extend(noises.into_iter().filter_map(|(field, sigma)| Some((field, origin(sigma?)))));
    stated
}

/// The fields, as `section.key`, that differ between `before` and `then`.
pub fn changed<S: Serialize>(before: &S, then: &S) -> Vec<String> {
    let (before, then) = (table(before), table(then));
    let is_other = |(field, value): &(String, &Value)| lookup(&before, field) != Some(value);
    fields(&then).into_iter().filter(is_other).map(|(field, _)| field).collect()
}

/// All fields of settings, as `section.key`.
#[cfg(test)]
pub(super) fn leaves<S: Serialize>(settings: &S) -> Vec<String> {
    fields(&table(settings)).into_iter().map(|(field, _)| field).collect()
}

fn table<S: Serialize>(settings: &S) -> Table {
    Table::try_from(settings).unwrap_or_default()
}

/// Every `section.key`, also of nested sections, with its value.
fn fields(table: &Table) -> Vec<(String, &Value)> {
    let mut all = Vec::new();
    for (name, section) in table.iter().filter_map(|(name, section)| Some((name, section.as_table()?))) {
        let own = section.iter().filter(|(_, value)| !value.is_table()).map(|(key, value)| (key.clone(), value));
        all.extend(own.chain(fields(section)).map(|(key, value)| (format!("{name}.{key}"), value)));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_log::log::Nominal;
    use scphd_worlds::scenario;

    fn lines(text: &str) -> BTreeMap<String, String> {
        let lines = text.lines().filter_map(|line| {
            let (setting, origin) = line.split_once("  # ")?;
            Some((setting.split_once(" = ")?.0.to_owned(), origin.to_owned()))
        });
        lines.collect()
    }

    fn data_sheet() -> Log {
        let nominal = Nominal { range_sigma_m: Some(0.1), detection_probability: Some(0.9), ..Nominal::default() };
        Log { nominal, simulated: false, ..scenario::survey(1) }
    }

    #[test]
    fn every_line_has_the_origin_of_its_value() {
        let log = data_sheet();
        let settings = Settings::for_log(&log);
        let text = Origins::of_log(&log).annotated(&settings, None).unwrap();
        let plain = settings.to_toml().unwrap();
        let settings_in = |text: &str, mark: &str| text.lines().filter(|line| line.contains(mark)).count();
        assert_eq!(settings_in(&text, "  # "), settings_in(&plain, " = "));
        assert_eq!(Origins::of_log(&log).overrides(&settings).unwrap(), "");
        let of = lines(&text);
        assert_eq!(of["range_sigma_m"], "stated 0.1, × 1.5 by default");
        assert_eq!(of["bearing_sigma_rad"], "default");
        assert_eq!((&*of["range_max_m"], &*of["range_min_m"]), ("stated", "default"));
        assert_eq!(
            (&*of["detection_far"], &*of["clutter_per_scan"], &*of["particles"]),
            ("stated", "default", "default")
        );
        assert_eq!(Settings::for_log(&scenario::survey(2)).with_toml(&text).unwrap(), settings);
    }

    /// Fields called stated change with the statements of the log, and no others do, except derived ones.
    #[test]
    fn fields_called_stated_are_those_that_depend_on_statements() {
        let full = Nominal {
            range_sigma_m: Some(0.37),
            range_sigma_ratio: 0.03,
            bearing_sigma_rad: Some(0.043),
            speed_sigma_mps: Some(0.21),
            rate_sigma_radps: Some(0.031),
            steering_sigma_rad: Some(0.033),
            detection_probability: Some(0.83),
            clutter_per_scan: Some(2.7),
        };
        for simulated in [false, true] {
            let mut log = Log { simulated, ..scenario::survey(1) };
            log.nominal = Nominal::default();
            let without = table(&Settings::for_log(&log));
            log.nominal = full;
            let settings = table(&Settings::for_log(&log));
            let origins = Origins::of_log(&log);
            for (field, value) in fields(&settings) {
                let stated = matches!(origins.get(&field), Some(Origin::Stated | Origin::WithMargin(_)));
                let of_view =
                    ["range_max_m", "bearing_min_rad", "bearing_max_rad"].iter().any(|key| field.ends_with(key));
                let moved = lookup(&without, &field) != Some(value);
                // Derived values change too.
                let follows = field.starts_with("filter.") || field.ends_with("edge_m") || field.ends_with("edge_rad");
                assert!(!stated || moved || of_view, "{field} is called stated");
                assert!(stated || !moved || follows, "{field} is not called stated");
            }
        }
    }

    #[test]
    fn each_kind_of_origin_is_written_and_read() {
        let log = data_sheet();
        let mut settings = Settings::for_log(&log);
        let mut origins = Origins::of_log(&log);
        settings.filter.particles = 3;
        origins.set("filter.particles", Origin::CommandLine("--particles"));
        let before = settings.clone();
        settings.sensor.range_sigma_m = 0.22;
        origins.set_changed(&before, &settings, &Origin::Learnt);
        let text = origins.annotated(&settings, None).unwrap();
        assert!(text.starts_with("learnt = [\"sensor.range_sigma_m\"]\n"), "{text}");
        assert_eq!(lines(&text)["particles"], "command line, --particles");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tuned.toml");
        std::fs::write(&path, &text).unwrap();
        let mut again = Origins::of_log(&log);
        let read = again.with_file(&path, |text| Settings::for_log(&log).with_toml(text));
        assert_eq!(read.unwrap(), settings);
        assert_eq!(again.get("sensor.range_sigma_m"), Some(&Origin::Learnt));
        assert_eq!(again.get("filter.particles"), Some(&Origin::File(path.display().to_string())));
        // Only fields in a file have it as their origin.
        std::fs::write(&path, "[filter]\nsamples = 2\n").unwrap();
        let mut few = Origins::of_log(&log);
        few.with_file(&path, |_| Ok(())).unwrap();
        assert_eq!(few.get("filter.particles"), Some(&Origin::Scheme));
        assert!(matches!(few.get("filter.samples"), Some(Origin::File(_))));
    }
}
