//! Names of settings in Python.

use scphd_vehicle::Setting;

/// The keyword of a setting of a joint map: its name without the group, with underscores.
pub fn keyword_of(setting: Setting) -> Option<String> {
    let name = setting.name();
    let own = ["joint.", "plausible."].iter().find_map(|part| name.strip_prefix(part));
    let moving = name.starts_with("moving.").then_some(name);
    own.or(moving).map(|name| name.replace('.', "_"))
}

/// The name of a setting in messages.
pub fn keyword(setting: Setting) -> String {
    keyword_of(setting).unwrap_or_else(|| setting.name().to_owned())
}
