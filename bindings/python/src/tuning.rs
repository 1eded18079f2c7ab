//! Settings of the filters, as keywords.

use crate::array::Number;
use crate::error::{Refusal, SettingError};
use crate::setting_name::keyword_of;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use scphd::{Config, Real};
use scphd_vehicle::{Description, Filter, Setting, StartError, Vehicle};

/// Converts the value of a setting to a number.
fn number<'py, T>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    value.extract().map_err(|_| {
        let kind = value.get_type();
        PyTypeError::new_err(format!("{name} must be a number, not {kind}"))
    })
}

fn word(name: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    value.extract().map_err(|_| PyTypeError::new_err(format!("{name} must be a string")))
}

fn truth(name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    value.extract().map_err(|_| PyTypeError::new_err(format!("{name} must be True or False")))
}

fn unknown(name: &str) -> PyErr {
    PyTypeError::new_err(format!("there is no setting '{name}'"))
}

/// The settings of a mixture.
pub fn of_mixture(
    proposal: &str,
    particles: usize,
    samples: usize,
    keywords: Option<&Bound<'_, PyDict>>,
) -> PyResult<Config<f32>> {
    let config = match proposal {
        "blind" => Config::blind(particles, samples),
        "informed" => Config { samples, ..Config::informed(particles) },
        other => {
            return Err(SettingError::new_err(format!("proposal must be 'blind' or 'informed', not '{other}'")));
        }
    };
    let mut description = Description { filter: Filter::Mixture(config), ..Description::robot() };
    set(&mut description, "mixture.", keywords)?;
    let Filter::Mixture(config) = description.filter else { return Err(unknown("filter")) };
    Ok(config)
}

/// The keywords of a joint map: name, range, unit and meaning.
#[pyfunction]
pub fn _joint_settings() -> Vec<(String, &'static str, &'static str, &'static str)> {
    let known =
        |setting| keyword_of(setting, "joint.").map(|name| (name, setting.range(), setting.unit(), setting.about()));
    Setting::all().filter_map(known).collect()
}

/// Converts the value of a keyword to the number of a setting.
fn value<T: Number>(name: &str, setting: Setting, value: &Bound<'_, PyAny>) -> PyResult<T> {
    match setting.choices() {
        [] => number(name, value),
        ["no", "yes"] => truth(name, value).map(|on| T::from_usize(on.into())),
        choices => {
            let word = word(name, value)?;
            let place = choices.iter().position(|choice| *choice == word);
            place
                .map(T::from_usize)
                .ok_or_else(|| SettingError::new_err(format!("{name} must be {}, not '{word}'", setting.range())))
        }
    }
}

/// Sets the settings of a filter whose names begin with `group`.
fn set<T: Number>(description: &mut Description<T>, group: &str, keywords: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    let mut chosen = Vec::new();
    for (name, object) in keywords.iter().flat_map(|keywords| keywords.iter()) {
        let name = name.to_string();
        let setting = Setting::all().find(|setting| keyword_of(*setting, group).is_some_and(|known| known == name));
        let setting = setting.ok_or_else(|| unknown(&name))?;
        chosen.push((setting, value(&name, setting, &object)?, name));
    }
    // Parts are switched on before their settings are set.
    chosen.sort_by_key(|(setting, ..)| (setting.choices().is_empty(), setting.number()));
    for (setting, number, name) in chosen {
        if description.get(setting, 0).is_none() {
            return Err(SettingError::new_err(match name.split('_').next().unwrap_or_default() {
                "informed" => format!("{name} is of the proposal 'informed' alone"),
                "moving" => format!("{name} takes movers=True"),
                part => format!("{name} takes {part}=True"),
            }));
        }
        description
            .set(setting, 0, number)
            .map_err(|invalid| SettingError::new_err(format!("{name} must be {}", invalid.setting.range())))?;
    }
    Ok(())
}

/// The description of a joint map with these keywords.
pub fn of_joint_map(vehicle: Vehicle<f64>, keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Description<f64>> {
    let mut description = Description { vehicle, ..Description::robot() };
    set(&mut description, "joint.", keywords)?;
    Ok(description)
}

/// Converts a description to the precision of a filter.
pub fn cast<T: Real>(of: &Description<f64>) -> PyResult<Description<T>> {
    let mut description = Description::robot();
    description.take_numbers(of.numbers()).map_err(|invalid| StartError::from(invalid).raised())?;
    Ok(description)
}
