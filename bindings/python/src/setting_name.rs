//! Names of settings in Python.

use scphd_vehicle::Setting;

/// Settings of a mixture that have parameters of their own.
const PARAMETERS: [&str; 3] = ["mixture.particles", "mixture.samples", "mixture.proposal"];

/// The keyword of a setting of the filter whose settings begin with `group`: its name without the group, with underscores.
pub fn keyword_of(setting: Setting, group: &str) -> Option<String> {
    let name = setting.name();
    let own = [group, "plausible."].iter().find_map(|part| name.strip_prefix(part));
    let moving = name.starts_with("moving.").then_some(name);
    own.or(moving).filter(|_| !PARAMETERS.contains(&name)).map(|name| name.replace('.', "_"))
}

/// The name of a setting in messages.
pub fn keyword(setting: Setting) -> String {
    keyword_of(setting, "joint.").unwrap_or_else(|| setting.name().to_owned())
}
