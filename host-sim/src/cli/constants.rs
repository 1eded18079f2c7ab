//! Settings as constants in a programming language, by their names in `scphd-vehicle` and in the C interface.

use super::args::Language;
use super::failure::Failure;
use scphd_filters::describe::description;
use scphd_filters::settings::Settings;
use scphd_log::log::Log;
use scphd_vehicle::{Description, SENSORS, Setting};
use std::fmt::Write as _;

/// A setting, the index of its sensor if it is one of a sensor, and its value.
type Number = (Setting, usize, f32);

/// The joint map of a log, as a table of the settings that differ from those of a new description.
pub fn constants(log: &Log, settings: &Settings, source: &str, language: Language) -> Result<String, Failure> {
    let sensors = log.sensors().count();
    if sensors > SENSORS {
        return Err(Failure::input(format_args!(
            "a description has {SENSORS} sensors at most, {source} has {sensors}"
        )));
    }
    let numbers = numbers(&description(log, settings))?;
    let mut text = String::new();
    let written = match language {
        Language::C => c(&mut text, &numbers, source),
        Language::Rust => rust(&mut text, &numbers, source),
    };
    written.map_err(Failure::input)?;
    Ok(text)
}

fn numbers(of: &Description<f64>) -> Result<Vec<Number>, Failure> {
    let (mut known, mut numbers) = (Description::<f32>::robot(), Vec::new());
    for setting in Setting::all() {
        for sensor in 0..if setting.is_of_a_sensor() { SENSORS } else { 1 } {
            let Some(number) = of.get(setting, sensor).map(|number| number as f32) else { continue };
            if known.get(setting, sensor) != Some(number) {
                known.set(setting, sensor, number).map_err(Failure::input)?;
                numbers.push((setting, sensor, number));
            }
        }
    }
    Ok(numbers)
}

fn rust(text: &mut String, numbers: &[Number], source: &str) -> std::fmt::Result {
    writeln!(
        text,
        "/// The joint map of {source}, for a `scphd_vehicle::Description::<f32>::robot()`: `description.set("
    )?;
    writeln!(text, "/// Setting::of_name(name)?, sensor, number)?` for each, in this order.")?;
    writeln!(text, "pub const SETTINGS: &[(&str, usize, f32)] = &[")?;
    for (setting, sensor, number) in numbers {
        let number = if number.is_infinite() { "f32::INFINITY".to_owned() } else { format!("{number:?}") };
        writeln!(text, "    (\"{}\", {sensor}, {number}),{}", setting.name(), comment(*setting))?;
    }
    write!(text, "];")
}

fn c(text: &mut String, numbers: &[Number], source: &str) -> std::fmt::Result {
    writeln!(
        text,
        "/* The joint map of {source}: scphd_description_set(description, one.setting, one.sensor, one.number, &reason) for"
    )?;
    writeln!(text, " * each, in this order, after scphd_description_start. */")?;
    writeln!(text, "static const struct {{ uint32_t setting; size_t sensor; float number; }} settings[] = {{")?;
    for (setting, sensor, number) in numbers {
        let name = format!("SCPHD_{}", setting.name().replace('.', "_").to_uppercase());
        let choice = setting.choices().get(*number as usize);
        let number = match choice {
            Some(choice) => format!("{name}_{}", choice.to_uppercase()),
            None if number.is_infinite() => "INFINITY".to_owned(),
            None => format!("{number:?}f"),
        };
        writeln!(text, "    {{{name}, {sensor}, {number}}},{}", comment(*setting))?;
    }
    write!(text, "}};")
}

/// The unit as a comment, if the setting has one.
fn comment(setting: Setting) -> String {
    if setting.unit().is_empty() { String::new() } else { format!(" // {}", setting.unit()) }
}
