//! Settings of the filters, as keywords.

use crate::error::SettingError;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use scphd::settings::{Extraction, Informed, Plausible, Proposal};
use scphd::{Config, JointConfig};

/// A number in the place of a setting.
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

/// Sets what is one of the limits of what a vehicle does; whether it is one.
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
        "moving_acceleration_psd_m2ps3" => moving.motion.acceleration_psd = number(name, value)?,
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

/// The settings of a joint map.
pub fn of_joint_map(tuning: Option<&Bound<'_, PyDict>>) -> PyResult<JointConfig<f32>> {
    let mut config = JointConfig::default();
    for (name, value) in tuning.iter().flat_map(|tuning| tuning.iter()) {
        let (name, value) = (&*name.to_string(), &value);
        if set_plausible(&mut config.plausible, name, value)? {
            continue;
        }
        let field = match name {
            "birth_probability_min" => &mut config.birth_probability_min,
            "gate" => &mut config.gate,
            "visible_s" => &mut config.persistence.visible_s,
            "occluded_s" => &mut config.persistence.occluded_s,
            "lifetime_s" => &mut config.persistence.lifetime_s,
            "occlusion_factor" => &mut config.occlusion_factor,
            "least_existence" => &mut config.least_existence,
            "least_tentative" => &mut config.least_tentative,
            "extraction_existence" => &mut config.extraction_existence,
            "merge_distance" => &mut config.merge_distance,
            _ => return Err(unknown(name)),
        };
        *field = number(name, value)?;
    }
    Ok(config)
}
