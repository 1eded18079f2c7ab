//! Settings of the filters, as keywords.

use crate::error::{Refusal, SettingError};
use crate::setting_name::keyword_of;
use crate::vehicle::{self, Driven};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use scphd::settings::{Extraction, Informed, Plausible, Proposal};
use scphd::{Config, Real};
use scphd_vehicle::{Description, Setting, StartError};

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

/// Sets a limit of the motion. Returns whether the name is that of one.
fn set_plausible(limits: &mut Plausible<f32>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    let field = match name {
        "step_max_s" => &mut limits.step_max_s,
        "speed_max_mps" => &mut limits.speed_max_mps,
        "turn_rate_max_radps" => &mut limits.turn_rate_max_radps,
        "jump_max_m" => &mut limits.jump_max_m,
        _ => return Ok(false),
    };
    *field = number(name, value)?;
    Ok(true)
}

/// The settings of a mixture.
pub fn of_mixture(
    proposal: &str,
    particles: usize,
    samples: usize,
    tuning: Option<&Bound<'_, PyDict>>,
) -> PyResult<Config<f32>> {
    let mut config = match proposal {
        "blind" => Config::blind(particles, samples),
        "informed" => Config { samples, ..Config::informed(particles) },
        other => {
            return Err(SettingError::new_err(format!("proposal must be 'blind' or 'informed', not '{other}'")));
        }
    };
    for (name, value) in tuning.iter().flat_map(|tuning| tuning.iter()) {
        set(&mut config, &name.to_string(), &value)?;
    }
    Ok(config)
}

fn set(config: &mut Config<f32>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    if set_plausible(&mut config.plausible, name, value)? {
        return Ok(());
    }
    let moving = &mut config.moving;
    match name {
        "resample_threshold" => config.resample_threshold = number(name, value)?,
        "prune_weight" => config.prune_weight = number(name, value)?,
        "confirming_detections" => config.confirming_detections = number(name, value)?,
        "unconfirmed_weight" => config.unconfirmed_weight = number(name, value)?,
        "confirmed_weight" => config.confirmed_weight = number(name, value)?,
        "merge_distance" => config.merge_distance = number(name, value)?,
        "max_components" => config.max_components = number(name, value)?,
        "extraction_weight" => config.extraction_weight = number(name, value)?,
        "births_wait" => config.births_wait = truth(name, value)?,
        "moving_velocity_sigma_mps" => moving.velocity_sigma_mps = number(name, value)?,
        "moving_acceleration_psd" => moving.motion.acceleration_psd = number(name, value)?,
        "moving_lifetime_s" => moving.motion.lifetime_s = number(name, value)?,
        "moving_spread_max_m" => moving.spread_max_m = number(name, value)?,
        "moving_extraction_weight" => moving.extraction_weight = number(name, value)?,
        "extraction" => {
            config.extraction = match &*word(name, value)? {
                "heaviest" => Extraction::Heaviest,
                "peaks" => Extraction::Peaks,
                "confirmed" => Extraction::Confirmed,
                other => {
                    let what = format!("extraction must be 'heaviest', 'peaks' or 'confirmed', not '{other}'");
                    return Err(SettingError::new_err(what));
                }
            }
        }
        "informed_rounds" => informed(config, name)?.rounds = number(name, value)?,
        "informed_sampled_fraction" => informed(config, name)?.sampled_fraction = number(name, value)?,
        "informed_min_responsibility" => informed(config, name)?.min_responsibility = number(name, value)?,
        _ => return Err(unknown(name)),
    }
    Ok(())
}

fn informed<'c>(config: &'c mut Config<f32>, name: &str) -> PyResult<&'c mut Informed<f32>> {
    match &mut config.proposal {
        Proposal::Informed(informed) => Ok(informed),
        Proposal::Blind => Err(SettingError::new_err(format!("{name} is of the proposal 'informed' alone"))),
    }
}

/// The keywords of a joint map: name, range, unit and meaning.
#[pyfunction]
pub fn _joint_settings() -> Vec<(String, &'static str, &'static str, &'static str)> {
    let known = |setting| keyword_of(setting).map(|name| (name, setting.range(), setting.unit(), setting.about()));
    Setting::all().filter_map(known).collect()
}

/// Converts the value of a keyword to the number of a setting.
fn value(name: &str, setting: Setting, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    match setting.choices() {
        [] => number(name, value),
        ["no", "yes"] => truth(name, value).map(f64::from),
        choices => {
            let word = word(name, value)?;
            let place = choices.iter().position(|choice| *choice == word);
            place
                .map(|place| place as f64)
                .ok_or_else(|| SettingError::new_err(format!("{name} must be {}, not '{word}'", setting.range())))
        }
    }
}

/// The description of a joint map with these keywords.
pub fn of_joint_map(vehicle: Driven<f64>, keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Description<f64>> {
    let mut description = Description { vehicle, ..Description::robot() };
    let mut chosen = Vec::new();
    for (name, object) in keywords.iter().flat_map(|keywords| keywords.iter()) {
        let name = name.to_string();
        let setting = Setting::all().find(|setting| keyword_of(*setting).is_some_and(|known| known == name));
        let setting = setting.ok_or_else(|| unknown(&name))?;
        chosen.push((setting, value(&name, setting, &object)?, name));
    }
    // Parts are switched on before their settings are set.
    chosen.sort_by_key(|(setting, ..)| (setting.choices().is_empty(), setting.number()));
    for (setting, number, name) in chosen {
        if description.get(setting, 0).is_none() {
            let part = name.split('_').next().unwrap_or_default();
            let part = if part == "moving" { "movers" } else { part };
            return Err(SettingError::new_err(format!("{name} takes {part}=True")));
        }
        description
            .set(setting, 0, number)
            .map_err(|invalid| SettingError::new_err(format!("{name} must be {}", invalid.setting.range())))?;
    }
    Ok(description)
}

/// Converts a description to the precision of a filter, without sensors and fixes.
pub fn cast<T: Real>(of: &Description<f64>) -> PyResult<Description<T>> {
    let mut description = Description { vehicle: vehicle::cast(&of.vehicle), ..Description::robot() };
    for setting in Setting::all().filter(|setting| keyword_of(*setting).is_some()) {
        if let Some(number) = of.get(setting, 0) {
            description.set(setting, 0, T::from_f64(number)).map_err(|invalid| StartError::from(invalid).raised())?;
        }
    }
    Ok(description)
}
