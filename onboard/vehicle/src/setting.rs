//! The settings of a description, with name, range, unit and meaning.

use crate::list::{MEANINGS, NAMES, RANGES};
use core::ffi::CStr;

/// A setting of a [`Description`](crate::Description), by its index in the list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting(u8);

const _: () = assert!(NAMES.len() < 256);

const fn equal(mut left: &[u8], mut right: &[u8]) -> bool {
    while let (Some((a, rest)), Some((b, behind))) = (left.split_first(), right.split_first()) {
        if *a != *b {
            return false;
        }
        (left, right) = (rest, behind);
    }
    left.is_empty() && right.is_empty()
}

impl Setting {
    /// Number of settings.
    pub const COUNT: usize = NAMES.len();

    /// The type of the filter.
    pub const FILTER: Self = Self::named("filter");
    /// The sensor model.
    pub(crate) const SENSOR_MODEL: Self = Self::named("sensor.model");
    /// How the noise grows with the range.
    pub(crate) const RANGE_RATIO: Self = Self::named("sensor.range_sigma_ratio");
    /// Whether there are moving features.
    pub(crate) const MOVERS: Self = Self::named("joint.movers");
    /// Whether there is an archive.
    pub(crate) const ARCHIVE: Self = Self::named("joint.archive");
    /// Whether there are several hypotheses.
    pub(crate) const HYPOTHESES: Self = Self::named("joint.hypotheses");
    /// Whether the odometry is calibrated.
    pub(crate) const ODOMETRY: Self = Self::named("joint.odometry");

    /// The first and the last setting of a sensor.
    const OF_A_SENSOR: [Self; 2] = [Self::SENSOR_MODEL, Self::named("sensor.yaw_rad")];

    /// The setting with this name; evaluated by the compiler.
    const fn named(name: &str) -> Self {
        let (mut place, mut names) = (0, NAMES);
        while let Some((first, rest)) = names.split_first() {
            if equal(first.to_bytes(), name.as_bytes()) {
                return Self(place);
            }
            (place, names) = (place + 1, rest);
        }
        assert!((place as usize) < NAMES.len(), "there is no setting of this name");
        Self(place)
    }

    /// All settings.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..Self::COUNT as u8).map(Self)
    }

    /// The setting with this number, from 1.
    #[must_use]
    pub fn of_number(number: u32) -> Option<Self> {
        let place = u8::try_from(number.checked_sub(1)?).ok()?;
        (usize::from(place) < Self::COUNT).then_some(Self(place))
    }

    /// Its number, from 1.
    #[must_use]
    pub fn number(self) -> u32 {
        u32::from(self.0) + 1
    }

    /// The setting with this name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::all().find(|setting| setting.name() == name)
    }

    /// Its place in the list, from 0; also that of its number among those of a description, except for a sensor.
    #[must_use]
    pub const fn place(self) -> usize {
        self.0 as usize
    }

    /// The setting at this place of the list.
    pub(crate) fn at(place: usize) -> Self {
        Self(place as u8)
    }

    /// Whether each sensor has this setting.
    #[must_use]
    pub fn is_of_a_sensor(self) -> bool {
        let [first, last] = Self::OF_A_SENSOR;
        (first.0..=last.0).contains(&self.0)
    }

    /// Its name, with a point between a part and its field.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.name_c().to_str().unwrap_or_default()
    }

    /// Its name as a C string.
    #[must_use]
    pub fn name_c(self) -> &'static CStr {
        NAMES.get(self.place()).copied().unwrap_or_default()
    }

    /// Its valid range as text, as in "must be above 0".
    #[must_use]
    pub fn range(self) -> &'static str {
        self.range_c().to_str().unwrap_or_default()
    }

    /// Its valid range as a C string.
    #[must_use]
    pub fn range_c(self) -> &'static CStr {
        RANGES.get(self.place()).copied().unwrap_or_default()
    }

    /// Its unit; empty for a dimensionless number.
    #[must_use]
    pub fn unit(self) -> &'static str {
        MEANINGS.get(self.place()).map_or("", |meaning| meaning.unit)
    }

    /// Its meaning.
    #[must_use]
    pub fn about(self) -> &'static str {
        MEANINGS.get(self.place()).map_or("", |meaning| meaning.about)
    }

    /// Names of the choices, in the order of their numbers; empty for a setting without choices.
    #[must_use]
    pub fn choices(self) -> &'static [&'static str] {
        MEANINGS.get(self.place()).map_or(&[], |meaning| meaning.choices)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::field::Range;
    use std::string::{String, ToString as _};

    fn spelled(range: &Range) -> String {
        let Range { least, most, closed: [low, high] } = *range;
        let (at_least, at_most) = (if low { "at least" } else { "above" }, if high { "at most" } else { "below" });
        match (least.is_finite(), most.is_finite()) {
            (false, _) => "finite".to_string(),
            (true, false) if high => std::format!("{at_least} {least}, or infinite"),
            (true, false) => std::format!("finite and {at_least} {least}"),
            (true, true) if low && high => std::format!("between {least} and {most}"),
            (true, true) => std::format!("{at_least} {least} and {at_most} {most}"),
        }
    }

    #[test]
    fn texts_of_ranges_agree_with_the_numbers() {
        for setting in Setting::all() {
            let range = crate::list::numbers(setting.place()).unwrap();
            let words = match setting.choices() {
                [] => spelled(range),
                names => std::format!("one of {}", names.join(", ")),
            };
            assert_eq!(setting.range(), words, "{}", setting.name());
        }
    }

    #[test]
    fn settings_of_a_sensor_have_its_prefix() {
        for setting in Setting::all() {
            assert_eq!(setting.is_of_a_sensor(), setting.name().starts_with("sensor."), "{}", setting.name());
            assert_eq!(Setting::of_number(setting.number()), Some(setting));
            assert_eq!(Setting::of_name(setting.name()), Some(setting));
        }
        assert!(Setting::of_number(0).is_none() && Setting::of_number(Setting::COUNT as u32 + 1).is_none());
    }
}
