//! Ranges of all fields of the settings.

use super::{CalibrationSettings, FilterSettings, Settings};
use scphd_log::log::FixNoise;
use std::borrow::Cow;

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field} = {found}, must be {range}")]
pub struct OutOfRange {
    /// The field with its section, `filter.particles`.
    pub field: Cow<'static, str>,
    pub found: f64,
    pub range: &'static str,
}

/// The range of a birth intensity.
const BORN: &str = "great enough for births to weigh filter.prune_weight or more: otherwise no feature is ever born";

pub(super) struct Limit<S> {
    pub(super) field: &'static str,
    value: fn(&S) -> f64,
    range: &'static str,
    /// Whether a value is in the range; false for NaN.
    holds: fn(f64) -> bool,
}

impl<S> Limit<S> {
    pub(super) fn check(&self, found: f64) -> Result<(), OutOfRange> {
        if (self.holds)(found) {
            Ok(())
        } else {
            Err(OutOfRange { field: self.field.into(), found, range: self.range })
        }
    }

    fn check_in(&self, settings: &S) -> Result<(), OutOfRange> {
        self.check((self.value)(settings))
    }
}

/// A limit with the field's path in [`Settings`] as its name, and its range in words and in code.
macro_rules! limit {
    (filter . $field:ident, $range:literal, $holds:expr) => {
        Limit {
            field: concat!("filter.", stringify!($field)),
            value: |filter: &FilterSettings| filter.$field as f64,
            range: $range,
            holds: $holds,
        }
    };
    ($section:ident . $field:ident, $range:literal, $holds:expr) => {
        Limit {
            field: concat!(stringify!($section), ".", stringify!($field)),
            value: |settings| settings.$section.$field as f64,
            range: $range,
            holds: $holds,
        }
    };
}

macro_rules! fix_limit {
    ($field:ident, $range:literal, $holds:expr) => {
        Limit {
            field: concat!("fixes.", stringify!($field)),
            value: |noise| noise.$field.unwrap_or(1.0),
            range: $range,
            holds: $holds,
        }
    };
}

/// All numbers of the recursion.
pub(super) const FILTER: &[Limit<FilterSettings>] = &[
    limit!(filter.particles, "1 to 65536", |x| (1.0..=65536.0).contains(&x)),
    limit!(filter.samples, "1 to 1024", |x| (1.0..=1024.0).contains(&x)),
    limit!(filter.birth_intensity, "0 to 1e6", |x| (0.0..=1e6).contains(&x)),
    limit!(filter.resample_threshold, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    limit!(filter.confirming_detections, "1 to 1000", |x| (1.0..=1e3).contains(&x)),
    limit!(filter.confirmed_weight, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    limit!(filter.unconfirmed_weight, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    limit!(filter.prune_weight, "1e-6 or more and less than 1", |x| (1e-6..1.0).contains(&x)),
    limit!(filter.merge_distance, "0 to 1e6", |x| (0.0..=1e6).contains(&x)),
    limit!(filter.max_components, "1 to 65536", |x| (1.0..=65536.0).contains(&x)),
    limit!(filter.extraction_weight, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    limit!(filter.proposal_rounds, "1 to 16", |x| (1.0..=16.0).contains(&x)),
    limit!(filter.proposal_sampled_fraction, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    limit!(filter.proposal_min_responsibility, "1e-6 or more and less than 1", |x| (1e-6..1.0).contains(&x)),
    limit!(filter.interval_margin, "0.1 to 100", |x| (0.1..=100.0).contains(&x)),
];

/// All other fields. Standard deviations of the sensor have a least value so that their squares are not zero in single precision;
/// p_D is below 1 because otherwise features with weight zero would remain.
pub(super) const LIMITS: &[Limit<Settings>] = &[
    limit!(moving.birth_intensity, "0 to 1e6 per m rad", |x| (0.0..=1e6).contains(&x)),
    limit!(moving.velocity_sigma_mps, "1e-3 to 1000 m/s", |x| (1e-3..=1e3).contains(&x)),
    limit!(moving.acceleration_psd, "1e-6 to 1e6 m2/s3", |x| (1e-6..=1e6).contains(&x)),
    limit!(moving.lifetime_s, "1e-3 to 1e9 s", |x| (1e-3..=1e9).contains(&x)),
    limit!(moving.extraction_weight, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    limit!(moving.spread_max_m, "1e-3 to 1e6 m", |x| (1e-3..=1e6).contains(&x)),
    limit!(joint.visible_s, "1e-3 to 1e9 s", |x| (1e-3..=1e9).contains(&x)),
    limit!(joint.occluded_s, "1e-3 to 1e9 s", |x| (1e-3..=1e9).contains(&x)),
    limit!(joint.lifetime_s, "1e-3 to 1e9 s", |x| (1e-3..=1e9).contains(&x)),
    limit!(joint.occlusion_factor, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    limit!(joint.merge_distance, "0 to 1e6", |x| (0.0..=1e6).contains(&x)),
    limit!(joint.hypotheses, "1 to 16", |x| (1.0..=16.0).contains(&x)),
    limit!(vehicle.speed_sigma_mps, "0 to 1000 m/s", |x| (0.0..=1e3).contains(&x)),
    limit!(vehicle.speed_sigma_ratio, "0 to 10", |x| (0.0..=1e1).contains(&x)),
    limit!(vehicle.turn_sigma, "0 to 100 rad or rad/s", |x| (0.0..=1e2).contains(&x)),
    limit!(vehicle.turn_sigma_ratio, "0 to 10", |x| (0.0..=1e1).contains(&x)),
    limit!(vehicle.noise_interval_s, "0 to 1000 s", |x| (0.0..=1e3).contains(&x)),
    limit!(sensor.range_sigma_m, "1e-6 to 1000 m", |x| (1e-6..=1e3).contains(&x)),
    limit!(sensor.range_sigma_ratio, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    limit!(sensor.bearing_sigma_rad, "1e-6 to 3 rad", |x| (1e-6..=3.0).contains(&x)),
    limit!(sensor.range_min_m, "0 to 1e6 m", |x| (0.0..=1e6).contains(&x)),
    limit!(sensor.range_max_m, "more than 0 and at most 1e6 m", |x| x > 0.0 && x <= 1e6),
    limit!(sensor.range_edge_m, "0 to 1e6 m", |x| (0.0..=1e6).contains(&x)),
    limit!(sensor.bearing_min_rad, "-10 to 10 rad", |x| (-10.0..=10.0).contains(&x)),
    limit!(sensor.bearing_max_rad, "-10 to 10 rad", |x| (-10.0..=10.0).contains(&x)),
    limit!(sensor.bearing_edge_rad, "0 to 3 rad", |x| (0.0..=3.0).contains(&x)),
    limit!(sensor.detection_near, "0 to 0.9999", |x| (0.0..=0.9999).contains(&x)),
    limit!(sensor.detection_far, "0 to 0.9999", |x| (0.0..=0.9999).contains(&x)),
    limit!(sensor.clutter_per_scan, "0 to 1e6", |x| (0.0..=1e6).contains(&x)),
    limit!(sensor.forward_m, "-1000 to 1000 m", |x| (-1e3..=1e3).contains(&x)),
    limit!(sensor.left_m, "-1000 to 1000 m", |x| (-1e3..=1e3).contains(&x)),
    limit!(sensor.birth_factor, "1e-6 to 1e6", |x| (1e-6..=1e6).contains(&x)),
    limit!(sensor.yaw_rad, "a turn to either side at most, rad", |x| x.abs() <= std::f64::consts::TAU),
];

macro_rules! calibration_limit {
    ($field:ident, $range:literal, $holds:expr) => {
        Limit {
            field: concat!("calibration.", stringify!($field)),
            value: |calibration| calibration.$field,
            range: $range,
            holds: $holds,
        }
    };
}

/// All numbers of the calibration of the odometry.
const CALIBRATION: &[Limit<CalibrationSettings>] = &[
    calibration_limit!(speed_scale_sigma, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    calibration_limit!(turn_scale_sigma, "0 to 1", |x| (0.0..=1.0).contains(&x)),
    calibration_limit!(turn_offset_sigma, "0 to 1 rad or rad/s", |x| (0.0..=1.0).contains(&x)),
    calibration_limit!(lasts_s, "1 to 1e9 s", |x| (1.0..=1e9).contains(&x)),
];

/// All numbers of fixes; unstated ones are in range.
const FIXES: &[Limit<FixNoise>] = &[
    fix_limit!(position_sigma_m, "1e-6 to 1e6 m", |x| (1e-6..=1e6).contains(&x)),
    fix_limit!(heading_sigma_rad, "1e-6 to 3 rad", |x| (1e-6..=3.0).contains(&x)),
    fix_limit!(gate, "more than 0", |x| x > 0.0),
    fix_limit!(patience_s, "0 or more", |x| x >= 0.0),
    Limit { field: "fixes.forward_m", value: |noise| noise.forward_m, range: ARM, holds: |x| x.abs() <= 1e3 },
    Limit { field: "fixes.left_m", value: |noise| noise.left_m, range: ARM, holds: |x| x.abs() <= 1e3 },
];
const ARM: &str = "-1000 to 1000 m";

impl FilterSettings {
    /// Checks that all fields are in range.
    pub fn check(&self) -> Result<(), OutOfRange> {
        FILTER.iter().try_for_each(|limit| limit.check_in(self))
    }

    /// Whether a feature can be born: an unexplained measurement gives one of weight w_b / (κ + w_b + w_m), with `clutter` for κ
    /// and `moving` for w_m, which must not be pruned immediately.
    pub(crate) fn check_births(&self, clutter: f64, moving: f64) -> Result<(), OutOfRange> {
        let all = clutter + self.birth_intensity + moving;
        let intensities = [("filter.birth_intensity", self.birth_intensity), ("moving.birth_intensity", moving)];
        let pruned = |intensity: f64| !(intensity >= self.prune_weight * all);
        if !(self.birth_intensity + moving > 0.0) {
            return Err(OutOfRange {
                field: "filter.birth_intensity".into(),
                found: self.birth_intensity,
                range: BORN,
            });
        }
        let unborn = intensities.into_iter().find(|&(_, intensity)| intensity > 0.0 && pruned(intensity));
        unborn.map_or(Ok(()), |(field, found)| Err(OutOfRange { field: field.into(), found, range: BORN }))
    }
}

impl Settings {
    /// Checks that all fields are in range.
    pub fn check(&self) -> Result<(), OutOfRange> {
        self.filter.check()?;
        for (name, sensor) in &self.others {
            // Checked as an only sensor.
            let alone = Self { sensor: sensor.clone(), sensor_name: name.clone(), others: Vec::new(), ..self.clone() };
            alone.check()?;
        }
        self.check_first().map_err(|error| match error.field.strip_prefix("sensor.") {
            Some(key) if !self.sensor_name.is_empty() => {
                OutOfRange { field: format!("sensors.{}.{key}", self.sensor_name).into(), ..error }
            }
            _ => error,
        })
    }

    fn check_first(&self) -> Result<(), OutOfRange> {
        LIMITS.iter().try_for_each(|limit| limit.check_in(self))?;
        if let Some(noise) = &self.fixes {
            FIXES.iter().try_for_each(|limit| limit.check_in(noise))?;
        }
        if let Some(calibration) = &self.calibration {
            CALIBRATION.iter().try_for_each(|limit| limit.check_in(calibration))?;
        }
        let sensor = &self.sensor;
        let above = |field: &'static str, found, range, least| {
            if found > least { Ok(()) } else { Err(OutOfRange { field: field.into(), found, range }) }
        };
        above("sensor.range_max_m", sensor.range_max_m, "more than sensor.range_min_m", sensor.range_min_m)?;
        above(
            "sensor.bearing_max_rad",
            sensor.bearing_max_rad,
            "more than sensor.bearing_min_rad",
            sensor.bearing_min_rad,
        )?;
        if !(sensor.detection_near.max(sensor.detection_far) > 0.0) {
            let range = "more than 0 here or in sensor.detection_far: otherwise nothing is ever detected";
            return Err(OutOfRange { field: "sensor.detection_near".into(), found: sensor.detection_near, range });
        }
        // Both intensities divided by the factor: the ratio to κ of this sensor is the same.
        let clutter = sensor.clutter_per_scan / sensor.measure() / sensor.birth_factor;
        self.filter.check_births(clutter, self.moving.birth_intensity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_worlds::scenario;

    #[test]
    fn every_field_has_a_limit() {
        let mut settings = Settings::for_log(&scenario::survey(1));
        // Otherwise the fields are not serialised.
        (settings.sensor.birth_factor, settings.sensor.range_sigma_ratio) = (2.0, 0.1);
        let table = toml::Table::try_from(&settings).unwrap();
        let mut fields = Vec::new();
        for (section, keys) in &table {
            // Names and Booleans have no limits; invalid ones are refused when they are read.
            let is_choice = |value: &toml::Value| value.is_str() || value.is_bool();
            let numbers = keys.as_table().unwrap().iter().filter(|(_, value)| !is_choice(value));
            fields.extend(numbers.map(|(key, _)| format!("{section}.{key}")));
        }
        let fields_of_filter = FILTER.iter().map(|limit| limit.field);
        let mut limited: Vec<_> =
            fields_of_filter.chain(LIMITS.iter().map(|limit| limit.field)).map(str::to_owned).collect();
        fields.sort();
        limited.sort();
        assert_eq!(fields, limited);
        let holds = FILTER.iter().map(|limit| limit.holds).chain(LIMITS.iter().map(|limit| limit.holds));
        assert!(holds.into_iter().all(|holds| !holds(f64::NAN) && !holds(f64::INFINITY)));
    }

    #[test]
    fn an_error_has_the_name_of_the_field() {
        let good = Settings::for_log(&scenario::survey(1));
        let mut bad = good.clone();
        bad.filter.particles = 0;
        assert_eq!(bad.check().unwrap_err().to_string(), "filter.particles = 0, must be 1 to 65536");
        let mut bad = good.clone();
        bad.sensor.range_min_m = bad.sensor.range_max_m;
        assert_eq!(bad.check().unwrap_err().field, "sensor.range_max_m");
        let mut bad = good.clone();
        bad.sensor.bearing_max_rad = -4.0;
        assert_eq!(bad.check().unwrap_err().field, "sensor.bearing_max_rad");
        let mut bad = good;
        (bad.sensor.detection_near, bad.sensor.detection_far) = (0.0, 0.0);
        assert_eq!(bad.check().unwrap_err().field, "sensor.detection_near");
        bad.sensor.detection_far = 0.5;
        assert_eq!(bad.check(), Ok(()));
    }

    #[test]
    fn births_must_be_heavier_than_the_pruning_weight() {
        let good = Settings::for_log(&scenario::survey(1));
        let clutter = good.sensor.clutter_per_scan / good.sensor.measure();
        let with = |birth: f64, moving: f64| {
            let mut settings = good.clone();
            settings.filter.birth_intensity = birth;
            settings.moving.birth_intensity = moving;
            settings.check().map_err(|error| error.field.into_owned())
        };
        // w / (κ + w) = p for w = κ p / (1 − p).
        let least = clutter * good.filter.prune_weight / (1.0 - good.filter.prune_weight);
        assert_eq!(with(1.001 * least, 0.0), Ok(()));
        assert_eq!(with(0.999 * least, 0.0), Err("filter.birth_intensity".to_owned()));
        assert_eq!(with(0.0, 0.0), Err("filter.birth_intensity".to_owned()));
        assert_eq!(with(0.0, 1.001 * least), Ok(()));
        assert_eq!(with(2.0 * least, 0.5 * least), Err("moving.birth_intensity".to_owned()));
        assert_eq!(with(1.001 * least, least), Err("filter.birth_intensity".to_owned()));
    }
}
